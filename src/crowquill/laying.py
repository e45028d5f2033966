"""Laying: where the tiles of a mosaic lie, in four ways: Hausner's, by Lloyd's relaxation, in rows, and as cells.

Source: A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001; G. Di Blasi, G. Gallo, Artificial Mosaics, The Visual
Computer 21(6), 2005; S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import relax
from crowquill.field import Rows
from crowquill.kernel import compiled
from crowquill.objects import Objects, Shape
from crowquill.paths import Array, Index, Paths
from crowquill.tesserae import APART, Ground, Progress, Tiles, spaced
from crowquill.tiles import SNAP, largest
from crowquill.tone import Tone

AVOID = 0.35  # of a tile: so near an edge nothing counts, and tiles are pushed off it
LIFTED = 3  # last steps, in which all counts again and gaps close
WINDOW = 2.0  # tiles to every side of a centre that it may claim

Way = Callable[[Ground, Tone, int, np.random.Generator], Iterator[Progress]]


def hausner(ground: Ground, tone: Tone, iterations: int, rng: np.random.Generator) -> Iterator[Progress]:
    """Tiles that move to the centroids of what is nearest to them by a metric whose circles are their own squares.

    Each place belongs to the tile in whose growing copy it lies first, as turned and stretched as that is. Places near an edge belong to
    none until the last steps. Tiles that nothing belongs to are left out.
    """
    demand, count = ground.crowd(tone)
    xy = relax.scatter(demand, count, rng)
    energy = movement = 0.0
    kept_off = off_edges(ground)
    for done in range(iterations + 1):
        yield Progress(done, ground.tiles(xy), energy, movement)
        free = kept_off if done < iterations - LIFTED else ground.inside
        centre, some, energy = centred(ground, tone, xy, free)
        movement = float(np.hypot(*(centre - xy)[some].T).mean() / ground.mean) if some.any() else 0.0
        xy = centre[some]


def centred(ground: Ground, tone: Tone, xy: Array, free: npt.NDArray[np.bool_]) -> tuple[Array, npt.NDArray[np.bool_], float]:
    """Where each tile's free squares have their centre, which tiles have any, and the sum of their squared distances, mm^4.

    A tile without any, or whose centre would be off the canvas, is where it was.
    """
    x, y = ground.places
    owner, far = claimed(ground, xy, free)
    held = owner >= 0
    mine, (row, column) = owner[held], np.nonzero(held)
    mass = np.bincount(mine, minlength=len(xy))
    some = mass > 0
    sums = np.stack([np.bincount(mine, place, len(xy)) for place in (x[column], y[row])], axis=1)
    centre = np.where(some[:, None], sums / np.maximum(mass, 1)[:, None], xy)
    energy = float((far[held] ** 2).sum() * np.prod(ground.pixel))
    return np.where(tone.holds(centre)[:, None], centre, xy), some, energy


def off_edges(ground: Ground) -> npt.NDArray[np.bool_]:
    """The squares of the grid that lie on the canvas and not near an edge."""
    return ground.inside & _clear(ground)


def claimed(ground: Ground, xy: Array, free: npt.NDArray[np.bool_]) -> tuple[Index, Array]:
    """The tile that each free square of the grid belongs to, -1 for none, and how far it is by that tile's metric, mm."""
    h, w = ground.grid
    owner, far = np.full((h, w), -1), np.full((h, w), np.inf)
    angle, ratio = ground.angles(xy), float(ground.pitch[0] / ground.pitch[1])
    wide = WINDOW * ground.mean * max(ratio, 1 / ratio) ** 0.5
    _claim(xy, np.cos(angle), np.sin(angle), ground.wished(xy), ratio, wide, *ground.places, free, owner, far)
    return owner, far


def lloyd(ground: Ground, tone: Tone, iterations: int, rng: np.random.Generator) -> Iterator[Progress]:
    """Whole squares that settle, each moving to the centroid of the places nearest to its outline and turning along the field.

    They take the size that is wished for where they come to lie, and places count by it, or large ones would spread into the
    room of small ones. Places near an edge count as nothing until the last steps.
    """
    demand, count = ground.crowd(tone)
    xy = relax.scatter(demand, count, rng)
    shape = Shape.of(Paths.of([np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * ground.pitch]))
    shape = replace(shape, axis=0.0)
    pushed = _off_edges(ground)
    done, angle = 0, ground.angles(xy)
    while len(xy):
        scale = (ground.sides(xy) / ground.pitch).mean(axis=1)
        objects = Objects.of(xy, (shape,), angle=angle, scale=scale)
        place = pushed if done < iterations - LIFTED and pushed.ink > 0 else demand
        states = relax.settle(objects, place, exponent=1.0, sampling=ground.mean / 2, towards=ground.angles)
        state = next(states)
        found = Tiles(state.objects.xy, state.objects.angle, ground.sides(state.objects.xy))
        spread = np.trace(state.moments.covariance, axis1=1, axis2=2)
        yield Progress(done, found, float((state.moments.mass * spread).sum()), state.movement)
        state = next(states)
        xy, angle, done = state.objects.xy, state.objects.angle, done + 1


