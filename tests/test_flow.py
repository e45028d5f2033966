"""The flow of pictures along their edges, and the lines drawn along it, against pictures of which both are known."""

import numpy as np
import pytest
import shapely
from scipy.ndimage import gaussian_filter

from crowquill import Paths, Tone, field
from crowquill.field import Sight, flow

SIZE = (40.0, 30.0)  # mm, of 200 x 150 pixels of 0.2 mm
X, Y = np.meshgrid((np.arange(200) + 0.5) / 5, (np.arange(150) + 0.5) / 5)
FROM = np.hypot(X - 20, Y - 15)  # mm from the middle
WIDTH = 0.5  # mm of strokes
PLACES = np.random.default_rng(1).uniform((5, 5), (35, 25), (200, 2))


def soft(off):
    """0 to 1 where `off` mm rise through 0, within a pixel."""
    return np.clip(off / 0.2 + 0.5, 0, 1)


def stroke(off, width=WIDTH, dark=0.8):
    """A dark line `off` mm from here."""
    return dark * soft(width / 2 - np.abs(off))


def apart(angle, other):
    """How far directions of lines are apart, rad."""
    return np.abs((np.asarray(angle) - other + np.pi / 2) % np.pi - np.pi / 2)


def found(coverage, width=WIDTH, **knobs):
    return field.lines(Tone(np.clip(coverage, 0, 1), SIZE), width, **knobs)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1, np.pi / 2, 2.2, 3.0])
def test_flow_runs_along_stripes(angle):
    stripes = 0.5 + 0.4 * np.sin((Y * np.cos(angle) - X * np.sin(angle)) * 2 * np.pi / 3)
    found, sure = field.tangents(Tone(stripes, SIZE), 0.3).at(PLACES)
    assert apart(found, angle).max() < 0.01 and sure.min() > 0.99  # rad: waves are not whole in the kernel


def test_flow_runs_around_a_disc_within_reach_of_its_edge():
    around = field.tangents(Tone(0.8 * soft(10 - FROM), SIZE), 0.4)
    turn = np.linspace(0, 2 * np.pi, 100)
    for radius in (9.0, 10.0, 11.0):
        xy = np.stack([20 + radius * np.cos(turn), 15 + radius * np.sin(turn)], axis=1)
        assert apart(around.at(xy)[0], turn + np.pi / 2).max() < 0.06  # rad: the kernel is a cross, 2 mm to each side


def test_noise_is_led_by_the_stronger_edge_beside_it():
    noisy = 0.3 * soft(X - 20) + np.random.default_rng(5).uniform(0, 0.1, X.shape)
    beside = np.stack([np.full(50, 21.4), np.linspace(3, 27, 50)], axis=1)  # 4.7 sigmas off: all there is is noise
    off = [apart(field.tangents(Tone(noisy, SIZE), 0.3, rounds).at(beside)[0], np.pi / 2).mean() for rounds in (1, 3)]
    assert off[1] < 0.3 and off[1] < 0.7 * off[0]  # rad; chance alone is 0.79


@pytest.mark.parametrize("shape", [(30, 40), (1, 40), (30, 1), (1, 1)])
def test_flat_paper_has_no_flow_and_no_lines(shape):
    flat = Tone(np.full(shape, 0.4), SIZE)
    assert field.tangents(flat, 0.3).strength.max() == 0
    assert len(field.lines(flat, WIDTH, detail=1.0)) == 0


def test_means_along_the_flow_keep_edges_and_even_out_what_lies_along_them():
    bumpy = 0.2 + 0.6 * soft(X - 20) + 0.1 * np.sin(Y * 2 * np.pi)
    tone = Tone(np.clip(bumpy, 0, 1), SIZE)
    smooth = flow.smoothed(tone.coverage, field.tangents(tone, 0.4), 1.5)
    inner = (abs(X - 20) < 1) & (abs(Y - 15) < 10)
    assert np.ptp(smooth[inner & (X > 20.2)]) < 0.25 * np.ptp(bumpy[inner & (X > 20.2)])
    assert smooth[inner & (X > 20.2)].min() - smooth[inner & (X < 19.8)].max() > 0.5  # of a step of 0.6


