"""What inks look like together, and which tones of each come nearest to a picture."""

from __future__ import annotations

import numpy as np
import pytest

from crowquill import inks, separation
from crowquill.inks import LUMINANCE
from crowquill.picture import encoded, linear
from crowquill.separation import COVERED, SUMS, mixed
from crowquill.tone import Tone

CMYK = inks.several("C,M,Y,K")  # yellow, cyan, magenta, black
TAKEN = 1 - inks.looks(CMYK)
CHANCE = np.random.default_rng(1)


def picture(codes: np.ndarray) -> Tone:
    """A tone of one row of these colours (n, 3), sRGB of 0 to 255."""
    rgb = np.asarray(codes, np.uint8)[None]
    return Tone(1 - linear(rgb / 255) @ LUMINANCE, (float(rgb.shape[1]), 1.0), rgb=rgb)


def greys(values: np.ndarray) -> Tone:
    """A tone of one row of greys, by the light of each."""
    return picture(np.repeat(np.round(255 * encoded(values))[:, None], 3, axis=1))


def shares(found: separation.Separation) -> np.ndarray:
    """What is asked of each ink, (colours, inks)."""
    return np.stack([tone.coverage[0] for tone in found.tones], axis=1)


def test_one_ink_takes_its_share_of_the_light_however_dots_lie():
    some = CHANCE.random((50, 1))
    for apart in (True, False):
        assert mixed(some, TAKEN[1:2], apart=apart) == pytest.approx(1 - some * TAKEN[1], abs=1e-9)


def test_dots_apart_add_up_while_there_is_room_and_those_of_chance_multiply():
    some = np.array([[0.1, 0.05, 0.1, 0.1]])
    assert mixed(some, TAKEN) == pytest.approx(1 - some @ TAKEN, abs=2e-3)  # at .35 they hardly meet
    product = np.prod(1 - some[0][:, None] * TAKEN, axis=0)
    assert mixed(some, TAKEN, apart=False)[0] == pytest.approx(product, abs=1e-12)


def test_inks_that_cover_all_are_filters_over_each_other_either_way():
    some = np.array([[1.0, 0.3, 1.0, 0.0], [1, 1, 0, 1]])
    product = np.prod(1 - some[:, :, None] * TAKEN, axis=1)
    for apart in (True, False):
        assert mixed(some, TAKEN, apart=apart) == pytest.approx(product, abs=1e-3)


def test_the_paper_left_free_is_that_which_was_measured():
    some = CHANCE.dirichlet(np.ones(3), 200) * CHANCE.uniform(0.3, 1.3, (200, 1))
    some = some[(some < 1).all(axis=1)]
    by_chance = 1 - np.prod(1 - some, axis=1)
    black = np.ones((3, 1))  # each takes all light: what is left is the paper
    wanted = np.maximum(np.interp(some.sum(axis=1), SUMS, COVERED), by_chance)  # dots that keep clear never cover less than chance
    assert 1 - mixed(some, black)[:, 0] == pytest.approx(wanted, abs=1e-4)  # k is 1e-3 at the least


def test_more_of_an_ink_never_leaves_more_light():
    some = CHANCE.uniform(0, 0.7, (300, 4))
    more = some.copy()
    more[np.arange(300), CHANCE.integers(0, 4, 300)] += 0.05
    assert (mixed(more, TAKEN) <= mixed(some, TAKEN) + 0.01).all()  # what fills a gap brings other inks nearer each other, a little


def test_the_colours_of_paper_and_of_inks_are_themselves():
    found = separation.of_colour(picture([(255, 255, 255), *(ink.rgb for ink in CMYK)]), CMYK)
    assert shares(found) == pytest.approx(np.concatenate([np.zeros((1, 4)), np.eye(4)]), abs=0.01)


def test_colours_of_all_kinds_come_out_within_a_hundredth():
    codes = CHANCE.integers(0, 256, (500, 3))
    found = separation.of_colour(picture(codes), CMYK)
    error = np.abs(mixed(shares(found), TAKEN) - linear(codes / 255))
    assert error.mean() < 0.005 and found.error == pytest.approx(error.mean(), abs=1e-9)
    assert found.lost == 0 and found.least == 0


