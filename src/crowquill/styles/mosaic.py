"""Mosaic: a picture in stones that follow its edges, with grout of one width between them, each stone of the picture's colour there.

Source: A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001; G. Di Blasi, G. Gallo, Artificial Mosaics, The Visual
Computer 21(6), 2005; S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import shapely

from crowquill import field, laying, parting, tesserae, vector
from crowquill import tiles as cutting
from crowquill.knobs import Choice, Flag, Range, Text
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, Step, in_process
from crowquill.stippling import Clock, cut_white, importance
from crowquill.styles import Work
from crowquill.tesserae import Ground, Progress
from crowquill.tiles import Stones
from crowquill.tone import Tone

COLOUR = True  # the picture's colours are wanted along with its tone
INK = 2.0  # stones in colours cover the canvas however light it is: not their area but their colour is the tone
TILE = 3.0  # mm
FINEST = 0.05  # mm
COARSEST = 20  # tiles to the side of a square as large as the canvas, at least, where nothing is said
GROUT = 0.1  # of a tile
ROUNDS = 3  # of cutting; after each slivers go, and the others are cut anew in the room that leaves
FILLED = 2  # rounds of filling hollows
EDGE = 0.5  # of a tile: the blur through which edges are found
FAINT = 1e-4  # of ink; a stone of less is white paper
ROUNDING = 1e-9  # of a mean of coverage
LENGTH = 3.0  # tiles: shorter edges are left out


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    mode: Annotated[str, Choice(tuple(laying.WAYS), "squares by Hausner or by Lloyd, in rows, or irregular cells")] = "hausner",
    tile: Annotated[float | None, Range(0.05, 500, "mm", "side of a stone; decides their number (3mm)")] = None,
    tiles: Annotated[int | None, Range(1, 100_000_000, "", "number of stones; decides their size")] = None,
    grout: Annotated[float | None, Range(0, 100, "mm", "width of the grout (a tenth of a tile)")] = None,
    aspect: Annotated[float, Range(0.2, 5, "", "length of stones along the rows over their width")] = 1.0,
    edges: Annotated[str, Text("what rows follow beside the canvas's outline: found, none, or an SVG of lines", file=True)] = "found",
    grow: Annotated[float, Range(0.5, 1.5, "", "how large stones begin before they are cut, over what fits; below 1 leaves gaps")] = 1.3,
    palette: Annotated[str | None, Text("colours to choose from: #aa3322,#e8e0d0, a file of such, or a GIMP palette", file=True)] = None,
    one_ink: Annotated[bool, Flag("stones of one ink, as large as the tone asks, in place of colours")] = False,
    iterations: Annotated[int, Range(0, 100_000, "", "relaxation steps")] = 20,
    white: Annotated[float, Range(0, 1, "", "no stones where coverage is below on the mean")] = 0.02,
    max_tiles: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 200_000,
) -> Work:
    """A sheet the tone's size with one layer of stones as filled rings, each with a colour of its own, or all in black.

    mode      "hausner": squares by a metric of squares; "lloyd": whole squares that settle; "rows": along lines at even distances
              from the edges, without relaxation; "cells": Voronoi cells of relaxed sites, less half a grout all around
    grout     kept between any two stones and, by half, to edges and the canvas's outline, in the files too
    edges     "found": as by Canny, through a blur of half a tile; an SVG is laid over the drawing
    one_ink   each stone shrinks to the ink asked for in its surroundings; what is too dark is `coverage_missing`; of stones in
              colours, which cover all, that is 0, and ink asked for and placed are not to be compared

    Colours are means over each stone of the light, or, without colours in the tone, of its coverage as grey. Importance of the
    tone makes stones finer, by half to twice. Slivers under 0.3 of a stone are left out and counted; hollows get stones of
    their own. White pictures give no stones and a warning. Raises ValueError for stones larger than the canvas, a
    grout as wide as they are, tile with tiles, palette with one_ink, and over max_tiles.
    """
    clock = Clock()
    colours = None if palette is None else cutting.palette(palette)
    if palette is not None and one_ink:
        raise ValueError(f"palette {palette!r} is of no use with one-ink; leave one out")
    asked, _ = cut_white(tone, white)
    ground = laid_out(tone, tile, tiles, grout, aspect, edges)
    _, count = ground.crowd(tone)
    if count > max_tiles:
        raise ValueError(f"the picture takes {count} stones, over the limit of {max_tiles}; use larger ones, or raise max-tiles")
    yield Step("plan", 0, 1, {"tiles": count, "tile_mm": ground.mean - ground.gap, "seconds": 1 + 2e-3 * count})
    clock.lap("plan")
    state = yield from _placed(ground, tone, mode, iterations, rng)
    clock.lap("place")
    yield Step("cut", 0, 1)
    stones, nominal, slivers = cut(ground, state, grow)
    clock.lap("cut")
    yield Step("colour", 0, 1)
    rings = cutting.rings_of(stones)
    fill = painted(rings, tone, one_ink)
    drawn = cutting.means(rings, tone.coverage, tone.size) >= white - ROUNDING
    kept = np.flatnonzero(drawn & (fill.max(axis=1) >= FAINT) & (rings.areas > 0))
    rings, nominal, fill = rings.take(kept), nominal[kept], fill[kept]
    if one_ink:
        rings = cutting.shrunk(rings, _due(ground, rings, asked))
        kept = np.flatnonzero(rings.areas > 0)
        rings, nominal = rings.take(kept), nominal[kept]
    fill = fill if colours is None else in_process(cutting.matched(cutting.colours(rings, tone), colours))
    layer = Layer(Ink(), rings, "stones", None if one_ink else fill)
    clock.lap("colour")
    report = {"mode": mode, **_measured(rings, nominal, ground, asked.ink, one_ink), "slivers": slivers}
    report |= {"iterations": state.done, "energy": state.energy, "movement": state.movement}
    clock.lap("measure")
    report |= {"seconds": clock.laps, "warnings": _warnings(report, ground, edges, colours)}
    return Sheet(tone.size, (layer,), report=report)


def laid_out(tone: Tone, tile: float | None, count: int | None, grout: float | None, aspect: float, edges: str) -> Ground:
    """The ground of a tone for tiles of a size or a number, with its edges."""
    if tile is not None and count is not None:
        raise ValueError(f"tile {tile:g} mm and tiles {count} are both given; leave one out")
    area, wish = float(shapely.area(tone.canvas)), importance(tone)
    root = np.sqrt(np.array([aspect, 1 / aspect]))
    side = float(np.clip(np.sqrt(area) / COARSEST, FINEST, TILE)) if tile is None else tile
    if count is not None:
        weight = area if wish is None else float((wish**2 * tone.inside).sum() * np.prod(tone.pixel))
        side = np.sqrt(weight / count)
        side -= grout if grout is not None else side * GROUT / (1 + GROUT)
    gap = GROUT * float(side) if grout is None else grout
    left, top, right, bottom = shapely.bounds(tone.canvas)
    if gap >= side * root.min():
        raise ValueError(f"grout {gap:.4g} mm is as wide as the stones of {max(side, 0) * root.min():.4g} mm; take less")
    if tile is not None and (side > max(right - left, bottom - top) or side**2 > area):
        raise ValueError(f"tile {side:g} mm is larger than the canvas of {right - left:.4g} x {bottom - top:.4g} mm; take smaller ones")
    ways = {"found": lambda: _found(tone, side), "none": lambda: Paths.of([], closed=False)}
    lines = ways.get(edges, lambda: _drawn(edges, tone.size))()
    return Ground(tone.canvas, tone.size, _plain(lines, side / 50), side * root + gap, gap, wish)


def _found(tone: Tone, side: float) -> Paths:
    """The edges of a tone, and of its colours where it has some, that are long beside tiles of so many mm.

    Colours are looked at along the line on which they spread most in CIE Lab; of the tone's own edges those come along
    that do not run within a tile of one of colour.
    """
    tone = _coarser(tone, EDGE * side / 4)
    own = field.edges(tone, EDGE * side, least=LENGTH * side)
    if tone.rgb is None or not np.ptp(tone.rgb.reshape(-1, 3), axis=0).any():
        return own
    seen = cutting.lab(tone.rgb.reshape(-1, 3).astype(np.float64))
    axis = np.linalg.eigh(np.cov(seen.T))[1][:, -1]
    along = (seen - seen.mean(axis=0)) @ axis / 100
    of_colour = field.edges(tone.holding(np.clip(0.5 + along.reshape(tone.shape), 0, 1)), EDGE * side, least=LENGTH * side)
    lines = [shapely.LineString(line) for line in of_colour]
    rest = shapely.difference([shapely.LineString(line) for line in own], shapely.buffer(shapely.union_all(lines), side))
    rest = [line for line in shapely.get_parts(rest) if line.length >= LENGTH * side]
    return Paths.of([shapely.get_coordinates(line) for line in [*lines, *rest]], closed=False)


def _coarser(tone: Tone, pixel: float) -> Tone:
    """Means of a tone and of its colours on pixels of so many mm, where its own are finer."""
    from PIL import Image

    h, w = tone.coverage.shape
    grid = max(1, min(w, round(tone.size[0] / pixel))), max(1, min(h, round(tone.size[1] / pixel)))
    ink = Image.fromarray(tone.coverage.astype(np.float32)).resize(grid, Image.Resampling.BOX)
    rgb = None if tone.rgb is None else np.asarray(Image.fromarray(tone.rgb).resize(grid, Image.Resampling.BOX))
    return Tone(np.clip(np.asarray(ink, np.float64), 0, 1), tone.size, rgb=rgb)


def _drawn(file: str, size: tuple[float, float]) -> Paths:
    """The lines of an SVG file, its page laid over a rectangle of this size in mm, as open lines."""
    if not Path(file).suffix:
        raise ValueError(f"no edges {file!r}; there are found and none, or give an SVG file")
    page, found = vector.shapes(vector.contents(Path(file)), file)
    if min(page) <= 0 or not found:
        raise ValueError(f"{file}: has no lines for stones to follow; draw some on a page the shape of the picture")
    scale = np.array(size) / page
    flat = [(paths.flat(1e-4 * max(page)), paths.closed) for paths, _ in found]
    return Paths.of([(line[[*range(len(line)), 0]] if ring else line) * scale for paths, ring in flat for line in paths], closed=False)


def _plain(lines: Paths, fine: float) -> Paths:
    """The same lines with no more corners than to stay within so many mm; those of no length are left out."""
    kept = shapely.simplify([shapely.LineString(line) for line in lines if len(line) > 1], fine)
    return Paths.of([shapely.get_coordinates(line) for line in kept if line.length > 0], closed=False)


def _placed(ground: Ground, tone: Tone, mode: str, iterations: int, rng: np.random.Generator) -> Generator[Step, None, Progress]:
    """Steps of tiles being placed; returns the last state."""
    for state in laying.WAYS[mode](ground, tone, iterations, rng):
        yield Step("place", min(state.done, iterations), iterations, {"energy": state.energy, "movement": state.movement})
        if state.done >= iterations:
            break
    return state


def cut(ground: Ground, state: Progress, grow: float) -> tuple[Stones, Array, int]:
    """Stones cut off edges and canvas and apart, with those that fill hollows; each one's area uncut; how many slivers went."""
    placed, slivers = state.tiles, 0
    full = _off(ground, placed.stones(grow) if state.cells is None else state.cells)
    stones, kept = full, np.ones(len(full), bool)
    nominal, angle = placed.sides.prod(axis=1), placed.angle
    for _ in range(ROUNDS):
        kept = shapely.area(stones) >= cutting.LEAST * nominal
        slivers += int((~kept).sum())
        full, nominal, angle = full[kept], nominal[kept], angle[kept]
        stones = parting.parted(shapely.convex_hull(full), angle, ground.gap)
    for _ in range(FILLED):
        stones = parting.grown(stones, shapely.convex_hull(full), angle, ground.gap)
        kept = shapely.area(stones) >= cutting.LEAST * nominal
        slivers += int((~kept).sum())
        more = ground.tiles(tesserae.hollows(ground, stones[kept]))
        extra = _off(ground, more.stones(grow))
        full = np.concatenate([full[kept], extra])
        nominal, angle = np.concatenate([nominal[kept], more.sides.prod(axis=1)]), np.concatenate([angle[kept], more.angle])
        stones = np.concatenate([stones[kept], np.full(len(extra), shapely.Polygon(), dtype=object)])
    stones = parting.grown(stones, shapely.convex_hull(full), angle, ground.gap)
    stones = cutting.largest(shapely.intersection(stones, full))
    kept = shapely.area(stones) >= cutting.LEAST * nominal
    return stones[kept], nominal[kept], slivers + int((~kept).sum())


