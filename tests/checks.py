"""Facts that hold for every right answer, whatever the input; tests run them on all that hypothesis finds.

Each check raises AssertionError and says by how much; test_checks.py shows each of them doing so.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely
from scipy.spatial import cKDTree

from crowquill.cells import Cells
from crowquill.moments import Moments
from crowquill.paths import Array, Paths
from crowquill.tone import Tone

ROUNDING = 1e-9  # of the size of the data: clipping and circle centres round at 1e-16, thin triangles cost some digits


def extent(cells: Cells) -> float:
    """The diagonal of the box of canvas and sites, mm: what rounding errors of a diagram are measured by."""
    corners = np.concatenate([np.reshape(shapely.bounds(cells.canvas), (2, 2)), cells.sites])
    return float(np.hypot(*np.ptp(corners, axis=0)))


def rounding(cells: Cells) -> float:
    """Distance in mm that rounding may cost: relative to the diagram, and the last bits of a far origin."""
    return ROUNDING * extent(cells) + 64 * float(np.spacing(np.abs(shapely.bounds(cells.canvas)).max()))


def shape_of(cells: Cells, i: int) -> shapely.Geometry:
    """The part of the canvas that site i has, as one shapely geometry; outer rings turn from x to y, holes back."""
    rings = cells.rings.take(np.arange(cells.first[i], cells.first[i + 1]))
    polygons, solid = shapely.buffer(rings.polygons(), 0), rings.areas > 0  # a buffer of 0 mends crossings by rounding
    return shapely.difference(shapely.union_all(polygons[solid]), shapely.union_all(polygons[~solid]))


def check_paths(paths: Paths) -> None:
    """Read-only arrays; starts rise from 0 to the number of points; no ring repeats its first point."""
    assert not paths.xy.flags.writeable and not paths.start.flags.writeable, "arrays can be written"
    assert paths.xy.dtype == np.float64 and np.isfinite(paths.xy).all(), "points are not finite float64"
    assert paths.start[0] == 0 and paths.start[-1] == len(paths.xy), f"starts run from {paths.start[0]} to {paths.start[-1]}"
    assert (np.diff(paths.start) >= 0).all(), "starts fall"
    again = [i for i, ring in enumerate(paths) if paths.closed and len(ring) > 1 and (ring[0] == ring[-1]).all()]
    assert not again, f"rings {again} repeat their first point"


def check_owners(cells: Cells) -> None:
    """Rings are sound, owners rise and are sites, pairs are i < j and sorted."""
    check_paths(cells.rings)
    assert len(cells.owner) == len(cells.rings), f"{len(cells.rings)} rings have {len(cells.owner)} owners"
    assert (np.diff(cells.owner) >= 0).all(), "owners fall"
    assert not len(cells.owner) or 0 <= cells.owner[0] <= cells.owner[-1] < len(cells.sites), "an owner is no site"
    pairs = cells.pairs
    assert pairs.shape[1:] == (2,) and (pairs[:, 0] < pairs[:, 1]).all(), "a pair is not i < j"
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    assert (order == np.arange(len(pairs))).all() and len(np.unique(pairs, axis=0)) == len(pairs), "pairs are not sorted or repeat"


def check_areas(cells: Cells) -> None:
    """Areas sum to the canvas, and no cell has less than none."""
    area = cells.canvas.area
    off = cells.rings.areas.sum() / area - 1 if len(cells.sites) else 0.0
    # about a far origin the canvas's own corners are known to their last bits only
    digits = float(np.spacing(np.abs(shapely.bounds(cells.canvas)).max())) * cells.canvas.length / area
    assert abs(off) <= ROUNDING + 8 * digits, f"areas sum to the canvas times 1 {off:+.2e}"
    least = np.bincount(cells.owner, cells.rings.areas, len(cells.sites)).min(initial=0.0)
    assert least >= -ROUNDING * area, f"a cell has an area of {least}"


def check_homes(cells: Cells) -> None:
    """A site in the canvas has a cell and lies in it; of coincident sites the first has it and the others none."""
    _, first, same = np.unique(cells.sites + 0.0, axis=0, return_index=True, return_inverse=True)
    twin = first[same.ravel()] != np.arange(len(cells.sites))
    counts = np.diff(cells.first)
    assert not counts[twin].any(), f"sites {np.flatnonzero(twin & (counts > 0))} have a cell that their first twin has"
    # a site on the border, within rounding, may see its cell end just short of it
    within = shapely.contains_xy(shapely.buffer(cells.canvas, -2 * rounding(cells)), *cells.sites.T)
    homeless = np.flatnonzero(within & ~twin & (counts == 0))
    assert not len(homeless), f"sites {homeless} lie in the canvas and have no cell"
    solid = np.flatnonzero(cells.rings.areas > -ROUNDING * cells.canvas.area)  # a cell of a few last digits may have none
    out = np.full(len(cells.sites), np.inf)
    at = cells.owner[solid]
    np.minimum.at(out, at, shapely.distance(cells.rings.take(solid).polygons(), shapely.points(cells.sites[at])))
    worst = out[within & ~twin].max(initial=0.0)
    assert worst <= rounding(cells), f"a site lies {worst} mm out of its cell"


def check_nearest(cells: Cells) -> None:
    """No site is nearer to a cell's corner than the cell's own.

    Where the canvas is not convex only the rings around their own sites are asked: the others may have been handed over.
    """
    if not len(cells.sites):
        return
    own = cells.owner[cells.rings.path]
    asked = np.ones(len(cells.rings), bool)
    if cells.canvas.convex_hull.area > cells.canvas.area * (1 + ROUNDING):
        asked = shapely.contains(cells.rings.polygons(), shapely.points(cells.sites[cells.owner]))
    asked = asked[cells.rings.path]
    far = np.hypot(*(cells.rings.xy - cells.sites[own]).T)[asked]
    least = cKDTree(cells.sites).query(cells.rings.xy[asked])[0]
    worst = (far - least).max(initial=0.0)
    assert worst <= rounding(cells), f"a corner is {worst} mm nearer to another site than to its own"


def check_least_power(cells: Cells, weights: Array) -> None:
    """At a cell's corner no site has a smaller squared distance, less its weight, than the cell's own."""
    own = cells.owner[cells.rings.path]
    powers = ((cells.rings.xy[:, None] - cells.sites) ** 2).sum(axis=2) - weights
    worst = (powers[np.arange(len(own)), own] - powers.min(axis=1, initial=np.inf)).max(initial=0.0)
    # a place off by the rounding is off by twice that times its distance to the furthest site in power
    assert worst <= 2 * rounding(cells) * extent(cells), f"a corner has {worst} mm2 less power to another site than to its own"


def check_shared_edges(cells: Cells) -> None:
    """Each side of a cell that the canvas's outline does not touch is, bit for bit, another cell's side walked back."""
    rings = cells.rings
    after = np.arange(1, len(rings.xy) + 1)
    filled = np.diff(rings.start) > 0
    after[rings.start[1:][filled] - 1] = rings.start[:-1][filled]
    free = shapely.distance(shapely.boundary(cells.canvas), shapely.points(rings.xy)) > rounding(cells)
    there = np.hstack([rings.xy, rings.xy[after]])[free & free[after]]
    there = there[(there[:, :2] != there[:, 2:]).any(axis=1)]
    back = there[:, [2, 3, 0, 1]]
    alone = {row.tobytes() for row in there} ^ {row.tobytes() for row in back}
    assert not alone, f"{len(alone) // 2} of {len(there)} sides inside the canvas are one cell's only"


def check_cells(cells: Cells) -> None:
    """All that holds for the cells of any sites in any canvas."""
    check_owners(cells)
    check_areas(cells)
    check_homes(cells)
    check_nearest(cells)
    check_shared_edges(cells)


def check_handed_over(cells: Cells) -> None:
    """On an island with sites, no cell is of another island's site, and each is in one part: parts cut off went to whom they touch."""
    points = shapely.points(cells.sites)
    inside = shapely.contains(cells.canvas, points)
    for island in shapely.get_parts(cells.canvas):
        here = shapely.contains(island, points)
        for i in np.unique(cells.owner) if here.any() else ():
            shape = shapely.intersection(shape_of(cells, i), island)
            if shape.area > ROUNDING * island.area:
                assert here[i] or not inside[i], f"site {i} has part of an island, and lies on another"
                parts = shapely.get_num_geometries(shapely.buffer(shape, rounding(cells)))
                assert parts == 1, f"the cell of site {i} is in {parts} parts that do not touch"


