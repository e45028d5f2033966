"""Objects that settle from where nobody would put them, and settings that make no sense."""

from itertools import islice

import numpy as np
import pytest
import shapely

from crowquill.objects import Objects, Shape
from crowquill.paths import Paths
from crowquill.relax import settle
from crowquill.settling import State
from crowquill.tone import Tone

UNIT = shapely.box(0, 0, 1, 1)
HORSESHOE = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 0, 2, 2))
POINT = Shape.of(Paths.of([[(0, 0)]]))
LINE = Shape.of(Paths.of([[(0, 0), (1, 0)]], closed=False))
SQUARE = Shape.of(Paths.of([[(0, 0), (1, 0), (1, 1), (0, 1)]]))


def after(steps: int, objects: Objects, place, **knobs) -> State:
    return next(islice(settle(objects, place, **knobs), steps, None))


def test_no_objects_are_at_rest() -> None:
    state = after(2, Objects.of([], ()), UNIT)
    assert len(state.objects) == len(state.moments.mass) == len(state.regions()) == len(state.axes()) == 0 and state.at_rest


@pytest.mark.parametrize("shape", [POINT, LINE, SQUARE])
def test_coincident_objects_are_parted(shape: Shape) -> None:
    state = after(60, Objects.of([(0.3, 0.3)] * 6, (shape,), scale=0.1), UNIT)
    assert state.moments.mass.min() > 0.05  # of a sixth each
    outlines = [shapely.linestrings(path) for path in (state.objects.rings()[0] if shape is SQUARE else state.objects.lines()[0])]
    apart = shapely.distance(np.array(outlines)[:, None], np.array(outlines)[None])[~np.eye(len(outlines), dtype=bool)]
    assert not len(apart) or apart.min() > 0.05


def test_coincident_objects_that_stay_are_not_parted() -> None:
    first = Objects.of([(0.3, 0.3)] * 3, (LINE,), scale=0.1)
    assert (after(2, first, UNIT, move=0).objects.xy == first.xy).all()
    held = after(2, first, UNIT, fixed=[True, True, False])
    assert (held.objects.xy[:2] == first.xy[:2]).all() and (held.objects.xy[2] != first.xy[2]).any()
    assert held.moments.mass[1] == 0 and np.isfinite(held.moments.centroid).all()  # the first has the cells of both


def test_lines_that_cross_in_their_middles_share_samples_and_come_apart() -> None:
    state = after(100, Objects.of([(0.5, 0.5), (0.5, 0.5)], (LINE,), angle=[0.4, 1.3], scale=0.4), shapely.box(0, 0, 1, 1.1))
    a, b = shapely.linestrings(state.objects.lines()[0].xy.reshape(2, 2, 2))
    assert shapely.distance(a, b) > 0.2 and state.moments.mass.sum() == pytest.approx(1.1)


def test_objects_larger_than_the_canvas_stay_about_it() -> None:
    state = after(20, Objects.of([(0.2, 0.3), (0.6, 0.1), (0.9, 0.9)], (LINE, SQUARE), scale=[5, 5, 0.1], shape=[0, 1, 0]), UNIT)
    assert np.isfinite(state.objects.xy).all() and state.moments.mass.sum() == pytest.approx(1)
    assert shapely.intersects_xy(UNIT, state.objects.xy).all()


@pytest.mark.parametrize("knobs", [{}, {"move": 0.5}, {"most_move": 0.2}])
def test_what_lies_off_the_canvas_comes_in(knobs: dict) -> None:
    slanted = shapely.Polygon([(0, 0), (1, 0.3), (0.7, 1.3), (-0.3, 1)])
    # the first two are nearest to nothing, and lie in one place
    state = after(40, Objects.of([(3, 3), (3, 3), (0.2, 0.2), (1.2, 0.7)], (LINE,), scale=0.3), slanted, **knobs)
    assert shapely.intersects_xy(slanted, state.objects.xy).all() and state.moments.mass.min() > 0.1
    assert not after(0, Objects.of([(3, 3), (0.5, 0.65)], (POINT,)), slanted).at_rest


