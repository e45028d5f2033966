"""Directions, edges and distances against pictures of which they are known: stripes, discs, frames, strokes."""

import numpy as np
import pytest
import shapely

from crowquill import Paths, Tone, field
from crowquill.field import Distances, Field

SIZE = (40.0, 30.0)  # mm, of 200 x 150 pixels of 0.2 mm
X, Y = np.meshgrid((np.arange(200) + 0.5) / 5, (np.arange(150) + 0.5) / 5)
PLACES = np.random.default_rng(1).uniform((5, 5), (35, 25), (200, 2))
FRAME = Paths.of([[(0, 0), (40, 0), (40, 30), (0, 30)]])


def apart(angle, other, fold=2):
    """How far directions are apart that repeat fold times in a full turn, rad."""
    turn = 2 * np.pi / fold
    return np.abs((np.asarray(angle) - other + turn / 2) % turn - turn / 2)


def stripes(angle):
    return 0.5 + 0.4 * np.sin((Y * np.cos(angle) - X * np.sin(angle)) * 2 * np.pi / 1.9)


def disc(radius, centre=(20.0, 15.0), dark=1.0):
    """A disc's coverage, its edge a pixel wide; mm."""
    return dark * np.clip((radius - np.hypot(X - centre[0], Y - centre[1])) / 0.2 + 0.5, 0, 1)


def check_circle(lines, radius, off):
    """Lines run all the way round a circle about (20, 15), no point further from it than `off` mm."""
    way = lines.xy - (20, 15)
    assert np.abs(np.hypot(*way.T) - radius).max() <= off
    turns = np.sort(np.arctan2(*way.T))
    assert np.diff(turns, append=turns[0] + 2 * np.pi).max() < 0.5


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1, np.pi / 2, 2.2, 3.0])
def test_stripes_have_their_own_angle(angle):
    found, sure = field.along(Tone(stripes(angle), SIZE), 1.0).at(PLACES)
    assert apart(found, angle).max() < 2e-3  # of a rad; pixels are square, waves are not whole in them
    assert sure.min() > 0.95


def test_stripes_in_pixels_that_are_not_square_have_their_angle_in_millimetres():
    tall = Tone(stripes(0.7)[::3], SIZE)
    assert apart(field.along(tall, 1.0).at(PLACES)[0], 0.7).max() < 0.02  # three pixels to a stripe are few


def test_a_picture_flipped_has_directions_flipped():
    rng = np.random.default_rng(2)
    tone = rng.random((60, 80))
    here, there = (field.along(Tone(values, SIZE), 2.0) for values in (tone, tone[:, ::-1]))
    assert apart(there.angle[:, ::-1], -here.angle).max() < 1e-9
    assert np.allclose(there.strength[:, ::-1], here.strength)


def test_flat_paper_has_no_direction():
    flat = field.along(Tone(np.full((30, 40), 0.4), SIZE), 1.0)
    assert flat.strength.max() == 0
    assert flat.eased(2.0).strength.max() == 0


def test_between_pixels_directions_meet_as_lines_do():
    two = Field(np.radians([[2.0, 178.0]]), np.ones((1, 2)), (2.0, 1.0))
    angle, strength = two.at([(1.0, 0.5)])
    assert apart(angle, 0)[0] < 1e-12 and strength[0] == pytest.approx(np.cos(np.radians(4)))  # not 90 degrees, the mean of both
    crosses = Field(np.radians([[2.0, 92.0]]), np.ones((1, 2)), (2.0, 1.0), fold=4)
    assert apart(crosses.at([(1.0, 0.5)])[0], np.radians(2), 4)[0] < 1e-12


def test_beyond_the_rectangle_the_nearest_pixel_counts():
    two = Field(np.array([[0.1, 0.2]]), np.ones((1, 2)), (2.0, 1.0))
    assert two.at([(-9, 5), (9, -5)])[0] == pytest.approx([0.1, 0.2])


def test_a_quarter_turn_makes_normals_tangents():
    assert apart(Field(np.zeros((1, 1)), np.ones((1, 1)), (1, 1)).turned(np.pi / 2).at([(0.5, 0.5)])[0], np.pi / 2)[0] < 1e-12


