"""Cells: a drawing of lines alone, the Voronoi cells of stippled sites or their Delaunay net, closer where it is darker.

Sites are as dense as lines of the pen's width around their cells need to be, and relaxed as in stippling.
Source: F. Aurenhammer, Voronoi Diagrams, ACM Computing Surveys 23(3), 1991; A. Secord, Weighted Voronoi
Stippling, NPAR 2002, for where the sites lie.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import hilbert, raster, relax
from crowquill.knobs import Choice, Flag, Range
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, cut_white, expected_seconds, settled, widest
from crowquill.styles import Work
from crowquill.tone import Tone

INKS = False  # lines through all of the canvas
PEN = 0.15  # mm, between the fine technical pens of 0.13 and 0.18
CAP = 0.85  # coverage; the white left in a cell is then 0.6 of the line's width across
ROUNDS = 3  # of drawing, at most
CLOSE = 0.005  # of the ink; nearer, no other round is made
REGULAR = {False: 0.971, True: 0.986}  # of the sites of regular cells, or net, that cover as much: relaxed ones are a little longer about


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "line width (0.15mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of cells, however much ink their lines are")] = None,
    net: Annotated[bool, Flag("draw the triangles between sites in place of the cells around them")] = False,
    iterations: Annotated[int, Range(0, 100_000, "", "most relaxation steps")] = 15,
    until: Annotated[float, Range(0, 1, "", "stop when sites move less, in spacings; 0 never")] = 0.0,
    start: Annotated[str, Choice(relax.STARTS, "where sites begin")] = "levels",
    white: Annotated[float, Range(0, 1, "", "no lines where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size with one layer of black lines, each edge once, in the order of a Hilbert curve.

    Lines end at the canvas, whose own outline is not drawn, and where they run out on pixels below the white cutoff, to
    half a pixel; one that crosses white is drawn if no more than half of it is white. Ink is what is asked up to a
    coverage of 0.85, and the report has `coverage_missing`. Where the first drawing is off by more than half a percent,
    as its borders make it, others follow with more or fewer sites, three at most; with `dots` there is one.
    No ink, or less than two cells take, gives an empty sheet and a warning.
    Raises ValueError for more than max_dots and for a pen wider than the canvas.
    """
    clock = Clock()
    asked, blank = cut_white(tone, white)
    width = widest(tone, pen, PEN)
    demand, wanted = _planned(asked, width, net)
    reached = asked.mapped(lambda c: np.minimum(c, CAP)).ink
    count = wanted if dots is None else dots if wanted else 0
    if count > max_dots:
        raise ValueError(
            f"the picture takes {count} cells, over the limit of {max_dots}; draw it smaller, use a wider pen, or raise max-dots"
        )
    yield Step("plan", 0, 1, {"dots": count, "pen_mm": width, "seconds": 2 * expected_seconds(count, iterations)})
    tried: list[tuple[int, float]] = []
    for chance in rng.spawn(ROUNDS):
        state = yield from settled(demand, count, chance, clock, start=start, iterations=iterations, until=until, banned=blank)
        lines = _lines(state, tone, blank, width, net)
        yield Step("measure", 0, 1)
        ink = inked(lines, width)
        clock.lap("measure")
        tried.append((count, ink))
        if dots is not None or not ink or abs(ink / reached - 1) <= CLOSE:
            break
        count = min(_corrected(tried, reached), max_dots)
    report: dict[str, Any] = {
        "marks": len(lines),
        "cells": len(state.sites),
        "pen_mm": width,
        "length_mm": float(np.hypot(*(lines.xy[::2] - lines.xy[1::2]).T).sum()),
        "ink_asked_mm2": asked.ink,
        "ink_placed_mm2": ink,
        "coverage_missing": max(0.0, 1 - ink / asked.ink) if asked.ink else 0.0,
        "iterations": state.done,
        "energy": state.energy,
        "movement": state.movement,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(report, dots)
    if tone.importance is not None:
        report["warnings"].append("importance is not heeded: lines of one pen leave nothing to choose; stippling heeds it")
    return Sheet(tone.size, (Layer(Ink(pen=width), lines, "net" if net else "cells"),), report=report)


def _planned(asked: Tone, pen: float, net: bool) -> tuple[Tone, int]:
    """Where sites go, as a tone over its densest, and how many the ink takes: two at least where there is as much as a dot.

    Lines of width w around regular cells of inradius r leave (1 - w / 2r)^2 white, around regular triangles too. A cell
    has an area of 2 sqrt(3) r^2, and the two triangles that a site has three times as much. As in stippling,
    the tone around decides how many, and the pixel its share.
    """
    from scipy.ndimage import gaussian_filter

    def density(c: Any) -> Any:
        r = pen / 2 / (1 - np.sqrt(1 - c))
        return REGULAR[net] / (2 * np.sqrt(3) * r**2) / (3 if net else 1)

    sigma = [3 * pen / side for side in reversed(asked.pixel)]  # about the radius of a cell of medium tone
    near = np.clip(gaussian_filter(np.minimum(asked.coverage, CAP), sigma, mode="nearest", truncate=3.0), 1e-4, CAP)
    crowd = density(near) / near * np.minimum(asked.coverage, CAP)
    most = max(float(crowd.max()), float(np.finfo(float).tiny))
    demand = Tone(crowd / most, asked.size, asked.canvas)
    sites = round(demand.ink * most)
    return demand, max(2, sites) if asked.ink > pen**2 else 0


def _corrected(tried: list[tuple[int, float]], reached: float) -> int:
    """How many sites should give the ink to be reached, after the numbers tried and the ink that each gave.

    Coverage rises about as the 2.3rd root of the number of sites, as tried twice where it has been; no step is over 2.
    """
    (count, ink), root = tried[-1], 2.3
    if len(tried) > 1 and tried[-2][1] != ink:
        root = float(np.clip(np.log(count / tried[-2][0]) / np.log(ink / tried[-2][1]), 0.8, 3))
    return max(2, round(count * float(np.clip((reached / ink) ** root, 0.5, 2))))


def _lines(state: relax.State, tone: Tone, blank: npt.NDArray[np.bool_], pen: float, net: bool) -> Paths:
    """The edges on the canvas where it is not white, in whole micrometres; those of no length are left out."""
    ends = state.sites[state.cells.pairs] if net or state.cells.net is None else state.cells.net.edges[1]
    edges = shapely.linestrings(ends)
    whole = shapely.contains_properly(tone.canvas, edges)
    parts = shapely.get_parts(shapely.intersection(edges[~whole], tone.canvas))
    parts = parts[(shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING) & (shapely.length(parts) > 0)]
    clipped = shapely.get_coordinates(parts).reshape(-1, 2, 2)
    ends = np.round(_off_white(np.concatenate([ends[whole], clipped]), tone, blank, pen), 3)
    ends = ends[(ends[:, 0] != ends[:, 1]).any(axis=1)]
    ends = ends[hilbert.of_points(ends.mean(axis=1))]
    return Paths(ends.reshape(-1, 2), np.arange(0, 2 * len(ends) + 1, 2), closed=False)


def _off_white(ends: Array, tone: Tone, blank: npt.NDArray[np.bool_], pen: float) -> Array:
    """Edges (n, 2, 2) without their ends on white, and without those of which more than half is on white even so.

    They are looked at every half pixel, or quarter of the pen where pixels are finer.
    """
    along = ends[:, 1] - ends[:, 0]
    count = np.maximum(1, np.ceil(np.hypot(*along.T) / max(min(tone.pixel) / 2, pen / 4))).astype(np.int64)
    edge = np.repeat(np.arange(len(ends)), count)
    place = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    drawn = ~blank[tone.under(ends[edge, 0] + along[edge] * ((place + 0.5) / count[edge])[:, None])]
    edge, place = edge[drawn], place[drawn]
    first, last, held = count.copy(), np.full(len(ends), -1), np.bincount(edge, minlength=len(ends))
    np.minimum.at(first, edge, place)
    np.maximum.at(last, edge, place)
    kept = 2 * held >= np.maximum(1, last + 1 - first)
    low, high = (first / count)[kept, None], ((last + 1) / count)[kept, None]
    return np.stack([ends[kept, 0] + along[kept] * low, ends[kept, 0] + along[kept] * high], axis=1)


def inked(lines: Paths, pen: float) -> float:
    """The area that lines of a pen cover together, mm^2, within about 1e-4 of many, 1e-3 of one."""
    if not len(lines):
        return 0.0
    low, high = lines.xy.min(axis=0) - pen, lines.xy.max(axis=0) + pen
    pixel = max(pen, float(np.sqrt(np.prod(high - low) / 4e7)))
    columns, rows = np.ceil((high - low) / pixel).astype(int)
    moved = lines.moved(np.eye(2), -low)
    cover = raster.covered(moved, (rows, columns), pixel=(pixel, pixel), pen=pen, lines=max(16, round(32 * pixel / pen)))
    return float(cover.sum()) * pixel**2


def _warnings(report: dict[str, Any], dots: int | None) -> list[str]:
    """What is to be said of the ink."""
    if not report["ink_asked_mm2"]:
        return ["no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on"]
    if not report["marks"] and dots is not None:
        return [f"no lines: {dots} cells have no edge between them that is not over white; more would"]
    if not report["marks"]:
        return [f"no lines: all the ink is less than two cells of {report['pen_mm']:.4g} mm lines take; a finer pen would draw it"]
    missing = report["coverage_missing"]
    if missing > 0.02:
        wish = f"a wider pen or lighter tones would help, {CAP} is the most lines cover" if dots is None else "more cells would help"
        return [f"{missing:.1%} of the ink asked for is not reached; {wish}"]
    return []
