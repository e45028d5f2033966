"""How objects come to rest: each moves to the centroid of its Voronoi region and turns to the region's long axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.cells import Cells, voronoi
from crowquill.inertia import ROUND, crosses, main_axis, pooled
from crowquill.moments import Moments, of_rings, of_tone
from crowquill.objects import Objects
from crowquill.paths import Array, Index, Paths
from crowquill.tone import Tone

APART = 0.15  # of the spacing: samples this close shift the border between objects a spacing apart by 0.3 % of it
NEXT = 1e-3  # of the spacing: as good as nothing, and far more than rounding
GOLDEN = np.pi * (3 - np.sqrt(5))  # rad; multiples of it never line up
MOVED, TURNED = 0.002, np.radians(1)  # spacings and rad: less does not show


@dataclass(frozen=True, eq=False)
class State:
    """Objects after `done` steps, their regions, and how far they still have to go.

    cells      of the samples along the outlines; a region is all cells of one object
    owner      (k,) the object that each sample is of, rising
    moments    of the regions, weighed as for moving
    turned_by  of the regions, weighed as for turning
    movement   mean distance to where they are to go, in square roots of the region's area, over the objects that move; 0 if none does
    turning    mean angle to the wanted axis, rad, over the objects that turn; 0 if none does
    moved      the objects a step later
    """

    done: int
    objects: Objects
    cells: Cells
    owner: Index
    moments: Moments
    turned_by: Moments
    movement: float
    turning: float
    moved: Objects

    @property
    def at_rest(self) -> bool:
        """Whether what is left to go would not show: a five hundredth of the spacing and one degree."""
        return self.movement < MOVED and self.turning < TURNED

    def regions(self) -> npt.NDArray[np.object_]:
        """Each object's part of the canvas as a shapely (Multi)Polygon, (n,), empty where it has none; to look at."""
        rings, of = self.cells.rings, self.owner[self.cells.owner]
        polygons, solid = shapely.buffer(rings.polygons(), 0), rings.areas > 0
        found = np.full(len(self.objects), shapely.Polygon(), dtype=object)
        for i in np.unique(of):
            mine = of == i
            found[i] = shapely.difference(shapely.union_all(polygons[mine & solid]), shapely.union_all(polygons[mine & ~solid]))
        return found

    def axes(self) -> Paths:
        """Two segments a region, through its centroid: its long axis, then that across, a standard deviation to either side."""
        covariance = self.turned_by.covariance
        phi, spread = main_axis(covariance)
        half = (covariance[:, 0, 0] + covariance[:, 1, 1]) / 2
        reach = np.sqrt(half[:, None] * np.clip(np.stack([1 + spread, 1 - spread], axis=1), 0, None))
        return crosses(self.turned_by.centroid, phi, reach)