def test_by_chance_they_come_out_too_by_other_shares():
    codes = CHANCE.integers(0, 256, (500, 3))
    found = separation.of_colour(picture(codes), CMYK, apart=False)
    assert np.abs(mixed(shares(found), TAKEN, apart=False) - linear(codes / 255)).mean() < 0.006


def test_light_colours_have_no_black_and_dark_ones_have_it_by_degrees():
    black = shares(separation.of_colour(greys(np.linspace(1, 0, 41)), CMYK))[:, 3]
    assert (black[:9] < 0.005).all(), "no black down to four fifths of the light"
    assert black[-1] == pytest.approx(1, abs=0.01)
    assert (np.diff(black) > -0.01).all() and np.diff(black).max() < 0.1


def test_skin_has_no_black():
    assert shares(separation.of_colour(picture([(230, 179, 153)]), CMYK))[0, 3] < 0.005


def test_greys_are_black_alone_where_that_is_asked_for():
    light = np.linspace(1, 0, 21)
    found = shares(separation.of_colour(greys(light), CMYK, greys=True))
    assert found[:, 3] == pytest.approx(1 - light, abs=0.01) and (found[:, :3] < 0.01).all()


def test_no_place_has_more_ink_than_the_limit_and_less_ink_comes_less_near():
    tone = picture(CHANCE.integers(0, 128, (200, 3)))
    tight, loose = (separation.of_colour(tone, CMYK, limit=limit) for limit in (0.8, 3.0))
    assert shares(tight).sum(axis=1).max() <= 0.8 + 1e-6 < shares(loose).sum(axis=1).max() <= 3
    assert tight.error > 2 * loose.error


def test_the_darkest_ink_stays_where_nothing_else_makes_the_colour():
    light = np.linspace(1, 0, 21)
    found = shares(separation.of_colour(greys(light), inks.several("ochre=#c8922b,black")))
    assert (found[:, 0] < 0.01).all() and found[:, 1] == pytest.approx(1 - light, abs=0.01)


def test_inks_that_do_not_reach_a_picture_say_how_far_off_it_is():
    found = separation.of_colour(picture([(0, 0, 255), (255, 255, 255)]), inks.several("Y,K"))
    assert found.lost == 0.5 and found.error > 0.1
    found = separation.of_colour(greys(np.linspace(0, 1, 11)), inks.several("ochre=#c8922b,sand=#e0c080"))
    assert 0.15 < found.least < 0.25 and found.lost > 0.3


def test_a_tone_without_colours_is_grey():
    light = np.linspace(0, 1, 11)
    alone = Tone(1 - light[None], (11.0, 1.0))
    codes = np.repeat(np.round(255 * encoded(light))[:, None], 3, axis=1)
    assert shares(separation.of_colour(alone, CMYK)) == pytest.approx(shares(separation.of_colour(picture(codes), CMYK)), abs=0.01)


@pytest.mark.parametrize("text", ["ochre=#c8922b,black", "rose=#e8a0b0,sea=#3080a0,K", "K", "C,M,Y,K"])
def test_lightness_is_that_of_the_tone_and_the_light_inks_begin(text: str):
    several = inks.several(text)
    tone = Tone(np.linspace(0, 1, 101)[None], (101.0, 1.0))
    found = separation.of_lightness(tone, several)
    each = shares(found)
    light = mixed(each, (1 - inks.looks(several)) @ LUMINANCE[:, None])[:, 0]
    assert light == pytest.approx(1 - tone.coverage[0], abs=2e-3) and found.error < 1e-3  # a hundred steps an ink, straight between
    assert (np.diff(each, axis=0) >= 0).all(), "no ink goes back as it grows darker"
    began = [np.flatnonzero(column > 0)[0] for column in each.T]
    assert began == sorted(began)


def test_lightness_that_no_ink_has_is_as_dark_as_all_together():
    several = inks.several("ochre=#c8922b,sand=#e0c080")
    found = separation.of_lightness(Tone([[0.5, 1.0]], (2.0, 1.0)), several)
    assert shares(found)[1] == pytest.approx([1, 1]) and 0.15 < found.least < 0.25 and found.lost == 0.5
