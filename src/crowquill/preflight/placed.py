"""What content places whole: forms, and bitmaps by name or inline."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pikepdf

from crowquill.preflight import operators as op
from crowquill.preflight.canvas import Stop, times
from crowquill.preflight.colours import Space, space
from crowquill.preflight.document import TooLarge, unpacked
from crowquill.preflight.drawing import Bitmap
from crowquill.preflight.states import group
from crowquill.preflight.tokens import TOKEN, value_of
from crowquill.preflight.values import text
from crowquill.units import INCH

if TYPE_CHECKING:
    from crowquill.preflight.walker import Walker

DEEP = 24  # forms inside forms
CALLS = 100_000  # forms drawn on a page
PIXELS = 64 * 2**20  # numbers of a bitmap whose ink is summed
SHORT = {"/W": "/Width", "/H": "/Height", "/BPC": "/BitsPerComponent", "/CS": "/ColorSpace", "/IM": "/ImageMask", "/F": "/Filter"}
END = re.compile(rb"[\x00\t\n\f\r ]EI(?=[\x00\t\n\f\r ]|$)")


def drawn(walk: Walker, found: Any, resources: Any, name: str) -> None:
    """Draws a form or a bitmap."""
    kind = text(found.get("/Subtype"))
    if "/OPI" in found:
        walk.met.note("opi", f"{name} is to be replaced (OPI)")
    if "/OC" in found:
        walk.met.note("layers", name)
    if kind == "/PS" or text(found.get("/Subtype2")) == "/PS":
        walk.met.note("postscript", f"{name} is PostScript")
    elif kind == "/Image":
        _bitmap(walk, found, resources, name)
    elif kind == "/Form":
        if "/Ref" in found:
            walk.met.note("opi", f"{name} stands for another file")
        form(walk, found, resources)
    else:
        walk.met.note("content", f"{name} is neither a form nor a bitmap")


def form(walk: Walker, found: Any, resources: Any) -> None:
    """Runs a form's content in its own matrix and clip."""
    walk.calls += 1
    if walk.calls > CALLS:
        raise Stop(f"over {CALLS} forms drawn; only those were looked at")
    key = found.objgen if found.is_indirect else id(found)
    if key in walk.under_way or len(walk.under_way) >= DEEP:
        walk.met.note("content", "a form that draws itself, or forms nested over 24 deep")
        return
    canvas = walk.canvas
    before, stack, deep, text = canvas.now.copy(), canvas.stack, int(canvas.counts[op.DEEP]), (canvas.text, canvas.at, canvas.line)
    canvas.stack, canvas.counts[op.DEEP], canvas.text = np.empty_like(stack), 0, False
    matrix = tuple(float(value) for value in found.get("/Matrix", (1, 0, 0, 1, 0, 0)))
    canvas.now[:6] = times(matrix, tuple(canvas.now[:6].tolist()))
    box = [float(value) for value in found.get("/BBox", ())]
    if len(box) == 4:
        corners = np.array([(x, y) for x in box[::2] for y in box[1::2]]) @ canvas.now[:4].reshape(2, 2) + canvas.now[4:6]
        low, high = canvas.now[op.CLIP : op.CLIP + 2], canvas.now[op.CLIP + 2 : op.CLIP + 4]
        low[:], high[:] = np.maximum(low, corners.min(axis=0)), np.minimum(high, corners.max(axis=0))
    group(walk.met, found)
    walk.under_way.append(key)
    try:
        own = found.get("/Resources")
        walk.run(walk.contents(found), own if isinstance(own, pikepdf.Dictionary) else resources)
    finally:
        walk.under_way.pop()
        canvas.stack, canvas.now[:] = stack, before
        canvas.counts[op.DEEP] = deep
        canvas.text, canvas.at, canvas.line = text


