"""Shapes and objects: centres, axes, symmetry, samples, and outlines that are none."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill.glyphs import load
from crowquill.inertia import main_axis, pooled
from crowquill.marks import Marks
from crowquill.moments import of_rings
from crowquill.objects import Objects, Shape
from crowquill.paths import Paths

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
BAR = [(0, 0), (4, 0), (4, 1), (0, 1)]
FLAG = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 2), (0, 2)]  # looks like itself after a full turn only
EDGES = np.radians([0, 30, 60, 90, 120, 150])


def shape(points, closed: bool = True, **knobs) -> Shape:
    return Shape.of(Paths.of([points], closed=closed), **knobs)


def turned(points, angle: float) -> np.ndarray:
    return np.asarray(points, float) @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def regular(n: int, angle: float = 0.0) -> np.ndarray:
    at = angle + np.arange(n) * 2 * np.pi / n
    return np.stack([np.cos(at), np.sin(at)], axis=1)


def between(a: float, b: float, period: float) -> float:
    return abs((a - b + period / 2) % period - period / 2)


@pytest.mark.parametrize("angle", EDGES)
def test_the_axis_of_a_turned_rectangle_is_its_long_side(angle: float) -> None:
    (phi,), (spread,) = main_axis(of_rings(Paths.of([turned(BAR, angle)])).covariance)
    assert between(phi, angle, np.pi) < 1e-9
    assert spread == pytest.approx(15 / 17, abs=1e-9)  # of 4 by 1: (16 - 1) / (16 + 1)
    assert between(shape(turned(BAR, angle)).axis, angle, np.pi) < 1e-9


def test_a_plain_arctangent_fails_that_test() -> None:
    covariance = of_rings(Paths.of([turned(BAR, angle) for angle in EDGES])).covariance
    phi = 0.5 * np.arctan(2 * covariance[:, 0, 1] / (covariance[:, 0, 0] - covariance[:, 1, 1]))
    assert [between(p, a, np.pi) < 1e-9 for p, a in zip(phi, EDGES, strict=True)] == [True, True, False, False, False, True]


def test_no_spread_at_all_has_no_anisotropy() -> None:
    assert main_axis(np.zeros((1, 2, 2)))[1].tolist() == [0.0]


@pytest.mark.parametrize(
    ("points", "closed", "fold"),
    [
        ([(0, 0)], False, 0),
        ([(0, 0), (3, 1)], False, 2),
        ([(0, 0), (1, 0), (1, 1)], False, 1),
        ([(0, 0), (1, 0), (1, 1), (2, 1)], False, 2),  # a Z
        (BAR, True, 2),
        (SQUARE, True, 4),
        (FLAG, True, 1),
        (regular(3), True, 3),
        (regular(5), True, 5),
        (regular(6), True, 6),
        (regular(12), True, 12),
        (regular(40), True, 0),
        (regular(40) * (1, 0.8), True, 2),
    ],
)
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_shape_looks_the_same_so_many_times_in_a_full_turn(points, closed: bool, fold: int, angle: float) -> None:
    assert shape(turned(points, angle), closed).fold == fold


def test_a_fold_that_is_given_stands() -> None:
    assert shape(SQUARE, fold=1).fold == 1


@pytest.mark.parametrize("n", [3, 4, 5, 6, 12])
def test_a_regular_ring_has_a_side_for_its_axis(n: int) -> None:
    # inertia knows no axis of it; an axis is one line both ways, so that a triangle's sides lie 60 degrees apart
    side = np.pi / 2 + np.pi / n + 0.3
    assert between(shape(regular(n, 0.3)).axis, side, 2 * np.pi / np.lcm(n, 2)) < 1e-9


def test_a_disc_of_cubics_is_a_disc() -> None:
    assert [Shape.of(glyph.paths).fold for glyph in load("disc").glyphs] == [0]


@given(st.floats(-7, 7), st.floats(-1e4, 1e4))
@settings(max_examples=30)
def test_a_shape_is_centred_and_its_axis_turns_with_it(angle: float, far: float) -> None:
    found = shape(turned(FLAG, angle) + far)
    assert np.abs(of_rings(found.paths).centroid).max() < 1e-9  # 1e4 mm off leaves 1e-12 of a millimetre
    assert between(found.axis, shape(FLAG).axis + angle, np.pi) < 1e-9


def test_lines_weigh_by_their_length() -> None:
    found = Objects.of_paths(Paths.of([[(0, 0), (3, 0), (3, 1)]], closed=False))
    # 3 mm about (1.5, 0) and 1 mm about (3, .5)
    assert found.xy[0] == pytest.approx([7.5 / 4, 0.5 / 4], abs=1e-12)


def test_a_letter_with_a_hole_has_the_mass_of_what_is_black() -> None:
    hole = np.array(SQUARE) * 0.5 + (0.4, 0.25)
    both = Objects.of([(0, 0)], (Shape.of(Paths.of([SQUARE, hole])),))
    rings, owner = both.rings()
    assert owner.tolist() == [0, 0] and rings.areas.sum() == pytest.approx(0.75)
    whole = pooled(of_rings(rings), owner, 1, np.zeros((1, 2)))
    assert np.abs(whole.centroid).max() < 1e-12
    # the hole's own corners are sampled too
    corners = rings.xy
    local, _ = both.samples(0.1)
    assert np.hypot(*(corners[:, None] - local).transpose(2, 0, 1)).min(axis=1).max() < 1e-12


def test_a_ring_that_crosses_itself_is_split_and_it_is_said() -> None:
    bow = shape([(0, 0), (2, 2), (2, 0), (0, 2)])
    assert len(bow.paths) == 2 and bow.paths.areas.sum() == pytest.approx(2) and bow.fold == 2
    assert bow.notes == ("an outline crosses itself; it was split where it does",)
    assert Objects.of([(0, 0), (1, 1)], (bow,)).notes == bow.notes
    assert Objects.of([(0, 0)], (bow, shape(SQUARE)), shape=1).notes == ()


@pytest.mark.parametrize(
    ("points", "closed", "said"),
    [
        ([], True, "no points"),
        ([(1, 1), (1, 1)], False, "no length"),
        ([(1, 1), (1, 1), (1, 1)], True, "no area"),
        ([(0, 0), (1, 0)], True, "no area"),
        ([(0, 0), (1, 0), (2, 0)], True, "no area"),
        ([(0, 0), (1, 0), (1, 1), (1, 0)], True, "no area"),  # there and back
    ],
)
def test_what_has_neither_length_nor_area_is_refused(points, closed: bool, said: str) -> None:
    with pytest.raises(ValueError, match=said) as error:
        shape(points, closed)
    assert "\n" not in str(error.value)


def test_an_error_tells_which_path_it_was() -> None:
    with pytest.raises(ValueError, match="path 1: a line has no length"):
        Objects.of_paths(Paths.of([[(0, 0), (1, 0)], [(2, 2), (2, 2)]], closed=False))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"shape": 1}, "index outside 0 to 0"), ({"scale": 0.0}, "scale 0.0 leaves nothing"), ({"angle": np.nan}, "not finite")],
)
def test_objects_are_checked(wrong: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Objects.of([(0, 0)], (shape(SQUARE),), **wrong)


def test_a_negative_fold_is_refused() -> None:
    with pytest.raises(ValueError, match="fold is -1"):
        shape(SQUARE, fold=-1)


def test_paths_become_objects_where_they_lie() -> None:
    paths = Paths.of([turned(FLAG, 0.4) + 7, np.array(BAR) + 1e5])
    found = Objects.of_paths(paths)
    rings, owner = found.rings()
    assert owner.tolist() == [0, 1]
    assert np.abs(rings.xy - paths.xy).max() < 1e-9


def test_points_and_lines_mix_in_one_list_of_paths() -> None:
    found = Objects.of_paths(Paths.of([[(0, 0), (1, 0)], [(3, 4)]], closed=False))
    assert found.points.tolist() == [False, True] and found.folds.tolist() == [2, 0]
    assert found.xy.tolist() == [[0.5, 0], [3, 4]]
    assert len(found.lines()[0]) == 1 and len(found.rings()[0]) == 0


def test_marks_become_objects_and_come_back() -> None:
    rng = np.random.default_rng(0)
    marks = Marks.of(rng.random((5, 2)), load("disc").glyphs, scale=rng.random(5) + 0.1, angle=rng.random(5))
    found = Objects.of_marks(marks)
    back = replace(marks, xy=found.xy, angle=found.angle)
    assert (back.xy == marks.xy).all() and (back.angle == marks.angle).all() and found.shape.tolist() == marks.glyph.tolist()
    # outlines in pieces lie inside the disc by up to a thousandth of its width, its area is 2 widths of that less at most
    assert found.rings()[0].areas == pytest.approx(marks.scale**2, rel=0.01)


def test_joined_objects_keep_order_and_look() -> None:
    bars = Objects.of([(0, 0), (1, 5)], (shape(BAR),), angle=[0, 1], scale=2)
    lines = Objects.of_paths(Paths.of([[(0, 0), (1, 0)], [(3, 4)]], closed=False))
    both = Objects.joined([bars, lines])
    assert len(both) == 4 and both.folds.tolist() == [2, 2, 2, 0]
    assert (both.rings()[0].xy == bars.rings()[0].xy).all() and both.lines()[1].tolist() == [2]
    assert both.take([2, 0]).xy.tolist() == [[0.5, 0], [0, 0]]
    assert both.take(both.points).xy.tolist() == [[3, 4]]
    assert len(Objects.joined([])) == 0


@given(st.floats(0.02, 3), st.floats(0.1, 5), st.sampled_from([BAR, FLAG, regular(40)]), st.booleans())
@settings(max_examples=40)
def test_samples_lie_on_the_outline_no_further_apart_than_asked(most: float, scale: float, points, closed: bool) -> None:
    found = Objects.of([(0, 0), (9, 9)], (shape(points, closed),), scale=[scale, 1], angle=[0, 2])
    local, owner = found.samples(most)
    at, outlines = found.placed(local, owner), found.rings()[0] if closed else found.lines()[0]
    for i in range(2):
        mine, path = at[owner == i], outlines[i]
        line = shapely.linearrings(path) if closed else shapely.linestrings(path)
        assert shapely.distance(shapely.points(mine), line).max() < 1e-9
        far = np.sort(shapely.line_locate_point(line, shapely.points(mine)))
        gaps = np.diff(far, append=line.length + far[0] if closed else far[-1])
        assert gaps.max() <= min(most, line.length / 8) + 1e-9
        corners = path if len(points) < 40 else path[: 0 if closed else 1]  # the many corners of a ring of 40 are no corners
        if len(corners):
            assert shapely.distance(shapely.points(corners), shapely.multipoints(mine)).max() < 1e-9


def test_a_step_that_would_fill_the_memory_is_refused() -> None:
    with pytest.raises(ValueError, match="1e-09 mm makes over"):
        Objects.of([(0, 0)], (shape(BAR),)).samples(1e-9)


def test_axes_reach_as_far_as_the_object() -> None:
    found = Objects.of([(5, 5)], (shape(BAR),), angle=np.pi / 2, scale=2).axes()
    assert found.xy == pytest.approx(np.array([(5, 1), (5, 9), (6, 5), (4, 5)]), abs=1e-9)


def test_a_whole_of_no_mass_has_its_fallback() -> None:
    none = of_rings(Paths.of([]))
    found = pooled(none, np.zeros(0, np.int64), 2, np.array([(1.0, 2), (3, 4)]))
    assert found.mass.tolist() == [0, 0] and found.centroid.tolist() == [[1, 2], [3, 4]] and not found.covariance.any()


def test_a_whole_far_from_the_origin_keeps_its_digits() -> None:
    halves = np.array([[(0, 0), (2, 0), (2, 1), (0, 1)], [(2, 0), (4, 0), (4, 1), (2, 1)]]) + 2.0**20
    found = pooled(of_rings(Paths.of(halves)), np.zeros(2, np.int64), 1, np.full((1, 2), 2.0**20))
    assert np.abs(found.covariance[0] - np.diag([16, 1]) / 12).max() < 1e-12
