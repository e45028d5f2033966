"""How much of each pixel of a grid a bitmap covers, exactly: its own pixels, copied where they are as large."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crowquill.halftone.averages import averaged
from crowquill.paths import Array
from crowquill.sheet import Bitmap
from crowquill.units import INCH

HELD = 1 << 20  # pixels of the bitmap at a time
SAME = 1e-6  # by which sides of pixels may differ and be called one: after 100 000 of them that is a tenth of a pixel


@dataclass(frozen=True, eq=False)
class Pixels:
    """A bitmap made ready for any rows of a grid of pixels, as a Raster is: its corner at (x, y), its own pixels `side`, in the grid's."""

    art: Bitmap
    at: tuple[float, float]
    side: tuple[float, float]
    width: int

    @classmethod
    def of(cls, art: Bitmap, *, pixel: tuple[float, float], width: int) -> Pixels:
        """On pixels as large as its own it lies on the nearest whole ones, so that they are copied."""
        (x, y), (dx, dy) = art.corner / pixel, (INCH / art.dpi / side for side in pixel)
        if abs(dx - 1) < SAME and abs(dy - 1) < SAME:
            (x, y), (dx, dy) = np.floor((x + 0.5, y + 0.5)), (1.0, 1.0)
        return cls(art, (float(x), float(y)), (float(dx), float(dy)), width)

    def touches(self, top: int, bottom: int) -> bool:
        """As of a Raster."""
        return bool(top < self.at[1] + len(self.art.bits) * self.side[1] and bottom > self.at[1])

    def rows(self, top: int, bottom: int) -> Array:
        """As of a Raster."""
        x: Array = (np.arange(self.width + 1, dtype=np.float64) - self.at[0]) / self.side[0]
        y: Array = (np.arange(top, bottom + 1, dtype=np.float64) - self.at[1]) / self.side[1]
        cover = np.empty((bottom - top, self.width))
        step = max(1, int(HELD * self.side[1] / self.art.width))
        for lo in range(0, len(cover), step):
            part = y[lo : lo + step + 1]
            first, last = (int(end) for end in np.clip((np.floor(part[0]), np.ceil(part[-1])), 0, len(self.art.bits)))
            cover[lo : lo + step] = averaged(self.art.rows(first, last).astype(np.float64), x, part - first)
        return cover
