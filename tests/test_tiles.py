"""Stones are parted by the grout, cut off lines and canvas, and take the picture's colours."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill import tiles
from crowquill.parting import CORNERS, grown, parted
from crowquill.paths import Paths
from crowquill.picture import encoded, linear
from crowquill.sheet import in_process, on_screen
from crowquill.tone import Tone

GAP = 0.3


def thrown(n: int, seed: int, side: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """n squares anywhere on 20 x 20 mm, turned by chance, and their angles: most overlap others."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, np.pi, n)
    return tiles.squares(20 * rng.random((n, 2)), angle, np.full((n, 2), side)), angle


def within(found: np.ndarray, stones: np.ndarray) -> bool:
    """Whether each stone that is left lies in its own, but for rounding where a cut ends on a side."""
    some = ~shapely.is_empty(found)
    return bool(shapely.covers(shapely.buffer(stones[some], 1e-9), found[some]).all())


def least_gap(stones: np.ndarray) -> float:
    """The least distance between two stones by brute force."""
    kept = [stone for stone in stones if not stone.is_empty]
    return min((float(a.distance(b)) for k, a in enumerate(kept) for b in kept[:k]), default=np.inf)


def test_a_tile_has_its_sides_along_its_angle():
    (stone,) = tiles.squares(np.array([[5.0, 7.0]]), np.array([np.pi / 6]), np.array([[4.0, 1.0]]))
    ring = shapely.get_coordinates(stone)
    assert shapely.area(stone) == pytest.approx(4)
    assert np.hypot(*(ring[1] - ring[0])) == pytest.approx(4)
    assert np.arctan2(*(ring[1] - ring[0])[::-1]) == pytest.approx(np.pi / 6)
    assert shapely.get_coordinates(stone.centroid)[0] == pytest.approx([5, 7])


@settings(max_examples=25, deadline=None)
@given(n=st.integers(0, 60), seed=st.integers(0, 10_000))
def test_stones_thrown_anywhere_are_parted_by_the_gap_and_only_shrink(n, seed):
    stones, angle = thrown(n, seed)
    found = parted(stones, angle, GAP)
    assert least_gap(found) >= GAP
    assert within(found, stones)


def test_the_gap_holds_in_whole_micrometres():
    stones, angle = thrown(300, 1)
    rings = tiles.rings_of(parted(stones, angle, GAP))
    overlap, nearest = tiles.met(rings)
    assert (overlap, nearest >= GAP) == (0, True)
    assert np.array_equal(rings.xy, np.round(rings.xy, 3))


def test_outlines_that_rounding_folds_or_pinches_are_sound():
    spike = shapely.Polygon([(0, 0), (1, 0), (1, 1), (0.5004, 1), (0.5002, 1.4), (0.5, 1), (0, 1)])
    waist = shapely.Polygon([(0, 0), (1, 0.4999), (2, 0), (2, 2), (1, 0.5001), (0, 1)])
    dust = shapely.Polygon([(0, 0), (2e-4, 0), (0, 2e-4)])
    assert not shapely.is_valid(shapely.Polygon(np.round(shapely.get_coordinates(spike), 3)))
    rings = tiles.rings_of(np.array([spike, dust, waist]))
    assert shapely.is_valid(rings.polygons()).all()
    assert rings.areas == pytest.approx([1, 0, 1], abs=1e-3) and list(np.diff(rings.start) > 0) == [True, False, True]


def test_overlap_and_nearness_see_stones_that_were_not_parted():
    overlap, nearest = tiles.met(Paths.of([[(0, 0), (2, 0), (2, 2), (0, 2)], [(1, 0), (3, 0), (3, 2), (1, 2)]]))
    assert (overlap, nearest) == (2, 0)
    overlap, nearest = tiles.met(Paths.of([[(0, 0), (2, 0), (2, 2), (0, 2)], [(2.2, 0), (3, 0), (3, 2), (2.2, 2)]]))
    assert overlap == 0 and nearest == pytest.approx(0.2)


