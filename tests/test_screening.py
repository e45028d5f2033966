"""What screens share: rulings, ground, lattices, waves whose levels cover what is asked, and outlines cut and thinned."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crowquill import Paths, Tone
from crowquill.screening import LEVELS, Ground, Lattice, Wave, clipped, contoured, inked, joined, phases, ruling, simplified, triangle
from crowquill.styles.dots import _euclidean
from crowquill.styles.screen import RULES

COVERAGES = (0.1, 0.3, 0.5, 0.7, 0.9)
CLOSED_FORMS = {  # coverage of a level, for two waves whose phases are independent
    "mean": lambda s: np.where(s <= 0.5, 2 * s**2, 1 - 2 * (1 - s) ** 2),
    "max": lambda s: s**2,
    "product": lambda s: np.where(s > 0, s * (1 - np.log(np.maximum(s, 1e-300))), 0),
}


def grey(coverage: float, canvas: shapely.Geometry | None = None) -> Tone:
    return Tone(np.full((30, 40), coverage), (20.0, 15.0), canvas)


def crossed(tone: Tone, wave: Wave, angles: tuple[float, float] = (15.0, 75.0), pitch: float = 0.5) -> Paths:
    lattice = Lattice.of(angles, pitch, np.array([0.2, 0.7]))
    return joined(list(contoured(Ground.of(tone, pitch / 8), tone, lattice, wave)))


@pytest.mark.parametrize(("rule", "tolerance"), [("mean", 1e-12), ("max", 1e-12), ("product", 0.0015)])
def test_what_a_level_covers_is_the_closed_form(rule, tolerance):
    wave = Wave.of(RULES[rule], 0.5, square=rule == "max")
    # the straight sides of the first two are drawn as they are; of the third's hyperbolas the outline has chords
    assert np.abs(wave.coverage - CLOSED_FORMS[rule](LEVELS)).max() <= tolerance


def test_without_their_corners_squares_would_cover_less():
    wave = Wave.of(RULES["max"], 0.17, square=False)
    assert np.abs(wave.coverage - CLOSED_FORMS["max"](LEVELS)).max() > 0.01


def test_the_euclidean_wave_is_its_own_negative():
    u, v = np.random.default_rng(1).random((2, 1000))
    assert _euclidean(u + 0.5, v + 0.5) == pytest.approx(1 - _euclidean(u, v), abs=1e-12)
    assert Wave.of(_euclidean, 0.5).levels(np.array([0.5]), 0, 1) == pytest.approx(0.5, abs=0.005)  # a table of 257


def test_a_line_wave_has_each_value_as_often_as_any_other():
    values = np.sort(triangle((np.arange(1000) + 0.5) / 1000))
    assert values == pytest.approx((np.arange(1000) + 0.5) / 1000, abs=1e-3)


@pytest.mark.parametrize("rule", [*RULES, "euclidean"])
@pytest.mark.parametrize("angles", [(15.0, 75.0), (75.0, 15.0), (45.0, -45.0), (0.0, 90.0)])
def test_shapes_cover_the_tone_and_holes_turn_the_other_way(rule, angles):
    wave = Wave.of({**RULES, "euclidean": _euclidean}[rule], 0.5, square=rule == "max")
    for coverage in COVERAGES:
        paths = crossed(grey(coverage), wave, angles)
        assert inked(paths, angles, 0.5) / 300 == pytest.approx(coverage, abs=0.005)
        outer = paths.areas > 0
        assert outer[0]
        if rule == "mean":
            assert outer.all() == (coverage <= 0.5)


@pytest.mark.parametrize("rule", RULES)
def test_black_is_the_whole_canvas_and_white_is_nothing(rule):
    canvas = shapely.Point(10, 7).buffer(6) - shapely.Point(10, 7).buffer(2)
    wave = Wave.of(RULES[rule], 0.5)
    black = shapely.union_all(crossed(grey(1.0, canvas), wave).take([]).polygons())
    assert black.is_empty
    art = crossed(grey(1.0, canvas), wave)
    assert inked(art, (15, 75), 0.5) == pytest.approx(canvas.area, rel=1e-3)
    assert len(crossed(grey(0.0, canvas), wave)) == 0


def test_holes_come_right_behind_their_outline():
    paths = crossed(grey(0.8), Wave.of(RULES["mean"], 0.5))
    polygon, outline = paths.polygons(), -1
    for k, area in enumerate(paths.areas):
        outline = k if area > 0 else outline
        assert area > 0 or polygon[outline].buffer(1e-6).contains(polygon[k])  # mm: simplified sides may touch


@pytest.mark.parametrize("turned", [(10.0, 55.0), (55.0, 10.0), (0.0, 90.0), (90.0, 0.0)])
def test_a_lattice_leads_there_and_back(turned):
    lattice = Lattice.of(turned, 0.7, np.array([0.3, 0.9]))
    assert lattice.steps @ lattice.back == pytest.approx(np.eye(2), abs=1e-12)
    assert np.linalg.det(lattice.steps) == pytest.approx(0.49 / abs(np.sin(np.radians(turned[1] - turned[0]))))
    x, y = lattice.places(np.arange(3), np.zeros(3))
    # dots lie in the middle of a line of each family
    for angle, phase in zip(turned, (0.3, 0.9), strict=True):
        across = (y * np.cos(np.radians(angle)) - x * np.sin(np.radians(angle))) / 0.7 - phase
        assert across == pytest.approx(np.round(across), abs=1e-9)


def test_the_ground_beyond_the_canvas_is_that_at_its_edge():
    tone = Tone(np.repeat([[0.2, 1.0]], 4, axis=0), (8.0, 16.0), shapely.box(0, 0, 4, 16))
    ground = Ground.of(tone, 1.0)
    assert ground.at(np.array([3.9, 4.1, 7.0]), np.full(3, 5.0)) == pytest.approx([0.2, 0.2, 0.2])


def test_the_ground_joins_pixels_finer_than_the_detail_and_keeps_their_ink():
    tone = Tone(np.random.default_rng(2).random((50, 70)), (7.0, 5.0))
    ground = Ground.of(tone, 0.35)
    assert ground.coverage.shape == (17, 24) and ground.pixel == pytest.approx((0.3, 0.3))
    assert ground.sum(ground.coverage) == pytest.approx(tone.ink)


def test_a_thinned_path_stays_within_half_a_micrometre_and_keeps_its_ends():
    t = np.linspace(0, 6, 5000)
    line = np.stack([t, np.sin(t)], axis=1)
    thin = simplified(Paths.of([line], closed=False))
    assert len(thin.xy) < 500 and (thin.xy[[0, -1]] == line[[0, -1]]).all()
    assert shapely.hausdorff_distance(shapely.LineString(thin.xy), shapely.LineString(line)) <= 5.5e-4  # mm: the stated 5e-4 and rounding


def test_a_thinned_path_keeps_its_spikes():
    thin = simplified(Paths.of([[(0, 0), (1, 0), (5, 0), (2, 0), (2, 1)]], closed=False))
    assert [5.0, 0.0] in thin.xy.tolist() and [2.0, 0.0] in thin.xy.tolist()


def test_outlines_are_cut_at_a_canvas_with_their_holes():
    ring, hole = shapely.box(0, 0, 4, 4), shapely.box(1, 1, 3, 3)
    paths = Paths.of_polygons(np.array([ring - hole, shapely.box(6, 0, 7, 1), shapely.box(20, 0, 21, 1)]))[0]
    cut = clipped(paths, shapely.box(0, 0, 10, 2))
    assert float(cut.areas.sum()) == pytest.approx(4 * 2 - 2 * 1 + 1)


def test_the_ink_of_lines_is_the_same_whichever_way_they_run():
    bars = [[(0, y), (30, y), (30, y + 0.1), (0, y + 0.1)] for y in np.linspace(0, 19.537, 40)]
    for angle in (0.0, 30.0, 90.0):
        cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        paths = Paths.of(bars).moved(((cos, -sin), (sin, cos)))
        assert inked(paths, (angle,), 0.5) == pytest.approx(40 * 3.0, rel=2e-3)  # each bar of 100 um is rounded its own way


def test_a_ruling_is_one_of_two_and_not_too_fine():
    tone = grey(0.5)
    assert ruling(None, None, tone) == pytest.approx(0.508) and ruling(100, None, tone) == pytest.approx(0.254)
    assert ruling(None, 0.3, tone) == 0.3
    with pytest.raises(ValueError, match=r"lpi 50 and pitch 0.5 mm are both given; leave one out"):
        ruling(50, 0.5, tone)
    with pytest.raises(ValueError, match=r"makes .* dots, over the limit of .*; take .* mm or more"):
        ruling(None, 0.02, Tone([[0.5]], (210.0, 297.0)))


def test_phases_are_as_given_or_by_chance():
    rng = np.random.default_rng(3)
    assert phases((0.25,), 2, rng).tolist() == [0.25, 0.25] and phases((0.1, 0.2), 2, rng).tolist() == [0.1, 0.2]
    assert phases(None, 3, rng).shape == (3,)
    with pytest.raises(ValueError, match="phase has 2 numbers for 3 families of lines; give one, or one for each"):
        phases((0.1, 0.2), 3, rng)
