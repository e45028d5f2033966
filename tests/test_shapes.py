"""Libraries of objects: those that come along, and what other people's SVG files become."""

import json
import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from crowquill import shapes
from crowquill.moments import of_rings
from crowquill.objects import Objects
from crowquill.paths import Paths
from crowquill.shapes import Library, Motif, clearance, ink, parsed

PAGE = 'width="100mm" height="60mm" viewBox="0 0 100 60"'
PX = 1e-5  # CSS pixels are read as 0.2645833 mm
BOW = "M0 0L4 4V0L0 4Z"


def svg(inside: str) -> bytes:
    spaces = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" xmlns:xlink="http://www.w3.org/1999/xlink"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {spaces} {PAGE}>{inside}</svg>'.encode()


def one(inside: str) -> Motif:
    (motif,) = parsed(svg(inside), "x.svg").motifs
    return motif


def check_library(library: Library) -> None:
    """Six to twelve objects, each of one outline that crosses itself nowhere, of area 1 as a glyph; free to use, and said by whom."""
    assert 6 <= len(library.motifs) <= 12 and not library.notes
    assert (library.about["licence"], library.about["by"]) == ("CC0-1.0", "crowquill") and library.about["how"]
    for motif in library.motifs:
        assert motif.glyph is not None, "an object is not one outline"
        unit = of_rings(motif.glyph.paths)
        assert unit.mass[0] == pytest.approx(1, abs=1e-9) and np.abs(unit.centroid).max() < 1e-9
        assert shapely.is_valid(motif.glyph.paths.flat(1e-4).polygons()).all()
        assert 0.5 < motif.across < 5  # mm


@pytest.mark.parametrize("name", shapes.names())
def test_a_library_that_comes_along_is_sound(name):
    check_library(shapes.load(name))


def test_the_check_of_libraries_sees_a_bow_tie_and_a_missing_licence():
    leaves = shapes.load("leaves")
    crossed = one(f'<path d="{BOW}"/>')
    for broken in (
        replace(leaves, motifs=(*leaves.motifs[:9], crossed)),
        replace(leaves, motifs=leaves.motifs[:3]),
        replace(leaves, about={}),
    ):
        with pytest.raises((AssertionError, KeyError)):
            check_library(broken)


def test_the_tool_draws_the_libraries_that_are_there():
    tool = runpy.run_path(str(Path(__file__).parents[1] / "tools" / "draw_objects.py"))
    assert sorted(tool["LENGTHS"]) == shapes.names() == ["diatoms", "grains", "leaves", "ticks"]
    for k, name in enumerate(("grains", "leaves", "ticks", "diatoms")):
        drawn = tool[name](np.random.default_rng([tool["SEED"], k]))
        kept = (shapes.FOLDER / f"{name}.svg").read_text(encoding="utf-8")
        assert len(drawn) == kept.count("<path") and tool["svg"](name, drawn, "x").splitlines()[2:] == kept.splitlines()[2:]


def test_an_outline_is_kept_as_it_was_drawn():
    motif = one('<g transform="translate(20 10) rotate(30) scale(2)"><rect x="1" y="1" width="4" height="1"/></g>')
    assert (
        motif.glyph is not None and motif.area == pytest.approx(16, rel=PX) and motif.across == pytest.approx(2 * np.hypot(4, 1), rel=1e-5)
    )
    assert motif.turn == pytest.approx(np.radians(30)) and motif.fold == 2 and not motif.notes
    cos, sin = np.cos(motif.turn), np.sin(motif.turn)
    back = motif.glyph.paths.moved(np.sqrt(motif.area) * np.array([[cos, -sin], [sin, cos]])).flat(1e-3).polygons()[0]
    drawn = shapely.affinity.rotate(shapely.box(-4, -1, 4, 1), 30, origin=(0, 0))
    assert shapely.hausdorff_distance(back, drawn) < 1e-4


def test_each_shape_is_an_object_and_each_outermost_group_is_one():
    box = '<rect width="2" height="1"/>'
    counted = {
        box + box: 2,
        f"<g>{box}{box}</g>{box}": 2,
        f"<g>{box}{box}</g>": 2,  # a lone group is looked through
        f"<g><g>{box}{box}</g><g>{box}</g>{box}</g>": 3,
        f'<g inkscape:groupmode="layer">{box}<g>{box}{box}</g></g><g inkscape:groupmode="layer">{box}</g>': 3,
        f'<defs><path id="a" d="M0 0h1v1z"/></defs><use xlink:href="#a"/><use xlink:href="#a" x="5"/>{box}': 3,
    }
    assert {inside: len(parsed(svg(inside), "x.svg").motifs) for inside in counted} == counted