@pytest.mark.parametrize("strength", [[[-0.1]], [[1.5]], [[1.0, 1.0]], [[np.nan]]])
def test_a_strength_that_is_none_is_refused(strength):
    with pytest.raises(ValueError, match="strength"):
        Field(np.zeros((1, 1)), np.array(strength), (1, 1))


def test_directions_spread_to_where_there_are_none():
    left = Field(np.full((30, 40), 0.3), (X[::5, ::5] < 10) * 1.0, SIZE).eased(1.0)
    assert left.strength.min() > 0.99 and apart(left.angle, 0.3).max() < 1e-6


def test_directions_are_smoothed_over_the_length_asked_for():
    step = Field(np.where(X > 20, 0.4, 0.0), np.ones(X.shape), SIZE)
    near, far = (step.eased(length).at([(20 + 2, 15)])[0][0] for length in (0.5, 8.0))
    assert near == pytest.approx(0.4, abs=0.01)  # four lengths off: e^-4 of the step is left
    assert 0.2 < far < 0.36
    with pytest.raises(ValueError, match="length is 0"):
        step.eased(0)


def test_distances_to_a_frame_are_exact():
    found = field.distances(FRAME, SIZE, (150, 200))
    assert np.abs(found.mm - np.minimum.reduce([X, Y, 40 - X, 30 - Y])).max() < 1e-12
    assert found.at([(20, 15)])[0] == pytest.approx(15 - 0.1, abs=1e-9)  # straight between centres a ridge is cut off


def test_distances_are_those_of_shapely():
    rng = np.random.default_rng(3)
    lines = Paths.of([rng.uniform(0, 30, (k, 2)) for k in (2, 3, 7)], closed=False)
    found = field.distances(lines, SIZE, (15, 20))
    whole = shapely.union_all([shapely.LineString(line) for line in lines])
    points = shapely.points(*np.meshgrid(np.arange(20) * 2 + 1.0, np.arange(15) * 2 + 1.0))
    assert np.abs(found.mm - shapely.distance(whole, points)).max() < 1e-12


def test_the_last_side_of_a_ring_counts_and_of_a_line_there_is_none():
    at = [(0.1, 15)]
    assert field.distances(FRAME, SIZE).at(at)[0] < 0.2
    assert field.distances(Paths(FRAME.xy, FRAME.start, closed=False), SIZE).at(at)[0] > 10


def test_no_lines_are_as_far_as_the_rectangle_is_across():
    assert field.distances(Paths.of([]), SIZE).mm.min() == pytest.approx(50)


def test_from_a_circle_distance_grows_along_the_radius():
    turn = np.linspace(0, 2 * np.pi, 721)[:-1]
    circle = Paths.of([np.stack([20 + 8 * np.cos(turn), 15 + 8 * np.sin(turn)], axis=1)])
    away = field.distances(circle, SIZE).field()
    off = np.abs(np.hypot(*(PLACES - (20, 15)).T) - 8) > 0.5
    inner = np.hypot(*(PLACES - (20, 15)).T) > 1.0
    wanted = np.arctan2(*(PLACES - (20, 15)).T[::-1])
    angle, strength = away.at(PLACES)
    assert apart(angle, wanted)[off & inner].max() < 0.03  # rad: a pixel of 0.17 mm seen from 1 mm
    assert strength[off & inner].min() > 0.97


def test_a_reach_makes_what_is_near_count_more():
    near, far = field.distances(FRAME, SIZE).field(reach=3.0).at([(20, 1), (20, 9)])[1]
    assert near == pytest.approx(np.exp(-1 / 9), rel=0.05) and far == pytest.approx(np.exp(-9), rel=0.2)


def test_crosses_in_a_frame_lie_with_it_to_the_corners_and_the_middle():
    away = field.distances(FRAME, SIZE).field(reach=4.0, fold=4)
    angle, strength = away.eased(1.0).at(PLACES)
    assert apart(angle, 0, 4).max() < np.radians(1) and strength.min() > 0.9
    _, lines = field.distances(FRAME, SIZE).field(reach=4.0).eased(1.0).at([(5.0, 5.0)])
    assert lines[0] < 0.5  # as lines, what comes from two sides cancels on the diagonal


