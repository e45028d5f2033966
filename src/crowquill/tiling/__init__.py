"""Relaxation tile by tile: dots too many for one process move as all of them together would, on as many workers as there are.

A worker gets a tile's own sites, those around it and the demand below them, and moves its own by one step. It says how far each
of them had to look: what lies farther from a site than twice the farthest ink of its cell can take none of that ink.
Where a tile had to look farther than it was given, it is done again with all that it needs. So each step is that of the whole
page, to the rounding of sums, and there are no seams to be mended in rounds: the tiles of one step meet exactly.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np

from crowquill import relax
from crowquill.cells import voronoi
from crowquill.knobs import Text
from crowquill.moments import Moments
from crowquill.paths import Array
from crowquill.sheet import Step
from crowquill.stippling import Clock
from crowquill.tiling import seams
from crowquill.tiling.grid import Grid, asked
from crowquill.tiling.hands import Hands, hiring, pooled
from crowquill.tiling.page import Kept, Page
from crowquill.tone import Tone

__all__ = ["Grid", "Hands", "Relaxed", "Tiles", "asked", "hiring", "relaxed", "settled"]

Tiles = Annotated[str | None, Text("relax in tiles, for drawings larger than a machine: auto, or columns by rows such as 4x4")]


@dataclass(frozen=True, eq=False)
class Relaxed:
    """Sites (n, 2) mm in their first order after `done` steps, the sums of relax.State, and how they were worked.

    again  tiles that were done again because they had to look farther than they were given, in all steps
    """

    sites: Array
    done: int
    energy: float
    movement: float
    grid: Grid
    again: int
    said: tuple[str, ...]


def settled(
    demand: Tone, dots: int, rng: np.random.Generator, clock: Clock, *, start: str, tiles: str, **how: Any
) -> Generator[Step, None, tuple[relax.State, dict[str, Any]]]:
    """What stippling.settled gives, without its cells, tile by tile; and what is to be reported of the tiles."""
    sites = relax.scatter(demand, dots, rng, start)
    yield Step("place", 1, 1, {"dots": len(sites)})
    clock.lap("place")
    work = relaxed(sites, demand, tiles=tiles, **how)
    del sites  # 16 bytes a dot that are held in no other order
    found = yield from work
    clock.lap("relax")
    told = seams.of(found.sites, found.grid.lines, demand.size, np.random.default_rng(0))
    clock.lap("measure")
    none = np.zeros((0, 2))
    cells, sums = voronoi(none, demand.canvas), Moments.of(np.zeros((0, 6)), none, none)
    state = relax.State(found.done, found.sites, cells, sums, found.energy, found.movement)
    columns, rows = found.grid.shape
    tiling = {"columns": columns, "rows": rows, "done_again": found.again, "seams": asdict(told)}
    return state, {"tiles": tiling, "warnings": list(found.said)}


def relaxed(
    sites: Array,
    demand: Tone,
    *,
    tiles: str,
    iterations: int,
    until: float = 0.0,
    step: float = 1.8,
    exponent: float = 2.0,
    avoid: bool = True,
) -> Generator[Step, None, Relaxed]:
    """Steps of first sites (n, 2) mm moving as relax.lloyd moves them, tile by tile; returns where they are at the end.

    tiles       as asked() takes them
    iterations  the most steps of each site; `until` ends them sooner where the mean movement is less
    avoid       no site may move onto pixels without demand

    The same tiles give the same sites, bit for bit, whoever works them. Raises ValueError for tiles that are none, LostError
    where workers end over and over.
    """
    columns, rows, said = asked(tiles, len(sites), demand.size)
    grid = Grid.of(sites, columns, rows, demand.size)
    page = Page.of(grid, sites, demand, step, exponent, avoid)
    del sites
    kept = Kept.of(page)
    energy = movement = 0.0
    begin = kept.taken_up() if kept else 0
    with pooled() as pool:
        for done in range(begin, iterations + 1):
            places, energy, movement = yield from page.stepped(pool)
            yield Step("relax", done, iterations, {"energy": energy, "movement": movement})
            if done >= iterations or movement < until:
                break
            page.sites = places
            if kept:
                kept.put(done + 1)
    return Relaxed(page.in_order(), done, energy, movement, grid, page.again, tuple(said))
