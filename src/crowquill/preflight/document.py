"""A PDF opened with care: its streams within bounds, what it says of itself, what it is to be held to."""

from __future__ import annotations

import io
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any
from xml.etree import ElementTree

import pikepdf

from crowquill.preflight.boxes import base, sides_of
from crowquill.preflight.drawing import Box, Drawing
from crowquill.preflight.values import real, text, told
from crowquill.vector import LIMIT

PDFX = "{http://www.npes.org/pdfx/ns/id/}GTS_PDFXVersion"
PART, LEVEL = (f"{{http://www.aiim.org/pdfa/ns/id/}}{key}" for key in ("part", "conformance"))
RDF = "{http://www.w3.org/1999/02/22-rdf-syntax-ns#}"
XMP = 16 * 2**20  # bytes of metadata
PACKED = 2**20  # bytes of a stream packed by LZW, which may grow a thousandfold
FAMILIES = {"PDF/X-1": "x1a", "PDF/X-3": "x3", "PDF/X-4": "x4"}
PLATES = {"All", "None", "Cyan", "Magenta", "Yellow", "Black"}  # names that are no spot inks


class TooLarge(Exception):
    """A stream grows beyond bounds."""


@dataclass
class Met:
    """What content was met to use: for each sort of thing, each by what is said of it, how often.

    `spots` has for each spot ink the alternates it is given; `embedded` whether a font that letters are shown in is.
    """

    things: dict[str, dict[str, int]] = field(default_factory=dict)
    spots: dict[str, set[str]] = field(default_factory=dict)
    fonts: dict[str, bool] = field(default_factory=dict)
    shown: set[str] = field(default_factory=set)
    ink: float = 0.0  # the greatest share of all inks on one place of a bitmap

    def note(self, sort: str, text: str, count: int = 1) -> None:
        """Counts one more."""
        found = self.things.setdefault(sort, {})
        found[text] = found.get(text, 0) + count

    def all(self, sort: str) -> dict[str, int]:
        """What was met of a sort."""
        return self.things.get(sort, {})


@dataclass(frozen=True, eq=False)
class Page:
    """A page: its object, its boxes in mm from its own top left by name, what it draws, and what was met on it.

    A MediaBox is always among the boxes; `sound` says whether it is the page's.
    """

    number: int
    obj: Any
    boxes: dict[str, Box]
    drawing: Drawing
    met: Met

    @property
    def where(self) -> str:
        """What findings call it."""
        return self.drawing.where

    @property
    def sound(self) -> bool:
        """Whether it has a MediaBox that can be read."""
        return "MediaBox" in sides_of(self.obj)

    @property
    def spaces(self) -> set[str]:
        """The colour spaces of all that is drawn, and those behind them."""
        plain = {"DeviceGray", "DeviceRGB", "DeviceCMYK"}
        words = {one.colour.space for one in self.drawing.words}
        return set(self.met.all("spaces")) | (({one.space for one in self.drawing.art.colours} | words) & plain)

    @property
    def spots(self) -> dict[str, set[str]]:
        """Spot inks, and the mixtures that stand for each."""
        return {name: mixes for name, mixes in self.met.spots.items() if name not in PLATES}

    @property
    def defaults(self) -> set[str]:
        """Which of /DefaultGray, /DefaultRGB and /DefaultCMYK the page sets."""
        resources = self.obj.get("/Resources")
        named = resources.get("/ColorSpace") if isinstance(resources, pikepdf.Dictionary) else None
        return {str(key) for key in named.keys()} if isinstance(named, pikepdf.Dictionary) else set()  # noqa: SIM118

    @property
    def notes(self) -> list[tuple[str, Box]]:
        """Annotations by their kind, and the box that each takes in mm."""
        found: list[tuple[str, Box]] = []
        every = self.obj.get("/Annots")
        a, _, _, d, e, f = base(self.obj)
        for one in every if isinstance(every, pikepdf.Array) else []:
            if isinstance(one, pikepdf.Dictionary):
                box = one.get("/Rect")
                sides = [real(side, 0.0) for side in box] if isinstance(box, pikepdf.Array) and len(box) == 4 else [0.0, 0.0, 0.0, 0.0]
                x, y = sorted(a * side + e for side in sides[::2]), sorted(d * side + f for side in sides[1::2])
                found.append((text(one.get("/Subtype")) or "/unknown", (x[0], y[0], x[1], y[1])))
        return found


@dataclass(frozen=True, eq=False)
class Document:
    """A PDF, its pages that were looked at, and what it is held to: x1a, x3, x4, a, or nothing."""

    name: str
    pdf: pikepdf.Pdf
    bytes: int
    version: str
    pages: tuple[Page, ...]
    held: frozenset[str]
    warnings: tuple[str, ...] = ()

    @cached_property
    def said(self) -> dict[str, str]:
        """What its XMP says: text by {namespace}name."""
        return xmp(self.pdf)

    @cached_property
    def info(self) -> dict[str, str]:
        """What its Info dictionary says."""
        info = self.pdf.trailer.get("/Info")
        if not isinstance(info, pikepdf.Dictionary):
            return {}
        return {key: text(info[key]) for key in info.keys() if isinstance(info[key], (pikepdf.String, pikepdf.Name))}  # noqa: SIM118

    @property
    def part(self) -> int:
        """The part of PDF/A that it claims, 1 where it claims none."""
        said = self.said.get(PART, "1")
        return int(said) if said in ("1", "2", "3", "4") else 1

    @property
    def intents(self) -> list[Any]:
        """Its output intents."""
        found = self.pdf.Root.get("/OutputIntents")
        return [one for one in found if isinstance(one, pikepdf.Dictionary)] if isinstance(found, pikepdf.Array) else []

    def objects(self) -> Iterator[Any]:
        """Every dictionary and stream of the file, those inside others too."""
        for top in self.pdf.objects:
            waiting = [top]
            while waiting:
                one = waiting.pop()
                if isinstance(one, pikepdf.Array):
                    waiting += [part for part in one if _direct(part)] if not _numbers(one) else []
                elif isinstance(one, (pikepdf.Dictionary, pikepdf.Stream)):
                    yield one
                    waiting += [part for part in one.values() if _direct(part)]