def test_squares_of_a_lattice_too_large_for_it_become_the_squares_that_fit():
    x, y = np.meshgrid(np.arange(6) * 2.0, np.arange(6) * 2.0)
    xy = np.stack([x.ravel(), y.ravel()], axis=1)
    found = parted(tiles.squares(xy, np.zeros(36), np.full((36, 2), 2.4)), np.zeros(36), GAP)
    inner = found.reshape(6, 6)[1:-1, 1:-1].ravel()
    assert shapely.area(inner) == pytest.approx(np.full(16, (2 - GAP - tiles.SNAP) ** 2))


def test_two_stones_in_one_place_are_both_cut_away_or_apart_and_none_is_unsound():
    stones = tiles.squares(np.array([[5.0, 5.0], [5.0, 5.0]]), np.zeros(2), np.full((2, 2), 2.0))
    found = parted(stones, np.zeros(2), GAP)
    assert shapely.is_valid(found).all() and least_gap(found) >= GAP


@settings(max_examples=25, deadline=None)
@given(n=st.integers(2, 60), seed=st.integers(0, 10_000))
def test_grown_stones_are_no_smaller_and_as_far_apart(n, seed):
    full, angle = thrown(n, seed)
    first = parted(full, angle, GAP)
    found = grown(first, full, angle, GAP)
    assert (shapely.area(found) >= shapely.area(first) - 1e-9).all()
    assert least_gap(found) >= GAP and within(found, full)


def test_a_stone_that_is_empty_grows_into_a_hollow_and_leaves_its_neighbours_alone():
    xy = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 0.0]])
    full = tiles.squares(xy, np.zeros(3), np.full((3, 2), 2.0))
    stones = full.copy()
    stones[2] = shapely.Polygon()
    found = grown(stones, full, np.zeros(3), GAP)
    assert shapely.equals(found[:2], full[:2]).all()
    assert shapely.area(found[2]) == pytest.approx(2 * (2 - 2 * (GAP + tiles.SNAP)))


def test_a_stone_of_many_corners_grows_from_what_it_was_cut_to():
    around = np.arange(31) * 2 * np.pi / 31
    rim = np.stack([np.cos(around), np.sin(around)], axis=1)
    some = np.arange(0, 31, 4)
    nibbling = tiles.squares((3.48 + GAP) * rim[some], around[some], np.ones((len(some), 2)))
    full, angle = np.array([shapely.Polygon(3 * rim), *nibbling]), np.concatenate([[0.0], around[some]])
    first = parted(full, angle, GAP)
    assert shapely.get_num_coordinates(first[0]) > CORNERS // 2 >= shapely.get_num_coordinates(full[0])
    found = grown(first, full, angle, GAP)
    assert least_gap(found) >= GAP and within(found, full)


def test_a_stone_across_a_line_keeps_its_larger_part_half_a_gap_off():
    (stone,) = tiles.squares(np.array([[0.0, 0.0]]), np.zeros(1), np.full((1, 2), 2.0))
    (found,) = tiles.severed(np.array([stone]), Paths.of([[(0.3, -5), (0.3, 5)]], closed=False), GAP)
    left, _, right, _ = shapely.bounds(found)
    assert left == -1 and 0.3 - 1.02 * (GAP + tiles.SNAP) / 2 <= right <= 0.3 - GAP / 2


@pytest.mark.parametrize("line", [[(0.2, 0), (5, 0)], [(0.3 * np.cos(t), 0.3 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 30)]])
def test_a_line_that_ends_or_closes_inside_a_stone_cuts_nothing(line):
    stones = tiles.squares(np.array([[0.0, 0.0]]), np.zeros(1), np.full((1, 2), 2.0))
    assert shapely.equals(tiles.severed(stones, Paths.of([line], closed=False), 0.1), stones).all()