def _off(ground: Ground, stones: Stones) -> Stones:
    """Stones cut off edges and canvas."""
    return cutting.held(cutting.severed(stones, ground.lines, ground.gap), ground.canvas, ground.gap, ground.mean / 50)


def _due(ground: Ground, rings: Paths, asked: Tone) -> Array:
    """The ink asked for on the places that are nearest to each ring, mm^2: all of the canvas's together."""
    from scipy.ndimage import distance_transform_edt

    x, y = np.meshgrid(*ground.places)
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    place, ring = shapely.STRtree(rings.polygons()).query(shapely.points(places), predicate="intersects")
    owner = np.full(ground.grid, -1)
    owner.ravel()[place] = ring
    if not len(place):
        return np.zeros(len(rings))
    nearest = distance_transform_edt(owner < 0, sampling=ground.pixel[::-1], return_distances=False, return_indices=True)
    ink = np.where(ground.inside.ravel(), asked.at(places), 0.0)
    due = np.bincount(owner[tuple(nearest)].ravel(), ink, len(rings))
    return np.asarray(due * asked.ink / max(due.sum(), np.finfo(float).tiny))


def painted(rings: Paths, tone: Tone, one_ink: bool) -> Array:
    """Shares of process inks (n, 4) in which each ring shows what the tone, or its colours, have there."""
    if tone.rgb is not None and not one_ink:
        return in_process(cutting.colours(rings, tone))
    ink = cutting.means(rings, tone.coverage, tone.size)
    return np.concatenate([np.zeros((len(ink), 3)), ink[:, None]], axis=1)