def _direct(part: Any) -> bool:
    return isinstance(part, (pikepdf.Array, pikepdf.Dictionary)) and not part.is_indirect


def _numbers(array: Any) -> bool:
    """Whether a long array is one of plain numbers, as widths are."""
    return len(array) > 1000 and not isinstance(array[0], pikepdf.Object)


def opened(data: bytes, name: str) -> pikepdf.Pdf:
    """The PDF. Raises ValueError for what is none, is broken beyond mending, or asks for a password."""
    if b"%PDF-" not in data[:1024]:
        raise ValueError(f"{name}: not a PDF file; give one")
    try:
        pdf = pikepdf.open(io.BytesIO(data))
        _ = pdf.Root.get("/Pages"), len(pdf.pages)
    except pikepdf.PasswordError:
        raise ValueError(f"{name}: asks for a password; save it without one") from None
    except (pikepdf.PdfError, RuntimeError, LookupError, TypeError, AttributeError, ValueError) as error:
        raise unsound(name, error) from None
    return pdf


def unsound(name: str, error: Exception) -> ValueError:
    """The refusal of a file that cannot be read."""
    return ValueError(f"{name}: not a sound PDF ({told(error)[-100:] or type(error).__name__}); save it again")


def held(pdf: pikepdf.Pdf, pdfx: str | None, pdfa: bool) -> frozenset[str]:
    """What a file is held to: what is asked for, or else what it claims."""
    if pdfx or pdfa:
        return frozenset(([pdfx] if pdfx else []) + (["a"] if pdfa else []))
    said = xmp(pdf)
    kind = claim(pdf, said)
    return frozenset(([kind] if kind else []) + (["a"] if PART in said else []))


def claim(pdf: pikepdf.Pdf, said: dict[str, str]) -> str | None:
    """The kind of PDF/X that a file claims to be: x1a, x3, x4, or None."""
    info = pdf.trailer.get("/Info")
    words = [said.get(PDFX, "")]
    if isinstance(info, pikepdf.Dictionary):
        words.append(text(info.get("/GTS_PDFXVersion")))
    for word in words:
        for family, kind in FAMILIES.items():
            if word.startswith(family):
                return kind
    return None


def unpacked(stream: Any, limit: int = LIMIT) -> bytes:
    """A stream's contents, what there is of those that are cut off. Raises TooLarge beyond the limit, PdfError for others' packing."""
    raw = bytes(stream.read_raw_bytes())
    names = packings(stream)
    for name in names:
        if name in ("/LZWDecode", "/LZW", "/RunLengthDecode", "/RL") and len(raw) > PACKED:
            raise TooLarge
        if name in ("/FlateDecode", "/Fl"):
            raw = _inflated(raw, limit)
        else:
            break
    if all(name in ("/FlateDecode", "/Fl") for name in names) and "/DecodeParms" not in stream:
        return raw
    return bytes(stream.read_bytes())


def packings(stream: Any) -> list[str]:
    """The filters that a stream is packed by, the last one first."""
    found = stream.get("/Filter")
    if isinstance(found, pikepdf.Array):
        return [text(one) for one in found]
    return [] if found is None else [text(found)]


def _inflated(raw: bytes, limit: int) -> bytes:
    opener = zlib.decompressobj()
    try:
        found = opener.decompress(raw, limit)
    except zlib.error:
        found, opener = b"", zlib.decompressobj()
        for at in range(0, len(raw), 4096):
            try:
                found += opener.decompress(raw[at : at + 4096], limit)
            except zlib.error:
                break
    if opener.unconsumed_tail or len(found) > limit:
        raise TooLarge
    return found


def sound(stream: Any) -> bool:
    """Whether deflated contents are whole."""
    if stream.get("/Filter") != pikepdf.Name.FlateDecode:
        return True
    opener, left = zlib.decompressobj(), bytes(stream.read_raw_bytes())
    try:
        while left and not opener.eof:
            opener.decompress(left, 2**20)
            left = opener.unconsumed_tail
    except zlib.error:
        return False
    return opener.eof


def xmp(pdf: pikepdf.Pdf) -> dict[str, str]:
    """The text of each property of a file's XMP, by {namespace}name; nothing where there is none, or none that can be read."""
    stream = pdf.Root.get("/Metadata")
    try:
        packet = unpacked(stream, XMP) if isinstance(stream, pikepdf.Stream) else b""
        if not packet or re.search(rb"<\0?!\0?[DE]", packet):  # declarations have no place in XMP
            return {}
        root = ElementTree.fromstring(packet.strip(b"\0 \r\n\t"))
    except (TooLarge, pikepdf.PdfError, ElementTree.ParseError, RecursionError, ValueError, LookupError):
        return {}
    found: dict[str, str] = {}
    for part in root.iter(f"{RDF}Description"):
        found |= {key: value for key, value in part.attrib.items() if not key.startswith(RDF)}
        for child in part:
            item = next(child.iter(f"{RDF}li"), child)
            found[str(child.tag)] = (item.text or "").strip()
    return found
