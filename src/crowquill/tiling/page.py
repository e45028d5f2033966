"""All sites of a drawing between two steps, tile by tile, and how a step is handed out to workers."""

from __future__ import annotations

import hashlib
import math
import os
import zipfile
from collections.abc import Generator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.cluster import Workers
from crowquill.paths import Array, Index
from crowquill.sheet import Step
from crowquill.tiling.grid import Grid
from crowquill.tiling.hands import hired, submitted
from crowquill.tiling.windows import Moved, Window, moved
from crowquill.tone import BLOCK, Tone

HALO = 4.0  # spacings that a tile first looks around itself: cells of a fresh start reach no farther
MORE = 1.2  # times what it looked at last that it is given next


@dataclass(eq=False)
class Page:
    """The sites of all tiles between two steps, those of a tile together.

    order  the place that each had among the first sites; those of tile k are start[k] to start[k + 1]
    halo   (tiles, 4) mm that each is given around the box of its sites, to the left, top, right and bottom
    """

    demand: Tone
    sites: Array
    order: Index
    start: Index
    halo: Array
    how: tuple[float, float, bool]
    again: int = 0

    @classmethod
    def of(cls, grid: Grid, sites: Array, demand: Tone, *how: Any) -> Page:
        """First sites (n, 2) mm on their tiles; `how` is what Window takes of step, exponent and avoid."""
        tile, tiles = grid.tile(sites), math.prod(grid.shape)
        order = np.argsort(tile, kind="stable")
        start = np.searchsorted(tile[order], np.arange(tiles + 1))
        spacing = math.sqrt(shapely.area(demand.canvas) / max(1, len(sites)))
        return cls(demand, sites[order], order, start, np.full((tiles, 4), HALO * spacing), how)

    def in_order(self) -> Array:
        """The sites in the order of the first ones."""
        found = np.empty_like(self.sites)
        found[self.order] = self.sites
        return found

    def stepped(self, pool: Workers) -> Generator[Step, None, tuple[Array, float, float]]:
        """Where all sites go, their energy and mean movement; a Step a tile."""
        full = np.flatnonzero(np.diff(self.start) > 0)
        boxes = np.array([[*own.min(axis=0), *own.max(axis=0)] for own in (self._own(k) for k in full.tolist())]).reshape(-1, 4)
        places, sums = np.empty_like(self.sites), np.zeros((len(full), 2))
        waiting: dict[Future[Moved], int] = {}
        todo, done = list(range(len(full)))[::-1], 0
        while todo or waiting:
            while todo and len(waiting) <= pool.count:
                j = todo.pop()
                waiting[submitted(pool, moved, self._window(full, boxes, j))] = j
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                j, found = waiting.pop(future), future.result()
                k = full[j]
                given, looked = self.halo[k], found.looked
                if ((looked > given) & ~self._ends(boxes[j], given)).any():
                    self.halo[k] = np.maximum(given, looked * MORE)  # never less on any side, so that it ends
                    self.again += 1
                    todo.append(j)
                    continue
                self.halo[k] = looked * MORE
                places[self.start[k] : self.start[k + 1]] = found.places
                sums[j] = found.energy, found.movement
                done += 1
                yield Step("tiles", done, len(full))
        energy, movement = sums.sum(axis=0).tolist() if len(full) else (0.0, 0.0)
        return places, energy, movement / max(1, len(self.sites))

    def _own(self, tile: int) -> Array:
        return self.sites[self.start[tile] : self.start[tile + 1]]

    def _ends(self, box: Array, halo: Array) -> npt.NDArray[np.bool_]:
        """Whether the page ends, (4,), before what a tile is given does."""
        return np.concatenate([box[:2] - halo[:2] <= 0, box[2:] + halo[2:] >= self.demand.size])

    def _window(self, full: Index, boxes: Array, j: int) -> Window:
        """The window of a tile, the j-th of those with sites."""
        (h, w), pixel, tile = self.demand.shape, np.array(self.demand.pixel), full[j]
        ends = self._ends(boxes[j], self.halo[tile])
        known = np.where(ends, np.array([-np.inf, -np.inf, np.inf, np.inf]), boxes[j] + self.halo[tile] * (-1, -1, 1, 1))
        low = np.maximum(0, np.floor(np.maximum(known[:2], 0) / pixel)).astype(int) // (BLOCK, 1) * (BLOCK, 1)
        high = np.minimum((w, h), np.ceil(np.minimum(known[2:], self.demand.size) / pixel).astype(int))
        near = np.all((boxes[:, :2] <= known[2:]) & (boxes[:, 2:] >= known[:2]), axis=1) & (np.arange(len(full)) != j)
        others = [own[((own >= known[:2]) & (own <= known[2:])).all(axis=1)] for own in (self._own(k) for k in full[near].tolist())]
        canvas = None
        if not self.demand.is_rectangle:
            canvas = shapely.to_wkb(shapely.intersection(self.demand.canvas, shapely.box(*(low * pixel), *(high * pixel))))
        return Window(
            self.demand.levels.cut(slice(low[1], high[1]), slice(low[0], high[0])).whole(),
            (int(low[0]), int(low[1])),
            self.demand.pixel,
            canvas,
            np.concatenate([self._own(tile), *others]),
            int(self.start[tile + 1] - self.start[tile]),
            (float(known[0]), float(known[1]), float(known[2]), float(known[3])),
            *self.how,
        )


class Kept:
    """A page between two steps as a file of a folder, under a name that only the same work gives."""

    @classmethod
    def of(cls, page: Page) -> Kept | None:
        """That of a page in the folder of those hired; None where they have none."""
        hands = hired.get()
        if hands is None or hands.folder is None:
            return None
        found = cls(hands.folder, page)
        hands.kept.append(found.file)
        return found

    def __init__(self, folder: Path, page: Page) -> None:
        made = hashlib.sha256(repr((version("crowquill"), page.how, page.start.tolist(), page.demand.size)).encode())
        levels = page.demand.levels
        for part in (page.sites, page.order, levels.codes, np.zeros(0) if levels.table is None else levels.table):
            made.update(np.ascontiguousarray(part).data)
        made.update(shapely.to_wkb(page.demand.canvas))
        self.file, self._page = folder / f"tiles-{made.hexdigest()[:24]}.npz", page

    def taken_up(self) -> int:
        """How many steps are done; the page is as they left it. A file that is none, or broken, is none."""
        try:
            with np.load(self.file) as kept:
                sites, halo, again, done = (kept[key] for key in ("sites", "halo", "again", "done"))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return 0
        self._page.sites, self._page.halo, self._page.again = sites, halo, int(again)
        return int(done)

    def put(self, done: int) -> None:
        """Keeps the page after so many steps, in place of what was there. An OSError names the file."""
        part = self.file.with_suffix(".part")
        try:
            with part.open("wb") as file:
                np.savez(file, sites=self._page.sites, halo=self._page.halo, again=self._page.again, done=done)
                file.flush()
                os.fsync(file.fileno())
            part.replace(self.file)
        except OSError as error:
            part.unlink(missing_ok=True)
            raise OSError(error.errno, error.strerror or str(error), str(self.file)) from error
