"""The walk through a page's content: every operator, forms inside forms, text, bitmaps; what is drawn, and what is used for it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pikepdf

from crowquill.preflight import operators as op
from crowquill.preflight.boxes import base, boxes
from crowquill.preflight.canvas import Canvas, Stop, times
from crowquill.preflight.colours import Space, first, space
from crowquill.preflight.document import Met, TooLarge, sound, unpacked
from crowquill.preflight.drawing import Bitmap, Box, Drawing
from crowquill.preflight.fonts import Font
from crowquill.preflight.placed import drawn, form, inline
from crowquill.preflight.states import applied, group
from crowquill.preflight.tokens import TOKEN, Name, of, value_of
from crowquill.preflight.values import told
from crowquill.vector import LIMIT

CONTENT = 256 * 2**20  # bytes of one stream: a million dots
OPERANDS = 100_000  # to an operator
IGNORED = {b"BMC", b"MP", b"DP", b"EMC", b"ri", b"d0", b"BX", b"EX", b"d", b"BI"}
SHOWS = {b"Tj", b"'", b'"', b"TJ"}
SETS = {b"Tc": op.SPACED, b"Tw": op.WORDS, b"TL": op.LEADING, b"Ts": op.RISE, b"Tr": op.MODE}
COLOURS = {b"sc": op.FILL, b"scn": op.FILL, b"SC": op.STROKE, b"SCN": op.STROKE}


def page(found: Any, number: int) -> tuple[dict[str, Box], Drawing, Met]:
    """The page's boxes in mm, what it draws, and what it was met to use."""
    sides, met = boxes(found.obj), Met()
    walk = Walker(met, Canvas(met, base(found.obj), sides["MediaBox"]))
    try:
        walk.page(found.obj)
        art = walk.canvas.art()
    except (Stop, TooLarge) as stop:
        met.note("limits", str(stop) or "content that grows without end when it is unpacked")
        art = Canvas(met, base(found.obj), sides["MediaBox"]).art()
    for font in walk.canvas.fonts:
        if font.unread or font.procs is not None:
            met.note("unread", f"font {font.name}")
    trim = sides.get("TrimBox", sides.get("ArtBox", sides.get("CropBox", sides["MediaBox"])))
    drawing = Drawing(
        f"page {number}",
        trim,
        sides.get("BleedBox", trim),
        art,
        tuple(walk.canvas.words()),
        tuple(walk.bitmaps),
        tuple(walk.canvas.extents),
        met.all("unread"),
        int(walk.canvas.counts[op.OPERATORS]) + walk.odd,
        ink=met.ink,
    )
    return sides, drawing, met