def test_no_lines_sever_nothing_and_no_stones_are_no_stones():
    stones, angle = thrown(5, 0)
    assert shapely.equals(tiles.severed(stones, Paths.of([], closed=False), GAP), stones).all()
    none = np.zeros(0, object)
    assert len(parted(none, angle[:0], GAP)) == len(grown(none, none, angle[:0], GAP)) == len(tiles.rings_of(none)) == 0
    assert tiles.met(Paths.of([])) == (0, np.inf)


def test_stones_over_the_canvas_end_half_a_gap_inside():
    stones, _ = thrown(60, 3)
    found = tiles.held(stones, shapely.box(5, 5, 15, 12), GAP)
    some = found[~shapely.is_empty(found)]
    assert shapely.within(some, shapely.box(5, 5, 15, 12)).all()
    assert shapely.distance(some, shapely.boundary(shapely.box(5, 5, 15, 12))).min() >= GAP / 2
    assert shapely.is_empty(found[shapely.disjoint(stones, shapely.box(5, 5, 15, 12))]).all()


def test_along_steps_of_pixels_stones_are_cut_straight_and_along_straight_sides_to_the_edge():
    steps = np.arange(200) * 0.1
    stairs = np.repeat(np.stack([steps, steps], axis=1), 2, axis=0)
    canvas = shapely.Polygon([*np.stack([stairs[1:, 0], stairs[:-1, 1]], axis=1), (20, 19.9), (20, 0)])
    stones = np.array([shapely.box(6, 5, 8, 8), shapely.box(16, 0, 22, 3)])
    rough, plain = tiles.held(stones, canvas, GAP), tiles.held(stones, canvas, GAP, 0.1)
    assert shapely.get_num_coordinates(rough[0]) > 20 and shapely.get_num_coordinates(plain[0]) <= 6
    assert shapely.covers(rough, plain).all() and shapely.area(plain[0]) > 0.85 * shapely.area(rough[0])
    box = shapely.box(0, 0, 20, 20)
    assert shapely.equals(tiles.held(stones, box, GAP, 0.1), tiles.held(stones, box, GAP)).all()


def test_the_mean_over_a_stone_is_exact():
    values = np.random.default_rng(0).random((8, 10))
    stones, _ = thrown(20, 2)
    size = (20.0, 16.0)
    stones = tiles.held(stones, shapely.box(0, 0, *size), 0)
    rings = tiles.rings_of(stones[shapely.area(stones) > 0])
    found = tiles.means(rings, values, size)
    pixels = [(shapely.box(2 * c, 2 * r, 2 * c + 2, 2 * r + 2), values[r, c]) for r in range(8) for c in range(10)]
    for ring, mean in zip(rings.polygons(), found, strict=True):
        by_parts = sum(shapely.area(shapely.intersection(ring, box)) * value for box, value in pixels) / shapely.area(ring)
        assert mean == pytest.approx(by_parts, rel=1e-9)


def test_a_stone_half_black_half_white_has_the_grey_of_half_the_light():
    rgb = np.zeros((1, 2, 3), np.uint8)
    rgb[0, 1] = 255
    tone = Tone(np.array([[1.0, 0.0]]), (2.0, 1.0), rgb=rgb)
    (code,) = tiles.colours(Paths.of([[(0.5, 0), (1.5, 0), (1.5, 1), (0.5, 1)]]), tone)
    assert code == pytest.approx(np.full(3, 255 * encoded(np.array(0.5))))
    assert linear(code / 255) == pytest.approx(np.full(3, 0.5))


def test_a_stone_of_one_colour_keeps_it_on_the_screen():
    codes = np.random.default_rng(4).integers(0, 256, (50, 3))
    rgb = np.repeat(codes[:, None], 2, axis=1).reshape(50, 2, 3).astype(np.uint8)
    tone = Tone(np.full((50, 2), 0.5), (2.0, 50.0), rgb=rgb)
    rings = Paths.of([[(0.2, k + 0.1), (1.8, k + 0.1), (1.0, k + 0.9)] for k in range(50)])
    assert np.array_equal(on_screen(in_process(tiles.colours(rings, tone))), codes)


