"""Dots placed one after another where distances weighed by importance reach a radius, in an order of which any beginning is a drawing.

Source: D. Mould, Stipple Placement using Distance in a Weighted Graph, Computational Aesthetics 2007.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill import hilbert
from crowquill.heap import Small, ordered, risen, taken
from crowquill.kernel import compiled
from crowquill.paths import Array, Index

STEP = 2**0.5  # from one level's radius to the next: about twice as many dots
LEVELS, ROUNDS = 200, 12  # at most: of radii, and of the search for the last one
NEAR = 0.01  # of the number, by which the last level may have too many, which are then left out
FAINT = 1e-6  # of a gradient or a deviation: below, it is rounding
LEAST = 0.02  # of the mean cost, added everywhere
Bits = npt.NDArray[np.bool_]
Ways = npt.NDArray[np.float32]  # pictures are large: half the memory, and faster by it
Pixels = Array | Ways


@dataclass(frozen=True, eq=False)
class Placed:
    """Dots placed so far: their pixels (n,) as indices into the flat grid, in order, how many there were after each level, and how far
    (h, w) each pixel is from the nearest of them."""

    dots: Index
    levels: tuple[int, ...]
    far: Ways

    @classmethod
    def seeded(cls, cost: Pixels, held: Bits, seeds: int, rng: np.random.Generator) -> Placed:
        """So many first dots, by chance in proportion to their cost among the pixels held; fewer where there are fewer."""
        share = np.where(held, np.asarray(cost, np.float64), 0.0).ravel()
        n = min(seeds, int(np.count_nonzero(share)))
        dots = rng.choice(share.size, n, replace=False, p=share / share.sum()) if n else np.zeros(0, np.int64)
        far = np.full(cost.shape, np.inf, np.float32)
        far.ravel()[dots] = 0.0
        _grown(np.asarray(cost, np.float32), held, far, np.inf, dots.astype(np.int32), np.empty(0, np.int64))
        return cls(dots, (n,), far)

    def filled(self, cost: Pixels, held: Bits, radius: float) -> Placed:
        """More dots, until no pixel held is further than the radius from one.

        The pixel next beyond the radius becomes a dot, its distance 0, and those around come nearer; so dots line up along
        what they have reached. A step from pixel to pixel costs its length times the mean of their costs.
        """
        far, found = self.far.copy(), np.empty(cost.size, np.int64)
        beyond = np.flatnonzero(held & (far > radius)).astype(np.int32)
        n = _grown(np.asarray(cost, np.float32), held, far, radius, beyond, found)
        more = _evenly(found[:n], cost.shape[1])
        return Placed(np.concatenate([self.dots, more]), (*self.levels, len(self.dots) + n), far)

    def first(self, n: int) -> Placed:
        """No more than the first n dots."""
        return Placed(self.dots[:n], tuple(min(level, n) for level in self.levels), self.far)


def tonal(demand: Pixels, coverage: Pixels, edges: float) -> Pixels:
    """Costs (h, w) by which dots lie as densely as the demand, and more densely at edges of the coverage, both 0 to 1.

    edges  1 doubles the cost where the gradient is greatest
    """
    slope = _slope(coverage)
    return np.asarray(np.sqrt(demand) * (1 + edges * slope / max(float(slope.max()), FAINT)))


def published(coverage: Pixels, edges: float) -> Pixels:
    """Costs (h, w) that are darkness and gradient, each over its own deviation, the gradient `edges` times, and a little everywhere.

    Dots lie as densely as the square of this: a tone twice as dark has four times as many. What deviates nowhere is left out.
    """
    slope = _slope(coverage)
    parts = [weight * part / part.std() for part, weight in ((coverage, 1.0), (slope, edges)) if part.size and part.std() > FAINT]
    cost = np.sum(parts, axis=0) if parts else np.ones_like(coverage)
    return np.asarray(cost + LEAST * cost.mean())


def _slope(coverage: Pixels) -> Pixels:
    """The gradient's length at each pixel (h, w), per pixel; along a side of one pixel there is none."""
    return np.asarray(
        np.hypot(*(np.gradient(coverage, axis=axis) if n > 1 else np.zeros_like(coverage) for axis, n in enumerate(coverage.shape)))
    )


def levels(cost: Pixels, held: Bits, n: int, seeds: int, rng: np.random.Generator) -> Iterator[Placed]:
    """Placed dots after each level, with n at the end: the radius shrinks by the root of two, and the last one is searched for.

    cost  (h, w) over 0: dots lie as densely as its square
    held  (h, w) pixels that may have one

    Of the last level the dots beyond n, a hundredth at most where the search succeeds, are left out. There are fewer than n only
    where there are fewer pixels. The first k dots lie as evenly as all, but for those of the level that k cuts, of which every
    part of the picture has an equal share.
    """
    now = Placed.seeded(cost, held, seeds, rng)
    yield now.first(n)
    radius = float(now.far[held].max(initial=0.0))
    for _ in range(LEVELS):
        if len(now.dots) >= n or len(now.dots) == np.count_nonzero(held):
            return
        following = now.filled(cost, held, radius / STEP)
        if len(following.dots) >= n:
            break
        now, radius = following, radius / STEP
        yield now
    low, high = radius / STEP, radius
    for _ in range(ROUNDS):
        if len(following.dots) <= (1 + NEAR) * n:
            break
        middle = (low * high) ** 0.5
        other = now.filled(cost, held, middle)
        if len(other.dots) >= n:
            low, following = middle, other
        else:
            high = middle
    yield following.first(n)


def _evenly(pixels: Index, columns: int) -> Index:
    """The pixels of a level in an order of which every beginning is spread over all: along a Hilbert curve, by bits reversed."""
    n = len(pixels)
    bits = max(1, (n - 1).bit_length())
    place = np.zeros(1 << bits, np.int64)
    for bit in range(bits):
        place |= ((np.arange(1 << bits) >> bit) & 1) << (bits - 1 - bit)
    row, column = np.divmod(pixels, columns)
    along = pixels[hilbert.of_points(np.stack([column, row], axis=1).astype(np.float64))]
    return along[place[place < n]]


@compiled
def _grown(cost: Ways, held: Bits, far: Ways, radius: float, first: Small, found: Index) -> int:
    """Lets distances grow from the pixels of `first`, and makes a dot of each held one beyond the radius, the nearest first.

    far    (h, w) distances, which are changed
    found  is filled with the dots, whose number is returned
    """
    h, w = cost.shape
    weight, may, distance = cost.ravel(), held.ravel(), far.ravel()
    key, item, place = np.empty(h * w, np.float32), np.empty(h * w, np.int32), np.full(h * w, -1, np.int32)
    size, n = len(first), 0
    for k in range(size):
        key[k], item[k] = distance[first[k]], first[k]
    ordered(key, item, place, size)
    while size > 0:
        pixel = taken(key, item, place, size)
        size -= 1
        if distance[pixel] > radius and may[pixel]:
            distance[pixel] = 0.0
            found[n] = pixel
            n += 1
        y, x = pixel // w, pixel % w
        for r in range(max(0, y - 1), min(h, y + 2)):
            for c in range(max(0, x - 1), min(w, x + 2)):
                other = r * w + c
                length = 1.0 if r == y or c == x else 1.4142135623730951
                due = np.float32(distance[pixel] + length * (weight[pixel] + weight[other]) / 2)
                if due < distance[other]:
                    distance[other] = due
                    at = place[other]
                    if at < 0:
                        at = size
                        size += 1
                    risen(key, item, place, at, due, other)
    return n