def settle(
    objects: Objects,
    place: Tone | shapely.Geometry,
    *,
    move: float = 1.0,
    turn: float = 1.0,
    exponent: float = 2.0,
    turn_exponent: float = 0.0,
    most_move: float = np.inf,
    most_turn: float = np.inf,
    sampling: float | None = None,
    fixed: npt.ArrayLike | None = None,
    towards: Callable[[Array], Array] | None = None,
) -> Iterator[State]:
    """States of objects that settle without end, as they were given first: Lloyd's relaxation of whole objects.

    An object has the places nearer to its outline than to any other's. In a step it moves to the centroid of that
    region, then turns its long axis to the region's, by the least angle after which it looks as wanted.

    place          a tone, whose canvas they share, or a shapely (Multi)Polygon in mm, the same all over
    move, turn     shares of the way and of the angle in a step, 0 to under 2: 1 is published, 0 keeps them
                   as they are, one half calms what swings
    exponent       regions weigh coverage ** exponent when their centroid is sought: see lloyd()
    turn_exponent  and when their long axis is; 0 is their shape alone
    most_move      mm, and most_turn rad, that an object goes in a step at most
    sampling       mm between samples along the outlines at most; None for 0.15 of the spacing. An outline has eight or
                   more. The border between two objects D apart strays from the true one by up to sampling^2 / 8 D
    fixed          (n,) objects that stay; they keep their regions
    towards        gives directions (n,), rad, one for each of places (n, 2) mm: objects turn to them in place of
                   the regions' axes. Directions half a turn apart are one

    No energy is known to fall: region and pose depend on each other; count the steps, or stop at_rest. A region with
    next to no long axis (anisotropy under 0.05) turns nothing; one without weight keeps its object.
    Centres stay on the canvas: where a centroid lies off it, as in a bay, the nearest place on it is sought; where
    a step would leave it the centre goes all the way, or else stays. Outlines may hang over the edge: nothing is
    cut. What starts off the canvas comes in: it has the places nearest to it, or goes to the nearest if it has none.
    Objects that have all their samples in common with others are parted; those that cross are untangled by their
    regions, nearly all within 60 steps. What starts inside a closed outline stays inside.
    Raises ValueError for a share, exponent, limit, step or mask out of range, and a canvas without area.

    Source: S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003.
    """
    for name, share in (("move", move), ("turn", turn)):
        if not 0 <= share < 2:
            raise ValueError(f"{name} {share} is outside 0 to under 2")
    for name, power in (("exponent", exponent), ("turn_exponent", turn_exponent)):
        if not 0 <= power <= 4:
            raise ValueError(f"{name} {power} is outside 0 to 4")
    for name, limit in (("most_move", most_move), ("most_turn", most_turn), ("sampling", np.inf if sampling is None else sampling)):
        if not limit > 0:
            raise ValueError(f"{name} {limit} is no way to go; it takes a number over 0")
    free = np.ones(len(objects), bool) if fixed is None else ~np.asarray(fixed, bool)
    if free.shape != (len(objects),):
        raise ValueError(f"fixed has shape {free.shape}; it takes one value an object, ({len(objects)},)")
    canvas = place.canvas if isinstance(place, Tone) else place
    if not (shapely.is_valid(canvas) and shapely.area(canvas) > 0):
        raise ValueError(f"canvas has no area or is not sound: {shapely.is_valid_reason(canvas)}; it takes a polygon in mm")
    weight = _weighed(place, exponent if move else turn_exponent)
    turn_weight = weight if turn_exponent == exponent or not turn else _weighed(place, turn_exponent)
    spacing = float(np.sqrt(shapely.area(canvas) / max(1, len(objects))))
    rules = _Rules(canvas, spacing, move, turn, weight, turn_weight, most_move, most_turn, free, towards)
    return _states(objects, *objects.samples(APART * spacing if sampling is None else sampling), rules)


@dataclass(frozen=True, eq=False)
class _Rules:
    """What settle() was asked for; a weight of None is the same all over."""

    canvas: shapely.Geometry
    spacing: float
    move: float
    turn: float
    weight: Tone | None
    turn_weight: Tone | None
    most_move: float
    most_turn: float
    free: npt.NDArray[np.bool_]
    towards: Callable[[Array], Array] | None


def _weighed(place: Tone | shapely.Geometry, exponent: float) -> Tone | None:
    """The tone with coverage ** exponent for coverage, or None where that is the same all over."""
    if isinstance(place, Tone) and exponent == 1:
        return place  # whose sums are kept
    return place.mapped(lambda coverage: coverage**exponent) if isinstance(place, Tone) and exponent else None


