"""A pen's strokes put down the ink of the dots and areas they stand for: no more, no less, and no white inside."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from hypothesis import given
from hypothesis import settings as setting
from hypothesis import strategies as st

from crowquill import glyphs, hatching, lettering, plotforms, raster
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.plotforms import Strokes

Array = npt.NDArray[np.float64]
NIB = 0.3
LIBRARIES = ("disc", *(name for name in glyphs.names() if name != "disc"))
BAR = 0.03  # of a dot's area; measured, fills are within 0.006


def drawn(strokes: Strokes) -> Paths:
    """The strokes as a file keeps them."""
    return Paths(np.round(strokes.paths.xy, 3), strokes.paths.start, closed=False)


def shapes(library: str, width: float, nib: float, n: int = 12) -> tuple[Marks, float]:
    """Some dots of a library, so many nibs wide, in a row of squares that they do not leave, and the side of these in mm."""
    found = glyphs.load(library).glyphs
    side = 3 * width * nib
    at = (np.stack([np.arange(n), np.zeros(n)], axis=1) + 0.5) * side
    k = np.arange(n)
    marks = Marks.of(at, found, scale=width * nib * np.sqrt(np.pi) / 2, angle=0.7 * k, glyph=k * 3 % len(found))
    return marks.snapped(), side


def inked(strokes: Strokes, side: float, nib: float, n: int = 12) -> Array:
    """The mm^2 of ink that a nib leaves in each square of a row."""
    cover = raster.covered(drawn(strokes), (64, 64 * n), pixel=(side / 64, side / 64), pen=nib)
    return np.asarray(cover.reshape(64, n, 64).sum(axis=(0, 2)) * (side / 64) ** 2)


def check_ink(strokes: Strokes, marks: Marks, side: float, nib: float) -> None:
    """Raises AssertionError where the ink of a dot is not its area."""
    off = np.abs(inked(strokes, side, nib) / marks.scale**2 - 1).max()
    assert off < BAR, f"a dot has {off:.1%} more or less ink than its area"


@pytest.mark.parametrize("form", ["spiral", "hatch"])
@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("width", [1.25, 1.5, 2.1, 3.3, 10])
def test_filled_dots_have_the_ink_of_their_area(library: str, form: str, width: float) -> None:
    marks, side = shapes(library, width, NIB)
    check_ink(plotforms.dots(marks, NIB, form), marks, side, NIB)


@pytest.mark.parametrize("nib", [0.05, 0.1, 1.0])  # 0.05: a whole micrometre is a fiftieth of it
def test_filled_dots_have_their_ink_with_any_nib(nib: float) -> None:
    marks, side = shapes("nib-05", 4, nib)
    check_ink(plotforms.dots(marks, nib, "spiral"), marks, side, nib)


def test_discs_up_to_two_nibs_wide_have_their_ink_from_one_circle() -> None:
    for width in (1.3, 1.6, 2.0):
        marks, side = shapes("disc", width, NIB)
        check_ink(plotforms.dots(marks, NIB, "circle"), marks, side, NIB)


def test_the_check_of_ink_sees_a_dot_that_is_not_filled() -> None:
    marks, side = shapes("disc", 4, NIB)
    with pytest.raises(AssertionError, match="more or less ink"):
        check_ink(plotforms.dots(marks, NIB, "circle"), marks, side, NIB)


@pytest.mark.parametrize("form", ["spiral", "hatch"])
@pytest.mark.parametrize("library", ["disc", "nib-03", "brush"])
def test_no_white_shows_inside_a_filled_dot(library: str, form: str) -> None:
    marks, _ = shapes(library, 7, NIB)
    ink = shapely.union_all(shapely.buffer([shapely.LineString(path) for path in drawn(plotforms.dots(marks, NIB, form))], NIB / 2))
    # sharp corners are rounded by the nib: what is closed again by two thirds of it is the dot without them
    inside = shapely.buffer(shapely.buffer(marks.outlines().flat(1e-3).polygons(), -0.7 * NIB), 0.5 * NIB)
    white = shapely.difference(shapely.union_all(inside), ink)
    assert white.area < 1e-4 * ink.area


@pytest.mark.parametrize("form", plotforms.FORMS)
def test_a_dot_as_wide_as_the_nib_is_one_touch_where_it_lies(form: str) -> None:
    marks, _ = shapes("nib-03", 1.0, NIB)
    strokes = plotforms.dots(marks, NIB, form)
    assert len(strokes.paths) == len(marks) and strokes.dot.all()
    for path, at, angle in zip(strokes.paths, marks.xy, marks.angle, strict=True):
        if form in ("circle", "spiral"):
            assert (path[0] == path[-1]).all()
            np.testing.assert_allclose(np.hypot(*(path - at).T), 0.05 * NIB)
        else:
            way = path[1] - path[0]
            np.testing.assert_allclose(path.mean(axis=0), at)
            np.testing.assert_allclose(way, np.hypot(*way) * np.array([np.cos(angle), np.sin(angle)]), atol=1e-12)
            assert 0.02 - 1e-9 <= np.hypot(*way) <= 0.1


def test_a_long_narrow_dot_is_a_tick_of_as_much_ink() -> None:
    from crowquill.marks import Glyph

    needle = Glyph.of(Paths.of([[(0, 0), (8, 0), (8, 1), (0, 1)]]))
    marks = Marks.of([(2.4, 2.4)], (needle,), scale=0.8)  # 2.26 by 0.28 mm
    strokes = plotforms.dots(marks, NIB, "hatch")
    assert len(strokes.paths) == 1 and len(strokes.paths.xy) == 2
    assert inked(strokes, 4.8, NIB, 1)[0] == pytest.approx(0.64, rel=0.01)


def test_every_dot_is_one_dot_however_many_strokes_it_takes() -> None:
    marks, _ = shapes("nib-05", 10, NIB, 40)
    for form in ("spiral", "hatch"):
        strokes = plotforms.dots(marks, NIB, form)
        assert strokes.dot.sum() == len(marks) <= len(strokes.paths) <= 1.2 * len(marks)


def area(strokes: list[Array], nib: float) -> shapely.Geometry:
    return shapely.union_all(shapely.buffer([shapely.LineString(np.round(stroke, 3)) for stroke in strokes], nib / 2, quad_segs=32))


def test_areas_are_inked_to_their_corners_and_holes_stay_open() -> None:
    ring = [[(0, 0), (20, 0), (20, 12), (0, 12)], [(4, 2), (4, 10), (12, 10), (12, 2)], [(6, 4), (10, 4), (10, 8), (6, 8)]]
    outline = shapely.Polygon(ring[0], [ring[1]]).union(shapely.Polygon(ring[2]))
    ink = area(hatching.areas(Paths.of(ring), 0.5), 0.5)
    assert ink.difference(outline).area < 0.01  # of 192 mm^2: roundings to whole micrometres
    # in each of the 8 outer corners the nib leaves 1 - pi/4 of a square of half its width
    assert outline.difference(ink).area == pytest.approx(8 * (1 - np.pi / 4) * 0.25**2, abs=0.01)


def test_an_area_turned_the_other_way_is_drawn_the_same() -> None:
    square = [(1, 1), (9, 1), (9, 5), (1, 5)]
    one, other = (area(hatching.areas(Paths.of([path]), 0.3), 0.3) for path in (square, square[::-1]))
    assert one.symmetric_difference(other).area < 0.01


POINT = st.tuples(st.integers(0, 12), st.integers(0, 12))
RINGS = st.lists(st.lists(POINT, min_size=3, max_size=6), min_size=1, max_size=4)


@given(RINGS)
@setting(max_examples=60)
def test_any_rings_are_filled_by_the_nonzero_rule(rings: list[list[tuple[int, int]]]) -> None:
    """Against the renderer, which counts windings along lines: crossing, nested and folded rings alike."""
    paths = Paths.of(rings)
    solid = shapely.union_all(hatching.covered(paths))
    truth = raster.covered(paths, (130, 130), pixel=(0.1, 0.1)).sum() * 0.01
    assert solid.area == pytest.approx(truth, abs=0.05)  # level borders between scan lines
    strokes = hatching.areas(paths, 0.2)
    assert all(np.isfinite(stroke).all() and len(stroke) > 1 for stroke in strokes)
    if solid.area:
        ink = area(strokes, 0.2)
        assert ink.difference(solid.buffer(0.12)).area < 0.02  # slivers come out as wide as the nib
        assert solid.buffer(-0.15).difference(ink).area < 0.02


def test_a_bar_narrower_than_the_nib_is_one_stroke_along_it() -> None:
    (stroke,) = hatching.areas(Paths.of([[(1, 1), (11, 1), (11, 1.2), (1, 1.2)]]), 0.3)
    np.testing.assert_allclose(np.sort(stroke, axis=0), [(1.15, 1.1), (10.85, 1.1)], atol=1e-9)


def test_letters_finer_than_the_nib_can_still_be_read() -> None:
    words = lettering.text("ae8 0", 1, 3, size=2)
    ink = area(hatching.areas(words, 0.3), 0.3)
    letters = shapely.union_all(hatching.covered(words.flat(0.005)))
    assert letters.difference(ink.buffer(0.05)).area < 0.01 * letters.area
    assert ink.difference(letters.buffer(0.15)).area < 0.01 * ink.area


def test_strokes_stay_where_they_are_and_curves_within_a_hundredth() -> None:
    curve = Paths.of([[(0, 0), (0, 10), (10, 10), (10, 0)]], closed=False, cubic=True)
    (path,) = plotforms.lines(curve).paths
    true = shapely.LineString(curve.flat(1e-6).xy)
    assert true.hausdorff_distance(shapely.LineString(path)) <= plotforms.FLAT
    (ring,) = plotforms.lines(Paths.of([[(0, 0), (5, 0), (5, 5)]])).paths
    assert ring.tolist() == [[0, 0], [5, 0], [5, 5], [0, 0]]
