"""Each check is shown failing: a check that cannot fail proves nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from checks import (
    check_areas,
    check_cells,
    check_handed_over,
    check_homes,
    check_in_canvas,
    check_least_power,
    check_moments,
    check_nearest,
    check_owners,
    check_partition_of,
    check_paths,
    check_shared_edges,
    shape_of,
)

from crowquill.cells import Cells, voronoi
from crowquill.moments import Moments, of_tone
from crowquill.paths import Paths
from crowquill.tone import Tone

BOX = shapely.box(0, 0, 3, 2)
FRAME = BOX.difference(shapely.box(1, 0.5, 2, 1.5))
SITES = np.random.default_rng(1).random((40, 2)) * (3, 2)
CELLS = voronoi(SITES, BOX)
HORSESHOE = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 0, 2, 2))
ARMS = voronoi([(0.5, 0.5), (2.5, 0.5), (2.5, 2.9)], HORSESHOE)
TONE = Tone(np.repeat([[0.5, 0.0]], 10, axis=0).repeat(10, axis=1), (3, 2))  # white on the right
HALVES = voronoi([(0.5, 1), (2.5, 1)], BOX)


def changed(cells: Cells, **spoiled: object) -> SimpleNamespace:
    """What a check looks at of cells, some of it spoiled."""
    whole = {name: getattr(cells, name) for name in ("sites", "rings", "owner", "canvas", "pairs")} | spoiled
    first = np.searchsorted(np.asarray(whole["owner"]), np.arange(len(cells.sites) + 1))
    return SimpleNamespace(**whole, first=first)


def shifted(cells: Cells, point: int, by: float) -> SimpleNamespace:
    """Cells with one corner pushed so many mm along x, away from its site."""
    xy = cells.rings.xy.copy()
    xy[point, 0] += by * np.sign(xy[point, 0] - cells.sites[cells.owner[cells.rings.path[point]], 0])
    return changed(cells, rings=replace(cells.rings, xy=xy))


def with_pairs(pairs: list) -> SimpleNamespace:
    return SimpleNamespace(rings=CELLS.rings, owner=CELLS.owner, sites=CELLS.sites, pairs=np.array(pairs))


def inner_point(cells: Cells) -> int:
    """A corner of a cell that lies well inside the canvas."""
    return int(shapely.distance(shapely.boundary(cells.canvas), shapely.points(cells.rings.xy)).argmax())


def halved(**spoiled: np.ndarray) -> Moments:
    """Right moments of HALVES on TONE with some rows spoiled."""
    return replace(Moments(np.array([1.5, 0.0]), np.array([(0.75, 1), (2.5, 1)]), np.zeros((2, 2, 2))), **spoiled)


def test_every_check_passes_on_right_answers() -> None:
    check_cells(CELLS)
    check_cells(voronoi(SITES[shapely.contains_xy(FRAME, *SITES.T)], FRAME))
    check_handed_over(ARMS)
    check_partition_of([shape_of(CELLS, i) for i in range(40)], BOX)
    check_moments(halved(), HALVES, TONE)
    check_moments(of_tone(voronoi([(1, 1)], BOX), TONE), voronoi([(1, 1)], BOX), TONE)
    check_in_canvas(SITES, TONE)


@pytest.mark.parametrize(
    ("paths", "words"),
    [
        (SimpleNamespace(xy=np.zeros((1, 2)), start=np.array([0, 1])), "can be written"),
        (SimpleNamespace(xy=np.broadcast_to(np.float32(1), (1, 2)), start=np.broadcast_to(0, 2)), "not finite float64"),
        (SimpleNamespace(xy=np.broadcast_to(np.nan, (1, 2)), start=np.broadcast_to(0, 2)), "not finite float64"),
        (SimpleNamespace(xy=np.broadcast_to(1.0, (1, 2)), start=np.broadcast_to(0, 2)), "starts run from 0 to 0"),
        (SimpleNamespace(xy=np.broadcast_to(1.0, (1, 2)), start=np.frombuffer(np.array([0, 2, 1]).tobytes(), np.int64)), "starts fall"),
        (Paths.of([[(0, 0), (1, 0), (0, 1), (0, 0)]]), "repeat their first point"),
    ],
)
def test_spoiled_paths_are_found(paths: Paths, words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_paths(paths)


@pytest.mark.parametrize(
    ("check", "cells", "words"),
    [
        (check_owners, changed(CELLS, owner=CELLS.owner[:-1]), "40 rings have 39 owners"),
        (check_owners, changed(CELLS, owner=CELLS.owner[::-1]), "owners fall"),
        (check_owners, changed(CELLS, owner=CELLS.owner + 1), "an owner is no site"),
        (check_owners, with_pairs([(1, 0)]), "not i < j"),
        (check_owners, with_pairs([(1, 2), (0, 1)]), "not sorted"),
        (check_owners, with_pairs([(0, 1), (0, 1)]), "repeat"),
        (check_areas, changed(CELLS, rings=CELLS.rings.take(range(1, 40)), owner=CELLS.owner[1:]), "areas sum to the canvas times"),
        (check_areas, shifted(CELLS, int(CELLS.rings.xy[:, 0].argmax()), 1e-7), "areas sum to the canvas times"),
        (check_areas, changed(CELLS, canvas=BOX.buffer(1e-8)), "areas sum to the canvas times"),
        (check_areas, changed(HALVES, rings=Paths.of([HALVES.rings[0][::-1], [(0, 0), (9, 0), (9, 1), (0, 1)]])), "a cell has an area of"),
        (check_homes, changed(CELLS, sites=CELLS.sites[::-1]), "out of its cell"),
        (check_homes, changed(CELLS, rings=CELLS.rings.take(range(1, 40)), owner=CELLS.owner[1:]), "have no cell"),
        (check_homes, changed(HALVES, sites=np.array([(0.5, 1), (0.5, 1)])), "first twin"),
        (check_nearest, changed(CELLS, sites=CELLS.sites + (1e-6, 0) * (np.arange(40) == 7)[:, None]), "nearer to another site"),
        (check_nearest, shifted(CELLS, inner_point(CELLS), 1e-7), "nearer to another site"),
        (check_shared_edges, shifted(CELLS, inner_point(CELLS), 4e-16), "one cell's only"),
        (check_handed_over, changed(ARMS, owner=np.array([0, 0, 2])), "parts that do not touch"),
    ],
)
def test_spoiled_cells_are_found(check, cells: Cells, words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check(cells)


def test_a_corner_of_less_power_to_another_site_is_found() -> None:
    check_least_power(CELLS, np.zeros(40))
    with pytest.raises(AssertionError, match="less power to another site"):
        check_least_power(CELLS, 1e-6 * (np.arange(40) == 7))
    with pytest.raises(AssertionError, match="less power to another site"):
        check_least_power(shifted(CELLS, inner_point(CELLS), 1e-6), np.zeros(40))


def test_a_cell_on_two_islands_is_found() -> None:
    islands = shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)])
    cells = voronoi([(0.5, 0.5), (2.5, 0.5)], islands)
    with pytest.raises(AssertionError, match="lies on another"):
        check_handed_over(changed(cells, owner=cells.owner[::-1]))


@pytest.mark.parametrize(
    ("spoiled", "words"),
    [
        ({"centroid": np.array([(0.75, np.nan), (2.5, 1)])}, "not finite"),
        ({"mass": np.array([1.5 + 1e-11, 0.0])}, "mass differs from ink"),
        ({"mass": np.array([1.5 + 1e-13, -1e-13])}, "a mass is -1e-13"),
        ({"centroid": np.array([(0.75, 1), (2.5 + 1e-15, 1)])}, "lost its site"),
        ({"covariance": np.ones((2, 2, 2))}, "has a spread"),
        ({"centroid": np.array([(1.6, 1), (2.5, 1)])}, "outside its cell"),
        ({"mass": np.array([1.5, 1e-13]), "centroid": np.array([(0.75, 1), (1.4, 1)])}, "outside its cell"),
    ],
)
def test_spoiled_moments_are_found(spoiled: dict, words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_moments(halved(**spoiled), HALVES, TONE)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([shapely.box(0, 0, 1, 2)], "areas sum to"),
        ([shapely.box(0, 0, 2, 2), shapely.box(1, 0, 2, 2)], "the union is not the whole"),
    ],
)
def test_gaps_and_overlaps_are_found(parts: list, words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_partition_of(parts, BOX)


@pytest.mark.parametrize("sites", [np.array([(1, 1), (3.1, 1)]), np.array([(np.nan, 1)]), np.zeros(2)])
def test_sites_outside_are_found(sites: np.ndarray) -> None:
    with pytest.raises(AssertionError, match="sites"):
        check_in_canvas(sites, TONE)