@pytest.mark.parametrize(("rule", "hole"), [("evenodd", "M1 1h2v2h-2z"), ("evenodd", "M1 1v2h2v-2z"), ("nonzero", "M1 1v2h2v-2z")])
def test_a_hole_is_open_by_the_even_odd_rule_or_where_it_turns_back(rule, hole):
    for inside in (f'<path fill-rule="{rule}" d="M0 0h4v4h-4z{hole}"/>', f'<path style="fill-rule:{rule}" d="M0 0h4v4h-4z{hole}"/>'):
        motif = one(inside)
        assert motif.glyph is None and motif.area == pytest.approx(12, rel=PX) and len(motif.rings) == 2 and not len(motif.lines)
        assert sorted(np.sign(motif.rings.areas)) == [-1, 1]


@pytest.mark.parametrize(
    ("outline", "winding", "odd"),
    [
        ("M0 0h6v6h-6zM3 3h6v6h-6z", 63, 54),
        ("M10 0h6v6h-6zM12 2h2v2h-2z", 36, 32),
        ("M0 0h6v6h-6zM3 3v6h6v-6z", 54, 54),  # where they lie on each other they turn against each other
    ],
)
def test_areas_are_filled_by_winding_unless_a_file_says_even_odd(outline, winding, odd):
    path = f'<path d="{outline}"/>'
    assert one(path).area == pytest.approx(winding, rel=PX)
    assert one(f'<g fill-rule="evenodd">{path}</g>').area == pytest.approx(odd, rel=PX)  # inherited
    assert one(f"<style>path {{fill-rule: evenodd}}</style>{path}").area == pytest.approx(odd, rel=PX)


def test_shapes_of_a_group_that_overlap_are_one_area():
    motif = one('<g><rect width="4" height="2"/><rect x="3" width="4" height="2"/></g><g/>')
    assert motif.area == pytest.approx(14, rel=1e-4) and motif.glyph is not None and motif.across == pytest.approx(np.hypot(7, 2), rel=1e-4)


def test_what_is_open_or_not_filled_is_lines():
    motif = one('<g id="twig"><path d="M0 0h10" stroke="red"/><circle cx="12" r="2" style="fill:none;stroke:red"/></g><g/>')
    assert motif.glyph is None and not len(motif.rings) and len(motif.lines) == 2
    assert motif.length == pytest.approx(10 + 4 * np.pi, rel=2e-3)  # straight within a thousandth


def test_ink_and_scale_lead_to_each_other():
    motif = one('<g><path d="M0 0h10" fill="none" stroke="red"/><circle cx="12" r="2"/></g><g/>')
    scales = np.array([0.1, 1.0, 3.0])
    assert motif.ink(1.0, 0.5) == pytest.approx(4 * np.pi + 5 + np.pi / 16, rel=0.01)  # straight within a thousandth of its extent
    assert motif.scale_of(motif.ink(scales, 0.5), 0.5) == pytest.approx(scales)
    assert motif.scale_of(0.0, 0.5) == 0


def test_an_outline_that_crosses_itself_is_mended_and_said():
    motif = one(f'<path d="{BOW}"/>')
    assert motif.area == pytest.approx(8, rel=PX) and len(motif.rings) == 2 and "crosses itself" in motif.notes[0]


@pytest.mark.parametrize("name", ["leafs", "leaves.png", ""])
def test_a_library_there_is_not_is_answered_with_those_there_are(name):
    with pytest.raises(ValueError, match="diatoms, grains, leaves, ticks"):
        shapes.load(name)


def crowd(n: int = 60, side: float = 12.0) -> tuple[Objects, tuple[Motif, ...]]:
    """So many diatoms at random in a square too small for them."""
    rng = np.random.default_rng(4)
    motifs = shapes.load("diatoms").motifs
    kinds = tuple(motif.shape for motif in motifs)
    return Objects.of(rng.uniform(0, side, (n, 2)), kinds, angle=rng.uniform(0, 7, n), shape=rng.integers(0, len(motifs), n)), motifs


