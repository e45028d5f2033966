"""From a scanned page of ink dots to a glyph library: each dot's outline at true size, and its grey.

Work is done in light, not in code values: a scanner's optics blur light, and its edge lies where half of it is lost.

Source: dots are scanned, as by D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and example-based
grayscale stippling, Computers & Graphics 35(1), 2011.
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from crowquill.glyphs import parsed
from crowquill.glyphs.cubics import fitted
from crowquill.glyphs.page import Covers, Grey, Source, beside, called, code_values, flattened, nowhere, otsu, smoothed, tagged
from crowquill.glyphs.scale import aslant, fine, of_page
from crowquill.glyphs.sorting import GIANT, sorted_out
from crowquill.paths import Array, Paths, frozen
from crowquill.picture import linear
from crowquill.units import INCH

Box = tuple[float, float, float, float]  # left, top, right, bottom

TILE = 1.5  # mm, of the grid on which the paper's light is taken: a dot of 0.4 mm covers a twentieth
FAINT = 0.2  # what takes less of the paper's light is no ink
STRAY = 0.003  # mm an outline may lie off its contour
NOISY = 0.1  # pixels, or 0.7 of STRAY, by which noise may move an edge (rms) before it is smoothed: more asks for six cubics and more
SHAKEN = 0.14  # pixels: areas are out by 3 % here and there
FEW = 6.0  # pixels across: below, the middle of a dot is blurred too
UNEVEN = 0.8  # of the brightest paper: less light on any part is worth a warning
ROW = 8  # dots in a row of a library's contact sheet


@dataclass(frozen=True, eq=False)
class Scan:
    """The dots of a scanned page, in the order in which their first pixels are met, row by row.

    outlines   closed cubic Paths in mm, where they lie on the page, turning from x to y
    diameters  (n,) mm, of the circles of their areas
    patches    n arrays (h, w) float32 of the light taken, 0 (paper) to 1, other dots blanked
    corners    (n, 2) mm, the top left corner of each patch on the page
    levels     (n,) of the patch, where its outline was taken: half way from paper to ink, but for the optics' rounding
    rejected   what is no dot: why ("dust", "giant", "merged", "cut by the border" or "ruler") and its box in mm
    size       width and height of the page, mm
    scale      who said the dpi: "given", "tag" (the file's) or "ruler" (the mean along it)
    smoothing  pixels of the Gaussian that took out noise before all else, 0 on a clean page; patches have it too
    """

    outlines: Paths
    diameters: Array
    patches: tuple[Grey, ...]
    corners: Array
    levels: Array
    rejected: tuple[tuple[str, Box], ...]
    dpi: float
    size: tuple[float, float]
    scale: str = "given"
    smoothing: float = 0.0
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.outlines)
        object.__setattr__(self, "diameters", frozen(self.diameters, np.float64, (n,), "diameters"))
        object.__setattr__(self, "corners", frozen(self.corners, np.float64, (n, 2), "corners"))
        object.__setattr__(self, "levels", frozen(self.levels, np.float64, (n,), "levels"))
        object.__setattr__(self, "patches", tuple(frozen(patch, np.float32, (None, None), "patch") for patch in self.patches))
        if len(self.patches) != n:
            raise ValueError(f"patches are {len(self.patches)}; it takes {n}, one an outline")

    @property
    def counts(self) -> dict[str, int]:
        """How many were rejected for each reason."""
        return dict(Counter(reason for reason, _ in self.rejected))


def scan(source: Source, *, dpi: float | None = None, invert: bool = False) -> Scan:
    """The dots of a scanned or photographed page, and what on it is no dot.

    source  path or binary file of a picture, or an array (h, w) of grey code values: 0 (black) to 1, or unsigned integers
    dpi     pixels to the inch, 300 or more; left out, that of the file's tag, or else of a ruler with millimetres on the page
    invert  the page is a negative, white dots on black

    Sizes follow from the scale alone. A ruler may lie at any angle; a tag under 300 dpi counts as none. Raises ValueError
    for a page without dots, a negative not said to be one, an unknown or coarse scale.
    """
    name = called(source)
    if dpi is not None:
        fine(dpi, name)
    light = _light(source, name, invert)
    dpi, scale, ruler, said = of_page(light, name, dpi, tagged(source) if dpi is None else None)
    mm = INCH / dpi
    darkness, evenness = flattened(light, tile=max(4, round(TILE / mm)), hidden=ruler.shades if ruler else nowhere)
    del light
    hiding = (ruler.shades, ruler.covers) if ruler else (nowhere,)
    hidden, ink, threshold = _ink(darkness, hiding)
    bound = STRAY / mm
    darkness, smoothing, moved = smoothed(darkness, ink, threshold, limit=max(NOISY, 0.7 * bound), hidden=hidden)
    if smoothing:
        hidden, ink, threshold = _ink(darkness, hiding)
    if ink < FAINT:
        raise ValueError(f"{name}: no dots; scan dark ink on light paper")
    dots, rejected = sorted_out(darkness, threshold, mm, ruler)
    if not dots:
        counts = Counter(reason for reason, _ in rejected)
        why = ", ".join(f"{count} {reason}" for reason, count in sorted(counts.items()))
        raise ValueError(f"{name}: no dots of a pen ({why}); scan single dots that do not touch, at 1200 dpi")
    rings, stray = zip(*(fitted(dot.contour, bound) for dot in dots), strict=True)
    outlines = Paths.of([(ring + dot.corner) * mm for ring, dot in zip(rings, dots, strict=True)], cubic=True)
    diameters = 2 * np.sqrt(outlines.areas / np.pi)
    said += _warnings(np.array(stray), bound, moved, diameters / mm, evenness)
    return Scan(
        outlines,
        diameters,
        tuple(dot.patch for dot in dots),
        np.array([dot.corner for dot in dots]) * mm,
        np.array([dot.level for dot in dots]),
        tuple((why, (x.start * mm, y.start * mm, x.stop * mm, y.stop * mm)) for why, (y, x) in rejected),
        dpi,
        (darkness.shape[1] * mm, darkness.shape[0] * mm),
        scale,
        smoothing,
        said + (aslant(ruler, outlines, mm) if ruler else ()),
    )


def _ink(darkness: Grey, hiding: tuple[Covers, ...]) -> tuple[Covers, float, float]:
    """What to hide of these, the darkness of the ink's middles by what is left, over the paper's, and the threshold that parts them."""
    found = []
    for k, hidden in enumerate(hiding):
        seen = beside(darkness, hidden)
        _, paper, threshold = otsu(seen)
        ink, _, _ = otsu(seen[seen > threshold])  # where dots are few, the first parts shading from paper
        found.append((ink - paper, k, max(threshold, ink / 2)))
    ink, k, threshold = max(found)
    return hiding[k], ink, threshold


def _light(source: Source, name: str, invert: bool) -> Grey:
    """The light of a page with dark ink, (h, w), 0 to 1."""
    code = code_values(source)
    code = 1 - code if invert else code
    low, middle, high = np.quantile(code, (0, 0.5, 1)) if code.size else (0, 0, 0)
    if high - low < 0.1:  # of the code values: less than FAINT on any paper
        raise ValueError(f"{name}: no dots; scan dark ink on light paper")
    if middle < min(0.5, (low + high) / 2):
        raise ValueError(f"{name}: dark all over with light dots; {'leave out invert' if invert else 'use invert for white on black'}")
    return linear(code).astype(np.float32)


def _warnings(stray: Array, bound: float, moved: float, across: Array, evenness: float) -> tuple[str, ...]:
    """What is to be said of outlines so many pixels off their contours, of what noise moves them, of dots' pixels, of the light."""
    said = []
    if moved > SHAKEN:
        said.append(f"noise moves edges by {moved:.2f} pixels even when smoothed: areas are doubtful; scan with more light or less gain")
    if astray := int((stray > bound).sum()):
        said.append(f"{astray} outlines lie up to {stray.max():.2f} pixels off their contours: the scan is noisy or the dots ragged")
    if (usual := float(np.median(across))) < FEW:
        said.append(f"dots of {usual:.1f} pixels: their areas are known to some 20 % only; scan with more dpi")
    if evenness < UNEVEN:
        said.append(
            f"uneven light: the dimmest paper has {evenness:.0%} of the light of the brightest; press the page flat, or light it evenly"
        )
    return tuple(said)


def library(scan: Scan, *, name: str, pen_mm: float, about: Mapping[str, Any]) -> bytes:
    """The dots as an SVG glyph library, a contact sheet in mm, as they were turned on the page.

    name    of the library: a letter, then letters, digits, dots and hyphens
    pen_mm  width of the pen
    about   JSON values; has "simulated" (true or false), "source" and "licence"; may have "made" and more

    Its metadata keeps the grey under "patches": "pixel_mm"; "shape", rows and columns of each patch in the order of the paths;
    "centre_mm", each outline's centroid from its patch's top left corner; and "grey", base64 of zlib of all patches' bytes
    end to end, row by row, 255 where all light is taken.

    Raises ValueError for a scan without dots, or a name, pen or metadata that no library can have.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9.-]{0,63}", name):
        raise ValueError(f"name {name[:40]!r} is not a letter and up to 63 letters, digits, dots and hyphens; give one such as nib-03")
    if not 0 < pen_mm <= GIANT:
        raise ValueError(f"pen_mm is {pen_mm}; it takes over 0 to {GIANT:g} mm")
    if lost := {"simulated", "source", "licence"} - about.keys():
        raise ValueError(f"about lacks {', '.join(sorted(lost))}; say where the dots come from and who may use them")
    if not isinstance(about["simulated"], bool):
        raise ValueError(f"simulated is {about['simulated']!r} in about; it takes True or False")
    if not len(scan.outlines):
        raise ValueError("the scan has no dots; scan a page that has some")
    how = "photographed beside a ruler" if scan.scale == "ruler" else "scanned"
    made = f"{how} at {scan.dpi:.5g} dpi; outlines in 5 to 8 cubics each, by crowquill.glyphs.scanning"
    what = {"made": made, **about}
    facts = {**what, "name": name, "pen_mm": pen_mm, "count": len(scan.outlines), "patches": _kept(scan)}
    try:
        text = escape(json.dumps(facts, indent=2, allow_nan=False))
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(f"about is not of JSON values ({error}); give texts, numbers, lists and true or false") from None
    data = _contact_sheet(scan, name, text, f"{len(scan.outlines)} dots of a {pen_mm:g} mm pen: {what['made']}.").encode()
    parsed(data, name)
    return data


def _kept(scan: Scan) -> dict[str, Any]:
    """The patches of a scan as JSON values."""
    grey = b"".join(np.round(255 * patch).astype(np.uint8).tobytes() for patch in scan.patches)
    return {
        "pixel_mm": round(INCH / scan.dpi, 9),
        "shape": [list(patch.shape) for patch in scan.patches],
        "centre_mm": np.round(_centroids(scan.outlines) - scan.corners, 5).tolist(),
        "grey": base64.b64encode(zlib.compress(grey, 9)).decode("ascii"),
    }


def _centroids(outlines: Paths) -> Array:
    """The centroid of each closed outline, (n, 2) mm."""
    m = outlines.green()
    return np.asarray(outlines.xy[outlines.start[:-1]] + m[:, 1:3] / m[:, :1])


def _contact_sheet(scan: Scan, name: str, facts: str, about: str) -> str:
    """The SVG file: each outline about the centre of its own square, in mm with five decimals."""
    centred = scan.outlines.xy - _centroids(scan.outlines)[scan.outlines.path]
    pitch = np.ceil(25 * np.abs(centred).max()) / 10  # a quarter more than the widest, in tenths
    n = len(scan.outlines)
    columns = min(ROW, n)
    wide, high = pitch * columns, pitch * -(-n // columns)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="{wide:g}mm" height="{high:g}mm" viewBox="0 0 {wide:g} {high:g}">',
        f"<title>{escape(name)}</title>",
        f"<desc>{escape(about)}</desc>",
        f'<metadata><library xmlns="urn:crowquill:library" schema="1">{facts}</library></metadata>',
        '<g fill="#000">',
    ]
    for i, ring in enumerate(Paths(centred, scan.outlines.start, True, True)):
        pairs = [f"{x:.5f},{y:.5f}" for x, y in (ring + pitch * (np.array([i % columns, i // columns]) + 0.5)).tolist()]
        pairs.append(pairs[0])
        cubics = (" ".join(pairs[k : k + 3]) for k in range(1, len(pairs), 3))
        lines.append(f'<path id="{name}-{i:02d}" d="M {pairs[0]} ' + " ".join(f"C {three}" for three in cubics) + ' Z"/>')
    return "\n".join([*lines, "</g>", "</svg>", ""])
