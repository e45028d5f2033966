"""Cover as the raster has it is the area of shapely's shapes, pixel by pixel; the rest are facts about one pixel or two."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from hypothesis import given
from hypothesis import settings as setting
from hypothesis import strategies as st

from crowquill import glyphs, kernel, raster
from crowquill.marks import Glyph, Marks
from crowquill.paths import Paths
from crowquill.raster import covered

Array = npt.NDArray[np.float64]
NIB = glyphs.load("nib-03").glyphs
DISC = glyphs.load("disc").glyphs
UNIT = (1.0, 1.0)
SEEDS = st.integers(0, 2**32 - 1)
# A level border falls between two of N lines and is put half way: it errs by 1 / 2N of a pixel's width at most.
LEVEL = 1 / (2 * raster.LINES)


def rectangle(x: float, y: float, width: float, height: float) -> list[tuple[float, float]]:
    """A ring from x to y, as outer rings turn."""
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def by_pixel(shape: shapely.Geometry, grid: tuple[int, int], pixel: tuple[float, float] = UNIT) -> Array:
    row, column = np.indices(grid)
    dx, dy = pixel
    boxes = shapely.box(column * dx, row * dy, (column + 1) * dx, (row + 1) * dy)
    return np.asarray(shapely.area(shapely.intersection(boxes, shape)) / (dx * dy))


def scattered(n: int, seed: int, *, scale: tuple[float, float] = (0.3, 3)) -> Marks:
    rng = np.random.default_rng(seed)
    which = rng.integers(len(NIB), size=n)
    return Marks.of(rng.uniform(-1, 11, (n, 2)), NIB, scale=rng.uniform(*scale, n), angle=rng.uniform(0, 7, n), glyph=which)


def test_whole_pixels_are_covered_wholly_and_no_others() -> None:
    got = covered(Paths.of([rectangle(1, 2, 3, 1)]), (4, 5), pixel=UNIT)
    wanted = np.zeros((4, 5))
    wanted[2, 1:4] = 1
    assert got.tolist() == wanted.tolist()


@pytest.mark.parametrize("side", [rectangle(0, 0, 0.5, 1), rectangle(0.5, 0, 0.5, 1), rectangle(0, 0.5, 1, 0.5), [(0, 0), (1, 0), (1, 1)]])
def test_half_of_a_pixel_is_one_half(side: list[tuple[float, float]]) -> None:
    assert covered(Paths.of([side]), (1, 1), pixel=UNIT).item() == pytest.approx(0.5, abs=1e-7)  # crossings are kept to 2^-24


def test_a_quarter_across_is_exact_and_a_third_down_is_so_to_half_a_line() -> None:
    assert covered(Paths.of([rectangle(0.3, 0, 0.4, 1)]), (1, 1), pixel=UNIT).item() == pytest.approx(0.4, abs=1e-6)
    assert covered(Paths.of([rectangle(0, 0, 1, 1 / 3)]), (1, 1), pixel=UNIT).item() == pytest.approx(1 / 3, abs=LEVEL)


def test_pixels_are_lengths_of_their_own_each_way() -> None:
    got = covered(Paths.of([rectangle(0.2, 1.5, 0.2, 1.5)]), (2, 3), pixel=(0.2, 1.5))
    np.testing.assert_allclose(got, [[0, 0, 0], [0, 1, 0]], atol=1e-6)


def test_a_place_covered_twice_or_thrice_counts_once() -> None:
    one = rectangle(0.5, 0, 2, 2)
    once = covered(Paths.of([one]), (3, 4), pixel=UNIT)
    assert covered(Paths.of([one] * 3), (3, 4), pixel=UNIT).tolist() == once.tolist()
    across = covered(Paths.of([rectangle(0, 0, 3, 1), rectangle(1, 0, 1, 3), rectangle(0, 0, 2, 1)]), (3, 3), pixel=UNIT)
    assert across.tolist() == [[1, 1, 1], [0, 1, 0], [0, 1, 0]]


def test_a_hole_turns_the_other_way_and_an_island_the_same_way_again() -> None:
    rings = [rectangle(0, 0, 5, 5), rectangle(1, 1, 3, 3)[::-1], rectangle(2, 2, 1, 1)]
    got = covered(Paths.of(rings), (5, 5), pixel=UNIT)
    assert got.sum() == 25 - 9 + 1 and got[2, 2] == 1 and got[1, 1] == 0
    same_way = covered(Paths.of([rings[0], rings[1][::-1]]), (5, 5), pixel=UNIT)
    assert same_way.sum() == 25  # nonzero, not even and odd
    mirrored = covered(Paths.of([ring[::-1] for ring in rings]), (5, 5), pixel=UNIT)
    assert mirrored.tolist() == got.tolist()


@pytest.mark.parametrize("radius", [0.05, 0.4, 3.0, 20.0])
def test_a_disc_has_its_area(radius: float) -> None:
    side = int(2 * radius + 4)
    scale = radius * np.sqrt(np.pi)
    got = covered(Marks.of([(side / 2 + 0.1, side / 2 - 0.2)], DISC, scale=scale), (side, side), pixel=UNIT, lines=64)
    # chords between the ends of 64 lines a pixel err most for the smallest, which only six lines cross
    assert got.sum() == pytest.approx(scale**2, rel=0.05 if radius < 0.1 else 2e-3)


def test_a_ring_is_a_disc_less_a_disc() -> None:
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    got = covered(Paths.of([10 + 8 * circle, (10 + 5 * circle)[::-1]]), (20, 20), pixel=UNIT)
    assert got.sum() == pytest.approx(200 * np.sin(2 * np.pi / 400) * (64 - 25), rel=1e-3)
    assert got[10, 10] == 0 and got[10, 3] == 1


@given(SEEDS)
@setting(max_examples=20)
def test_every_pixel_has_its_share_of_the_union(seed: int) -> None:
    rng = np.random.default_rng(seed)
    marks = scattered(int(rng.integers(1, 60)), seed)
    grid, pixel = (9, 12), (0.8, 1.1)
    union = shapely.union_all(marks.outlines().flat(1e-5).polygons())
    got = covered(marks, grid, pixel=pixel, lines=256, flat=1e-5)
    # 512ths of a pixel for a level border; a few borders of small marks may add in one pixel
    np.testing.assert_allclose(got, by_pixel(union, grid, pixel), atol=4e-3)
    # with the knobs left alone a border strays by a 32nd of a pixel at most, and two may share a pixel
    np.testing.assert_allclose(covered(marks, grid, pixel=pixel), by_pixel(union, grid, pixel), atol=0.06)


@given(SEEDS)
@setting(max_examples=20)
def test_polygons_with_holes_are_covered_as_shapely_has_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    blots = shapely.buffer(shapely.points(rng.uniform(0, 10, (12, 2))), rng.uniform(0.3, 2, 12), quad_segs=4)
    shape = shapely.difference(shapely.union_all(blots[:8]), shapely.union_all(blots[8:]))
    rings, _ = Paths.of_polygons([shape])
    np.testing.assert_allclose(covered(rings, (10, 10), pixel=UNIT, lines=256), by_pixel(shape, (10, 10)), atol=4e-3)


def test_the_comparison_notices_one_mark_moved_by_a_tenth_of_a_pixel() -> None:
    marks = Marks.of([(2, 2), (5, 5), (8, 3)], NIB, scale=0.8)
    union = shapely.union_all(marks.outlines().flat(1e-5).polygons())
    moved = marks.moved([(0.1, 0), (0, 0), (0, 0)])
    assert np.abs(covered(marks, (10, 10), pixel=UNIT, lines=256) - by_pixel(union, (10, 10))).max() < 4e-3
    assert np.abs(covered(moved, (10, 10), pixel=UNIT, lines=256) - by_pixel(union, (10, 10))).max() > 0.03


@given(st.floats(0, 1), st.integers(0, 3 * raster.LINES))
@setting(max_examples=20)
def test_a_drawing_moved_by_part_of_a_pixel_keeps_its_ink(dx: float, lines: int) -> None:
    marks = scattered(20, seed=3, scale=(0.3, 1)).moved((2, 2))
    still = covered(marks, (20, 20), pixel=UNIT).sum()
    # across to rounding; down as exactly when it is by whole lines
    assert covered(marks.moved((dx, lines / raster.LINES)), (20, 20), pixel=UNIT).sum() == pytest.approx(still, rel=1e-6)


def test_a_drawing_moved_by_whole_pixels_or_turned_about_is_the_same_pixels() -> None:
    marks = scattered(40, seed=8)
    got = covered(marks, (10, 10), pixel=UNIT)
    np.testing.assert_allclose(covered(marks.moved((3, 2)), (12, 13), pixel=UNIT)[2:, 3:], got, atol=1e-6)
    flipped = Paths.of([(10, 10) - ring for ring in marks.outlines().flat(1e-3)])
    np.testing.assert_allclose(
        covered(flipped, (10, 10), pixel=UNIT), covered(Paths.of(marks.outlines().flat(1e-3)), (10, 10), pixel=UNIT)[::-1, ::-1], atol=1e-6
    )


def test_bands_and_cores_do_not_change_a_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    marks = scattered(200, seed=3)
    whole = covered(marks, (40, 30), pixel=(0.3, 0.25)).tobytes()
    for pixels, cores in ((1 << 20, 1), (1, 1), (100, 2), (1 << 20, 3), (700, 7)):
        monkeypatch.setattr(raster, "PIXELS", pixels)
        monkeypatch.setattr(kernel, "CORES", cores)
        assert covered(marks, (40, 30), pixel=(0.3, 0.25)).tobytes() == whole


def test_the_order_of_marks_does_not_change_a_bit() -> None:
    marks = scattered(100, seed=5)
    shuffled = marks.take(np.random.default_rng(0).permutation(100))
    assert covered(shuffled, (10, 10), pixel=UNIT).tobytes() == covered(marks, (10, 10), pixel=UNIT).tobytes()


def test_crossings_in_any_order_are_sorted() -> None:
    order = np.random.default_rng(1).permutation(500)
    # one ring with 500 teeth, met out of order along each line; what joins them lies above the grid
    comb = [point for k in order for point in [(2 * k, -1), (2 * k, 1), (2 * k + 1, 0.5), (2 * k + 1, -1)]]
    got = covered(Paths.of([comb]), (1, 1000), pixel=UNIT)
    np.testing.assert_allclose(got[0], np.tile([0.75, 0], 500), atol=1e-6)


def strokes(seed: int) -> Paths:
    rng = np.random.default_rng(seed)
    return Paths.of([rng.uniform(1, 9, (k, 2)) for k in rng.integers(2, 7, 5)], closed=bool(rng.integers(2)))


@given(SEEDS, st.floats(0.05, 3))
@setting(max_examples=30)
def test_a_stroke_covers_what_shapely_buffers(seed: int, pen: float) -> None:
    lines = strokes(seed)
    around = [np.concatenate([line, line[:1]]) if lines.closed else line for line in lines]
    # side by side: the buffer of a whole ring that crosses itself may lack a part
    sides = [shapely.linestrings(line[k : k + 2]) for line in around for k in range(len(line) - 1)]
    wanted = shapely.union_all(shapely.buffer(sides, pen / 2, quad_segs=64))
    got = covered(lines, (10, 10), pixel=UNIT, pen=pen, lines=256, flat=1e-4)
    np.testing.assert_allclose(got, by_pixel(wanted, (10, 10)), atol=4e-3)


def test_a_curve_is_stroked_as_its_chords_are() -> None:
    curve = Paths.of([[(1, 1), (12, 2), (-3, 8), (9, 9)]], closed=False, cubic=True)
    wanted = shapely.buffer(shapely.linestrings(curve.flat(1e-4).xy), 0.35, quad_segs=64)
    got = covered(curve, (10, 10), pixel=UNIT, pen=0.7, lines=256)
    np.testing.assert_allclose(got, by_pixel(wanted, (10, 10)), atol=0.01 + 4e-3)  # a 200th of a pixel at each border


def test_curves_are_made_straight_a_few_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    outlines = scattered(40, seed=9).outlines()
    mixed = Paths.of([[], outlines[0], [], [], *list(outlines)[1:], []], cubic=True)
    whole = covered(mixed, (10, 10), pixel=UNIT)
    assert whole.tobytes() == covered(outlines, (10, 10), pixel=UNIT).tobytes()
    np.testing.assert_allclose(whole, covered(scattered(40, seed=9), (10, 10), pixel=UNIT), atol=0.02)
    for chunk in (1, 50, 400):
        monkeypatch.setattr(raster, "CHUNK", chunk)
        assert covered(mixed, (10, 10), pixel=UNIT).tobytes() == whole.tobytes()


def test_rings_of_a_stroke_all_turn_one_way() -> None:
    for seed in range(20):
        assert raster.stroked(strokes(seed), 0.4, 1e-3).areas.min() > 0


def test_points_are_dots_as_renderers_have_it() -> None:
    disc = np.pi * 0.25
    for points, closed, dots in (
        ([[(5, 5)]], True, 1), ([[(5, 5)]], False, 0), ([[(5, 5), (5, 5)]], False, 1), ([[(5, 5), (5, 5), (5, 5)]], True, 1),
        ([[(5, 5)] * 2, [(5, 5)] * 2], False, 1), ([[(2, 2)] * 2, [], [(7, 7)] * 4], False, 2), ([], False, 0), ([[]], True, 0),
    ):  # fmt: skip
        got = covered(Paths.of(points, closed=closed), (10, 10), pixel=UNIT, pen=1.0, lines=64, flat=1e-4).sum()
        assert got == pytest.approx(dots * disc, rel=1e-3), (points, closed)


def test_points_said_twice_do_not_change_a_stroke() -> None:
    plain = Paths.of([[(1, 1), (8, 2), (4, 8)]])
    for points in ([(1, 1), (1, 1), (8, 2), (8, 2), (4, 8)], [(1, 1), (8, 2), (4, 8), (1, 1), (1, 1)]):
        again = covered(Paths.of([points]), (10, 10), pixel=UNIT, pen=0.5)
        np.testing.assert_allclose(again, covered(plain, (10, 10), pixel=UNIT, pen=0.5), atol=1e-6)


def test_marks_are_stroked_along_their_outlines() -> None:
    mark = Marks.of([(5, 5)], DISC, scale=3 * np.sqrt(np.pi))
    got = covered(mark, (10, 10), pixel=UNIT, pen=1.0, lines=64)
    assert got.sum() == pytest.approx(np.pi * (3.5**2 - 2.5**2), rel=5e-3) and got[5, 5] == 0


def test_lines_that_are_open_are_closed_where_they_are_filled() -> None:
    ring = rectangle(0.5, 0.5, 2, 2)
    assert covered(Paths.of([ring], closed=False), (3, 3), pixel=UNIT).tolist() == covered(Paths.of([ring]), (3, 3), pixel=UNIT).tolist()


def test_what_hangs_over_the_edge_is_not_seen_and_what_is_beyond_does_no_harm() -> None:
    ring = [rectangle(-5, -5, 6.5, 6.25)]
    assert covered(Paths.of(ring), (2, 2), pixel=UNIT).tolist() == [[1, 0.5], [0.25, 0.125]]
    for far in (1e4, 1e9, 1e15):
        beyond = [rectangle(far, 0, 1, 1), rectangle(-far, 0, 1, 1), rectangle(0, far, 1, 1), rectangle(0, -far, 1, 1)]
        assert covered(Paths.of(ring + beyond), (2, 2), pixel=UNIT).tolist() == [[1, 0.5], [0.25, 0.125]]
        assert covered(Paths.of([rectangle(-far, -far, 2 * far, 2 * far)]), (2, 2), pixel=UNIT).tolist() == [[1, 1], [1, 1]]


@pytest.mark.parametrize("pen", [None, 0.2])
def test_nothing_covers_nothing(pen: float | None) -> None:
    nothing = (Marks.of([], DISC, scale=1), Marks.of([], (), scale=1), Paths.of([]), Paths.of([[], []]), Paths.of([[], []], closed=False))
    for art in nothing:
        assert not covered(art, (2, 3), pixel=UNIT, pen=pen).any()


def test_outlines_without_area_cover_nothing() -> None:
    for ring in ([(0, 0)], [(0, 0), (2, 2)], [(0, 0), (2, 2), (1, 1)], [(1, 1)] * 5):
        assert covered(Paths.of([ring]), (2, 2), pixel=UNIT).sum() == pytest.approx(0, abs=1e-7)
    assert not covered(Marks.of([(1, 1)], DISC, scale=0), (2, 2), pixel=UNIT).any()


def test_marks_far_smaller_than_a_pixel_keep_their_area_in_sum() -> None:
    rng = np.random.default_rng(6)
    hair = (Glyph.of(Paths.of([[(0, 0), (9, 0.05), (18, 0), (9, -0.05)]])),)
    for shapes in (NIB, DISC, hair):
        marks = Marks.of(rng.uniform(1, 9, (20_000, 2)), shapes, scale=0.01, angle=rng.uniform(0, 7, 20_000))
        got = covered(marks, (10, 10), pixel=UNIT).sum()
        # few lines hit each, but at random: of 2 in 20 000 overlap some; the mean of 20 000 x 1/6 hits errs by 2 %
        assert got == pytest.approx(2.0, rel=0.08)
