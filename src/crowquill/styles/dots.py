"""Halftone dots: one to each square of a turned lattice, as large as the ink there, as presses print pictures.

Dots meet, overlap and close up; their sizes make up for it, to full black.
Source: R. Ulichney, Digital Halftoning, MIT Press 1987, for clustered dots; Green's theorem for the ink of each square.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import shapely

from crowquill import glyphs, measure, moments, raster
from crowquill.cells import Cells
from crowquill.knobs import Numbers, Range, Text
from crowquill.marks import Glyph, Marks
from crowquill.paths import Array, Index, Paths
from crowquill.screening import Ground, Lattice, Wave, contoured, inked, joined, phases, ruling
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, snapped
from crowquill.styles import Work
from crowquill.tone import Tone
from crowquill.units import INCH

EITHER = ("lpi", "pitch")  # of which one is enough: who types one means to do without what a recipe has of the other
SHAPES = ("round", "euclidean", "ellipse", "diamond")
LONG = 1.3  # the length of an ellipse over its width
ANGLE = 45.0  # degrees, at which rows are seen least
AREAS = np.arange(0.0, 3.01, 0.02)  # of a dot over its square: irregular ones close up beyond 2
ROWS = 64  # of the lattice looked at together
CLOSED = 1e-4  # of the paper: less white between dots is none


def turned(knobs: Mapping[str, Any], by: float) -> dict[str, Any]:
    """The knobs of the same lattice turned by so many degrees: for one ink of several."""
    return {**knobs, "angle": (knobs.get("angle", ANGLE) + by + 90) % 180 - 90}


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    lpi: Annotated[float | None, Range(0.25, 1270, "", "dots to the inch, along their rows (50)")] = None,
    pitch: Annotated[float | None, Range(0.02, 101.6, "mm", "from dot to dot, in place of lpi")] = None,
    angle: Annotated[float, Range(-180, 180, "", "degrees in which rows run, clockwise from level")] = ANGLE,
    phase: Annotated[tuple[float, ...] | None, Numbers(0, 1, "", "where the lattice lies, in pitches (by seed)", 2)] = None,
    shape: Annotated[
        str,
        Text("round, euclidean, ellipse, diamond, or a library: a name or an SVG file; all but euclidean hang over the edge", file=True),
    ] = "round",
    min_dot: Annotated[float, Range(0, 10, "mm", "least diameter that prints; smaller dots are left out")] = 0.03,
) -> Work:
    """A sheet the tone's size with one layer of black dots, of which each covers what its own square of the lattice asks for.

    shape    "round" overlaps from 0.785 on, "diamond" makes a checkerboard at one half, "ellipse" joins to chains first; dots of
             a library are turned at random. "euclidean" is round, at one half a checkerboard, and in the shadows all ink but for
             round holes: outlines cut at the canvas, which follow the tone inside their squares too; all others are marks
    canvas   a square that it cuts has a dot of the ink of its part, at its middle where that lies on the canvas, and
             at the part's own otherwise. Dots at the edge are whole, and hang over it by up to half their width; those of
             "euclidean" are cut
    min_dot  the report has what smaller dots would have held, mm^2 and share
    no ink   an empty sheet and a warning. Raises ValueError for lpi and pitch together, a ruling too fine for the canvas or for
             min_dot, and an unknown shape
    """
    clock = Clock()
    p = ruling(lpi, pitch, tone)
    largest = p * 2 / np.sqrt(np.pi)  # of a dot that has all of its square
    if largest < min_dot:
        raise ValueError(
            f"a pitch of {p:.4g} mm has no dots over {largest:.2g} mm, and min-dot is {min_dot:g} mm; take a coarser ruling, or less"
        )
    library = None if shape == "euclidean" else _glyphs(shape)
    chance = rng.spawn(2)
    shift = phases(phase, 2, chance[0])
    lattice = Lattice.of((angle, angle + 90), p, shift)
    count = round(float(shapely.area(tone.canvas)) / p**2)
    yield Step("plan", 0, 1, {"dots": count, "pitch_mm": p, "seconds": round(1 + count * 6e-6, 1)})
    if library is None:
        ground, wave, least = Ground.of(tone, p / 8), Wave.of(_euclidean, p), np.pi / 4 * (min_dot / p) ** 2
        art: Paths | Marks = joined(list(contoured(ground, tone, lattice, wave, least)))
        lost = ground.sum(np.where(ground.coverage < least, ground.coverage, 0))
    else:
        art, lost = _marks(_squares(tone, lattice, p), tone, p, library, np.radians(angle), min_dot, chance[1])
    clock.lap("draw")
    yield Step("measure", 0, 1)
    ink = measure.ink(art.snapped()) if isinstance(art, Marks) else inked(art, (angle, angle + 90), p)
    clock.lap("measure")
    report: dict[str, Any] = {
        "marks": len(art),
        "pitch_mm": p,
        "lpi": INCH / p,
        "phase": shift.tolist(),
        "ink_asked_mm2": tone.ink,
        "ink_placed_mm2": ink,
        "coverage_missing": max(0.0, 1 - ink / tone.ink) if tone.ink else 0.0,
        "left_out_mm2": lost,
        "left_out": lost / tone.ink if tone.ink else 0.0,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(report, tone, min_dot)
    return Sheet(tone.size, (Layer(Ink(), art, "dots"),), report=report)


@dataclass(frozen=True, eq=False)
class Squares:
    """The parts of squares on the canvas: area (n,) mm^2 of each, ink (n,) mm^2 in it, and place (n, 2) of its dot."""

    area: Array
    ink: Array
    place: Array


def _glyphs(shape: str) -> tuple[Glyph, ...]:
    """The unit dots of a shape, the long axis along x. Raises ValueError for a name that there is not, OSError for a lost file."""
    disc = glyphs.load("disc").glyphs[0]
    if shape == "round":
        return (disc,)
    if shape == "ellipse":
        return (Glyph(disc.paths.moved(((LONG**0.5, 0), (0, LONG**-0.5))), disc.size),)
    if shape == "diamond":
        half = 0.5**0.5
        return (Glyph(Paths.of([[(half, 0), (0, half), (-half, 0), (0, -half)]]), disc.size),)
    if shape not in glyphs.names() and not shape.lower().endswith(".svg"):
        raise ValueError(f"no shape {shape!r}; there are {', '.join((*SHAPES, *glyphs.names()))}, or the path of an SVG file")
    return glyphs.load(shape).glyphs


def _euclidean(u: Array, v: Array) -> Array:
    """The wave of discs that square up to a checkerboard at one half, and then are white, between the first ones."""
    return np.asarray(np.arccos(np.clip((np.cos(2 * np.pi * u) + np.cos(2 * np.pi * v)) / 2, -1, 1)) / np.pi)


def _squares(tone: Tone, lattice: Lattice, pitch: float) -> Squares:
    """All squares that lie on the canvas, some rows at a time; ink by moments, exact for coverage constant on each pixel."""
    low, high = lattice.reach(tone.canvas)
    found = [_rows(tone, lattice, pitch, v, min(v + ROWS, high[1] + 1), low[0], high[0]) for v in range(low[1], high[1] + 1, ROWS)]
    return Squares(*(np.concatenate([getattr(part, name) for part in found]) for name in ("area", "ink", "place")))


def _rows(tone: Tone, lattice: Lattice, pitch: float, top: int, bottom: int, left: int, right: int) -> Squares:
    """The squares of rows top to bottom, that one not among them."""
    u, v = (part.ravel().astype(np.float64) for part in np.meshgrid(np.arange(left, right + 1), np.arange(top, bottom)))
    place = np.stack(lattice.places(u, v), axis=1)
    box = np.array(shapely.bounds(tone.canvas)).reshape(2, 2)
    near = ((place > box[0] - pitch) & (place < box[1] + pitch)).all(axis=1)
    u, v, place = u[near], v[near], place[near]
    around = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    corners = np.stack(lattice.places(u[:, None] + around[:, 0], v[:, None] + around[:, 1]), axis=2)
    if tone.is_rectangle:
        whole = ((corners >= 0) & (corners <= tone.size)).all(axis=(1, 2))
    else:
        whole = np.asarray(shapely.contains_properly(tone.canvas, shapely.polygons(corners)))
    parts = shapely.intersection(shapely.polygons(corners[~whole]), tone.canvas)
    area = np.concatenate([np.full(int(whole.sum()), pitch**2), shapely.area(parts)])
    place = np.concatenate([place[whole], place[~whole]])
    shapes, rings, owner = _pieces(parts)
    edges = joined([Paths(corners[whole].reshape(-1, 2), np.arange(0, 4 * int(whole.sum()) + 1, 4)), rings])
    owner = np.concatenate([np.arange(int(whole.sum())), int(whole.sum()) + owner])
    ink = moments.of_tone(Cells(place, edges, owner, tone.canvas), tone)
    out = np.flatnonzero(~tone.holds(place) & (area > 0))
    place[out] = ink.centroid[out]
    lost = out[~tone.holds(place[out])]
    place[lost] = shapely.get_coordinates(shapely.point_on_surface(shapes[lost - int(whole.sum())]))
    some = area > 0
    return Squares(area[some], ink.mass[some], place[some])


def _pieces(parts: Any) -> tuple[Any, Paths, Index]:
    """Parts of squares without what has no area, their rings, and the part that each ring is of."""
    single, part = shapely.get_parts(parts, return_index=True)
    areal = shapely.area(single) > 0
    rings, piece = Paths.of_polygons(single[areal])
    return parts, rings, part[areal][piece]


def _marks(
    squares: Squares, tone: Tone, pitch: float, shapes: tuple[Glyph, ...], angle: float, min_dot: float, rng: np.random.Generator
) -> tuple[Marks, float]:
    """A dot for each square, and the ink in mm^2 of those too small to print."""
    n = len(squares.ink)
    glyph, turn = np.zeros(n, np.int64), np.full(n, angle)
    if len(shapes) > 1:
        glyph, turn = rng.permutation(np.arange(n) % len(shapes)), rng.uniform(0, 2 * np.pi, n)
    coverage, area = overlap(shapes, rng)
    mean = np.clip(squares.ink / squares.area, 0, 1)
    # a dot at the edge has fewer neighbours to overlap, and swells as much less as its square is cut
    scale = np.sqrt((mean + (np.interp(mean, coverage, area) - mean) * squares.area / pitch**2) * squares.area)
    place, kept = snapped(squares.place, tone, np.zeros(tone.coverage.shape, bool))
    kept &= (2 * scale / np.sqrt(np.pi) >= min_dot) & (scale >= 1e-3)  # below a micrometre a sheet keeps no size
    marks = Marks.of(place, shapes, scale=scale, angle=turn, glyph=glyph).take(kept)
    return marks, float(squares.ink[~kept].sum())


def overlap(shapes: tuple[Glyph, ...], rng: np.random.Generator) -> tuple[Array, Array]:
    """What dots on a square lattice cover together, rising to 1, and the area of a dot over its square that gives it.

    Measured on one square; of several shapes, turned at random, on 16 by 16 of them.
    """
    side, lines = (1, 512) if len(shapes) == 1 else (16, 64)
    rows = np.arange(-3, side + 3) + 0.5
    place = np.stack(np.meshgrid(rows, rows), axis=-1).reshape(-1, 2)
    several = len(shapes) > 1
    marks = Marks.of(
        place,
        shapes,
        scale=1.0,
        angle=rng.uniform(0, 2 * np.pi, len(place)) if several else 0.0,
        glyph=rng.permutation(np.arange(len(place)) % len(shapes)),
    )
    coverage = []
    for area in AREAS:
        grown = Marks(marks.xy, marks.angle, np.full(len(place), np.sqrt(area)), marks.glyph, shapes)
        coverage.append(float(raster.covered(grown, (side, side), pixel=(1.0, 1.0), lines=lines, flat=2e-4).mean()))
        if coverage[-1] > 1 - CLOSED:
            break
    found = np.maximum.accumulate(coverage)
    found[-1] = 1.0
    return found, AREAS[: len(found)]


def _warnings(report: dict[str, Any], tone: Tone, min_dot: float) -> list[str]:
    """What is to be said of the ink, and of importance."""
    if not report["ink_asked_mm2"]:
        said = ["no ink: the picture is white where it may be drawn on"]
    elif not report["marks"]:
        said = [f"no dots: all would be smaller than {max(min_dot, 1e-3):g} mm; a coarser ruling would help"]
    elif report["left_out"] > 0.02:
        said = [f"{report['left_out']:.1%} of the ink is dots smaller than {min_dot:g} mm, left out; a coarser ruling would help"]
    else:
        said = []
    if tone.importance is not None:
        said.append("importance is not heeded: a screen is as fine everywhere; stippling heeds it")
    return said