def cells(ground: Ground, tone: Tone, iterations: int, rng: np.random.Generator) -> Iterator[Progress]:
    """Stones of no one shape: the Voronoi cells of relaxed sites, less half a grout all around."""
    demand, count = ground.crowd(tone)
    pushed = _off_edges(ground)
    first = max(0, iterations - LIFTED)
    sites = relax.scatter(demand, count, rng)
    done = 0
    for place, last in ((pushed if pushed.ink > 0 else demand, first), (demand, iterations)):
        for state in relax.lloyd(sites, place):
            if done >= last:
                break
            done += 1
            yield Progress(done - 1, ground.tiles(state.sites), state.energy, state.movement)
        sites = state.sites
    ring = np.minimum(state.cells.first[:-1], len(state.cells.rings) - 1)  # a site may be without one; what it then shares is parted
    rings = shapely.buffer(state.cells.rings.polygons()[ring], -(ground.gap + SNAP) / 2, join_style="mitre")
    yield Progress(done, ground.tiles(sites), state.energy, state.movement, largest(rings))


def rows(ground: Ground, tone: Tone, iterations: int, rng: np.random.Generator) -> Iterator[Progress]:  # noqa: ARG001
    """Tiles in rows along lines at even distances from the edges and the canvas's outline, each row closed by whole tiles."""
    far = ground.far if ground.wish is None else ground.far.through(ground.finer)
    xy, angle, sides = [np.empty((0, 2))], [np.empty(0)], [np.empty((0, 2))]
    for line in Rows(far, ground.pitch[1], 0.5 * ground.pitch[1]).lines(far.mm[ground.inside].max(initial=0)):
        found = _in_row(ground, line, rng)
        xy.append(found.xy)
        angle.append(found.angle)
        sides.append(found.sides)
    every = Tiles(np.concatenate(xy), np.concatenate(angle), np.concatenate(sides))
    inside = tone.holds(every.xy)
    kept = np.flatnonzero(inside)[spaced(every.xy[inside], APART * ground.mean / ground.wished(every.xy[inside]))]
    yield Progress(0, Tiles(every.xy[kept], every.angle[kept], every.sides[kept]))


WAYS: dict[str, Way] = {"hausner": hausner, "lloyd": lloyd, "rows": rows, "cells": cells}


def _in_row(ground: Ground, line: Array, rng: np.random.Generator) -> Tiles:
    """Tiles one after the other along a line (m, 2): as many as it takes, a little longer or shorter than wished for."""
    step = np.hypot(*np.diff(line, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(step)])
    wish = ground.wished(line)
    wanted = np.concatenate([[0.0], np.cumsum(step * (wish[1:] + wish[:-1]) / 2)]) / ground.pitch[0]
    ring, count = bool((line[0] == line[-1]).all()), round(wanted[-1])
    if count < 1 or (ring and count < 3):
        return ground.tiles(np.empty((0, 2)))
    part = np.arange(count) + (rng.random() if ring else 0.5)
    begin, at, end = (np.interp((part + k) % count if ring else part + k, wanted * count / wanted[-1], along) for k in (-0.5, 0, 0.5))
    end = np.where(end < begin, end + along[-1], end)
    place = np.stack([np.interp(at, along, axis) for axis in line.T], axis=1)
    ends = [np.stack([np.interp(t % along[-1] if ring else t, along, axis) for axis in line.T], axis=1) for t in (begin, end)]
    way = ends[1] - ends[0]
    angle, quarter = ground.angles(place), np.pi / 2  # the line rounds corners that the field does not
    angle += quarter * np.round((np.arctan2(way[:, 1], way[:, 0]) - angle) / quarter)
    sides = ground.sides(place)
    sides[:, 0] = np.maximum(end - begin - ground.gap, 0.3 * sides[:, 0])
    return Tiles(place, angle, sides)


def _clear(ground: Ground) -> npt.NDArray[np.bool_]:
    """The squares of the grid that are not near an edge."""
    return np.asarray(ground.edges.mm >= AVOID * ground.mean / ground.finer)


def _off_edges(ground: Ground) -> Tone:
    """Where tiles are wished for how densely, over the densest, and nothing near edges."""
    return Tone(_clear(ground) * (ground.finer / ground.finest) ** 2, ground.size, ground.canvas)


@compiled
def _claim(
    xy: Array,
    cos: Array,
    sin: Array,
    wish: Array,
    ratio: float,
    wide: float,
    x: Array,
    y: Array,
    free: npt.NDArray[np.bool_],
    owner: Index,
    far: Array,
) -> None:
    """Each tile in turn takes the squares around it that no other is nearer to: max(|u| / sqrt q, |v| sqrt q) by its own axes."""
    root = np.sqrt(ratio)
    dx, dy = x[1] - x[0], y[1] - y[0]
    for i in range(len(xy)):
        reach = wide / wish[i]
        low, high = max(0, int((xy[i, 1] - reach) / dy)), min(len(y), int((xy[i, 1] + reach) / dy) + 1)
        left, right = max(0, int((xy[i, 0] - reach) / dx)), min(len(x), int((xy[i, 0] + reach) / dx) + 1)
        for row in range(low, high):
            b = y[row] - xy[i, 1]
            for column in range(left, right):
                a = x[column] - xy[i, 0]
                u, v = abs(cos[i] * a + sin[i] * b) / root, abs(cos[i] * b - sin[i] * a) * root
                d = max(u, v) * wish[i]
                if d < far[row, column] and free[row, column]:
                    far[row, column] = d
                    owner[row, column] = i