def _measured(rings: Paths, nominal: Array, ground: Ground, asked: float, one_ink: bool) -> dict[str, Any]:
    """What is reported of stones: how many and how large, what lies between them, and their ink."""
    overlap, nearest = cutting.met(rings)
    placed = float(rings.areas.sum())
    return {
        "marks": len(rings),
        "tile_mm": float(np.sqrt(nominal.mean())) if len(rings) else ground.mean - ground.gap,
        "grout_mm": ground.gap,
        "grout_least_mm": nearest if np.isfinite(nearest) else ground.gap,
        "coverage": placed / float(shapely.area(ground.canvas)),
        "overlap_mm2": overlap,
        "ink_asked_mm2": asked,
        "ink_placed_mm2": placed,
        "coverage_missing": max(0.0, 1 - placed / asked) if asked and one_ink else 0.0,
    }


def _warnings(report: dict[str, Any], ground: Ground, edges: str, palette: Array | None) -> list[str]:
    """What is to be said of edges, colours and ink."""
    said = []
    if not report["ink_asked_mm2"]:
        return ["no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on"]
    if not report["marks"]:
        return [f"no stones: none of {report['tile_mm']:.4g} mm finds room, or all are lighter than the white cutoff; take smaller ones"]
    if not len(ground.lines) and edges == "found":
        said.append("no edges were found: stones follow the canvas's outline; draw some in an SVG file to be followed")
    if palette is not None and len(palette) == 1:
        said.append("a palette of one colour shows no picture; give more, or one-ink for stones sized by tone")
    if report["coverage_missing"] > 0.02:
        said.append(f"{report['coverage_missing']:.1%} of the ink asked for is not reached; less grout or lighter tones would help")
    return said
