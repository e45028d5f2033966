"""Halftone: squares of one size, black or white, set by error diffusion or over thresholds; as pixels, outlines or dots.

Each square, a cell, takes the mean of the picture under it, and the method decides which are black.
Source: R. Ulichney, Digital Halftoning, MIT Press 1987; V. Ostromoukhov, A Simple and Efficient Error-Diffusion
Algorithm, SIGGRAPH 2001; the others in crowquill.halftone.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from crowquill import glyphs as libraries
from crowquill import halftone, measure
from crowquill.grid import BLOCK, Grid
from crowquill.halftone.borders import corners, rings
from crowquill.knobs import Choice, Flag, Range, Text
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Art, Bitmap, Ink, Layer, Sheet, Shown, Step
from crowquill.stippling import Clock, dotted, snapped
from crowquill.styles import Work
from crowquill.tone import Tone
from crowquill.units import INCH

EITHER = ("cell", "cells_per_inch")  # of which one is enough
FORMS = ("auto", "pixels", "polygons", "dots")
CELL = 0.3  # mm: as wide as the commonest technical pen, and seen at arm's length
CORNERS = 3_000_000  # of outlines: some 20 MB of SVG, more than editors bear
MOST = 2_000_000_000  # cells; a bitmap format takes no more bits
RATE = 2e7  # cells a second, about, of a machine of 2024
Bits = npt.NDArray[np.bool_]


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    method: Annotated[str, Choice(halftone.METHODS, "how cells become black")] = halftone.DEFAULT,
    serpentine: Annotated[bool, Flag("error diffusion to and fro, not each row from the left")] = True,
    cell: Annotated[float | None, Range(0.005, 50, "mm", "side of a cell (0.3mm)")] = None,
    cells_per_inch: Annotated[float | None, Range(0.5, 5080, "", "the same, as the dpi of a device")] = None,
    form: Annotated[
        str, Choice(FORMS, "what is drawn; auto is pixels for PNG and TIFF alone, else polygons while these have few corners")
    ] = "auto",
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the cell)", file=True)] = None,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size with one layer of black: cells whose centre is in the canvas, their grid in the picture's middle.

    pixels    a bitmap of exactly these cells, which PNG and TIFF of its own dpi copy bit by bit
    polygons  outlines of cells that share a side, as one, so that no seam shows; up to CORNERS corners
    dots      a glyph in the middle of each black cell, of the cell's area; the report has the ink lost where they overlap

    As many cells are drawn as come nearest to the picture's sides, so that the outermost may hang over by half of one. Tone is
    kept but for `threshold` and `atkinson`; the report has `coverage_missing`, and `tone_error`, the root mean square
    of what blocks of 8 x 8 cells are off. No ink gives an empty sheet and a warning. Raises ValueError for two sizes of the
    cell, one larger than the canvas, and more cells, corners or dots than files bear.
    """
    clock = Clock()
    grid = _planned(tone, cell, cells_per_inch)
    dots = round(tone.ink / grid.cell**2) if form == "dots" else 0
    if dots > max_dots:
        raise ValueError(f"the picture takes {dots} dots, over the limit of {max_dots}; use larger cells, or raise max-dots")
    library = libraries.load(glyphs) if glyphs else None
    facts = {"cells": grid.columns * grid.rows, "cell_mm": grid.cell, "seconds": round(1 + grid.columns * grid.rows / RATE, 1)}
    yield Step("plan", 0, 1, {**facts, "dots": dots} if dots else facts)
    chance = rng.spawn(2)
    bitmap, error = yield from _black(grid, method, chance[0], serpentine)
    clock.lap("halftone")
    yield Step("draw", 0, 1)
    ink, overlap = len(bitmap) * grid.cell**2, 0.0
    art: Art = bitmap
    if form == "dots":
        art = _dots(bitmap, grid, library, chance[1])
        own, ink = float((art.scale**2).sum()), measure.ink(art)
        overlap = 1 - ink / own if own else 0.0
    elif form != "pixels":
        art = _outlined(bitmap, form)
    clock.lap("draw")
    report: dict[str, Any] = {
        "marks": len(art),
        "method": method,
        "cell_mm": grid.cell,
        "dpi": grid.dpi,
        "cells": grid.columns * grid.rows,
        "black": len(bitmap),
        "ink_asked_mm2": tone.ink,
        "ink_placed_mm2": ink,
        "coverage_missing": max(0.0, 1 - ink / tone.ink) if tone.ink else 0.0,
        "overlap": overlap,
        "tone_error": error,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(report, tone)
    return Sheet(tone.size, (Layer(Ink(), art, "halftone"),), report=report)


def suited(values: Mapping[str, Any], files: Sequence[Shown]) -> dict[str, Any]:
    """The knobs for these files: pixels where all are of pixels, as outlines would be made into pixels of another size."""
    return {**values, "form": "pixels"} if values.get("form") == "auto" and all(file.pixels for file in files) else dict(values)


def _planned(tone: Tone, cell: float | None, cells_per_inch: float | None) -> Grid:
    """The grid for a size of cells, or for the usual one, as fine as the canvas is narrow."""
    if cell is not None and cells_per_inch is not None:
        raise ValueError(f"cell {cell:g} mm and cells-per-inch {cells_per_inch:g} are both given; leave one out")
    least = tone.across
    given = INCH / cells_per_inch if cells_per_inch else cell
    side = min(CELL, least) if given is None else given
    if side > least:
        raise ValueError(f"a cell of {side:.4g} mm is wider than the canvas of {least:.4g} mm; use smaller ones")
    grid = Grid.of(tone, side, cells_per_inch)
    if grid.columns * grid.rows > MOST:
        raise ValueError(
            f"a cell of {side:.4g} mm makes {grid.columns} x {grid.rows} cells of this picture, over the limit of "
            f"{MOST // 1_000_000} million; use larger ones"
        )
    return grid


def _black(grid: Grid, method: str, rng: np.random.Generator, serpentine: bool) -> Generator[Step, None, tuple[Bitmap, float]]:
    """Steps of a bitmap under way, band by band, and then it and the root mean square of what blocks of its cells are off."""
    under_way: list[tuple[Array, Bits]] = []

    def rows() -> Iterator[Array]:
        for top in range(0, grid.rows, grid.band):
            under_way.append(grid.asked(top, min(grid.rows, top + grid.band)))
            yield under_way[-1][0]

    bits, top, off, blocks = np.empty((grid.rows, -(-grid.columns // 8)), np.uint8), 0, 0.0, 0
    for black in halftone.bands(rows(), method, rng=rng, serpentine=serpentine):
        coverage, held = under_way.pop()
        black &= held
        bits[top : top + len(black)] = np.packbits(black, axis=1)
        error, known = _in_blocks(black - coverage), _in_blocks(held)
        off, blocks = off + float((error**2).sum()), blocks + int((known > 0).sum())
        top += len(black)
        yield Step("halftone", top, grid.rows)
    return Bitmap(bits, grid.columns, grid.dpi, grid.corner), float(np.sqrt(off / max(1, blocks)))


def _in_blocks(values: npt.NDArray[Any]) -> Array:
    """Means over blocks of cells; those at the right and the lower edge count what they lack as 0."""
    h, w = (-(-side // BLOCK) for side in values.shape)
    whole = np.zeros((h * BLOCK, w * BLOCK), values.dtype)
    whole[: values.shape[0], : values.shape[1]] = values
    return np.asarray(whole.reshape(h, BLOCK, w, BLOCK).mean(axis=(1, 3)))


def _bands(bitmap: Bitmap) -> Iterator[Bits]:
    """The bitmap's rows, some at a time."""
    step = max(1, halftone.BAND // bitmap.width)
    return (bitmap.rows(top, top + step) for top in range(0, len(bitmap.bits), step))


def _outlined(bitmap: Bitmap, form: str) -> Paths | Bitmap:
    """The outlines of black pixels; where they have too many corners the bitmap itself, or a ValueError where only they will do."""
    if corners(_bands(bitmap), CORNERS) > CORNERS:
        if form == "auto":
            return bitmap
        raise ValueError(
            f"outlines of cells of {INCH / bitmap.dpi:.4g} mm have over {CORNERS} corners, more than files bear; use larger ones, or pixels"
        )
    return rings(_bands(bitmap)).moved(INCH / bitmap.dpi * np.eye(2), bitmap.corner)


def _dots(bitmap: Bitmap, grid: Grid, library: libraries.Library | None, rng: np.random.Generator) -> Marks:
    """A glyph of a cell's area in the middle of each black cell."""
    sites = grid.centres(*np.nonzero(bitmap.rows(0, grid.rows)))
    sites, kept = snapped(sites, grid.tone, np.zeros(grid.tone.coverage.shape, bool))
    width = 2 * grid.cell / float(np.sqrt(np.pi))
    library = library or libraries.load(libraries.nearest(width))
    return dotted(sites[kept], library.glyphs, width, rng)


def _warnings(report: dict[str, Any], tone: Tone) -> list[str]:
    """What is to be said of the ink, and of importance."""
    asked, placed, method, said = report["ink_asked_mm2"], report["ink_placed_mm2"], report["method"], []
    if not asked:
        said.append("no ink: the picture is white where it may be drawn on")
    elif not report["marks"]:
        said.append(f"no cell is black: there is too little ink for one of {report['cell_mm']:.4g} mm; smaller ones would draw it")
    elif method not in halftone.KEEPING:
        said.append(f"{method} does not keep tone: {placed / asked:.1%} of the ink asked for is placed; {halftone.DEFAULT} would keep it")
    elif report["coverage_missing"] > 0.02:
        wish = "polygons lose none where dots overlap" if report["overlap"] > 0.01 else "smaller cells would help"
        said.append(f"{report['coverage_missing']:.1%} of the ink asked for is not reached; {wish}")
    if tone.importance is not None:
        said.append("importance is not heeded: cells are all of one size; stippling heeds it")
    return said
