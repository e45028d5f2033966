"""Dots of several inks keep clear of each other, each ink's pattern, tone and ink stay, and none leaves the place it may have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from crowquill import draw, inks, measure, separation, styles
from crowquill.marks import Marks, together
from crowquill.mingling import mingled
from crowquill.tone import Tone

SIDE = 18.0  # mm


def flat(*coverage: float) -> list[Tone]:
    return [Tone(np.full((30, 30), share), (SIDE, SIDE)) for share in coverage]


def stippled(tones: Sequence[Tone], **knobs: object) -> list[Marks]:
    """Dots of each tone by itself."""
    return [draw("stipple", tone, seed=seed, **({"pen": 0.3} | knobs)).marks for seed, tone in enumerate(tones)]


def kept_apart(parts: Sequence[Marks], tones: Sequence[Tone], gap: float = 0.0) -> list[Marks]:
    return styles.run(mingled(parts, tones, tones[0].canvas, gap))


def spacing(count: float, area: float) -> float:
    """Of so many evenly spaced dots on an area."""
    return float(np.sqrt(2 * area / (np.sqrt(3) * count)))


def near(parts: Sequence[Marks], limits: dict[tuple[int, int], float]) -> int:
    """How many pairs of dots of two inks are nearer than the limit of these two."""
    trees = [cKDTree(marks.xy) for marks in parts]
    return sum(trees[i].count_neighbors(trees[j], limit) for (i, j), limit in limits.items())


def half_spacings(parts: Sequence[Marks], area: float = SIDE**2) -> dict[tuple[int, int], float]:
    """For any two inks, half the mean of their spacings."""
    each = [spacing(len(marks), area) for marks in parts]
    return {(i, j): (each[i] + each[j]) / 4 for i in range(len(parts)) for j in range(i)}


def half_of_all(parts: Sequence[Marks], area: float = SIDE**2) -> dict[tuple[int, int], float]:
    """For any two inks, half the spacing of all dots together."""
    every = spacing(sum(map(len, parts)), area) / 2
    return {(i, j): every for i in range(len(parts)) for j in range(i)}


def tone_error(marks: Marks, tone: Tone) -> float:
    """How far dots are from a tone on the mean, both seen through a blur of two spacings of dots at .3."""
    cells = 120
    drawn = measure.rendered(marks, tone.size, (cells, cells))
    asked = np.kron(tone.coverage, np.ones((cells // len(tone.coverage),) * 2))
    blurred = [gaussian_filter(part, 2 * 0.52 / SIDE * cells, mode="nearest") for part in (drawn, asked)]
    return float(np.sqrt(((blurred[0] - blurred[1]) ** 2)[10:-10, 10:-10].mean()))


@pytest.mark.parametrize("coverage", [(0.3, 0.3), (0.15, 0.25), (0.5, 0.4), (0.25, 0.25, 0.25)])
def test_few_dots_of_different_inks_are_nearer_than_half_their_spacings(coverage: tuple[float, ...]):
    tones = flat(*coverage)
    parts = stippled(tones)
    moved = kept_apart(parts, tones)
    by_chance, now = near(parts, half_spacings(parts)), near(moved, half_spacings(moved))
    assert by_chance > 0.4 * len(parts[0]), "independent dots are near each other"
    assert now < by_chance / 3


@pytest.mark.parametrize("coverage", [(0.1, 0.4), (0.2, 0.1, 0.3), (0.15, 0.15, 0.15, 0.15)])
def test_inks_of_many_kinds_are_nowhere_nearer_than_half_the_spacing_of_all(coverage: tuple[float, ...]):
    # for these half the mean of two inks' own spacings is as far as all dots together can be from each other at best
    tones = flat(*coverage)
    parts = stippled(tones)
    moved = kept_apart(parts, tones)
    assert near(moved, half_of_all(moved)) < 0.02 * near(parts, half_of_all(parts))


def test_each_ink_keeps_its_dots_its_ink_and_its_tone():
    ramp = np.tile(np.linspace(0, 0.8, 30), (30, 1))
    tones = [Tone(part, (SIDE, SIDE)) for part in (ramp, 0.8 - ramp, 0.5 * ramp.T)]
    parts = stippled(tones)
    for before, after, tone in zip(parts, kept_apart(parts, tones), tones, strict=True):
        assert len(after) == len(before) and (after.glyph == before.glyph).all() and (after.angle == before.angle).all()
        assert measure.ink(after) == pytest.approx(measure.ink(before), rel=1e-3)
        assert tone_error(after, tone) < 1.5 * tone_error(before, tone) + 1e-3
        assert (after.xy == np.round(after.xy, 3)).all()


def test_dots_of_sizes_by_tone_mingle_too():
    tones = flat(0.35, 0.25)
    parts = stippled(tones, size_by="tone")
    moved = kept_apart(parts, tones)
    assert near(moved, half_of_all(moved)) < 0.05 * near(parts, half_of_all(parts))
    for before, after in zip(parts, moved, strict=True):
        assert measure.ink(after) == pytest.approx(measure.ink(before), rel=1e-3)


def test_what_they_look_like_together_is_foretold():
    coverage = (0.45, 0.4, 0.3)
    tones = flat(*coverage)
    moved = kept_apart(stippled(tones), tones)
    grid = (round(SIDE / 0.02),) * 2
    each = [measure.rendered(marks, (SIDE, SIDE), grid, pitch=0.01)[100:-100, 100:-100] for marks in moved]
    taken = 1 - inks.looks(inks.several("rose=#e05080,olive=#808020,slate=#405070"))
    seen = np.prod([1 - cover[..., None] * one for cover, one in zip(each, taken, strict=True)], axis=0).mean(axis=(0, 1))
    shares = np.array([[cover.mean() for cover in each]])
    assert seen == pytest.approx(separation.mixed(shares, taken)[0], abs=0.02)  # triples meet a little less often than k^2 a b c
    assert np.abs(seen - separation.mixed(shares, taken, apart=False)[0]).max() > 0.03, "dots that lie by chance look otherwise"
    every = measure.rendered(together(moved), (SIDE, SIDE), grid, pitch=0.01)[100:-100, 100:-100].mean()
    foretold = np.interp(shares.sum(), separation.SUMS, separation.COVERED)
    assert every == pytest.approx(foretold, abs=0.015)  # which is the mean of two and of three inks


def test_dots_stay_in_the_canvas_and_off_white():
    canvas = shapely.Point(9, 9).buffer(8) - shapely.box(7, 7, 11, 11)
    cover = np.full((30, 30), 0.3)
    cover[:, 20:] = 0
    tones = [Tone(cover, (SIDE, SIDE), canvas), Tone(cover[:, ::-1], (SIDE, SIDE), canvas)]
    for marks, tone in zip(kept_apart(stippled(tones), tones), tones, strict=True):
        assert tone.holds(marks.xy).all() and (tone.at(marks.xy) > 0).all()


def test_a_gap_between_dots_of_one_ink_is_kept():
    tones = flat(0.2, 0.2)
    parts = stippled(tones, min_gap=0.05)
    for before, after in zip(parts, kept_apart(parts, tones, 0.05), strict=True):
        reach = np.array([glyph.reach for glyph in before.glyphs])[before.glyph] * before.scale
        for marks in (before, after):
            i, j = cKDTree(marks.xy).query_pairs(1.0, output_type="ndarray").T
            assert (np.hypot(*(marks.xy[i] - marks.xy[j]).T) - reach[i] - reach[j]).min() > 0.05 - 1e-9
        assert (after.xy != before.xy).any()


def test_no_dot_goes_far():
    tones = flat(0.3, 0.3)
    parts = stippled(tones)
    for before, after in zip(parts, kept_apart(parts, tones), strict=True):
        gone = np.hypot(*(after.xy - before.xy).T)
        assert 0.02 < gone.mean() < gone.max() < 0.75 * spacing(len(before), SIDE**2)


@pytest.mark.parametrize("seed", range(3))
def test_dots_that_lie_on_each_other_are_parted(seed: int):
    tones = flat(0.2, 0.2)
    one = draw("stipple", tones[0], seed=seed, pen=0.3).marks
    moved = kept_apart([one, one], tones)
    assert cKDTree(moved[0].xy).query(moved[1].xy)[0].min() > 0.05


@pytest.mark.parametrize("coverage", [(0.3,), (0.3, 0.0), (0.0, 0.0)])
def test_nothing_moves_where_there_is_but_one_ink_or_none(coverage: tuple[float, ...]):
    tones = flat(*coverage)
    parts = stippled(tones)
    assert all((after.xy == before.xy).all() for before, after in zip(parts, kept_apart(parts, tones), strict=True))


def test_the_same_dots_are_moved_to_the_same_places():
    tones = flat(0.2, 0.3)
    parts = stippled(tones, iterations=3)
    first, again = kept_apart(parts, tones), kept_apart(parts, tones)
    assert all((one.xy == other.xy).all() and (one.scale == other.scale).all() for one, other in zip(first, again, strict=True))


def test_one_dot_of_each_ink_has_an_answer():
    tones = flat(0.3, 0.3)
    one = stippled(tones[:1])[0].take(slice(1))
    for marks in kept_apart([one, replace(one, xy=one.xy + 0.01)], tones):
        assert len(marks) == 1 and np.isfinite(marks.xy).all() and tones[0].holds(marks.xy).all()
