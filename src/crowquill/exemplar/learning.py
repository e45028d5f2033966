"""From the scan of a drawing to a Style without tiles: shapes of its marks, and the texture of each of its tones.

Single dots are those of crowquill.glyphs.scanning. Tones are squares of the page where the coverage is about even; dots that
touch need not be told apart, because texture is the correlation of ink with itself.

Source: S. Kim, R. Maciejewski, T. Isenberg, W. M. Andrews, W. Chen, M. C. Sousa, D. S. Ebert, Stippling by Example, NPAR 2009.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from crowquill.exemplar.correlation import radial
from crowquill.exemplar.style import Hand, Level, Style
from crowquill.glyphs.cubics import fitted
from crowquill.glyphs.page import Source, called, code_values, flattened
from crowquill.glyphs.scanning import STRAY, TILE, Scan, scan
from crowquill.glyphs.sorting import sorted_out
from crowquill.marks import Glyph
from crowquill.paths import Array, Paths
from crowquill.picture import colours, linear
from crowquill.units import INCH
from crowquill.vector import regular

Mask = npt.NDArray[np.bool_]

LEVELS = 10  # tones told apart, white and black not counted
WINDOW = 24.0  # diameters of a dot: the side of a square that has one tone
UNEVEN = 0.06  # of coverage, rms over a square's sixteenths, beyond what chance does: more is a change of tone
CHANCE = 3.0  # times the variance of random dots: groups of dots do so much
ALIKE = 0.035  # of asin(sqrt(coverage)), in which chance is as large at all tones: squares of one tone
APART = 0.05  # of it, at least, between tones
FAINT = 0.01  # of coverage, of marks on a ground: less is dust, or no tone
TOLD_APART = 2.0  # the darkest tone over the lightest: squares half on a patch of one tone have down to half of it
SAMPLED = 500  # pixels a side, of which the paper's colour is taken
REACH = 4.0  # mean spacings: how far the texture is followed; from there to FAR it only tells how tone drifts
FAR = 5.0
STEP = 0.2  # of a dot's diameter, between distances
FINER = 8  # pixels to a dot's diameter in which texture is read
BANK = 300  # shapes kept of an ink
CAST = 1 / 3  # of the paper's strongest light: the weakest of red, green and blue. Old yellow paper has a half, brown wrapping a quarter
FEW = 12  # single marks, from which on there is a bank; a single white one is no style
DARK = 0.6  # coverage from which on marks may be white
ISLANDS = 0.12  # of the white of a dark tone that must be single marks: of three tenths of white, crowded, a fifth is
BLEND = 0.04  # of coverage, over which black marks give way to white ones, each way
UNHEARD = ("uneven light", "outlines lie")  # warnings of scans: dark tones look like dim paper, and marks are drawn, not measured


@dataclass(frozen=True, eq=False)
class Page:
    """A scanned page as ink (h, w), true or false, where it is of a drawing at all, its pixels in mm, and its dots' usual diameter."""

    ink: Mask
    seen: Mask
    pixel: float
    diameter: float


