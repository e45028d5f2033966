"""Stippling along frontiers: the figures of a reference run on pixels, the order that makes any beginning a drawing, and bad input."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from crowquill import Tone, draw, frontier, measure
from crowquill.__main__ import main
from crowquill.frontier import Placed, levels, published, tonal
from crowquill.marks import Marks
from crowquill.paths import Array, Index
from crowquill.sheet import Sheet

SIZE = (40.0, 30.0)
STEP = np.tile(np.where(np.arange(160) < 80, 0.3, 0.5), (160, 1))
RAMP = np.tile((np.arange(240) + 0.5) / 240, (120, 1))
X, Y = np.meshgrid((np.arange(120) + 0.5) / 120, (np.arange(90) + 0.5) / 90)
HILLS = Tone(0.45 + 0.4 * np.sin(7 * X) * np.cos(5 * Y), SIZE)
FLAT = Tone(np.full((30, 40), 0.3), SIZE)


def placed(cost: Array, noise: float, radius: float, seed: int) -> Index:
    """The dots of one level from one seed, by chance as much as the noise."""
    rng = np.random.default_rng(seed)
    swayed, held = cost * rng.uniform(1 - noise, 1 + noise, cost.shape), np.ones(cost.shape, bool)
    return Placed.seeded(swayed, held, 1, rng).filled(swayed, held, radius).dots


def nearest(xy: Array) -> Array:
    """How far each point is from the next."""
    return np.asarray(cKDTree(xy).query(xy, 2)[0][:, 1])


def spread(xy: Array) -> float:
    """The deviation of the distances to the nearest over their mean."""
    far = nearest(xy)
    return float(far.std() / far.mean())


def points(dots: Index, columns: int) -> Array:
    return np.stack([dots % columns, dots // columns], axis=1).astype(np.float64)


@pytest.mark.parametrize(
    ("noise", "radius", "least", "most", "apart"),
    # published: .06 to .09 with least distances of .63 to .73 of a hexagon's, and .10 to .14 with .55, over radii of 2 to 4
    [(0.3, 2.0, 0.06, 0.09, 0.63), (0.3, 4.0, 0.04, 0.09, 0.63), (0.5, 2.0, 0.10, 0.14, 0.54), (0.5, 4.0, 0.06, 0.14, 0.54)],
)
def test_dots_of_a_flat_tone_lie_as_evenly_as_published(noise: float, radius: float, least: float, most: float, apart: float) -> None:
    xy = points(placed(np.full((200, 200), 0.51), noise, radius, 1), 200)
    hexagon = np.sqrt(2 / np.sqrt(3) * 40_000 / len(xy))
    assert least <= spread(xy) <= most and apart <= nearest(xy).min() / hexagon <= 0.75


def test_without_noise_dots_are_a_lattice_and_the_check_of_evenness_sees_it() -> None:
    assert spread(points(placed(np.full((200, 200), 0.51), 0.0, 2.0, 1), 200)) == 0


@pytest.mark.parametrize(("pixels", "radius"), [(200, 2.0), (200, 4.0), (300, 8.0)])
def test_half_the_radius_makes_about_four_times_the_dots(pixels: int, radius: float) -> None:
    few, many = (len(placed(np.full((pixels, pixels), 0.51), 0.3, r, 0)) for r in (radius, radius / 2))
    assert 3.65 <= many / few <= 4.5


def test_published_weights_make_density_the_square_of_darkness_and_tonal_ones_darkness_itself() -> None:
    def ratio(cost: Array, radius: float) -> float:
        column = np.concatenate([placed(cost, 0.3, radius, seed) % 160 for seed in range(6)])
        return float((column >= 88).sum() / (column < 72).sum())  # off the edge

    assert ratio(published(STEP, 1.0), 20.0) == pytest.approx((0.5 / 0.3) ** 2, abs=0.2)  # 2.66 here
    assert ratio(tonal(STEP, STEP, 0.0), 6.0) == pytest.approx(0.5 / 0.3, abs=0.1)  # 1.62 here


def test_quarters_of_a_ramp_have_their_shares() -> None:
    def shares(cost: Array, radius: float) -> Array:
        column = np.concatenate([placed(cost, 0.3, radius, seed) % 240 for seed in range(3)])
        return np.asarray(np.bincount(column // 60, minlength=4) / len(column))

    assert shares(published(RAMP, 1.0), 10.0) == pytest.approx([0.016, 0.114, 0.300, 0.570], abs=0.015)
    assert shares(tonal(RAMP, RAMP, 0.0), 3.0) == pytest.approx([0.062, 0.188, 0.312, 0.438], abs=0.01)


@pytest.mark.parametrize(("edges", "low", "high"), [(1.0, 0.07, 0.10), (3.0, 0.26, 0.30)])
def test_dots_gather_at_an_edge_as_published(edges: float, low: float, high: float) -> None:
    column = np.concatenate([placed(published(STEP, edges), 0.3, 20.0, seed) % 160 for seed in range(6)])
    assert low <= (np.abs(column + 0.5 - 80) <= 2.5).mean() <= high  # of area .031


def test_a_term_that_deviates_nowhere_is_left_out() -> None:
    assert np.ptp(published(np.full((9, 9), 0.4), 3.0)) == 0 and np.isfinite(published(RAMP, 1.0)).all()
    assert published(np.zeros((1, 1)), 1.0).tolist() == [[1 + frontier.LEAST]]
    assert np.isfinite(tonal(np.zeros((1, 7)), np.zeros((1, 7)), 2.0)).all()


def test_after_a_level_no_pixel_is_further_than_the_radius_and_no_two_dots_nearer() -> None:
    rng = np.random.default_rng(0)
    cost, held = rng.uniform(0.5, 1.5, (60, 80)), rng.random((60, 80)) < 0.7
    begun = Placed.seeded(cost, held, 4, rng)
    found = begun.filled(cost, held, 5.0)
    assert found.far[held].max() <= 5.0 and held.ravel()[found.dots].all() and len(np.unique(found.dots)) == len(found.dots)
    alone = np.full(cost.shape, np.inf, np.float32)
    for dot in found.dots[4:]:  # from all others, by another road: the dots one by one
        others = Placed(found.dots[found.dots != dot], (), alone)
        far = np.full(cost.shape, np.inf, np.float32)
        far.ravel()[others.dots] = 0
        frontier._grown(cost.astype(np.float32), held, far, np.inf, others.dots.astype(np.int32), np.empty(0, np.int64))
        assert far.ravel()[dot] > 4.0  # beyond 5 where it was placed; another may have come from behind by a step


@cache
def drawn(name: str, **knobs: Any) -> Sheet:
    return draw("frontier", {"hills": HILLS, "flat": FLAT}[name], seed=3, **knobs)


def first(marks: Marks, n: int) -> Marks:
    """The first n marks, as much larger as they are fewer."""
    part = marks.take(slice(n))
    return Marks(part.xy, part.angle, part.scale * np.sqrt(len(marks) / n), part.glyph, part.glyphs)


@pytest.mark.parametrize("n", [200, 390, 700, 1000])
def test_the_first_dots_lie_as_evenly_as_all(n: int) -> None:
    xy = drawn("flat", dots=2000).marks.xy
    assert spread(xy) < 0.16 and spread(xy[:n]) < 0.18
    assert spread(np.random.default_rng(0).permutation(xy)[:n]) > 0.2  # the check sees another order


def test_the_first_half_of_the_dots_is_the_same_picture() -> None:
    sheet = drawn("hills", dots=2400)
    half = first(sheet.marks, 1200)
    error = gaussian_filter(measure.rendered(half, SIZE, (90, 120)) - HILLS.coverage, 6.0)[
        10:-10, 10:-10
    ]  # 2 mm, 1.4 mm being between dots
    assert np.sqrt((error**2).mean()) < 0.05 and abs(error.mean()) < 0.02
    assert sheet.report["levels"][-1] == 2400 and (np.diff(sheet.report["levels"]) > 0).all()
    shuffled = first(sheet.marks.take(np.argsort(sheet.marks.xy[:, 0], kind="stable")), 1200)  # the check sees the left half
    assert np.abs(gaussian_filter(measure.rendered(shuffled, SIZE, (90, 120)) - HILLS.coverage, 6.0)).max() > 0.3


@pytest.mark.parametrize("dots", [1, 2, 3, 10, 777])
def test_there_are_exactly_as_many_dots_as_asked_for_and_the_ink_is_kept(dots: int) -> None:
    for name, tone in (("hills", HILLS), ("flat", FLAT)):
        sheet = drawn(name, dots=dots)
        assert len(sheet.marks) == sheet.report["marks"] == dots
        assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)


@pytest.mark.parametrize("edges", [0.0, 2.0])
def test_a_pen_keeps_its_width_and_the_ink(edges: float) -> None:
    sheet = drawn("hills", pen=0.5, edges=edges)
    assert sheet.report["pen_mm"] == pytest.approx(0.5, rel=0.031) and sheet.report["ink_placed_mm2"] == pytest.approx(HILLS.ink, rel=0.01)


def test_with_a_pen_and_a_number_the_tone_gives() -> None:
    sheet = drawn("hills", pen=0.4, dots=1000)
    assert len(sheet.marks) == 1000 and sheet.report["coverage_missing"] > 0.5 and "not reached" in sheet.report["warnings"][0]
    over = drawn("hills", pen=2.0, dots=400).report
    assert any("of the ink asked for is placed; a pen or a number alone" in said for said in over["warnings"])


def test_tones_are_kept_place_by_place() -> None:
    error = gaussian_filter(measure.rendered(drawn("hills", pen=0.3, edges=0.0).marks, SIZE, (90, 120)) - HILLS.coverage, 4.0)[8:-8, 8:-8]
    assert np.abs(error).max() < 0.06 and np.sqrt((error**2).mean()) < 0.025


def test_published_weights_say_what_they_do_to_the_tone() -> None:
    wish = Tone(HILLS.coverage, SIZE, importance=0.5 + 0.5 * X)
    report = draw("frontier", wish, dots=500, weight="published").report
    assert "published weights do not keep tone" in report["warnings"][-2] and "importance is not heeded" in report["warnings"][-1]
    finer = draw("frontier", wish, dots=1000).marks.xy
    assert (finer[:, 0] > 20).mean() > (drawn("hills", dots=1000).marks.xy[:, 0] > 20).mean() + 0.03


def test_neither_coarse_pixels_nor_the_canvas_make_edges() -> None:
    coarse = np.tile(np.linspace(0.2, 0.8, 8), (6, 1))  # pixels of 5 mm
    marks = draw("frontier", Tone(coarse, SIZE, shapely.box(3, 3, 37, 27)), dots=1500, edges=4.0).marks
    inner = marks.xy[(marks.xy[:, 1] > 4) & (marks.xy[:, 1] < 26) & (marks.xy[:, 0] > 4) & (marks.xy[:, 0] < 36)]
    assert (np.abs((inner[:, 0] + 2.5) % 5 - 2.5) < 0.5).mean() == pytest.approx(7 / 32, abs=0.018)  # 0.5 mm from a border of pixels
    assert len(inner) / len(marks) == pytest.approx(32 * 22 / (34 * 24), abs=0.06)  # the rim has a few more, as at every border


def test_several_seeds_begin_in_several_places() -> None:
    assert drawn("flat", dots=60, seeds=40).report["levels"][0] == 40 and drawn("flat", dots=60).report["levels"][0] == 3
    assert len(drawn("flat", dots=20, seeds=40).marks) == 20


def test_islands_and_white_between_them_keep_their_shares() -> None:
    canvas = shapely.union(shapely.box(1, 1, 12, 29), shapely.box(25, 5, 39, 20))
    tone = Tone(np.where(X < 0.2, 0.0, 0.3), SIZE, canvas)
    marks = draw("frontier", tone, dots=600).marks
    left = shapely.box(8, 1, 12, 29).area  # what is not white of it
    assert (marks.xy[:, 0] < 20).mean() == pytest.approx(left / (left + 14 * 15), abs=0.04)  # borders have some more
    assert (tone.at(marks.xy) > 0).all() and tone.holds(marks.xy).all()


def test_more_dots_than_pixels_are_placed_on_finer_ones_and_what_has_no_room_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(draw("frontier", Tone([[0.2, 0.6]], (20.0, 10.0)), dots=3000).marks) == 3000
    monkeypatch.setattr("crowquill.styles.frontier.MOST", 900)
    report = draw("frontier", Tone([[0.2, 0.6]], (20.0, 10.0)), dots=3000).report
    assert report["marks"] < 1000 and any(f"{report['marks']} dots in place of 3000" in said for said in report["warnings"])


def test_black_and_white_and_a_picture_without_an_edge_have_an_answer() -> None:
    for value in (0.0, 0.5, 1.0):
        for knobs in ({"dots": 100}, {"pen": 1.0, "weight": "published"}, {"dots": 50, "noise": 0.0, "edges": 10.0}):
            report = draw("frontier", Tone(np.full((4, 4), value), (10.0, 10.0)), **knobs).report
            assert report["marks"] if value else "no ink" in report["warnings"][0]
    none = list(levels(np.ones((5, 5)), np.zeros((5, 5), bool), 4, 3, np.random.default_rng(0)))
    assert len(none) == 1 and len(none[0].dots) == 0
    every = list(levels(np.ones((5, 5)), np.ones((5, 5), bool), 40, 3, np.random.default_rng(0)))[-1]
    assert sorted(every.dots.tolist()) == list(range(25))


WRONG: list[tuple[list[str], str]] = [
    (["--pen", "25mm"], "a pen of 25 mm is wider than the canvas of 20 mm; use a finer pen"),
    (["--dots", "5000", "--max-dots", "1000"], "over the limit of 1000; draw it smaller, use a wider pen, or raise max-dots"),
    (["--pen", "0.01mm"], "over the limit of 1000000"),
    (["--noise", "1"], "noise is 1.0; it takes a number from 0 to 0.9"),
    (["--seeds", "0"], "seeds is 0; it takes a whole number from 1 to 1000"),
    (["--weight", "grey"], "no weight 'grey'; there are tone, published"),
]


@pytest.mark.parametrize(("typed", "said"), WRONG, ids=[" ".join(typed) for typed, _ in WRONG])
def test_bad_input_is_answered_in_a_line(
    typed: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.full((40, 40), 90, np.uint8)).save("picture.png")
    assert main(["frontier", "picture.png", "out.svg", "--width", "20mm", *typed]) == 2
    told = capsys.readouterr().err
    assert said in told.splitlines()[-1] and "Traceback" not in told and not Path("out.svg").exists()
