"""Scales: how large a specimen is drawn, and the bar of known length that says so."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from crowquill.lettering import Words
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer

MICRO = "\N{MICRO SIGN}m"  # the code point that fonts have
UNITS = {"nm": 1e-6, "um": 1e-3, MICRO: 1e-3, "\N{GREEK SMALL LETTER MU}m": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1e3, "km": 1e6}  # mm
SHOWN = (("km", 1e6), ("m", 1e3), ("mm", 1.0), (MICRO, 1e-3), ("nm", 1e-6))  # of which the largest that leaves 1 or more is said
OWN = (1e-12, 1e15)  # mm of a specimen: beyond these nothing is drawn, and digits without an exponent fill a page
LIMITS = (1e-9, 1e9)  # mm drawn to a mm of the specimen: from a continent on a page to an atom
THICK = 0.5  # mm
LETTERS = 2.5  # mm, some 7 points: the least that journals print
APART = 0.6  # mm between bar and label
TICK = 1.6  # mm
SHORTEST = 1.0  # mm: less is a blot
SHARES = (0.2, 1 / 3)  # of the width that a bar of no stated length takes
ROUND = (1.0, 2.0, 5.0, 1.5, 3.0, 7.5)  # one times a power of ten is always within SHARES, the first three wherever they can
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|[-+]?(?:nan|inf)"
LENGTH = rf"({NUMBER})\s*([a-zµμ]+)"


@dataclass(frozen=True)
class Bar:
    """A scale bar as layers, its label "500 µm", and the box (left, top, right, bottom) mm that holds all its ink."""

    layers: tuple[Layer, ...]
    label: str
    box: tuple[float, float, float, float]


def length(text: str) -> float:
    """Millimetres of a length of a specimen, such as "250 um"; units are nm, um or µm, mm, cm, m, km. Raises ValueError otherwise.

    >>> length("250 um"), length("2 km")
    (0.25, 2000000.0)
    """
    value, unit = _measure(text)
    return float(value) * UNITS[unit]


def parsed(text: str) -> float:
    """How many mm are drawn for a mm of the specimen. Raises ValueError for what is no scale, or none that can be.

    >>> parsed("1 mm in the figure = 250 um in the specimen"), parsed("1 mm = 250 um"), parsed("1:50"), parsed("20:1")
    (4.0, 4.0, 0.02, 20.0)
    """
    words = text.strip().lower()
    if found := re.fullmatch(rf"({NUMBER})\s*:\s*({NUMBER})", words):
        return _ratio(float(found[1]), float(found[2]), text)
    if found := re.fullmatch(rf"({LENGTH})(?:\s+in the (?:figure|drawing))?\s*=\s*({LENGTH})(?:\s+in the specimen)?", words):
        return _ratio(length(found[1]), length(found[4]), text)
    raise ValueError(f"scale {text!r} is not understood; write 1 mm = 250 um, the drawing's length first, or 1:50")


def of_pixel(text: str, pixel: float) -> float:
    """How many mm are drawn for a mm of the specimen, where a pixel is so long on it ("1.3 um") and `pixel` mm wide on paper."""
    return _ratio(pixel, length(text), text)


def rounded(ratio: float, width: float) -> float:
    """A round length of the specimen, mm, whose bar is a fifth to a third of this width in mm.

    >>> rounded(4.0, 100.0), rounded(0.02, 120.0)
    (5.0, 2000.0)
    """
    low, high = (share * width / ratio for share in SHARES)
    ten = 10.0 ** math.floor(math.log10(high))
    fits = (step * power for step in ROUND for power in (ten, ten / 10) if low * (1 - 1e-9) <= step * power <= high * (1 + 1e-9))
    return float(f"{next(fits):.6g}")


def bar(
    ratio: float,
    width: float,
    text: str = "auto",
    *,
    at: tuple[float, float] = (0.0, 0.0),
    anchor: str = "right",
    thickness: float = THICK,
    ticks: bool = False,
    size: float = LETTERS,
    ink: Ink | None = None,
    font: str = "regular",
) -> Bar:
    """A filled bar of the exact length with its label above its middle.

    ratio   mm drawn to a mm of the specimen
    width   mm of the room: a longer bar or label is refused
    text    the length of the specimen, said in the digits it is written in ("500 um"), or "auto" for a round one
    at      the lower right corner of it all in mm, or by anchor "left" its lower left
    size    mm of the label's font, which is a face or a file as Words take it

    Raises ValueError for a ratio or a length that cannot be, and for a bar over the width or under 1 mm.
    """
    ratio = _ratio(ratio, 1.0, f"{ratio:g}:1")
    if not (0 < width < math.inf and 0 < thickness < math.inf):
        raise ValueError(f"a scale bar {thickness} mm thick in a room {width} mm wide; both must be over 0")
    if text.strip().lower() == "auto":
        value = rounded(ratio, width)
        label = said(value)
    else:
        number, unit = _measure(text)
        value, label = float(number) * UNITS[unit], f"{number:f} {MICRO if UNITS[unit] == UNITS[MICRO] else unit}"
    long = value * ratio
    if not SHORTEST <= long <= width * (1 + 1e-9):
        raise ValueError(
            f"a scale bar of {label} is {_plain(long, 4)} mm long in a room of {width:.4g} mm; "
            + (f"{said(rounded(ratio, width))} would do" if width > SHORTEST / SHARES[0] else "draw it larger")
        )
    half = TICK / 2 if ticks else thickness / 2
    bars = [(0.0, half - thickness / 2, long, thickness)]
    if ticks:
        thin = min(thickness, long / 4)
        bars += [(0.0, 0.0, thin, TICK), (long - thin, 0.0, thin, TICK)]
    rings = Paths.of([[(x, y), (x + w, y), (x + w, y + h), (x, y + h)] for x, y, w, h in bars])
    words = Words.of([(label, long / 2, -APART)], size=size, anchor="middle", font=font)
    letters = words.outlines().flat(1e-3).xy
    (left, top), (right, bottom) = np.minimum(letters.min(0), (0, 0)), np.maximum(letters.max(0), (long, 2 * half))
    if right - left > width * (1 + 1e-9):
        raise ValueError(f"the scale bar's label {label} is {right - left:.3g} mm wide in a room of {width:.4g} mm; draw it larger")
    shift = np.round([at[0] - (right if anchor == "right" else left), at[1] - bottom], 3)
    named = Ink() if ink is None else ink
    layers = (Layer(named, rings.moved(np.eye(2), shift), "scale bar"), Layer(named, words.moved(shift), f"scale bar {label}"))
    x, y = shift.tolist()
    return Bar(layers, label, (float(left) + x, float(top) + y, float(right) + x, float(bottom) + y))


def said(value: float) -> str:
    """A length of so many mm in the unit that suits it.

    >>> said(0.5), said(20.0), said(1500.0)
    ('500 µm', '20 mm', '1.5 m')
    """
    unit, size = next((pair for pair in SHOWN if value >= pair[1] * (1 - 1e-9)), SHOWN[-1])
    return f"{_plain(value / size, 6)} {unit}"


def _plain(number: float, digits: int) -> str:
    """A number of so many digits, without an exponent."""
    return f"{Decimal(f'{number:.{digits}g}'):f}"


def _measure(text: str) -> tuple[Decimal, str]:
    """The number of a specimen's length, with its digits as they are written, and the unit."""
    found = re.fullmatch(LENGTH, text.strip().lower())
    if not found or found[2] not in UNITS:
        raise ValueError(
            f"length {text!r} of a specimen is not understood; write a number and one of nm, um, mm, cm, m, km, such as 500 um"
        )
    if not OWN[0] <= float(found[1]) * UNITS[found[2]] <= OWN[1]:
        raise ValueError(f"length {text!r} of a specimen; it takes a number over 0, and no more than {said(OWN[1])}")
    return Decimal(found[1]), found[2]


def _ratio(drawn: float, own: float, text: str) -> float:
    """Drawn over own, if that is a scale."""
    ratio = drawn / own if own else math.nan
    if not (drawn > 0 and own > 0 and LIMITS[0] <= ratio <= LIMITS[1]):
        raise ValueError(f"scale {text!r} is none that can be drawn; write 1 mm = 250 um, the drawing's length first, or 1:50")
    return ratio
