"""Colour spaces of PDF, and the inks that colours in them ask for."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import pikepdf

from crowquill.preflight.document import TooLarge, unpacked
from crowquill.preflight.drawing import Colour
from crowquill.preflight.values import text

PROCESS = ("Cyan", "Magenta", "Yellow", "Black")
SHORT = {"G": "DeviceGray", "RGB": "DeviceRGB", "CMYK": "DeviceCMYK", "I": "Indexed"}
SIZES = {"DeviceGray": 1, "CalGray": 1, "DeviceRGB": 3, "CalRGB": 3, "Lab": 3, "DeviceCMYK": 4, "Pattern": 0}
DEEP = 6  # spaces inside spaces


@dataclass(frozen=True)
class Space:
    """A colour space: its kind, its numbers to a colour, its spot inks, the space behind it, its table if it is indexed."""

    kind: str
    n: int
    names: tuple[str, ...] = ()
    base: Space | None = None
    table: bytes = b""
    tint: str = ""  # what is wrong with the function from its inks to the space behind it
    mix: str = ""  # the space behind it and that function, the same for the same mixtures

    @property
    def label(self) -> str:
        """What it is called in findings."""
        if self.kind == "ICCBased":
            return f"ICCBased of {self.n}"
        return f"{self.kind} on {self.base.label}" if self.base and self.kind in ("Separation", "DeviceN", "Indexed") else self.kind

    @property
    def parts(self) -> list[Space]:
        """Itself and the spaces behind it."""
        return [self, *(self.base.parts if self.base else [])]


def space(found: Any, named: Any, depth: int = 0) -> Space | None:
    """The space that a name or an array stands for, `named` being the resources' own; None where it is none."""
    if depth > DEEP:
        return None
    if isinstance(found, pikepdf.Name):
        name = SHORT.get(text(found)[1:], text(found)[1:])
        if name in SIZES and name not in ("CalGray", "CalRGB", "Lab"):
            return Space(name, SIZES[name])
        inner = named.get(found) if isinstance(named, pikepdf.Dictionary) else None
        return space(inner, named, depth + 1) if inner is not None else None
    if not isinstance(found, pikepdf.Array) or not len(found) or not isinstance(found[0], pikepdf.Name):
        return None
    kind = SHORT.get(text(found[0])[1:], text(found[0])[1:])
    if kind == "Pattern":
        return Space(kind, 0, base=space(found[1], named, depth + 1) if len(found) > 1 else None)
    if kind in SIZES:
        return Space(kind, SIZES[kind])
    try:
        return _deeper(kind, found, named, depth)
    except (LookupError, TypeError, ValueError, AttributeError, TooLarge, pikepdf.PdfError):
        return None


def _deeper(kind: str, found: Any, named: Any, depth: int) -> Space | None:
    """A space that is made of others, or of a profile."""
    if kind == "ICCBased":
        n = int(found[1].get("/N", 0))
        return Space(kind, n) if n in (1, 3, 4) else None
    if kind == "Indexed":
        base = space(found[1], named, depth + 1)
        table = unpacked(found[3], 4096) if isinstance(found[3], pikepdf.Stream) else bytes(found[3])
        return Space(kind, 1, base=base, table=table) if base else None
    if kind in ("Separation", "DeviceN"):
        names = (found[1],) if kind == "Separation" else tuple(found[1])
        base = space(found[2], named, depth + 1)
        spots = tuple(text(name)[1:] for name in names)
        return Space(kind, len(spots), spots, base, tint=_tint(found[3], len(spots), base.n), mix=_mix(base, found[3])) if base else None
    return None


def _tint(function: Any, takes: int, gives: int) -> str:
    """What is wrong with a tint transform, in words; nothing where its numbers agree with its spaces."""
    kind = int(function.get("/FunctionType", -1)) if isinstance(function, (pikepdf.Dictionary, pikepdf.Stream)) else -1
    if kind not in (0, 2, 3, 4):
        return "no tint transform"
    if len(function.get("/Domain", [])) != 2 * takes:
        return f"a tint transform of {len(function.get('/Domain', [])) // 2} inks for {takes}"
    ends = function.get("/C1", [1]) if kind == 2 else function.get("/Range", [])
    size = len(ends) if kind == 2 else len(ends) // 2
    if (kind != 3 or size) and size != gives:
        return f"a tint transform that gives {size} numbers where {gives} are needed"
    if kind == 2 and gives == 4 and max((float(end) for end in ends), default=0) <= 0:
        return "a tint transform whose full tint has no ink"
    return ""


def _mix(base: Space, function: Any) -> str:
    """The space behind spot inks and the function into it, in short."""
    said = function.unparse(resolved=True) if isinstance(function, pikepdf.Dictionary) else b""
    if isinstance(function, pikepdf.Stream):
        said = unpacked(function, 2**20) + str([(key, function[key]) for key in ("/Domain", "/Range") if key in function]).encode()
    return f"{base.label} {hashlib.sha256(said).hexdigest()[:12]}"


def colour(of: Space | None, numbers: tuple[float, ...]) -> Colour:
    """The inks, or the light, of a colour in a space."""
    if of is None or of.kind == "Pattern":
        return Colour("Pattern" if of else "unknown", known=False)
    values = tuple(min(1.0, max(0.0, value)) for value in (*numbers, *(0.0,) * of.n)[: of.n])
    if of.kind == "DeviceGray":
        return Colour(of.kind, _inks(("Black",), (1 - values[0],)))
    if of.kind == "DeviceCMYK" or (of.kind == "ICCBased" and of.n == 4):
        return Colour(of.label, _inks(PROCESS, values))
    if of.kind in ("Separation", "DeviceN"):
        return Colour("Separation All" if of.names == ("All",) else of.kind, _inks(of.names, values))
    if of.kind == "Indexed" and of.base:
        at = int(numbers[0]) * of.base.n if numbers else 0
        inner = tuple(byte / 255 for byte in of.table[at : at + of.base.n])
        return colour(of.base, inner) if len(inner) == of.base.n else Colour(of.kind, known=False)
    if of.kind == "Lab":
        light = max(0.0, min(1.0, (numbers[0] if numbers else 0) / 100))
        return Colour(of.kind, light=(light,) * 3)  # as dark as it is; its hue does not matter here
    red, green, blue = values * 3 if of.n == 1 else values
    return Colour(of.label, light=(red, green, blue))


def first(of: Space) -> tuple[float, ...]:
    """The colour that a space begins with: full tints, black elsewhere."""
    if of.kind in ("Separation", "DeviceN"):
        return (1.0,) * of.n
    return (0.0, 0.0, 0.0, 1.0) if of.n == 4 else (0.0,) * of.n


def _inks(names: tuple[str, ...], values: tuple[float, ...]) -> tuple[tuple[str, float], ...]:
    """The inks that are there. All is every plate, None no plate."""
    pairs: list[tuple[str, float]] = []
    for name, value in zip(names, values, strict=True):
        if name == "All":
            pairs += [(process, value) for process in PROCESS]
        elif name != "None":
            pairs.append((name, value))
    return tuple((name, round(value, 4)) for name, value in pairs if value > 0)
