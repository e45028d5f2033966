"""Contrast-aware diffusion: errors go to those neighbours that they take nearer to black or white, so that structure stays.

Source: H. Li, D. Mould, Contrast-aware Halftoning, Computer Graphics Forum 29(2), 2010; Structure-preserving Stippling by
Priority-based Error Diffusion, Graphics Interface 2011.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill.heap import ordered, risen, sunk, taken
from crowquill.kernel import compiled
from crowquill.paths import Array, Index

Bits = npt.NDArray[np.bool_]
Levels = npt.NDArray[np.float32]  # pictures are large: half the memory, and faster by it
ORDERS = ("priority", "raster")
EXPONENT = {"priority": 2.0, "raster": 2.6}  # as published
WHITE, HALF = 255.0, 127.0  # levels: black is 0, and a pixel of HALF or less becomes black
CHANCE = 1e-3  # levels by which chance parts pixels of one priority


@dataclass(frozen=True)
class Diffusing:
    """How errors are spread.

    order        "priority": the pixel nearest to black or white is next, whatever errors have made of it; "raster": row by row
    mask         pixels, the diameter of the disc that takes a pixel's error
    exponent     weights fall with distance to this power; None is the published one of the order
    more, less   G+ and G-: errors of black pixels are multiplied by r^G+, those of white ones by r^-G-, so that fewer are black
    extra        k: what of the ink of a dot beyond its pixel counts as error, levels to the pixel; not of one on full black
    radii        r, in pixels, where the picture is white and where it is black, straight between them
    """

    order: str = "priority"
    mask: int = 7
    exponent: float | None = None
    more: float = 0.0
    less: float = 0.0
    extra: float = 0.0
    radii: tuple[float, float] = (1.0, 2.0)

    def __post_init__(self) -> None:
        if self.order not in ORDERS:
            raise ValueError(f"no order {self.order!r}; there are {', '.join(ORDERS)}")

    def black(self, coverage: npt.ArrayLike, rng: np.random.Generator, held: npt.ArrayLike | None = None) -> Bits:
        """Black pixels (h, w) of coverage (h, w), 0 to 1.

        held  (h, w) pixels that take part; all others are white and take no error. White ones stay white, and black ones black

        With no G and no k the share of black pixels is the coverage, but for errors that no neighbour can take.

        >>> Diffusing().black([[0.5, 0.5], [0.5, 0.5]], np.random.default_rng(0)).sum()
        np.int64(2)
        """
        share = np.asarray(coverage, np.float64)
        if share.ndim != 2 or (share.size and not 0 <= share.min() <= share.max() <= 1):
            raise ValueError(f"coverage has shape {share.shape} and must run from 0 to 1; give rows by columns of shares")
        level = (WHITE * (1 - share)).astype(np.float32)
        if held is not None:
            level[~np.asarray(held, bool)] = -1
        black = np.zeros(share.shape, np.bool_)
        law = np.array([*self.radii, self.more, self.less, self.extra])
        if self.order == "raster":
            _by_row(level, share, law, *self._disc(), black)
        else:
            _by_priority(level, share, law, *self._disc(), CHANCE * rng.random(share.shape, np.float32), black)
        return black

    def _disc(self) -> tuple[Index, Index, Array]:
        """Rows and columns of the mask's pixels from its middle, and the weight of each by its distance."""
        reach = self.mask // 2
        row, column = np.mgrid[-reach : reach + 1, -reach : reach + 1]
        far = np.hypot(row, column)
        inside = (far > 0) & (far <= self.mask / 2)
        exponent = EXPONENT[self.order] if self.exponent is None else self.exponent
        return row[inside], column[inside], far[inside] ** -exponent


@compiled
def _by_row(level: Levels, share: Array, law: Array, row: Index, column: Index, near: Array, black: Bits) -> None:
    """Fills `black`, row by row; `level` is -1 for pixels that are done or take no part, `law` what Diffusing says of errors."""
    at, weight = np.empty(len(near), np.int64), np.empty(len(near))
    flat = level.ravel()
    for pixel in range(flat.size):
        if flat[pixel] >= 0:
            error = _decided(pixel, flat, share, law, black)
            _shared(pixel, error, level, row, column, near, at, weight)


@compiled
def _by_priority(level: Levels, share: Array, law: Array, row: Index, column: Index, near: Array, chance: Levels, black: Bits) -> None:
    """Fills `black`, always the pixel that is nearest to black or white next; its neighbours' places in the order change with them."""
    flat, tie = level.ravel(), chance.ravel()
    n = flat.size
    at, weight = np.empty(len(near), np.int64), np.empty(len(near))
    key, item, place = np.empty(n, np.float32), np.empty(n, np.int32), np.full(n, -1, np.int32)
    size = 0
    for pixel in range(n):
        if flat[pixel] >= 0:
            key[size], item[size] = min(flat[pixel], WHITE - flat[pixel]) + tie[pixel], pixel
            size += 1
    ordered(key, item, place, size)
    while size > 0:
        pixel = taken(key, item, place, size)
        size -= 1
        error = _decided(pixel, flat, share, law, black)
        for k in range(_shared(pixel, error, level, row, column, near, at, weight)):
            other = at[k]
            due, where = np.float32(min(flat[other], WHITE - flat[other]) + tie[other]), place[other]
            if due < key[where]:
                risen(key, item, place, where, due, other)
            else:
                sunk(key, item, place, size, where, due, other)


@compiled
def _decided(pixel: int, level: Levels, share: Array, law: Array, black: Bits) -> float:
    """Makes a pixel black or leaves it white, and gives the error that its neighbours are to have, over 0 if they become lighter."""
    low, high, more, less, extra = law
    value = float(level[pixel])
    level[pixel] = -1
    radius = low + (high - low) * share.ravel()[pixel]
    if value > HALF:
        return float((value - WHITE) * radius**-less)
    black.ravel()[pixel] = True
    return float((value + extra * (np.pi * radius**2 - 1)) * radius**more) if value > 0 else 0.0


@compiled
def _shared(pixel: int, error: float, level: Levels, row: Index, column: Index, near: Array, at: Index, weight: Array) -> int:
    """Shares an error out among the pixels around, and gives the number of those that it reached, which `at` lists.

    Each takes its part by how near it is and how far it still is from where the error leads: a dark pixel is not made lighter
    while light ones can be. What it takes beyond is lost, as published: handed on, it would grow without end for any G over 1.
    """
    h, w = level.shape
    flat = level.ravel()
    y, x = pixel // w, pixel % w
    total, n = 0.0, 0
    for k in range(len(near)):
        r, c = y + row[k], x + column[k]
        if error == 0.0 or r < 0 or c < 0 or r >= h or c >= w or flat[r * w + c] < 0:
            continue
        value = flat[r * w + c]
        part = near[k] * (value if error > 0 else WHITE - value)
        if part > 0:
            at[n], weight[n] = r * w + c, part
            total += part
            n += 1
    for k in range(n):
        flat[at[k]] = min(max(flat[at[k]] + error * weight[k] / total, 0.0), WHITE)
    return n
