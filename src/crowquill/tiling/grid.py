"""How a drawing is cut into tiles of equally many dots."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from crowquill.paths import Array, Index

DOTS = 80_000  # of a tile, where their number is left to us: a worker takes some 400 MB
LEAST = 1000  # dots of a tile: below, more sites are looked at around it than in it
MOST = 1000  # tiles to a side


@dataclass(frozen=True, eq=False)
class Grid:
    """Columns of tiles, each cut into rows by itself, so that every tile begins with as many sites as any other.

    across  (columns - 1,) x of the lines between columns, mm
    down    (columns, rows - 1) y of the lines between the tiles of each
    size    width and height in mm of what they cut
    """

    across: Array
    down: Array
    size: tuple[float, float]

    @classmethod
    def of(cls, sites: Array, columns: int, rows: int, size: tuple[float, float]) -> Grid:
        """The grid of so many columns and rows over first sites (n, 2) mm. Lines may coincide where sites do."""
        across = _cuts(sites[:, 0], columns)
        column = np.searchsorted(across, sites[:, 0], side="right")
        down = [_cuts(sites[column == k, 1], rows) for k in range(columns)]
        return cls(across, np.array(down).reshape(columns, rows - 1), size)

    @property
    def shape(self) -> tuple[int, int]:
        """Columns and rows."""
        return len(self.down), self.down.shape[1] + 1

    def tile(self, sites: Array) -> Index:
        """The tile of each site, counted down the first column, then the next."""
        column = np.searchsorted(self.across, sites[:, 0], side="right")
        row = (sites[:, 1, None] >= self.down[column]).sum(axis=1)
        return np.asarray(column * self.shape[1] + row, np.int64)

    @property
    def lines(self) -> Array:
        """The seams, as straight lines (k, 2, 2) mm."""
        width, height = self.size
        edges = np.concatenate([[0.0], self.across, [width]])
        upright = [((x, 0.0), (x, height)) for x in self.across]
        level = [((edges[k], y), (edges[k + 1], y)) for k, own in enumerate(self.down) for y in own]
        return np.array([*upright, *level], np.float64).reshape(-1, 2, 2)


def _cuts(values: Array, parts: int) -> Array:
    """Where values are cut into so many parts of equally many, (parts - 1,) rising; 0 where there are none."""
    return np.quantile(values, np.arange(1, parts) / parts) if len(values) else np.zeros(parts - 1)


def asked(tiles: str, dots: int, size: tuple[float, float]) -> tuple[int, int, list[str]]:
    """Columns and rows of tiles, from "auto" or such as "4x4", and what is to be said where they would be too small.

    auto  as many as give each some 80 000 dots, as square as the drawing lets them be

    Raises ValueError for what is neither.
    """
    across = math.sqrt(size[0] / size[1])
    found = re.fullmatch(r"\s*(\d{1,9})\s*[x×]\s*(\d{1,9})\s*", tiles)
    if tiles.strip() == "auto":
        number = max(1, round(dots / DOTS))
        columns = max(1, round(math.sqrt(number) * across))
        return columns, max(1, round(number / columns)), []
    if not found or not all(1 <= int(side) <= MOST for side in found.groups()):
        raise ValueError(f"tiles is {tiles!r}; it takes auto, or columns by rows such as 4x4, each from 1 to {MOST}")
    columns, rows = (int(side) for side in found.groups())
    if columns * rows * LEAST <= dots or columns * rows == 1:
        return columns, rows, []
    shrink = math.sqrt(max(1.0, dots / LEAST) / (columns * rows))
    fewer = max(1, int(columns * shrink)), max(1, int(rows * shrink))
    return *fewer, [f"{columns}x{rows} tiles would have {dots / columns / rows:.3g} dots each, too few; {fewer[0]}x{fewer[1]} are used"]
