"""Progressive stippling: dots at the frontier of distances that grow by tone and edges; the first of them are a drawing of fewer dots.

Source: D. Mould, Stipple Placement using Distance in a Weighted Graph, Computational Aesthetics 2007.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from crowquill import frontier, measure
from crowquill import glyphs as libraries
from crowquill.frontier import Placed, Ways
from crowquill.grid import Grid
from crowquill.knobs import Choice, Range, Text
from crowquill.marks import Glyph, Marks
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, Plan, allowed, dotted, found, planned, snapped
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots")  # of which one is enough
# Coverage that such dots really give when their areas sum to stippling.NOMINAL of the paper. Written by tools/calibrate.py.
RENDERED = np.array([0.0, 0.1995, 0.3977, 0.4937, 0.5786, 0.6621, 0.7319, 0.7901, 0.8385, 0.8788, 0.9092, 0.9357, 0.953])
FINE = 4.5  # pixels from dot to dot where they lie most densely
SEEN = 250_000  # pixels, as many of the picture's as are looked at whatever the number of dots
MOST = 8_000_000  # pixels: half a gigabyte
JITTER = 0.4  # of a pixel, each way: hides the grid
OFF, SIZED = (0.97, 1.03), (0.8, 1.25)  # times the planned diameter that dots may be, with a pen and without
LEAST = 0.005  # of the mean cost: no way is free
LADDER = 20  # levels, about
TRIES, SAME = 2, 0.005  # of numbers of dots for a pen, until their ink is as near as this
RATE = 5e6  # pixels a second and level, about, of a machine of 2024
Bits = npt.NDArray[np.bool_]


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "dot diameter; decides the number of dots (0.3mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of dots; decides their diameter")] = None,
    weight: Annotated[str, Choice(("tone", "published"), "dots lie by tone, or by darkness and gradient alike")] = "tone",
    edges: Annotated[float, Range(0, 10, "", "how much more densely dots lie at edges; 0 by tone alone")] = 0.5,
    noise: Annotated[float, Range(0, 0.9, "", "how much chance sways distances; 0 makes lattices")] = 0.3,
    seeds: Annotated[int, Range(1, 1000, "", "dots from which all begins")] = 3,
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the pen)", file=True)] = None,
    white: Annotated[float, Range(0, 1, "", "no dots where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 1_000_000,
) -> Work:
    """A sheet the tone's size with one layer of black dots in the order in which they were placed.

    order       level by level, each with about twice as many dots as the last (`levels` of the report): the first k are evenly
                placed too, and a drawing of the picture once they are as much larger as they are fewer
    pen, dots   with a pen as many dots as the ink asks for, within 3 % of that diameter; with a number exactly so many, as
                large as the ink asks for; with both the tone gives. They lie on fine pixels of their own, so that there may be
                more of them than the picture has; where even MOST pixels are too few, the report says so
    weight      "tone": flat tones are kept, and dots at edges are taken from everywhere; "published": density follows the square
                of darkness and gradient, each over its deviation, `edges` being the gradient's factor; only the ink on the whole is kept
    importance  of the tone: more dots there, by weight "tone"
    no ink      an empty sheet and a warning. Raises ValueError for a pen wider than the canvas, and more than max_dots
    """
    clock = Clock()
    plan = planned(tone, pen=pen, dots=dots, white=white, white_rule="before", min_gap=0.0, max_dots=max_dots, rendered=RENDERED)
    chance = rng.spawn(2)
    ground = _ground(tone, plan, weight, edges, noise, chance[0])
    facts = {"dots": plan.dots, "pen_mm": plan.pen, "seconds": round(1 + LADDER * ground.cost.size / RATE, 1)}
    yield Step("plan", 0, 1, facts)
    clock.lap("plan")
    library = libraries.load(glyphs or libraries.nearest(plan.pen))
    limits = OFF if dots is None else SIZED if pen is None else (1.0, 1.0)
    chosen, number = chance[1].integers(2**62, size=2), plan.dots
    for turn in range(TRIES):
        placed = yield from _placed(ground, number, seeds, np.random.default_rng(chosen[0]))
        marks = _marks(placed, ground, plan, library.glyphs, np.random.default_rng(chosen[1]))
        marks, ink = measure.covering(marks, plan.ink, limits)
        if dots is not None or turn + 1 == TRIES or not ink or abs(ink / plan.ink - 1) <= SAME:
            break
        number = min(max_dots, round(number * plan.ink / ink))
    clock.lap("place")
    plan = replace(plan, dots=number, pen=float(2 * marks.scale.mean() / np.sqrt(np.pi)) if len(marks) else plan.pen)
    report: dict[str, Any] = {
        **found(plan, len(marks), ink),
        "levels": list(placed.levels),
        "pitch_mm": ground.grid.cell,
        "glyphs": library.name,
        "iterations": len(placed.levels),
        "seconds": clock.laps,
    }
    report["warnings"] += _warnings(report, tone, plan, weight)
    return Sheet(tone.size, (Layer(Ink(), marks),), report=report)


@dataclass(frozen=True, eq=False)
class Ground:
    """Pixels on which dots are placed: their grid, what a way across each costs (rows, columns), and which may have a dot."""

    grid: Grid
    cost: Ways
    held: Bits


def _ground(tone: Tone, plan: Plan, weight: str, edges: float, noise: float, rng: np.random.Generator) -> Ground:
    """Pixels as fine as the densest dots ask for, or as the picture's, up to SEEN of them, whichever is finer; never over MOST."""
    area, demand = tone.size[0] * tone.size[1], plan.demand
    densest = plan.dots * float(demand.coverage.max()) / max(demand.ink, np.finfo(float).tiny)  # dots to the mm^2
    pitch = min(1 / (FINE * np.sqrt(densest)) if densest else np.inf, np.sqrt(area / min(tone.coverage.size, SEEN)), tone.across)
    grid = Grid.of(demand, max(float(pitch), float(np.sqrt(area / MOST))))
    wanted, held = grid.whole()
    seen = _seen(tone, grid)
    held &= (wanted > 0) & ~_under(plan.white, grid)
    cost = frontier.tonal(wanted, seen, edges) if weight == "tone" else frontier.published(seen, edges)
    mean = float(cost[held].mean()) if held.any() else 1.0
    cost = np.where(held, np.maximum(cost, LEAST * mean), mean).astype(np.float32)  # no short way across white: it would join its borders
    return Ground(grid, cost * (1 + noise * (2 * rng.random(cost.shape, np.float32) - 1)), held)


