"""HPGL, read back as an old plotter reads it: every stroke in its place, with its pen, and no dot lost."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from drawings import everything, strokes
from hypothesis import given
from hypothesis import strategies as st
from plotter import PAGE, Stroke, faults, hpgl, scribble

from crowquill import formats
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

STEP = 1 / 40
WIDTH, HEIGHT = PAGE


def upside_down(drawn: list[Stroke], height: float = HEIGHT) -> list[Stroke]:
    return [replace(stroke, places=[(x, height - y) for x, y in stroke.places]) for stroke in drawn]


def lines(*paths: object, size: tuple[float, float] = PAGE) -> Sheet:
    return Sheet(size, (Layer(Ink(pen=0.3), Paths.of(paths, closed=False)),))


@pytest.mark.parametrize("seed", range(5))
def test_every_stroke_is_drawn_within_a_step_in_order_by_the_pen_of_its_layer(seed: int):
    sheet = scribble(seed)
    drawn = upside_down(hpgl(formats.to_bytes(sheet, "hpgl")))
    assert faults(drawn, sheet, STEP) == [] and {stroke.pen for stroke in drawn} == {1, 3, 4}


def test_the_comparison_sees_a_dot_moved_a_dot_lost_and_a_pen_changed():
    sheet = scribble()
    drawn = upside_down(hpgl(formats.to_bytes(sheet, "hpgl")))
    x, y = drawn[3].places[0]
    assert faults([*drawn[:3], Stroke(1, [(x + STEP, y)]), *drawn[4:]], sheet, STEP)[0].startswith("stroke 3 strays")
    assert faults(drawn[:3] + drawn[4:], sheet, STEP)[0].startswith("12 strokes for 13")
    assert faults([*drawn[:3], Stroke(2, [(x, y)]), *drawn[4:]], sheet, STEP) == ["stroke 3 has pen 2 for 1"]
    assert faults([*drawn[:2], Stroke(1, drawn[2].places[:4]), *drawn[3:]], sheet, STEP)[0].startswith("stroke 2 strays")


def test_strokes_shorter_than_a_step_are_dots_and_none_is_lost():
    places = np.random.default_rng(3).uniform(1, 39, (200, 2))
    for lines in (places[:, None], places[:, None] + [(0, 0), (0.002, 0.001)], places[:, None] + [(0, 0)] * 3):
        data = formats.to_bytes(Sheet(PAGE, (Layer(Ink(pen=0.3), Paths.of(lines, closed=False)),)), "hpgl")
        drawn = upside_down(hpgl(data))
        assert data.count(b"PD") == len(drawn) == 200
        shift = np.array([stroke.places[0] for stroke in drawn]) - places
        assert np.abs(shift).max() <= STEP / 2 + 1e-3  # places of a sheet are whole micrometres


def test_a_page_turned_is_drawn_turned_clockwise_and_not_mirrored():
    sheet = scribble()
    plain, turned = (hpgl(formats.to_bytes(sheet, "hpgl", turned=turn)) for turn in (False, True))
    for one, other in zip(plain, turned, strict=True):  # (x, y) goes to (y, width - x), y up
        assert np.array(other.places) == pytest.approx(np.array([(y, WIDTH - x) for x, y in one.places]), abs=STEP / 2)
    (corner,) = hpgl(formats.to_bytes(lines([(0, 0)]), "hpgl", turned=True))
    assert corner.places == [(HEIGHT, WIDTH)], "the top left corner has come to the top right"


def test_the_small_case_by_hand():
    sheet = lines([(1, 2), (3, 4), (3, 4), (5, 6)], [(10, 39)])
    assert formats.to_bytes(sheet, "hpgl") == b"IN;\nSP1;\nPU40,1520;PD120,1440,200,1360;\nPU400,40;PD;PU;\nPU;SP0;\n"
    assert formats.to_bytes(sheet, "hpgl", speed=12.5).startswith(b"IN;VS12.5;\nSP1;\n")
    assert formats.to_bytes(Sheet(PAGE), "hpgl") == b"IN;\nPU;SP0;\n"


def test_a_long_stroke_is_several_instructions_and_one_line():
    points = np.stack([np.linspace(1, 59, 1001), 20 + np.sin(np.arange(1001))], axis=1)
    data = formats.to_bytes(lines(points), "hpgl")
    (drawn,) = upside_down(hpgl(data))
    assert np.abs(np.array(drawn.places) - points).max() <= STEP / 2 + 1e-3
    assert max(map(len, data.split(b";"))) < 1100


@given(st.lists(st.tuples(st.integers(-3, 9), st.integers(-3, 7)), min_size=1, max_size=8))
def test_what_lies_off_the_page_is_cut_at_its_edge(corners: list[tuple[int, int]]):
    """Whole numbers, so that lines along edges and through corners come up."""
    size = (6.0, 4.0)
    drawn = upside_down(hpgl(formats.to_bytes(lines(corners, size=size), "hpgl")), size[1])
    for stroke in drawn:
        assert (np.array(stroke.places) >= 0).all() and (np.array(stroke.places) <= size).all()
    pieces = [shapely.LineString(pair) for pair in pairwise(corners)]
    page = shapely.box(0, 0, *size)
    wanted = sum(piece.intersection(page).length for piece in pieces)
    assert sum(np.hypot(*np.diff(stroke.places, axis=0).T).sum() for stroke in drawn) == pytest.approx(
        wanted, abs=2 * STEP * len(pieces) + 1e-9
    )
    assert bool(drawn) == any(shapely.intersects(part, page) for part in [*pieces, *map(shapely.Point, corners)])


def test_no_step_lies_beyond_a_page_of_odd_size():
    size = (10.017, 10.017)
    for turned in (False, True):
        drawn = hpgl(formats.to_bytes(lines([(0, 0), size], [(size[0], 0), (0, size[1])], size=size), "hpgl", turned=turned))
        places = np.array([stroke.places for stroke in drawn])
        assert places.min() == 0 and places.max() == 10.0  # the last whole step; 10.025 is off the page


def test_fills_are_refused_and_layers_without_art_are_not():
    with pytest.raises(ValueError, match=r"^hpgl draws strokes only; draw with --for plotter$"):
        formats.to_bytes(everything(), "hpgl")
    assert len(hpgl(formats.to_bytes(strokes(), "hpgl"))) > 60


def test_more_layers_than_pens_are_refused():
    assert formats.to_bytes(scribble(), "hpgl", pens=4)
    with pytest.raises(ValueError, match=r"^layer 4 has no pen: the plotter holds 3; "):
        formats.to_bytes(scribble(), "hpgl", pens=3)


@pytest.mark.parametrize(
    ("bed", "turned", "says"),
    [
        ("60x40mm", False, None),
        ("40x60mm", True, None),
        ("a5", False, None),
        ("30x20mm", False, "a sheet of 60 x 40 mm is larger than the bed of 30 x 20 mm; give paper of at most 30 x 20 mm"),
        ("40x60mm", False, "bed of 40 x 60 mm; turn the page with turned, or give paper of at most 40 x 60 mm"),
        ("60x40mm", True, "a sheet of 40 x 60 mm is larger than the bed of 60 x 40 mm; leave out turned, or give"),
        ("a99", False, "no paper 'a99'"),
    ],
)
def test_a_sheet_larger_than_the_bed_is_refused_with_what_fits(bed: str, turned: bool, says: str | None):
    if says is None:
        assert formats.to_bytes(scribble(), "hpgl", bed=bed, turned=turned)
        return
    with pytest.raises(ValueError, match=re.escape(says)):
        formats.to_bytes(scribble(), "hpgl", bed=bed, turned=turned)


def test_a_named_bed_lies_on_its_long_side_and_takes_a_sheet_of_its_size():
    for name, size in (("letter", (279.4, 215.9)), ("a4", (297, 210))):
        assert formats.to_bytes(Sheet(size), "hpgl", bed=name)
        assert formats.to_bytes(Sheet(size[::-1]), "hpgl", bed=name, turned=True)
        with pytest.raises(ValueError, match="turn the page"):
            formats.to_bytes(Sheet(size[::-1]), "hpgl", bed=name)


def test_a_bed_too_small_is_known_before_the_work(tmp_path):
    with pytest.raises(ValueError, match="larger than the bed"):
        formats.foresee([tmp_path / "a.plt"], PAGE, 0, {"bed": "30x20mm"})
    formats.foresee([tmp_path / "a.plt"], PAGE, 0, {})


def test_names_of_layers_and_recipes_do_not_reach_the_plotter():
    names = ("PU0,0;SP7;", "a\n;PD9,9;", "\x1b.(")
    assert formats.to_bytes(replace(scribble(names=names), recipe={"style": ";PD;"}), "hpgl") == formats.to_bytes(scribble(), "hpgl")


def test_the_suffix_plt_is_hpgl_too(tmp_path):
    formats.save(scribble(), tmp_path / "a.plt", tmp_path / "b.hpgl")
    assert (tmp_path / "a.plt").read_bytes() == (tmp_path / "b.hpgl").read_bytes()
