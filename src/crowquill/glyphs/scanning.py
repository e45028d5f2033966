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
from dataclasses import dataclass, replace
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from crowquill.glyphs import parsed
from crowquill.glyphs.outline import STRAY, edge_level, fitted, iso_contour, shape
from crowquill.glyphs.page import Grey, Source, called, code_values, flattened, otsu, resolution
from crowquill.paths import Array, Paths, frozen
from crowquill.picture import linear
from crowquill.units import INCH

Label = npt.NDArray[np.int32]
Window = tuple[slice, slice]  # rows, columns
Box = tuple[float, float, float, float]  # left, top, right, bottom

GIANT = 3.0  # mm: no pen leaves a dot so wide
TILE = 1.5  # mm, of the grid on which the paper's light is taken: a dot of 0.4 mm covers a twentieth
FAINT = 0.2  # what takes less of the paper's light is no ink
DUST = 0.3  # of the median area, and 5 pixels; diameters of one pen's dots spread by 11 % at most, three times that leaves 0.45
MARGIN = 0.1  # mm of paper around a patch, at least 4 pixels
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
    rejected   what is no dot: why ("dust", "giant", "merged" or "cut by the border") and its box in mm
    """

    outlines: Paths
    diameters: Array
    patches: tuple[Grey, ...]
    corners: Array
    levels: Array
    rejected: tuple[tuple[str, Box], ...]
    dpi: float
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
    """The dots of a scanned page, and what on it is no dot.

    source  path or binary file of a picture, or an array (h, w) of grey code values: 0 (black) to 1, or unsigned integers
    dpi     pixels to the inch, 300 or more; the file's own when left out
    invert  the page is a negative, white dots on black

    Sizes follow from dpi alone. Raises ValueError for a page without dots, a negative not said to be one, an unknown or
    coarse dpi.
    """
    name = called(source)
    code = code_values(source)
    dpi = resolution(source, dpi)
    code = 1 - code if invert else code
    low, middle, high = np.quantile(code, (0, 0.5, 1)) if code.size else (0, 0, 0)
    if high - low < 0.1:  # of the code values: less than FAINT on any paper
        raise ValueError(f"{name}: no dots; scan dark ink on light paper")
    if middle < min(0.5, (low + high) / 2):
        raise ValueError(f"{name}: dark all over with light dots; {'leave out invert' if invert else 'use invert for white on black'}")
    darkness, evenness = flattened(linear(code).astype(np.float32), tile=max(4, round(TILE * dpi / INCH)))
    del code
    ink, paper, threshold = otsu(darkness)
    if ink - paper < FAINT:
        raise ValueError(f"{name}: no dots; scan dark ink on light paper")
    labels, _ = ndimage.label(darkness > threshold, np.ones((3, 3), int))
    found = _sorted_out(darkness, np.asarray(labels, np.int32), dpi)
    if not len(found.outlines):
        why = ", ".join(f"{count} {reason}" for reason, count in sorted(found.counts.items()))
        raise ValueError(f"{name}: no dots of a pen ({why}); scan single dots that do not touch, at 1200 dpi")
    warnings = found.warnings
    if evenness < UNEVEN:
        warnings += (f"uneven light: the dimmest paper has {evenness:.0%} of the light of the brightest; press the page flat",)
    return replace(found, warnings=warnings)


def _sorted_out(darkness: Grey, labels: Label, dpi: float) -> Scan:
    """The Scan of labelled components: each is a dot, or is rejected for a reason."""
    mm = INCH / dpi
    areas = np.bincount(labels.ravel())[1:]
    boxes: list[Window] = [(box[0], box[1]) for box in ndimage.find_objects(labels)]
    reasons = [_too_large(box, area, labels.shape, mm) for box, area in zip(boxes, areas, strict=True)]
    usual = _usual(areas[[not reason for reason in reasons]])
    dots = []
    for k, box in enumerate(boxes):
        reasons[k] = reasons[k] or ("dust" if areas[k] < max(DUST * usual, 5) else "")
        if reasons[k]:
            continue
        patch, corner, level = _patch(darkness, labels, k + 1, box, max(4, round(MARGIN / mm)))
        contour = iso_contour(patch, level)
        if _merged(contour, areas[k], usual):
            reasons[k] = "merged"
        else:
            dots.append((patch, corner, level, *fitted(contour)))
    outlines = Paths.of([(ring + corner) * mm for _, corner, _, ring, _ in dots], cubic=True)
    diameters = 2 * np.sqrt(outlines.areas / np.pi)
    return Scan(
        outlines,
        diameters,
        tuple(dot[0] for dot in dots),
        np.array([dot[1] for dot in dots]).reshape(-1, 2) * mm,
        np.array([dot[2] for dot in dots]),
        tuple((why, (x.start * mm, y.start * mm, x.stop * mm, y.stop * mm)) for why, (y, x) in zip(reasons, boxes, strict=True) if why),
        dpi,
        _warnings(np.array([dot[4] for dot in dots]), diameters / mm),
    )


def _too_large(box: Window, area: int, page: tuple[int, ...], mm: float) -> str:
    """Why a component of so many pixels of so many mm is no whole dot, or nothing."""
    if any(side.start < 2 or side.stop > length - 2 for side, length in zip(box, page, strict=True)):
        return "cut by the border"
    return "giant" if area * mm * mm > np.pi / 4 * GIANT**2 else ""


def _usual(areas: npt.NDArray[np.integer[Any]]) -> float:
    """The median area of single dots.

    First each is counted by its diameter, which neither much dust nor a few blots move; then those near it are counted alike.
    """
    if not len(areas):
        return 0.0
    areas = np.sort(areas)
    weight = np.cumsum(np.sqrt(areas))
    usual = float(areas[np.searchsorted(weight, weight[-1] / 2)])
    for _ in range(3):
        usual = float(np.median(areas[(areas >= usual / 2) & (areas <= usual * 1.5)]))
    return usual


def _patch(darkness: Grey, labels: Label, label: int, box: Window, margin: int) -> tuple[Grey, Array, float]:
    """A dot's darkness from its own paper, the patch's corner (x, y) in pixels, and the level of its outline."""
    top, left = (max(0, side.start - margin) for side in box)
    window = slice(top, box[0].stop + margin), slice(left, box[1].stop + margin)
    near = labels[window]
    away, (row, column) = ndimage.distance_transform_edt(near == 0, return_indices=True)
    own = near[row, column] == label  # nearer to this dot than to another
    bare = darkness[window][own & (away >= 3)]
    paper = np.median(bare) if bare.size else 0.0
    patch = np.where(own, (darkness[window] - paper) / (1 - paper), 0).astype(np.float32)
    depth = ndimage.distance_transform_edt(near == label)
    ink = float(np.median(patch[depth > 0.75 * depth.max()]))
    patch = np.clip(patch, 0, 1)
    return patch, np.array([left, top], np.float64), edge_level(patch, ink)


def _merged(contour: Array, pixels: int, usual: float) -> bool:
    """Whether a contour is of more than one dot.

    Touching discs have 2 areas, solidity 0.9, axis ratio 0.5. A contour much smaller than its component is of one of two.
    """
    if len(contour) < 8:
        return True
    area, solidity, ratio = shape(contour)
    size = area / usual
    parted = abs(area - pixels) > 0.25 * pixels + 4  # 4: a dot of few pixels gains or loses its corners
    return parted or size > 1.6 or solidity < 0.86 or ratio < 0.6 or (size > 1.3 and (solidity < 0.95 or ratio < 0.75))


def _warnings(stray: Array, across: Array) -> tuple[str, ...]:
    """What is to be said of outlines that lie so many pixels off their contours, of dots so many pixels wide."""
    said = []
    if astray := int((stray > STRAY).sum()):
        said.append(f"{astray} outlines lie up to {stray.max():.2f} pixels off their contours: the scan is noisy or the dots ragged")
    if len(across) and (usual := float(np.median(across))) < FEW:
        said.append(f"dots of {usual:.1f} pixels: their areas are known to some 20 % only; scan with more dpi")
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
    what = {"made": f"scanned at {scan.dpi:g} dpi; outlines in 5 to 8 cubics each, by crowquill.glyphs.scanning", **about}
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