def _bitmap(walk: Walker, found: Any, resources: Any, name: str) -> None:
    """Notes a bitmap: its resolution, its space, its transparency, the most ink in it."""
    if "/SMask" in found or int(found.get("/SMaskInData", 0)):
        walk.met.note("transparency", f"bitmap {name} has a soft mask")
    if "/Alternates" in found:
        walk.met.note("alternates", f"bitmap {name} has alternates")
    mask = bool(found.get("/ImageMask", False))
    of = None if mask else space(found.get("/ColorSpace"), resources.get("/ColorSpace"))
    if of is not None:
        walk.uses(of)
    bits = 1 if mask else int(found.get("/BitsPerComponent", 8))
    _place(walk, name, int(found.Width), int(found.Height), bits)
    if of is not None and of.n == 4 and bits == 8:
        _sum(walk, found, of)


def _sum(walk: Walker, found: Any, of: Space) -> None:
    """The most ink in a bitmap of four process inks."""
    size = int(found.Width) * int(found.Height) * 4
    if found.get("/Filter") not in (None, pikepdf.Name.FlateDecode) or "/DecodeParms" in found or "/Decode" in found or size > PIXELS:
        walk.met.note("unread", f"ink of a bitmap in {of.label}")
        return
    try:
        data = np.frombuffer(unpacked(found, size + 64)[:size], np.uint8)
    except TooLarge:
        data = np.zeros(0, np.uint8)
    if len(data) == size and size:
        walk.met.ink = max(walk.met.ink, float(data.reshape(-1, 4).sum(axis=1, dtype=np.int64).max()) / 255)


def _place(walk: Walker, name: str, width: int, height: int, bits: int) -> None:
    """Notes a bitmap in the unit square of the matrix."""
    now = walk.canvas.now
    a, b, c, d = now[:4].tolist()
    wide, high = np.hypot(a, b) / INCH, np.hypot(c, d) / INCH
    ppi = min(width / wide if wide else np.inf, height / high if high else np.inf)
    corners = np.array([(x, y) for x in (0.0, 1.0) for y in (0.0, 1.0)]) @ now[:4].reshape(2, 2) + now[4:6]
    if width <= 0 or height <= 0 or not np.isfinite(corners).all() or not np.isfinite(ppi):
        walk.met.note("content", f"bitmap {name} has no size")
        return
    walk.canvas.extend(corners)
    walk.met.note("unread", "bitmap")
    low, high_ = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    walk.bitmaps.append(Bitmap(name, (low[0], low[1], high_[0], high_[1]), (width, height), bits, float(ppi)))


def inline(walk: Walker, code: bytes, at: int, resources: Any) -> int:
    """Notes a bitmap that stands in the content; returns where it ends."""
    said: dict[str, Any] = {}
    key = None
    while True:
        found = TOKEN.search(code, at)
        if not found:
            walk.met.note("content", "a bitmap without an end")
            return len(code)
        at = found.end()
        if found.lastgroup == "word" and found[0] == b"ID":
            break
        if found.lastgroup == "word":
            value: Any = found[0] == b"true"
        elif found.lastgroup in ("mark", None):
            continue
        else:
            value, at = value_of(found, code)
        if key is None:
            key = SHORT.get(str(value), str(value))
        else:
            said.setdefault(key, value)
            key = None
    mask, width, height = bool(said.get("/ImageMask", False)), int(said.get("/Width", 0)), int(said.get("/Height", 0))
    bits = 1 if mask else int(said.get("/BitsPerComponent", 8))
    of = None if mask else space(pikepdf.Name(str(said.get("/ColorSpace", "/DeviceGray"))), resources.get("/ColorSpace"))
    if of is not None:
        walk.uses(of)
    if said.get("/Filter") in ("/LZW", "/LZWDecode"):
        walk.met.note("lzw", "an inline bitmap")
    _place(walk, "inline", width, height, bits)
    plain = (width * bits * (of.n if of else 1) + 7) // 8 * height if "/Filter" not in said else 0
    end = END.search(code, min(at + plain, len(code)))
    return end.end() if end else len(code)