def test_edges_of_a_disc_lie_on_its_circle():
    for sigma in (0.2, 0.4):
        lines = field.edges(Tone(disc(10.0), SIZE), sigma)
        assert len(lines) == 1 and not lines.closed
        check_circle(lines, 10.0, 0.1)  # half a pixel


def test_the_check_of_edges_sees_a_circle_beside_and_a_part_of_one():
    lines = field.edges(Tone(disc(10.0), SIZE), 0.3)
    with pytest.raises(AssertionError):
        check_circle(lines.moved(np.eye(2), (0.2, 0)), 10.0, 0.1)
    with pytest.raises(AssertionError):
        check_circle(Paths.of([lines[0][: len(lines[0]) // 2]], closed=False), 10.0, 0.1)


@pytest.mark.parametrize("place", [12.0, 12.05, 12.1, 12.17])
def test_an_edge_lies_between_pixels_where_it_is(place):
    (line,) = field.edges(Tone(np.clip((X - place) / 0.2 + 0.5, 0, 1), SIZE), 0.3)
    assert np.abs(line[:, 0] - place).max() < 0.02  # mm, a tenth of a pixel: what is 0 there is no straight line between pixels


def test_faint_edges_are_kept_only_where_they_lead_to_strong_ones():
    fading = np.where(X > 20, 0.3 * np.clip(Y / 30, 0, 1), 0.0)
    (line,) = field.edges(Tone(fading, SIZE), 0.4, low=0.1, high=0.25)
    assert line[:, 1].min() == pytest.approx(10, abs=0.5) and line[:, 1].max() > 29  # the step is 0.1 at y = 10
    assert len(field.edges(Tone(fading, SIZE), 0.4, low=0.1, high=0.35)) == 0


def test_short_edges_are_left_out():
    both = Tone(np.maximum(disc(8.0, (12, 15)), disc(1.0, (33, 15))), SIZE)
    assert len(field.edges(both, 0.3)) == 2
    assert len(field.edges(both, 0.3, least=20.0)) == 1


@pytest.mark.parametrize("shape", [(1, 40), (30, 1), (1, 1), (30, 40)])
def test_pictures_of_one_row_or_one_tone_have_no_edges(shape):
    assert len(field.edges(Tone(np.full(shape, 0.5), SIZE), 0.5)) == 0


def svg(inside, size='width="80mm" height="60mm" viewBox="0 0 80 60"'):
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{inside}</svg>'.encode()


def test_strokes_of_a_file_lead_the_places_around_them():
    found = field.strokes(svg('<path d="M10 10L30 30"/><g transform="translate(60 50)"><path d="M0 0h10"/></g>'), "x.svg", SIZE)
    angle, strength = found.at([(10, 10), (6, 6), (32.5, 25), (38, 27)])
    assert apart(angle[:2], np.pi / 4).max() < 0.02 and apart(angle[2:], 0).max() < 0.1  # a little of the other reaches there
    assert strength[[0, 2]].min() > 0.8


def test_a_stroke_either_way_is_the_same_stroke():
    one, other = (field.strokes(svg(f'<path d="{d}"/>'), "x.svg", SIZE) for d in ("M10 10L30 40", "M30 40L10 10"))
    assert np.allclose(one.waves, other.waves, atol=1e-6)


@pytest.mark.parametrize("inside", ["", "<text>a</text>", '<path d="M5 5L5 5"/>'])
def test_a_file_without_strokes_is_refused(inside):
    with pytest.raises(ValueError, match=r"x\.svg: has no lines .*; draw strokes"):
        field.strokes(svg(inside), "x.svg", SIZE)


def test_values_between_centres_are_straight():
    ramp = Distances(np.arange(4.0).reshape(1, 4), (4.0, 1.0))
    assert ramp.at([(0.5, 0.5), (1.25, 0.1), (3.5, 0.9), (9, 9)]) == pytest.approx([0, 0.75, 3, 3])


def test_edges_do_not_hang_on_how_fine_the_pixels_are_below_their_blur():
    y, x = np.indices((1500, 1500)) / 50 + 0.01
    fine = Tone(np.where(np.hypot(x - 15, y - 15) < 9, 0.7, 0.0), (30, 30))
    (ring,) = field.edges(fine, 1.2)
    assert np.hypot(*(ring - 15).T).mean() == pytest.approx(9 - 1.2**2 / 18, abs=2e-3) and len(ring) < 400