def learn(source: Source, dpi: float | None = None) -> Style:
    """What a scan of a drawing teaches, its hands without tiles.

    source  a path, an open file or an array (h, w) of grey code values, as scanning.scan() takes it
    dpi     of the scan; left out, that of the file's tag, or of a ruler on the page

    White marks are learned where a tone over 0.6 has a dozen or more that are single. Raises ValueError for a page of one
    tone, without a dozen single dots, with dots of white alone, with a colour cast, or of an unknown or coarse scale.
    """
    name = called(source)
    _balanced(source)
    try:
        found = scan(source, dpi=dpi)
    except ValueError as error:
        raise ValueError(_by_our_options(str(error))) from None
    if len(found.outlines) < FEW:
        counts = "".join(f", {count} {why}" for why, count in sorted(found.counts.items()))
        raise ValueError(f"{name}: {len(found.outlines)} single dots{counts}; scan more of the drawing, or a page with dots apart")
    page, darkness = _page(source, found)
    windows, means, rough = _windows(page)
    levels: list[Level] = []
    white: list[Level] = []
    glyphs: tuple[Glyph, ...] = ()
    regions = _tones(page, windows, means, rough)
    tones = [float(page.ink[region].mean()) for region in regions]
    if not tones or max(tones) < TOLD_APART * min(tones):
        raise ValueError(
            f"{name}: has one tone at most; give an example with patches of light and dark, {WINDOW * page.diameter:.0f} mm wide"
        )
    single = _white(darkness, page) if max(tones) > DARK else ()
    for region, covers in zip(regions, tones, strict=True):
        own = [mark for mark, at in single if region[at]] if covers > DARK else []
        area = sum(np.pi / 4 * glyph.size**2 for glyph in own)
        if len(own) >= FEW and area > ISLANDS * (1 - covers) * region.sum() * page.pixel**2:
            glyphs += tuple(own)
            white.append(_level(~page.ink, region, page, float(np.sqrt(area / len(own)))))
        else:
            levels.append(_level(page.ink, region, page, page.diameter * np.sqrt(np.pi) / 2))
    if not levels:
        raise ValueError(f"{name}: has no light tones; give an example with black dots on paper, too")
    bank = tuple(Glyph.of(found.outlines.take([i])) for i in _evenly(len(found.outlines)))
    black = Hand(bank, tuple(sorted(levels, key=lambda level: level.coverage)))
    notes = tuple(f"the example: {said}" for said in found.warnings if not any(word in said for word in UNHEARD))
    if not white:
        return Style(name_of(source), found.dpi, digest(source), black, notes=notes)
    middle = (black.levels[-1].coverage + 1 - max(level.coverage for level in white)) / 2
    half = min(BLEND, (1 - middle) / 2)
    pale = Hand(tuple(glyphs[i] for i in _evenly(len(glyphs))), tuple(sorted(white, key=lambda level: level.coverage)))
    return Style(name_of(source), found.dpi, digest(source), black, pale, (middle - half, middle + half), notes)


