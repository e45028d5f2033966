"""Scales are read as people write them, and a scale bar has the length that it says."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from crowquill import scale
from crowquill.lettering import Words
from crowquill.paths import Paths
from crowquill.sheet import Sheet


@pytest.mark.parametrize(
    ("text", "ratio"),
    [
        ("1 mm in the figure = 250 um in the specimen", 4),
        ("1 mm in the drawing = 250um", 4),
        ("1 mm = 250 um", 4),
        ("1 mm = 250 \N{MICRO SIGN}m", 4),
        ("1 mm = 250 \N{GREEK SMALL LETTER MU}m", 4),
        ("1MM=250 UM", 4),
        ("1 cm = 2 km", 5e-6),
        ("2cm=1mm", 20),
        ("1 mm = 1 nm", 1e6),
        ("1 mm = .5 m", 0.002),
        ("1:50", 0.02),
        (" 20 : 1 ", 20),
    ],
)
def test_a_scale_is_mm_drawn_to_a_mm_of_the_specimen(text: str, ratio: float):
    assert math.isclose(scale.parsed(text), ratio, rel_tol=1e-12)


def test_a_pixel_s_length_gives_the_same_scale():
    assert math.isclose(scale.of_pixel("1.3 um", 0.052), 40, rel_tol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1:0",
        "0:1",
        "-1:50",
        "nan:1",
        "inf:1",
        "1:nan",
        "1e300:1e-300",
        "1:1e12",
        "1 mm = 0 um",
        "1 mm = -250 um",
        "1 mm = nan um",
        "1 mm = 250",
        "1 = 250 um",
        "1 mm = 1 furlong",
        "250 um in the specimen = 1 mm in the figure",
        "1,5 mm = 2 um",
        "1 mm = 2 um = 3 um",
        "1 mm\n= 2 parsec",
    ],
)
def test_a_scale_that_is_none_is_refused_in_one_line(text: str):
    with pytest.raises(ValueError, match="; ") as error:
        scale.parsed(text)
    assert "\n" not in str(error.value) and len(str(error.value)) < 160


@pytest.mark.parametrize("text", ["1.3", "0 um", "nan um", "-1 um", "1,3 um", "um", "1 px", "1 lightyear"])
def test_a_pixel_s_length_that_is_none_is_refused(text: str):
    with pytest.raises(ValueError, match=r"length .*of a specimen.*; "):
        scale.of_pixel(text, 0.1)


@pytest.mark.parametrize("text", ["500 um", "auto", "2 mm", "0.37 mm"])
@pytest.mark.parametrize("ticks", [False, True])
def test_a_bar_is_as_long_as_its_label_says_to_half_a_micrometre(text: str, ticks: bool):
    made = scale.bar(4.0, 80, text, at=(70, 40), ticks=ticks)
    (drawn,) = [layer.art for layer in Sheet((80, 50), made.layers).layers if isinstance(layer.art, Paths)]
    assert math.isclose(np.ptp(drawn.xy[:, 0]), 4 * scale.length(made.label), abs_tol=5e-4), "a sheet has whole micrometres"


def test_a_label_says_the_length_as_it_was_written_with_the_micro_sign_that_fonts_have():
    assert scale.bar(4.0, 80, "1500um").label == "1500 \N{MICRO SIGN}m"
    assert scale.bar(1.0, 80, "5 cm").label == "5 cm"


@pytest.mark.parametrize(
    ("ratio", "text", "label"),
    [
        (1 / 123.4567, "1234567 um", "1234567 µm"),
        (0.1, "150000000 nm", "150000000 nm"),
        (4, "1.50 mm", "1.50 mm"),
        (4, "1e3 um", "1000 µm"),
        (4e4, "0.00025 mm", "0.00025 mm"),
        (4e4, "2.5e-4 mm", "0.00025 mm"),
        (4, "+.5 mm", "0.5 mm"),
        (4, "5. mm", "5 mm"),
    ],
)
def test_a_label_keeps_its_digits_and_has_no_exponent(ratio: float, text: str, label: str):
    made = scale.bar(ratio, 80, text)
    assert made.label == label and math.isclose(scale.length(made.label), scale.length(text), rel_tol=1e-12)


@pytest.mark.parametrize(
    ("ratio", "width", "text", "says"),
    [
        (4, 80, "150000000 nm", "a scale bar of 150000000 nm is 600 mm long in a room of 80 mm; 5 mm would do"),
        (4, 80, "50 m", "a scale bar of 50 m is 200000 mm long in a room of 80 mm; 5 mm would do"),
        (4, 80, "12 nm", "a scale bar of 12 nm is 0.000048 mm long in a room of 80 mm; 5 mm would do"),
    ],
)
def test_a_refused_bar_is_told_without_exponents(ratio: float, width: float, text: str, says: str):
    with pytest.raises(ValueError, match=f"^{says}$"):
        scale.bar(ratio, width, text)


def test_a_length_beyond_all_specimens_is_refused_in_a_short_line():
    for text in ("1e300 m", "1e-300 nm"):
        with pytest.raises(ValueError, match=r"^length '1e.*' of a specimen; it takes a number over 0, ") as error:
            scale.bar(4, 80, text)
        assert len(str(error.value)) < 160


def test_lengths_of_continents_and_atoms_are_said_without_exponents():
    assert (scale.said(2e13), scale.said(2e-13)) == ("20000000 km", "0.0000002 nm")


@pytest.mark.parametrize(("value", "text"), [(2e-6, "2 nm"), (1e-3, "1 µm"), (0.5, "500 µm"), (50.0, "50 mm"), (2e3, "2 m"), (5e6, "5 km")])
def test_an_automatic_length_is_said_in_the_unit_that_suits(value: float, text: str):
    assert scale.said(value) == text


@pytest.mark.parametrize("ratio", [4.0, 0.02, 1e6, 1.37e-7])
@pytest.mark.parametrize("width", [5.01, 9.9, 24.9, 80, 143, 1e4])
def test_an_automatic_bar_is_round_and_a_fifth_to_a_third_of_the_width(ratio: float, width: float):
    length = scale.rounded(ratio, width)
    assert 0.2 - 1e-6 <= length * ratio / width <= 1 / 3 + 1e-6
    assert f"{length:.1e}"[:3] in {"1.0", "1.5", "2.0", "3.0", "5.0", "7.5"}


@pytest.mark.parametrize("anchor", ["right", "left"])
def test_all_ink_of_a_bar_lies_in_its_box_and_touches_the_corner_asked_for(anchor: str):
    made = scale.bar(4.0, 80, "500 um", at=(60, 40), anchor=anchor)
    ink = np.concatenate([layer.art.xy if isinstance(layer.art, Paths) else _letters(layer.art) for layer in made.layers])
    left, top, right, bottom = made.box
    assert (ink >= (left - 1e-3, top - 1e-3)).all() and (ink <= (right + 1e-3, bottom + 1e-3)).all()
    assert math.isclose(right if anchor == "right" else left, 60, abs_tol=1e-3) and math.isclose(bottom, 40, abs_tol=1e-3)
    assert shapely.box(*made.box).area < 1.2 * np.prod(np.ptp(ink, axis=0)), "and it is no larger than it must be"


def _letters(words: Words) -> np.ndarray:
    return words.outlines().flat(1e-3).xy


@pytest.mark.parametrize(
    ("ratio", "width", "text"), [(4, 80, "21 mm"), (4, 80, "1 um"), (4, 2, "auto"), (4, 4, "5000000 nm"), (4, 4, "1 mm")]
)
def test_a_bar_that_has_no_room_or_cannot_be_seen_is_refused_in_one_line(ratio: float, width: float, text: str):
    with pytest.raises(ValueError, match=r"scale bar.*; ") as error:
        scale.bar(ratio, width, text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("ratio", [0, -4, math.nan, math.inf, 1e30])
def test_a_bar_of_an_impossible_scale_is_refused(ratio: float):
    with pytest.raises(ValueError, match="none that can be drawn; "):
        scale.bar(ratio, 80)


def test_a_length_that_would_do_is_named():
    with pytest.raises(ValueError, match="120 mm long in a room of 100 mm; 5 mm would do"):
        scale.bar(4, 100, "30 mm")