def test_a_centroid_in_a_bay_sends_its_object_to_the_nearest_place_on_the_canvas() -> None:
    # one object has all of a horseshoe, whose centroid lies in its mouth
    state = after(3, Objects.of([(0.5, 0.5)], (LINE,), angle=0.2, scale=0.3), HORSESHOE)
    assert not shapely.intersects_xy(HORSESHOE, state.moments.centroid).any()
    assert shapely.intersects_xy(HORSESHOE, state.objects.xy).all() and state.movement < 1e-9
    # the spacing is the root of 7, a thousandth of which it keeps from the edge
    away = shapely.distance(HORSESHOE, shapely.points(state.moments.centroid[0]))
    assert np.hypot(*(state.objects.xy - state.moments.centroid).T)[0] == pytest.approx(away + 1e-3 * np.sqrt(7), abs=1e-9)


def test_an_island_of_canvas_belongs_to_somebody() -> None:
    islands = shapely.union(UNIT, shapely.box(3, 0, 4, 1))
    state = after(10, Objects.of([(0.2, 0.2), (0.6, 0.6), (3.5, 0.5)], (LINE, POINT), shape=[0, 1, 0], scale=0.3), islands)
    assert state.moments.mass.sum() == pytest.approx(2) and shapely.intersects_xy(islands, state.objects.xy).all()


def test_a_far_canvas_costs_no_digits() -> None:
    rng = np.random.default_rng(0)
    xy, angle = rng.random((20, 2)), rng.random(20)
    near = after(5, Objects.of(xy, (LINE,), angle=angle, scale=0.1), UNIT).objects
    far = after(
        5, Objects.of(xy + 2.0**17, (LINE,), angle=angle, scale=0.1), shapely.box(2.0**17, 2.0**17, 2.0**17 + 1, 2.0**17 + 1)
    ).objects
    # a coordinate of 1e5 is kept to 1e-11, a sample cannot be placed better, and circles through close samples lose some digits
    assert np.abs(far.xy - 2.0**17 - near.xy).max() < 1e-6 and np.abs(far.angle - near.angle).max() < 1e-6


def test_the_same_input_gives_the_same_bytes() -> None:
    rng = np.random.default_rng(0)
    first = Objects.of(rng.random((50, 2)), (LINE, SQUARE), angle=rng.random(50), scale=0.1, shape=rng.integers(0, 2, 50))
    tone = Tone(rng.random((30, 30)), (1, 1))
    a, b = (after(4, first, tone, turn_exponent=1).objects for _ in range(2))
    assert a.xy.tobytes() == b.xy.tobytes() and a.angle.tobytes() == b.angle.tobytes()


def test_regions_have_two_axes_to_draw() -> None:
    state = after(0, Objects.of([(1, 1)], (LINE,)), shapely.box(0, 0, 4, 2))
    a, b = np.array([4, 2]) / np.sqrt(12)  # standard deviations of a rectangle's sides
    assert state.axes().xy == pytest.approx(np.array([(2 - a, 1), (2 + a, 1), (2, 1 - b), (2, 1 + b)]), abs=1e-9)


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"move": 2}, "move 2 is outside 0 to under 2"),
        ({"turn": -0.1}, "turn -0.1 is outside"),
        ({"turn": float("nan")}, "turn nan is outside"),
        ({"exponent": 5}, "exponent 5 is outside 0 to 4"),
        ({"turn_exponent": -1}, "turn_exponent -1 is outside"),
        ({"most_move": 0}, "most_move 0 is no way"),
        ({"most_turn": -1}, "most_turn -1 is no way"),
        ({"sampling": 0}, "sampling 0 is no way"),
        ({"fixed": [True]}, r"fixed has shape \(1,\)"),
    ],
)
def test_settings_out_of_range_are_refused_at_once(knobs: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        settle(Objects.of([(0, 0), (1, 1)], (LINE,)), UNIT, **knobs)


@pytest.mark.parametrize("canvas", [shapely.Polygon(), shapely.Point(0, 0), shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])])
def test_a_canvas_without_sound_area_is_refused(canvas: shapely.Geometry) -> None:
    with pytest.raises(ValueError, match="canvas has no area or is not sound"):
        settle(Objects.of([(0, 0)], (LINE,)), canvas)
