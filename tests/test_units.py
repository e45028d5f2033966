"""Lengths and papers: what is understood, and what is refused in words that help."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crowquill.units import INCH, LARGEST, PAPERS, POINT, UNITS, length, paper


@pytest.mark.parametrize(
    ("text", "mm", "story"),
    [
        ("0.3mm", 0.3, "a pen"),
        ("1in", 25.4, "an inch is exact since 1959"),
        ("72pt", 25.4, "72 points to the inch, as PDF counts"),
        ("12pt", 12 * 25.4 / 72, "a line of print"),
        ("2.5cm", 25.0, "centimetres"),
        ("300um", 0.3, "micrometres"),
        ("  0.3  mm ", 0.3, "spaces round and between"),
        ("1 IN", 25.4, "capitals"),
        (".5mm", 0.5, "no digit before the point"),
        ("5.mm", 5.0, "no digit after it"),
        ("-2mm", -2.0, "to the left"),
        ("+2mm", 2.0, "a plus, written out"),
        ("0mm", 0.0, "none at all is a length"),
        ("100000mm", 100_000.0, "the largest"),
    ],
)
def test_a_length_with_its_unit_is_millimetres(text: str, mm: float, story: str) -> None:
    assert length(text) == pytest.approx(mm, rel=1e-15), story  # one product or two: the last bit may differ


@pytest.mark.parametrize(
    ("text", "words", "story"),
    [
        ("3", "write 3mm", "a bare number meant pixels to one program and points to the next"),
        (" 0.5 ", "write 0.5mm", "and is answered with what to write"),
        ("", "not understood", "nothing"),
        ("mm", "not understood", "a unit alone"),
        ("3px", "one of mm, cm, um, in, pt", "pixels are no length"),
        ("3 mm wide", "not understood", "words after it"),
        ("1,5mm", "not understood", "a decimal comma is not guessed at"),
        ("1e3mm", "not understood", "powers of ten"),
        ("nanmm", "not understood", "not a number"),
        ("infmm", "not understood", "without end"),
        (".mm", "not understood", "a point without digits"),
        ("--3mm", "not understood", "two signs"),
        ("3mm\x00", "not understood", "a byte that hides"),
        ("٣mm", "not understood", "digits of another script"),
        ("3ｍｍ", "not understood", "letters that only look like the unit"),
        ("101m", "not understood", "metres are no unit here"),
        ("100001mm", "over 100 m", "a slip of the keyboard"),
        ("-100001mm", "over 100 m", "to the left as well"),
        ("9" * 400 + "mm", "over 100 m", "more digits than a float holds"),
    ],
)
def test_what_is_no_length_is_refused_with_what_to_write(text: str, words: str, story: str) -> None:
    with pytest.raises(ValueError) as error:
        length(text)
    assert words in str(error.value), story


@pytest.mark.parametrize(
    ("text", "size", "story"),
    [
        ("a4", (210, 297), "by name"),
        ("A5", (148, 210), "in capitals"),
        (" letter ", (215.9, 279.4), "with spaces round it, in mm and not in inches"),
        ("100x50mm", (100, 50), "one unit for both"),
        ("100mmx5cm", (100, 50), "a unit each"),
        ("8.5x11in", (215.9, 279.4), "letter by its inches is letter by its name"),
        ("100 × 50 mm", (100, 50), "a true times sign"),
        ("72ptx1in", (25.4, 25.4), "points by inches"),
    ],
)
def test_a_paper_is_its_width_and_height(text: str, size: tuple[float, float], story: str) -> None:
    assert paper(text) == pytest.approx(size, abs=1e-9), story  # mm: inches times 25.4 round in the last bits


@pytest.mark.parametrize(
    ("text", "words", "story"),
    [
        ("a44", "a4, a5, letter", "a miss says what there is"),
        ("", "a4, a5, letter", "nothing"),
        ("100x50", "no paper", "no unit"),
        ("100mmx50", "no paper", "a unit for the width alone"),
        ("100mm", "no paper", "one side"),
        ("1x2x3mm", "no paper", "three sides"),
        ("-1x5mm", "no paper", "a negative side"),
        ("0x50mm", "has no area", "a line"),
        ("0.0000001x50mm", "has no area", "a side that rounds to nothing"),
        ("200000x10mm", "over 100 m", "a slip of the keyboard"),
    ],
)
def test_what_is_no_paper_is_refused(text: str, words: str, story: str) -> None:
    with pytest.raises(ValueError) as error:
        paper(text)
    assert words in str(error.value), story


@given(st.floats(-1000, 1000), st.sampled_from(sorted(UNITS)))
def test_every_number_comes_back_through_every_unit(number: float, unit: str) -> None:
    text = f"{number:.9f}{unit}"
    # nine places are written, and 1000in are 25400 mm
    assert length(text) == pytest.approx(number * UNITS[unit], rel=1e-14, abs=1e-9 * INCH)


@given(st.text(max_size=20))
def test_any_text_is_a_length_or_a_refusal(text: str) -> None:
    for read in (length, paper):
        try:
            found = read(text)
        except ValueError as error:
            assert repr(text) in str(error)  # the refusal shows what was written, control characters escaped
        else:
            assert all(math.isfinite(side) and abs(side) <= LARGEST for side in (found if isinstance(found, tuple) else (found,)))


def test_constants_agree_with_each_other() -> None:
    assert length("72pt") == length("1in") == INCH and length("1pt") == POINT
    assert PAPERS["a4"][0] < PAPERS["a4"][1] and PAPERS["a5"][1] == PAPERS["a4"][0]  # upright; A5 is half of A4