def test_a_dark_line_is_drawn_once_along_its_middle():
    lines = found(stroke(FROM - 10))
    assert len(lines) == 1 and not lines.closed
    assert np.abs(np.hypot(*(lines.xy - (20, 15)).T) - 10).max() < 0.03  # mm, a sixth of a pixel
    assert np.hypot(*np.diff(lines[0], axis=0).T).sum() == pytest.approx(20 * np.pi, rel=0.005)
    assert (lines[0][0] == lines[0][-1]).all()


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2])
def test_a_straight_line_stays_straight(angle):
    (line,) = found(stroke((Y - 15) * np.cos(angle) - (X - 20) * np.sin(angle)))
    assert np.abs((line[:, 1] - 15) * np.cos(angle) - (line[:, 0] - 20) * np.sin(angle)).max() < 0.02


def test_an_edge_is_drawn_on_its_dark_side_where_the_stroke_ends_with_it():
    lines = found(0.8 * soft(10 - FROM))
    assert len(lines) == 1
    assert np.abs(np.hypot(*(lines.xy - (20, 15)).T) - (10 - 0.62 * WIDTH)).max() < 0.08  # mm: pixels of 0.2 blur it some more


def test_a_line_of_light_is_no_line_but_two_edges():
    lines = found(0.8 - stroke(X - 20, 1.0, 0.7))
    assert len(lines) == 2
    assert sorted(np.mean(line[:, 0]) for line in lines) == pytest.approx([20 - 0.5 - 0.31, 20 + 0.5 + 0.31], abs=0.08)


def test_more_detail_brings_fainter_lines_and_keeps_the_strong_ones():
    both = 0.1 + stroke(X - 12, dark=0.8) + stroke(X - 28, dark=0.08)
    counts = [len(found(both, detail=detail)) for detail in (0.0, 0.2, 0.5, 0.8, 1.0)]
    assert counts[1] == 1 and counts[-1] == 2 and counts == sorted(counts)


def test_a_line_that_fades_is_followed_down_to_a_third():
    fading = stroke(X - 20) * np.clip(Y / 30, 0, 1)
    (line,) = found(fading, detail=0.3)
    low, high = field.contrast(0.3)
    assert high == pytest.approx(3 * low) and len(found(fading * 0.9 * low, detail=0.3)) == 0
    assert line[:, 1].max() > 29 and 2 < line[:, 1].min() < 12


def test_short_lines_are_specks_and_left_out():
    dash = stroke(X - 20) * soft(1.0 - np.abs(Y - 15))
    assert len(found(dash)) == 0 and len(found(dash, least=0.5)) == 1


def test_lines_are_the_same_on_pixels_that_are_finer_than_a_pen_needs():
    fine = np.meshgrid((np.arange(1600) + 0.5) / 40, (np.arange(1200) + 0.5) / 40)
    tone = Tone(stroke(np.hypot(fine[0] - 20, fine[1] - 15) - 10), SIZE)
    assert max(Sight.of(tone, WIDTH).tone.coverage.shape) < 300
    lines = field.lines(tone, WIDTH)
    assert len(lines) == 1 and np.abs(np.hypot(*(lines.xy - (20, 15)).T) - 10).max() < 0.02


def test_a_picture_flipped_has_its_lines_flipped():
    blots = gaussian_filter(np.random.default_rng(3).random((120, 120)), 4)
    blots = (blots - blots.min()) / np.ptp(blots)
    one, other = (field.lines(Tone(values, (30.0, 30.0)), WIDTH) for values in (blots, blots[:, ::-1]))
    here, there = (shapely.union_all([shapely.LineString(line) for line in lines]) for lines in (one, other))
    back = shapely.transform(there, lambda xy: np.stack([30 - xy[:, 0], xy[:, 1]], axis=1))
    assert here.length > 30 and here.length == pytest.approx(back.length, rel=0.01)  # rounding decides on a line's last square
    assert shapely.buffer(here, 0.05).intersection(back).length > 0.99 * back.length


def test_strokes_are_smooth():
    (line,) = found(stroke(FROM - 10))
    way = np.diff(line, axis=0)
    bends = np.abs(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0]))))
    assert bends.max() < 0.35  # rad at a corner of the polygon, of sides that stray 5 um from the curve