def check_moments(moments: Moments, cells: Cells, tone: Tone) -> None:
    """Mass sums to the ink, none is negative, a cell without ink keeps its site, centroids lie in the hulls of cells."""
    for values in (moments.mass, moments.centroid, moments.covariance):
        assert np.isfinite(values).all(), "a moment is not finite"
    off = moments.mass.sum() - tone.ink
    assert abs(off) <= 1e-12 * tone.ink, f"mass differs from ink by {off / tone.ink:+.1e} of it"  # sums of n roundings of 1e-16
    assert (moments.mass >= 0).all(), f"a mass is {moments.mass.min()}"
    none = moments.mass == 0
    assert (moments.centroid[none] == cells.sites[none]).all(), "a cell without ink has lost its site"
    assert not moments.covariance[none].any(), "a cell without ink has a spread"
    for i in np.flatnonzero(~none):
        cell = shape_of(cells, i)
        # where next to nothing is left of sums over whole pixels the hull is lost in rounding, but never the cell's box
        hull = cell.convex_hull if moments.mass[i] > 1e-6 * cell.area else cell.envelope
        out = shapely.distance(hull, shapely.Point(moments.centroid[i]))
        assert out <= rounding(cells), f"centroid {i} lies {out} mm outside its cell, whose mass is {moments.mass[i]}"


def check_partition_of(parts: npt.NDArray[np.object_], whole: shapely.Geometry) -> None:
    """Shapes that fill the whole and do not overlap, by shapely's own union."""
    union, total = shapely.union_all(parts), float(shapely.area(parts).sum())
    assert abs(total / whole.area - 1) <= ROUNDING, f"areas sum to {total / whole.area} of the whole"
    assert shapely.symmetric_difference(union, whole).area <= ROUNDING * whole.area, "the union is not the whole"


def check_in_canvas(sites: Array, tone: Tone) -> None:
    """Every site is finite and lies in the tone's canvas or on its border."""
    assert sites.ndim == 2 and sites.shape[1] == 2, f"sites have shape {sites.shape}"
    out = ~tone.holds(sites)
    assert not out.any(), f"{out.sum()} sites lie outside the canvas, the first at {sites[out][0]}"