def least_gap(objects: Objects) -> float:
    """The least distance between two hulls, mm."""
    hulls = clearance.hulls(objects)
    i, j = np.triu_indices(len(hulls), 1)
    return float(shapely.distance(hulls[i], hulls[j]).min())


@pytest.mark.parametrize("skirt", [0.0, 0.1])
def test_objects_scaled_to_be_clear_are_apart_and_touch(skirt):
    objects, _ = crowd()
    scale = clearance.clear(objects, skirt)
    assert (scale <= objects.scale).all() and least_gap(objects) == 0 and (scale > 0).sum() > 50  # what lies on another's centre has 0
    clear = replace(objects, scale=np.maximum(scale, 1e-9)).take(scale > 0)
    assert skirt - 1e-9 < least_gap(clear) < skirt + 0.01  # what has room grows until it has none


def test_objects_that_are_apart_stay_as_they_are():
    objects, _ = crowd(n=5, side=500)
    assert (clearance.clear(objects, 0.1) == objects.scale).all() and not clearance.pushed(objects, 0.1).any()


def test_pushing_parts_objects_that_overlap():
    objects, motifs = crowd(n=40, side=14.0)
    before = ink.overlaps(objects, motifs, 0.1)[1]
    for _ in range(30):
        objects = replace(objects, xy=objects.xy + clearance.pushed(objects, 0.0))
    assert ink.overlaps(objects, motifs, 0.1)[1] < 0.02 * before


def test_objects_are_brought_into_the_canvas_or_made_smaller():
    objects, _ = crowd()
    canvas = shapely.Point(6, 6).buffer(6)
    inner = objects.take(shapely.contains_xy(canvas, *objects.xy.T))
    held = replace(inner, scale=np.maximum(clearance.held(inner, canvas, 0.0), 1e-9))
    assert shapely.covers(canvas, clearance.hulls(held)).all() and not shapely.covers(canvas, clearance.hulls(inner)).all()
    moved = replace(inner, xy=inner.xy + clearance.brought_in(inner, canvas))
    over = [shapely.area(shapely.difference(clearance.hulls(o), canvas)).sum() for o in (inner, moved)]
    assert over[1] < 0.1 * over[0]


def test_overlap_is_counted_and_measured():
    motifs = parsed(svg('<rect width="2" height="2"/><path d="M0 5h4" fill="none" stroke="red"/>'), "x.svg").motifs
    kinds = tuple(motif.shape for motif in motifs)
    squares = Objects.of([(0, 0), (1.5, 0), (9, 9)], kinds, angle=-motifs[0].turn)
    pairs, lost = ink.overlaps(squares, motifs, 0.5)
    assert pairs == 1 and lost == pytest.approx(0.5 * 2, rel=1e-5)
    crossing = Objects.of([(0, 0), (0, 0)], kinds, shape=[1, 1], angle=[0, np.pi / 2])
    assert ink.overlaps(crossing, motifs, 0.5) == (1, pytest.approx(0.25, rel=1e-5))
    assert ink.of_each(crossing, motifs, 0.5) == pytest.approx(4 * 0.5 + np.pi / 16, rel=1e-5)


def test_marks_areas_and_lines_are_layers_of_their_own():
    library = parsed(
        svg('<rect width="4" height="2"/><path d="M0 0h4v4h-4zM1 1v2h2v-2z"/><path d="M0 5h4" fill="none" stroke="red"/>'), "x.svg"
    )
    objects = Objects.of([(5, 5), (12, 5), (20, 5)], tuple(m.shape for m in library.motifs), shape=[0, 1, 2])
    marks, areas, lines = ink.layers(objects, library.motifs, 0.5)
    assert len(marks.art) == 1 and isinstance(areas.art, Paths) and len(areas.art) == 2 and not lines.art.closed
    assert (areas.ink.pen, lines.ink.pen) == (None, 0.5)
    covered = ink.covered(objects, library.motifs, 0.5, (25.0, 10.0), (100, 250)).sum() * 0.01
    assert covered == pytest.approx(8 + 12 + 2 + np.pi / 16, rel=1e-3)
    assert json.dumps([layer.name for layer in ink.layers(objects.take(objects.scale > 9), library.motifs, 0.5)]) == '["objects"]'