def _balanced(source: Source) -> None:
    """Raises ValueError for paper so far from grey that its light says little of ink."""
    if isinstance(source, np.ndarray):
        return
    rgb = colours(source)[0][..., :3]
    if not isinstance(source, (str, os.PathLike)):
        source.seek(0)
    few = rgb[:: len(rgb) // SAMPLED + 1, :: rgb.shape[1] // SAMPLED + 1].reshape(-1, 3)
    bright = few.sum(axis=1, dtype=np.int64)
    paper = np.median(few[bright >= np.quantile(bright, 0.9)], axis=0)
    light = linear(paper / 255)
    if light.min() < CAST * light.max():
        told = ", ".join(f"{value:.0f}" for value in paper)
        raise ValueError(
            f"{called(source)}: has a colour cast, its paper is {told} (red, green, blue); scan it in grey, or balance its white"
        )


def name_of(source: Source) -> str:
    """The bare name of an example, without a folder or a suffix."""
    return Path(called(source)).stem


def digest(source: Source) -> str:
    """The SHA-256 of an example's file, "" where it is none. Raises ValueError for a folder, a pipe or a device."""
    if not isinstance(source, (str, os.PathLike)):
        return ""
    regular(Path(source))
    with Path(source).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _by_our_options(said: str) -> str:
    """A refusal of a scan in words of the options that an example has."""
    said = (
        said.replace("--dpi", "--example-dpi").replace("give dpi", "give --example-dpi").replace("the true dpi", "the true --example-dpi")
    )
    said = said.replace("use invert for white on black", "crop it so that most of it is paper")
    return said.replace("scan single dots that do not touch, at 1200 dpi", "give an example in whose lights dots stand apart")


def _page(source: Source, found: Scan) -> tuple[Page, Array]:
    """The page that dots were found on, and its darkness."""
    mm = INCH / found.dpi
    darkness, _ = flattened(linear(code_values(source)).astype(np.float32), tile=max(4, round(TILE / mm)))
    if found.smoothing:
        darkness = ndimage.gaussian_filter(darkness, found.smoothing)
    seen = np.ones(darkness.shape, bool)
    for why, box in found.rejected:
        if why == "ruler":
            left, top, right, bottom = (round(side / mm) for side in box)
            seen[top:bottom, left:right] = False
    return Page(darkness > float(np.median(found.levels)), seen, mm, float(np.median(found.diameters))), np.asarray(darkness)


def _windows(page: Page) -> tuple[npt.NDArray[np.object_], Array, Array]:
    """Squares of the page as pairs of slices (n,), the coverage of each, and how uneven it is: 1 at most where it is of one tone."""
    cell = max(1, round(WINDOW * page.diameter / page.pixel / 4))
    down, across = (side // cell for side in page.ink.shape)
    whole = page.ink[: down * cell, : across * cell].reshape(down, cell, across, cell).mean(axis=(1, 3))
    seen = page.seen[: down * cell, : across * cell].reshape(down, cell, across, cell).all(axis=(1, 3))
    if min(down, across) < 4:
        return np.empty(0, object), np.zeros(0), np.zeros(0)
    parts, sight = (np.lib.stride_tricks.sliding_window_view(values, (4, 4)).reshape(-1, 16) for values in (whole, seen))
    rows, columns = np.indices((down - 3, across - 3)).reshape(2, -1) * cell
    squares = np.empty(len(rows), object)
    squares[:] = [(slice(top, top + 4 * cell), slice(left, left + 4 * cell)) for top, left in zip(rows, columns, strict=True)]
    mean, variance = parts.mean(axis=1), parts.var(axis=1)
    dot = np.pi / 4 * page.diameter**2 / (cell * page.pixel) ** 2  # of a sixteenth
    rough = variance / (UNEVEN**2 + CHANCE * dot * mean * (1 - mean))
    return squares, mean, np.where(sight.all(axis=1) & (mean > FAINT) & (mean < 1 - FAINT), rough, np.inf)


def _tones(page: Page, squares: npt.NDArray[np.object_], means: Array, rough: Array) -> list[Mask]:
    """Where on the page each tone is that many even squares have, (h, w) each; the commonest first, LEVELS at most.

    Of the squares of a tone the evener half is kept: others reach into a neighbour.
    """
    rank = np.arcsin(np.sqrt(np.clip(means, 0, 1)))
    left = rough <= 1
    found: list[Mask] = []
    while left.any() and len(found) < LEVELS:
        near = np.abs(rank[left][:, None] - rank[left]) < ALIKE
        middle = rank[left][np.argmax(near.sum(axis=1))]
        off = np.abs(rank - middle)
        own = np.flatnonzero(left & (off < ALIKE))
        region = np.zeros(page.ink.shape, bool)
        for k in own[np.argsort(rough[own], kind="stable")][: max(1, len(own) // 2)]:
            region[squares[k]] = True
        found.append(region)
        left &= off >= max(APART, ALIKE)
    return found


def _level(ink: Mask, region: Mask, page: Page, size: float) -> Level:
    """The coverage and texture of a region of marks whose area is `size` squared.

    A change of tone within the region adds the same to the correlation at all distances: what is left far off is taken from it.
    """
    rows, columns = np.flatnonzero(region.any(axis=1)), np.flatnonzero(region.any(axis=0))
    diameter = 2 * size / np.sqrt(np.pi)
    coarse = max(1, int(diameter / page.pixel / FINER))
    part = (slice(rows[0], rows[-1] + 1, coarse), slice(columns[0], columns[-1] + 1, coarse))
    covers = float(ink[region].mean())
    spacing = size / np.sqrt(covers)
    lags = np.arange(0, FAR * spacing, STEP * diameter)
    curve = radial(ink[part], lags, page.pixel * coarse, region[part])
    drift = max(0.0, float(curve[lags > REACH * spacing].mean()))
    kept = lags <= REACH * spacing
    return Level(covers, lags[kept], (curve[kept] - drift) / (1 - drift))


def _white(darkness: Array, page: Page) -> tuple[tuple[Glyph, tuple[int, int]], ...]:
    """The single white marks of a page, and the pixel that each lies on."""
    light = np.clip(1 - darkness / max(float(np.median(darkness[page.ink])), 1e-3), 0, 1).astype(np.float32)
    dots, _ = sorted_out(light, 0.5, page.pixel)
    found = []
    for dot in dots:
        ring, _ = fitted(dot.contour, STRAY / page.pixel)
        x, y = dot.contour.mean(axis=0) + dot.corner
        found.append((Glyph.of(Paths.of([ring * page.pixel], cubic=True)), (int(y), int(x))))
    return tuple(found)


def _evenly(count: int) -> list[int]:
    """Which of so many marks to keep, BANK at most, evenly chosen over the page."""
    return list(range(count)) if count <= BANK else [k * count // BANK for k in range(BANK)]
