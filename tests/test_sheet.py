"""Marks, glyphs, layers and sheets: what holds of each once it is made, and how a drawing is laid on paper."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crowquill.marks import TURN_STEPS, Glyph, Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

Array = npt.NDArray[np.float64]
EGG = np.array([(2, 0), (2, 1.1), (0.9, 1.4), (0, 1.2), (-1, 1), (-1.5, 0.8), (-1.6, 0), (-1.7, -0.9), (0.5, -1.3)])  # three cubics
KITE = np.array([(3.0, 0), (1, 1), (0, 0.2), (1, -0.7)])
STEP = 2 * np.pi / TURN_STEPS
SEEDS = st.integers(0, 2**32 - 1)


def glyph(outline: Array = KITE) -> Glyph:
    return Glyph.of(Paths.of([outline], cubic=outline is EGG))


def turned(points: Array, angle: float, scale: float = 1.0, offset: npt.ArrayLike = (0, 0)) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]]) * scale + offset


def reversed_ring(points: Array) -> Array:
    """The same ring the other way round from the same first point."""
    return np.roll(points[::-1], 1, axis=0)


def some_marks(seed: int, n: int = 40) -> Marks:
    rng = np.random.default_rng(seed)
    return Marks.of(
        rng.uniform(-10, 300, (n, 2)),
        (glyph(), glyph(KITE[::-1] * (1, -0.3))),
        scale=rng.uniform(0, 2, n),
        angle=rng.uniform(-20, 20, n),
        glyph=rng.integers(2, size=n),
    )


def same_marks(one: Marks, other: Marks) -> None:
    for name in ("xy", "angle", "scale", "glyph"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


@pytest.mark.parametrize("outline", [EGG, KITE], ids=["egg", "kite"])
@given(st.floats(-7, 7), st.floats(1e-6, 1e6), st.tuples(st.floats(-5, 5), st.floats(-5, 5)), st.booleans())
def test_a_glyph_is_the_same_however_its_outline_lies(
    outline: Array, angle: float, scale: float, offset: tuple[float, float], back: bool
) -> None:
    plain = glyph(outline)
    points = turned(outline, angle, scale, np.multiply(offset, scale))
    again = Glyph.of(Paths.of([reversed_ring(points) if back else points], cubic=outline is EGG))
    half_turned = 1 if np.dot(again.paths.xy[0], plain.paths.xy[0]) > 0 else -1  # an axis has two ends
    # 1e-9 of a glyph of size 1: offsets of five sizes lose a digit, axes not far from equal lose two
    np.testing.assert_allclose(again.paths.xy * half_turned, plain.paths.xy, atol=1e-9)
    assert again.size == pytest.approx(plain.size * scale, rel=1e-9)


@pytest.mark.parametrize("outline", [EGG, KITE], ids=["egg", "kite"])
def test_a_unit_glyph_has_area_one_centroid_nought_and_its_long_axis_on_x(outline: Array) -> None:
    made = glyph(outline)
    area, x, y, xx, xy, yy = made.paths.green()[0]
    corner = made.paths[0][0]
    # some tens of roundings of numbers of size 1
    assert area == pytest.approx(1, abs=1e-13)
    np.testing.assert_allclose(np.add(corner, (x, y)), 0, atol=1e-13)
    assert xy - x * y == pytest.approx(0, abs=1e-13)
    assert xx - x * x > yy - y * y
    flat = np.abs(Paths.of([outline], cubic=outline is EGG).flat(1e-6).areas[0])
    assert made.size == pytest.approx(2 * np.sqrt(flat / np.pi), rel=1e-6)  # a circle's diameter


def test_reach_holds_the_whole_outline() -> None:
    for outline in (EGG, KITE):
        made = glyph(outline)
        assert np.hypot(*made.paths.flat(1e-4).xy.T).max() <= made.reach


NO_AREA = {
    "nothing": [],
    "a point": [(1, 1)],
    "there and back": [(0, 0), (1, 0)],
    "a line": [(0, 0), (3, 0), (1, 0)],
    "an eight of equal halves": [(0, 0), (1, 1), (1, 0), (0, 1)],
    # rounding leaves these lines areas of 3e-18 and -4e-19: as unit glyphs they were 100 km long
    "a slanting line": np.add(np.outer([0.6, 0.3, 0, 0], (0.3, 0.7)), (0.1, 0.2)),
    "another": np.add(np.outer([0.8, 0.9, 0.6, 0.7], (0.3, 0.7)), (0.1, 0.2)),
}


@pytest.mark.parametrize("story", NO_AREA)
def test_an_outline_without_area_is_no_glyph(story: str) -> None:
    with pytest.raises(ValueError, match="area over 0"):
        Glyph.of(Paths.of([NO_AREA[story]]))


def test_open_and_double_outlines_are_no_glyphs() -> None:
    for paths in (Paths.of([KITE], closed=False), Paths.of([KITE, KITE]), Paths.of([])):
        with pytest.raises(ValueError, match="one closed outline"):
            Glyph.of(paths)


@pytest.mark.parametrize("outline", [EGG, KITE], ids=["egg", "kite"])
@given(SEEDS)
def test_a_mark_is_its_glyph_turned_scaled_and_put_in_its_place(outline: Array, seed: int) -> None:
    rng = np.random.default_rng(seed)
    marks = Marks.of(rng.uniform(0, 300, (9, 2)), (glyph(outline),), scale=rng.uniform(0.1, 5, 9), angle=rng.uniform(0, 7, 9))
    outlines = marks.outlines()
    np.testing.assert_allclose(outlines.areas, marks.scale**2, rtol=1e-9)  # digits lost 300 mm from the origin
    for k, ring in enumerate(outlines):
        cos, sin = np.cos(marks.angle[k]), np.sin(marks.angle[k])
        where = [(cos * x - sin * y, sin * x + cos * y) for x, y in glyph(outline).paths.xy]  # x turns towards y
        np.testing.assert_allclose(ring, marks.xy[k] + marks.scale[k] * np.array(where), atol=1e-12 * 300)


def test_a_quarter_turn_lays_the_long_axis_from_x_on_y() -> None:
    bar = Glyph.of(Paths.of([[(0, 0), (4, 0), (4, 1), (0, 1)]]))
    x, y = Marks.of([(0, 0)], (bar,), scale=2, angle=np.pi / 2).outlines().xy.T
    assert np.ptp(x) == pytest.approx(1) and np.ptp(y) == pytest.approx(4)


def test_outlines_keep_the_order_of_marks_of_many_glyphs() -> None:
    triangle = Glyph.of(Paths.of([[(0, 0), (1, 0), (0, 1)]]))
    marks = Marks.of([(5, 0), (0, 0), (9, 9)], (glyph(), triangle), scale=1, glyph=[1, 0, 1])
    assert np.diff(marks.outlines().start).tolist() == [3, 4, 3]
    np.testing.assert_allclose(marks.outlines()[0] - (5, 0), triangle.paths[0], atol=1e-15 * 9)  # roundings at 9 mm
    with pytest.raises(ValueError, match="mix straight and cubic"):
        Marks.of([(0, 0)], (glyph(), glyph(EGG)), scale=1).outlines()


def test_no_marks_are_marks() -> None:
    for glyphs in ((), (glyph(),)):
        none = Marks.of([], glyphs, scale=1)
        assert (len(none), len(none.outlines()), len(none.snapped().take(slice(None)))) == (0, 0, 0)


@given(SEEDS)
def test_snapping_moves_nothing_by_more_than_half_a_step_and_only_once(seed: int) -> None:
    marks = some_marks(seed)
    once = marks.snapped()
    assert np.abs(once.xy - marks.xy).max() <= 0.0005 * (1 + 1e-9)
    assert np.abs(once.scale - marks.scale).max() <= 0.0005 * (1 + 1e-9)
    turn = (once.angle - marks.angle + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(turn).max() <= STEP / 2 * (1 + 1e-9)
    assert once.angle.min() >= 0 and once.angle.max() < 2 * np.pi
    same_marks(once.snapped(), once)
    np.testing.assert_array_equal(np.round(once.xy * 1000) / 1000, once.xy)  # the doubles nearest to whole micrometres


def test_an_angle_just_below_a_full_turn_snaps_to_nought() -> None:
    assert Marks.of([(0, 0)], (glyph(),), scale=1, angle=-STEP / 3).snapped().angle.tolist() == [0]


WRONG: dict[str, dict[str, Any]] = {
    r"xy has shape \(2, 3\)": {"xy": np.zeros((2, 3))},
    r"angle has shape \(3,\); it takes 2": {"angle": np.zeros(3)},
    r"scale has shape \(1,\)": {"scale": np.ones(1)},
    "xy has a value that is not finite": {"xy": [[0, np.nan], [0, 0]]},
    "scale has a value that is not finite": {"scale": [1, np.inf]},
    r"scale -1\.0 mm is negative": {"scale": [1, -1]},
    "glyph has an index outside 0 to 0": {"glyph": [0, 1]},
    "glyph has an index outside 0 to": {"glyph": [-1, 0]},
    "outside 0 to -1": {"glyphs": ()},
}


@pytest.mark.parametrize("says", WRONG)
def test_marks_that_cannot_be_are_refused(says: str) -> None:
    right = {"xy": np.zeros((2, 2)), "angle": np.zeros(2), "scale": np.ones(2), "glyph": [0, 0], "glyphs": (glyph(),)}
    assert len(Marks(**right)) == 2
    with pytest.raises(ValueError, match=says):
        Marks(**{**right, **WRONG[says]})


def test_marks_are_copies_that_cannot_be_written() -> None:
    xy = np.zeros((1, 2))
    marks = Marks.of(xy, (glyph(),), scale=1)
    xy[:] = 7
    assert marks.xy.tolist() == [[0, 0]]
    for name in ("xy", "angle", "scale", "glyph"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(marks, name)[0] = 1
    with pytest.raises(FrozenInstanceError):
        marks.xy = xy  # type: ignore[misc]


@pytest.mark.parametrize("cmyk", [(0, 0, 0), (0, 0, 0, 1.1), (-0.1, 0, 0, 0), (0, 0, 0, np.nan)])
def test_an_ink_takes_four_shares(cmyk: Any) -> None:
    with pytest.raises(ValueError, match="four shares from 0 to 1"):
        Ink("red", cmyk)


@pytest.mark.parametrize("pen", [0, -1, np.nan, np.inf])
def test_a_pen_has_a_width(pen: float) -> None:
    with pytest.raises(ValueError, match="is not a width"):
        Ink(pen=pen)


def test_a_layer_is_called_by_its_name_or_else_its_ink() -> None:
    art = Paths.of([KITE])
    assert (Layer(Ink("red"), art).label, Layer(Ink("red"), art, "sky").label) == ("red", "sky")


def test_a_sheet_snaps_its_size_and_all_its_art() -> None:
    sheet = Sheet((100.00049, 50), (Layer(Ink(), Paths.of([KITE + 1e-4])), Layer(Ink(), some_marks(1))), {"seed": 1})
    assert sheet.size == (100, 50)
    np.testing.assert_array_equal(sheet.layers[0].art.xy, KITE)
    same_marks(sheet.marks, some_marks(1).snapped())
    again = Sheet(sheet.size, sheet.layers)
    same_marks(again.marks, sheet.marks)
    with pytest.raises(TypeError):
        sheet.recipe["seed"] = 2  # type: ignore[index]


@pytest.mark.parametrize("size", [(0, 1), (1, -1), (np.nan, 1), (1, np.inf), (1e-4, 1)])
def test_a_sheet_without_area_is_refused(size: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="has no area"):
        Sheet(size)


def test_a_sheet_without_marks_says_so() -> None:
    with pytest.raises(ValueError, match="no layer of marks"):
        _ = Sheet((1, 1), (Layer(Ink(), Paths.of([KITE])),)).marks


@given(st.floats(1, 180), st.floats(1, 180), st.sampled_from(["a4", "letter", (250.0, 200.0), "201.5x333.3mm"]))
def test_on_paper_the_drawing_lies_in_the_middle(width: float, height: float, page: Any) -> None:
    marks = Marks.of([(0, 0), (width, height)], (glyph(),), scale=1)
    sheet = Sheet((width, height), (Layer(Ink(), marks), Layer(Ink(), Paths.of([[(0, 0), (width, 0), (width, height)]]))), {"a": 1})
    laid = sheet.on(page, margin=10)
    for xy in (laid.marks.xy, laid.layers[1].art.xy):
        # equal margins left and right, to the micrometre that the odd one goes to
        np.testing.assert_allclose(xy[0] + xy[-1], laid.size, atol=0.0021)
        np.testing.assert_allclose(xy[-1] - xy[0], sheet.size, atol=1e-9)  # at its own size, not fitted
    assert laid.recipe["art_mm"] == list(sheet.size) and laid.recipe["a"] == 1


@pytest.mark.parametrize(
    ("art", "orientation", "size"),
    [
        ((20, 10), "auto", (210, 148)),
        ((10, 20), "auto", (148, 210)),
        ((10, 10), "auto", (148, 210)),
        ((20, 10), "portrait", (148, 210)),
        ((10, 20), "landscape", (210, 148)),
    ],
)
def test_paper_is_turned_as_asked_or_to_suit(art: tuple[float, float], orientation: str, size: tuple[float, float]) -> None:
    assert Sheet(art).on("a5", orientation=orientation).size == size


def test_a_drawing_fits_to_the_margin_and_not_a_micrometre_more() -> None:
    assert Sheet((118, 180)).on("a5", margin=15).size == (148, 210)
    assert Sheet((148, 210)).on("a5", margin=0).size == (148, 210)
    for size in ((118.002, 180), (118, 180.002)):
        with pytest.raises(ValueError, match=r"does not fit a paper of 148 x 210 mm with a margin of 15 mm; make it smaller"):
            Sheet(size).on("a5", margin=15)
    with pytest.raises(ValueError, match="no paper 'a9'"):
        Sheet((1, 1)).on("a9")
    with pytest.raises(ValueError, match="no orientation 'sideways'"):
        Sheet((1, 1)).on("a5", orientation="sideways")


@pytest.mark.parametrize("margin", [-5, np.nan])
def test_a_margin_that_would_lay_ink_beside_the_paper_is_refused(margin: float) -> None:
    with pytest.raises(ValueError, match="margin"):
        Sheet((150, 212)).on("a5", margin=margin)