class Walker:
    """Goes through content once. What is drawn is left on its canvas, what is used is noted in `met`."""

    def __init__(self, met: Met, canvas: Canvas) -> None:
        self.met, self.canvas = met, canvas
        self.bitmaps: list[Bitmap] = []
        self.odd = self.calls = self.read = 0
        self.under_way: list[Any] = []
        self.fonts: dict[Any, int] = {}

    def page(self, found: Any) -> None:
        """The page's own content, which may be in several streams."""
        content = found.get("/Contents")
        parts = list(content) if isinstance(content, pikepdf.Array) else [content]
        code = b"\n".join(self.contents(part) for part in parts if isinstance(part, pikepdf.Stream))
        resources, node = found.get("/Resources"), found
        for _ in range(50):
            node = node.get("/Parent")
            if resources is not None or not isinstance(node, pikepdf.Dictionary):
                break
            resources = node.get("/Resources")
        group(self.met, found)
        self.run(code, resources if isinstance(resources, pikepdf.Dictionary) else pikepdf.Dictionary())

    def contents(self, stream: Any) -> bytes:
        """A stream's content; what is broken is noted."""
        try:
            if not sound(stream):
                self.met.note("content", "a stream that is cut off or does not unpack")
            return unpacked(stream, CONTENT)
        except (pikepdf.PdfError, RuntimeError, TypeError, ValueError) as error:
            self.met.note("content", f"a stream that does not unpack ({told(error)[-60:]})")
            return b""

    def run(self, code: bytes, resources: Any) -> None:
        """Runs content, by compiled code as far as it goes, else operator by operator."""
        self.read += len(code)
        if self.read > LIMIT:
            raise Stop("content that is drawn over and over, more than is looked at")
        letters, at = np.frombuffer(code, np.uint8), 0
        before = int(self.canvas.counts[op.FAULTS])
        while at < len(code):
            at = self.canvas.run(letters, at)
            if at < len(code):
                at = self._operators(code, at, resources)
        if self.canvas.counts[op.FAULTS] > before or self.canvas.counts[op.DEEP]:
            self.met.note("content", "q and Q that do not pair")

    def _operators(self, code: bytes, at: int, resources: Any) -> int:
        """Runs one operator, and, inside text, those that follow it as far as they are of text; returns where to go on."""
        operands: list[Any] = []
        begin, done, depth = at, False, 0
        while True:
            found = TOKEN.search(code, at)
            if not found or len(operands) > OPERANDS:
                self.met.note("content", "operands without an operator")
                return len(code)
            at, kind = found.end(), found.lastgroup
            if kind == "word":
                word = found[0]
                if done and word not in SHOWS and not word.startswith((b"T", b"E")):
                    return begin
                self.odd += 1
                at = self._operator(word, operands, resources, code, at)
                if not self.canvas.text:
                    return at
                operands, begin, done, depth = [], at, True, 0
            elif kind == "mark":
                depth += {b"<<": 1, b">>": -1}.get(found[0], 0)
            elif kind is not None:
                value, at = value_of(found, code)
                if depth == 0 or isinstance(value, Name):
                    operands.append(value)

    def _operator(self, word: bytes, operands: list[Any], resources: Any, code: bytes, at: int) -> int:
        """Runs one operator; returns where its successor is."""
        try:
            if word == b"BI":
                return inline(self, code, at, resources)
            if word in (b"BT", b"ET"):
                self.canvas.text = word == b"BT"
                self.canvas.at = self.canvas.line = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
            elif word in SHOWS or word in SETS or word in (b"Tf", b"Tz", b"Td", b"TD", b"Tm", b"T*"):
                self._text(word, operands, resources)
            elif word in COLOURS or word in (b"cs", b"CS"):
                self._colour(word, operands, resources)
            elif word == b"gs":
                applied(self, of(resources, "/ExtGState", operands[-1]), str(operands[-1]))
            elif word == b"Do":
                drawn(self, of(resources, "/XObject", operands[-1]), resources, str(operands[-1]))
            elif word == b"sh":
                shading = of(resources, "/Shading", operands[-1])
                self.uses(space(shading.get("/ColorSpace"), resources.get("/ColorSpace")))
                self.met.note("unread", "shading")
                self.canvas.extend(self.canvas.now[op.CLIP : op.CLIP + 4].reshape(2, 2).copy())
            elif word == b"BDC" and operands and operands[0] == "/OC":
                self.met.note("layers", "marked content")
            elif word not in IGNORED and word not in (b"BDC", b"d1"):
                self.met.note("content", f"an operator {word[:12].decode('latin-1')!r} that is none, or lacks what it works on")
        except (LookupError, TypeError, ValueError, AttributeError, pikepdf.PdfError) as error:
            said = told(error)[:60]
            self.met.note("content", f"an operator {word[:12].decode('latin-1')!r} that cannot be run ({said})")
        return at

    def _text(self, word: bytes, operands: list[Any], resources: Any) -> None:
        """Runs an operator of text."""
        canvas = self.canvas
        if word == b"Td" or word == b"TD":
            if word == b"TD":
                canvas.now[op.LEADING] = -operands[-1]
            self._next(operands[-2], operands[-1])
        elif word == b"Tj":
            canvas.show(operands[-1])
        elif word == b"TJ":
            size = float(canvas.now[op.SIZE] * canvas.now[op.STRETCH]) / 1000
            for part in operands:
                if isinstance(part, bytes):
                    canvas.show(part)
                else:
                    canvas.forward(-part * size)
        elif word == b"Tm":
            a, b, c, d, e, f = operands[-6:]
            canvas.at = canvas.line = (a, b, c, d, e, f)
        elif word in (b"T*", b"'", b'"'):
            if word == b'"':
                canvas.now[op.WORDS], canvas.now[op.SPACED] = operands[-3], operands[-2]
            self._next(0.0, -float(canvas.now[op.LEADING]))
            if word != b"T*":
                canvas.show(operands[-1])
        elif word == b"Tf":
            canvas.now[op.SIZE] = operands[-1]
            self.font(of(resources, "/Font", operands[-2]))
        elif word == b"Tz":
            canvas.now[op.STRETCH] = operands[-1] / 100
        else:
            canvas.now[SETS[word]] = operands[-1]

    def _next(self, x: float, y: float) -> None:
        """The beginning of a line, so far from that of the last one."""
        self.canvas.at = self.canvas.line = times((1.0, 0.0, 0.0, 1.0, float(x), float(y)), self.canvas.line)

    def font(self, found: Any) -> None:
        """Takes up a font."""
        key = found.objgen if found.is_indirect else id(found)
        if key not in self.fonts:
            font = Font(found)
            self.fonts[key] = len(self.canvas.fonts)
            self.canvas.fonts.append(font)
            self.met.fonts[font.name] = font.embedded
        self.canvas.now[op.FONT] = self.fonts[key]

    def _colour(self, word: bytes, operands: list[Any], resources: Any) -> None:
        """Chooses a space, or a colour in one."""
        stroke = word[:1].isupper()
        if word in (b"cs", b"CS"):
            found = space(pikepdf.Name(operands[-1]), resources.get("/ColorSpace"))
            self.uses(found)
            self._paint(stroke, found, first(found) if found else ())
            return
        kind = int(self.canvas.now[COLOURS[word]])
        now = self.canvas.own[kind - op.OTHER][0] if kind >= op.OTHER else None
        if kind < op.OTHER:
            now = space(pikepdf.Name(("/DeviceGray", "/DeviceRGB", "/DeviceCMYK")[kind]), None)
        if operands and isinstance(operands[-1], Name):
            self._pattern(of(resources, "/Pattern", operands[-1]), resources)
        self._paint(stroke, now, tuple(float(value) for value in operands if not isinstance(value, Name)))

    def _paint(self, stroke: bool, found: Space | None, numbers: tuple[float, ...]) -> None:
        """Puts a colour into the state."""
        at = op.STROKE if stroke else op.FILL
        self.canvas.now[at : at + 5] = (self.canvas.number_of(found, numbers), 0, 0, 0, 0)

    def _pattern(self, found: Any, resources: Any) -> None:
        """Notes what a pattern is made of."""
        if isinstance(found.get("/Shading"), (pikepdf.Dictionary, pikepdf.Stream)):
            self.uses(space(found.Shading.get("/ColorSpace"), resources.get("/ColorSpace")))
            self.met.note("unread", "shading")
        elif isinstance(found, pikepdf.Stream):
            self.met.note("unread", "pattern")
            aside = Walker(self.met, Canvas(Met(), (1.0, 0.0, 0.0, 1.0, 0.0, 0.0), (-1e5, -1e5, 1e5, 1e5)))
            aside.under_way, aside.calls = self.under_way, self.calls
            form(aside, found, resources)
            for colour in aside.canvas.art().colours:
                self.met.note("spaces", colour.space)

    def uses(self, found: Space | None) -> None:
        """Notes a colour space, those behind it, and its spot inks."""
        if found is None:
            self.met.note("content", "a colour space that cannot be read")
            return
        for part in found.parts:
            self.met.note("spaces", part.label)
            if part.kind in ("Separation", "DeviceN"):
                for name in part.names:
                    self.met.spots.setdefault(name, set()).add(part.mix)
                if part.tint:
                    self.met.note("tints", f"{', '.join(part.names)} has {part.tint}")