def test_isophotes_are_one_less_than_the_levels():
    ramp = Tone(np.tile(np.linspace(0, 1, 200), (150, 1)), SIZE)
    for levels in (1, 2, 5, 8):
        borders = field.isophotes(ramp, levels, 0.3)
        assert len(borders) == levels - 1 and all(len(lines) == 1 for lines in borders)
        places = [lines.xy[:, 0].mean() for lines in borders]
        assert places == pytest.approx([0.1 + 39.8 * k / levels for k in range(1, levels)], abs=0.05)


def test_isophotes_of_a_hill_are_rings_of_their_height():
    hill = Tone(np.clip(1 - FROM / 14, 0, 1), SIZE)
    for k, lines in enumerate(field.isophotes(hill, 5, 0.2), 1):
        assert np.hypot(*(lines.xy - (20, 15)).T) == pytest.approx(np.full(len(lines.xy), 14 * (1 - k / 5)), abs=0.05)
    assert [len(lines) for lines in field.isophotes(hill, 5, 0.2, least=50)] == [1, 1, 0, 0]


@pytest.mark.parametrize("shape", [(30, 40), (1, 40), (30, 1), (1, 1)])
def test_one_tone_or_one_row_has_no_isophotes(shape):
    assert [len(lines) for lines in field.isophotes(Tone(np.full(shape, 0.4), SIZE), 4, 0.3)] == [0, 0, 0]


def test_rows_lie_at_even_distances():
    frame = field.distances(Paths.of([[(0, 0), (0, 30)]], closed=False), SIZE, (150, 200))
    rows = field.Rows(frame, 2.0, 0.5)
    assert rows.off([(0.5, 9), (1.5, 9), (2.5, 3), (3.0, 3), (0.1, 9)]) == pytest.approx([0, 1, 0, 0.5, 0.4])  # none nearer than the first
    share = rows.share(0.6)
    assert share.mean() == pytest.approx(0.6 / 2.0, rel=0.03) and share[:, 2].min() == 1 and share[:, 7].max() == 0
    assert [line[0, 0] for line in rows.lines(7.0)] == pytest.approx([0.5, 2.5, 4.5, 6.5])


def test_a_heavy_source_reaches_further_and_keeps_its_distances():
    left, right = (field.distances(Paths.of([[(x, 0), (x, 30)]], closed=False), SIZE, (150, 200)) for x in (0.0, 40.0))
    both = field.weighed([(left, 1.0), (right, 0.25)])
    assert both.at([(10, 15), (31, 15), (33, 15), (39, 15)]) == pytest.approx([10, 31, 7, 1])  # 32 mm is a quarter of the way
    assert field.weighed([(left, 1.0), (right, 1.0)]).mm.max() == pytest.approx(19.9)


def test_ways_of_even_cost_are_distances_and_slow_ones_are_longer():
    disc = field.distances(Paths.of([shapely.get_coordinates(shapely.Point(20, 15).buffer(8, 64))[:-1]]), SIZE, (150, 200))
    even = disc.through(np.ones((150, 200)))
    assert np.abs(even.mm - disc.mm).max() < 0.4  # mm, two squares: the sweeps are of first order
    slow = disc.through(np.where(X > 20, 2.0, 1.0))
    assert slow.at([(5, 15)]) == pytest.approx(disc.at([(5, 15)]), abs=0.1) and slow.at([(35, 15)])[0] == pytest.approx(14, abs=0.4)


def test_distances_on_fine_grids_are_nearly_those_of_shapely():
    rng = np.random.default_rng(3)
    lines = Paths.of([rng.uniform(0, 40, 2) + rng.normal(0, 2, (4, 2)) for _ in range(300)], closed=False)
    mm = field.distances(lines, SIZE, (150, 200)).mm
    true = shapely.distance(shapely.union_all([shapely.LineString(line) for line in lines]), shapely.points(X, Y))
    assert (mm >= true - 1e-12).all() and (mm - true).max() < 0.04 and (mm > true + 1e-9).mean() < 1e-3  # slivers, a fifth of a square


def test_lines_beyond_the_rectangle_count():
    assert field.distances(Paths.of([[(-5, -9), (-5, 90)]], closed=False), SIZE, (15, 20)).at([(9, 9)])[0] == pytest.approx(14)