def _seen(tone: Tone, grid: Grid) -> Ways:
    """The picture on a grid, whose slopes are its edges: means of finer pixels, straight lines between coarser ones, no canvas."""
    from PIL import Image

    if max(tone.pixel) <= grid.cell:
        return replace(grid, tone=Tone(tone.coverage, tone.size)).whole()[0]
    image = Image.fromarray(tone.coverage.astype(np.float32))
    return np.asarray(image.resize((grid.columns, grid.rows), Image.Resampling.BILINEAR), np.float32)


def _under(white: Bits, grid: Grid) -> Bits:
    """Which of a picture's pixels lies under the middle of each of a grid's."""
    row, _ = grid.tone.under(grid.centres(np.arange(grid.rows), np.zeros(grid.rows)))
    _, column = grid.tone.under(grid.centres(np.zeros(grid.columns), np.arange(grid.columns)))
    return white[np.ix_(row, column)]


def _placed(ground: Ground, number: int, seeds: int, rng: np.random.Generator) -> Generator[Step, None, Placed]:
    """Steps of dots being placed, a level a step."""
    for placed in frontier.levels(ground.cost, ground.held, number, seeds, rng):
        yield Step("place", len(placed.dots), max(number, 1))
    return placed


def _marks(placed: Placed, ground: Ground, plan: Plan, glyphs: tuple[Glyph, ...], rng: np.random.Generator) -> Marks:
    """A dot in each pixel, near its middle, and there where chance would move it onto white or off the canvas."""
    grid = ground.grid
    centre = grid.centres(*np.divmod(placed.dots, grid.columns))
    moved = centre + grid.cell * rng.uniform(-JITTER, JITTER, centre.shape)
    good = allowed(moved, grid.tone, plan.white)
    xy, kept = snapped(np.where(good[:, None], moved, centre), grid.tone, plan.white)
    return dotted(xy, glyphs, plan.pen, rng).take(kept)


def _warnings(report: dict[str, Any], tone: Tone, plan: Plan, weight: str) -> list[str]:
    """What is to be said of the number of dots, and of what the weights do to the tone."""
    said, excess = [], report["ink_placed_mm2"] / plan.ink - 1 if plan.ink else 0.0
    if plan.dots and report["marks"] < plan.dots:
        said.append(f"{report['marks']} dots in place of {plan.dots}: there is room for no more pixels; draw it smaller, or fewer")
    if excess > 0.02:
        said.append(f"{1 + excess:.1%} of the ink asked for is placed; a pen or a number alone keeps the tone")
    if weight == "published":
        said.append("published weights do not keep tone: darks get more dots than they ask for, and lights fewer; weight tone keeps it")
        if tone.importance is not None:
            said.append("importance is not heeded by published weights; weight tone heeds it")
    return said