def test_without_colours_a_stone_is_as_grey_as_its_coverage():
    (code,) = tiles.colours(Paths.of([[(0.5, 0), (1.5, 0), (1.5, 1), (0.5, 1)]]), Tone(np.array([[0.2, 0.6]]), (2.0, 1.0)))
    assert in_process(code[None])[0] == pytest.approx([0, 0, 0, 0.4])


@pytest.mark.parametrize("text", ["#aa3322,#E8E0D0", "#aa3322 stone\n#e8e0d0 sand", "#a32,#e8e0d0 sand;"])
def test_a_palette_is_read_from_a_list(text):
    assert tiles.palette(text).tolist() == [[0xAA, 0x33, 0x22], [0xE8, 0xE0, 0xD0]]


@pytest.mark.parametrize("text", ["#f00,red", "#f00 #12345", "#f00\n0000ff", "the two #aa3322;#e8e0d0", "#aabbccdd"])
def test_no_entry_of_a_palette_is_passed_over(text):
    with pytest.raises(ValueError, match=r"give some as #aa3322,#e8e0d0, not '(red|#12345|0000ff|the|#aabbccdd)'"):
        tiles.palette(text)


def test_a_palette_is_read_from_a_file_of_codes_or_of_gimp(tmp_path):
    listed, gimp = tmp_path / "list", tmp_path / "stones.gpl"
    listed.write_bytes(b"\xef\xbb\xbf# stones, two\r\n#\r\n#aa3322 red\r\n\r\n#e8e0d0\r\n")
    gimp.write_text("GIMP Palette\nName: stones 1\nColumns: 2\n# after '#aabbcc'\n170  51  34\tred\n232 224 208\n")
    assert tiles.palette(str(listed)).tolist() == tiles.palette(str(gimp)).tolist() == [[170, 51, 34], [232, 224, 208]]


@pytest.mark.parametrize("row", ["300 2 3", "1 2", "red"])
def test_a_row_of_a_gimp_palette_that_is_no_colour_is_refused(row, tmp_path):
    (tmp_path / "bad.gpl").write_text(f"GIMP Palette\n255 0 0 red\n{row}\n")
    with pytest.raises(ValueError, match=rf"bad\.gpl': '{row}' is no colour; give three numbers from 0 to 255"):
        tiles.palette(str(tmp_path / "bad.gpl"))


@pytest.mark.parametrize("text", ["", "red", "#12", "#12345"])
def test_a_palette_without_colours_is_refused(text):
    with pytest.raises(ValueError, match="has no colours; give some as"):
        tiles.palette(text)


def test_each_colour_takes_the_nearest_of_the_palette():
    choice = np.array([[0, 0, 0], [255, 255, 255], [200, 30, 30]], np.float64)
    assert tiles.matched(np.array([[40.0, 40, 40], [220, 230, 220], [160, 60, 50]]), choice).tolist() == choice.tolist()


def test_lab_has_the_values_of_the_standard():
    # white, black and sRGB red under D65: red is L 53.24, a 80.09, b 67.20
    assert tiles.lab(np.array([[255.0, 255, 255], [0, 0, 0], [255, 0, 0]])) == pytest.approx(
        np.array([[100, 0, 0], [0, 0, 0], [53.24, 80.09, 67.20]]), abs=0.02
    )


def test_a_stone_shrinks_to_its_area_and_stays_within_itself():
    rings = Paths.of([[(0, 0), (4, 0), (4, 2), (0, 2)]] * 3)
    found = tiles.shrunk(rings, np.array([2.0, 8.0, 80.0]))
    assert found.areas == pytest.approx([2, 8, 8], rel=2e-3)  # corners are whole micrometres
    assert shapely.covers(rings.polygons(), found.polygons()).all()