def _states(objects: Objects, local: Array, owner: Index, rules: _Rules) -> Iterator[State]:
    n, done, parts = len(objects), 0, None
    while True:
        parts = voronoi(objects.placed(local, owner), rules.canvas, parts)
        if rules.move and parts.net is not None and len(parts.net.unique) < len(owner):
            apart = _parted(objects, np.setdiff1d(np.arange(n), owner[parts.net.unique]), done, rules)
            if (apart.xy != objects.xy).any():
                objects, parts = apart, voronoi(apart.placed(local, owner), rules.canvas)
        sums = _regional(parts, owner, rules.weight, objects.xy)
        turned_by = sums if rules.turn_weight is rules.weight else _regional(parts, owner, rules.turn_weight, objects.xy)
        area = np.bincount(owner, parts.areas, n)
        way = np.where(rules.free[:, None] & (rules.move > 0), _inside(sums.centroid, rules) - objects.xy, 0.0)
        gone = np.hypot(*way.T) / np.sqrt(np.where(area > 0, area, rules.spacing**2))
        angle, turns = _still_to_turn(objects, turned_by, rules)
        movement = float(gone[rules.free].mean()) if rules.move and rules.free.any() else 0.0
        turning = float(np.abs(angle[turns]).mean()) if turns.any() else 0.0
        xy = _moved(objects.xy, way, rules)
        moved = replace(objects, xy=xy, angle=objects.angle + np.clip(rules.turn * angle, -rules.most_turn, rules.most_turn))
        yield State(done, objects, parts, owner, sums, turned_by, movement, turning, moved)
        objects, done = moved, done + 1


def _regional(parts: Cells, owner: Index, weight: Tone | None, xy: Array) -> Moments:
    """The moments of each object's region: sums over the cells of its samples, so that no cells are ever united."""
    if weight is None:
        return pooled(of_rings(parts.rings), owner[parts.owner], len(xy), xy)
    return pooled(of_tone(parts, weight), owner, len(xy), xy)


def _still_to_turn(objects: Objects, regions: Moments, rules: _Rules) -> tuple[Array, npt.NDArray[np.bool_]]:
    """The least angle, rad, from each object's axis to the one wanted, and which objects have one at all."""
    turns = (objects.folds > 0) & rules.free & (rules.turn > 0)
    if rules.towards is None:
        wanted, spread = main_axis(regions.covariance)
        turns &= spread >= ROUND
    else:
        wanted = np.asarray(rules.towards(objects.xy), np.float64)
    # an axis comes back after half a turn, the object after its own part of one: both together after this
    period = 2 * np.pi / np.lcm(np.maximum(objects.folds, 1), 2)
    angle = wanted - objects.angle - objects.own_axes
    return np.where(turns, angle - period * np.ceil(angle / period - 0.5), 0.0), turns


def _moved(xy: Array, way: Array, rules: _Rules) -> Array:
    """Each centre a step further; where that would leave the canvas it goes the whole way, or else stays."""

    def capped(step: Array) -> Array:
        length = np.hypot(*step.T)[:, None]
        return np.asarray(xy + step * np.minimum(1.0, rules.most_move / np.where(length > 0, length, 1.0)))

    target, off = capped(rules.move * way), ~shapely.intersects_xy(rules.canvas, xy)
    for other in (capped(way), xy):
        target = np.where((off | shapely.intersects_xy(rules.canvas, target))[:, None], target, other)
    return target


def _inside(xy: Array, rules: _Rules) -> Array:
    """The same places (n, 2), those off the canvas brought to the nearest on it, a thousandth of the spacing from its edge."""
    off = np.flatnonzero(~shapely.intersects_xy(rules.canvas, xy))
    if not len(off):
        return xy
    inner = shapely.buffer(rules.canvas, -NEXT * rules.spacing)  # on the very edge rounding would decide
    way = shapely.shortest_line(shapely.points(xy[off]), rules.canvas if shapely.is_empty(inner) else inner)
    inside = xy.copy()
    inside[off] = shapely.get_coordinates(way)[1::2]
    return inside


def _parted(objects: Objects, lost: Index, done: int, rules: _Rules) -> Objects:
    """Objects all of whose samples others have too moved off them by a thousandth of the spacing, each its own way round.

    What would leave the canvas tries another way in the next step.
    """
    xy, turn = objects.xy.copy(), GOLDEN * (lost + done)
    xy[lost] += NEXT * rules.spacing * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    stays = ~(rules.free & shapely.intersects_xy(rules.canvas, xy))
    return replace(objects, xy=np.where(stays[:, None], objects.xy, xy))
