"""Square cells over a tone: what each is to be, which lie in the canvas, and where their middles are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from crowquill import halftone
from crowquill.halftone.averages import averaged
from crowquill.paths import Array
from crowquill.tone import Tone
from crowquill.units import INCH

BLOCK = 8  # cells: the sides of blocks over which tone is compared; bands are of whole ones
Bits = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Grid:
    """Square cells over a tone: how many, their side in mm and their number to the inch."""

    tone: Tone
    columns: int
    rows: int
    cell: float
    dpi: float

    @classmethod
    def of(cls, tone: Tone, cell: float, dpi: float | None = None) -> Grid:
        """As many cells of this side as come nearest to the picture's sides, so that the outermost may hang over by half of one."""
        columns, rows = (max(1, round(side / cell)) for side in tone.size)
        return cls(tone, columns, rows, cell, dpi or INCH / cell)

    @property
    def corner(self) -> Array:
        """Where the first cell begins, mm: the grid's middle is the picture's."""
        return (np.array(self.tone.size) - self.cell * np.array([self.columns, self.rows])) / 2

    @cached_property
    def band(self) -> int:
        """Rows to a band: whole blocks, and no fewer than run in."""
        return max(halftone.RUN_IN, halftone.BAND // self.columns // BLOCK * BLOCK)

    def asked(self, top: int, bottom: int) -> tuple[Array, Bits]:
        """Mean coverage of the parts of these rows' cells that lie in the canvas, and which cells' centres do."""
        tone, (x, y) = self.tone, self.corner
        h, w = tone.coverage.shape
        across = (x + self.cell * np.arange(self.columns + 1)) / tone.size[0]
        down = (y + self.cell * np.arange(top, bottom + 1)) / tone.size[1]
        share = averaged(np.ones((1, 1)), across, down) if tone.is_rectangle else averaged(tone.inside, across * w, down * h)
        ink = averaged(self._lit, across * w, down * h)
        mean = np.clip(np.divide(ink, share, out=np.zeros_like(ink), where=share > 0), 0, 1)
        held = share > 1 - 1e-9
        row, column = np.nonzero((share > 0) & ~held)
        held[row, column] = tone.holds(self.centres(row + top, column))
        return np.where(held, mean, 0.0), held

    def whole(self) -> tuple[npt.NDArray[np.float32], Bits]:
        """The same of all rows, in half the memory."""
        coverage, held = np.empty((self.rows, self.columns), np.float32), np.empty((self.rows, self.columns), bool)
        for top in range(0, self.rows, self.band):
            part = slice(top, min(self.rows, top + self.band))
            coverage[part], held[part] = self.asked(part.start, part.stop)
        return coverage, held

    def centres(self, row: npt.ArrayLike, column: npt.ArrayLike) -> Array:
        """The middles of cells, (n, 2) mm."""
        return (np.stack([column, row], axis=1) + 0.5) * self.cell + self.corner

    @cached_property
    def _lit(self) -> Array:
        return self.tone.coverage if self.tone.is_rectangle else self.tone.coverage * self.tone.inside
