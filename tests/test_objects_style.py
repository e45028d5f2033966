"""Drawings of objects: apart, inside, as dark as asked for, turned as wished."""

from __future__ import annotations

import functools
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy.ndimage import gaussian_filter

import crowquill
from crowquill import Sheet, Tone, likeness, measure, shapes, styles
from crowquill.__main__ import main
from crowquill.sheet import Layer

RAMP = Tone(np.tile(np.linspace(0, 0.6, 90), (60, 1)), (36.0, 24.0))
GREY = Tone(np.full((40, 60), 0.3), (30.0, 20.0))
MIXED = """<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="20mm" viewBox="0 0 60 20">
<g id="flower"><path fill="none" stroke="red" d="M0 0v6M0 4l2 -2M0 4l-2 -2"/><circle r="2" cy="-1"/></g>
<path id="ring" d="M15 5a3 3 0 1 0 6 0a3 3 0 1 0 -6 0zM16.5 5a1.5 1.5 0 1 0 3 0a1.5 1.5 0 1 0 -3 0z" fill-rule="evenodd"/>
<path id="s" fill="none" stroke="red" d="M25 5c2 -4 4 4 6 0"/><ellipse cx="55" cy="5" rx="3" ry="1.5"/><text>a</text></svg>"""


@functools.cache
def drawn(tone: Tone, **knobs: Any) -> Sheet:
    """A drawing, made once for all tests that look at it."""
    return crowquill.draw("objects", tone, **knobs)


def outlines(sheet: Sheet) -> Any:
    """Each mark as a shapely polygon."""
    return sheet.marks.outlines().flat(1e-4).polygons()


def check_apart(polygons: Any, gap: float) -> None:
    """No two polygons are nearer than the gap, mm, to a thousandth."""
    tree = shapely.STRtree(polygons)
    i, j = tree.query(polygons, predicate="dwithin", distance=gap - 1e-3)
    assert not (i < j).any(), f"{(i < j).sum()} pairs are nearer than {gap} mm"


def tone_error(sheet: Sheet, tone: Tone) -> Any:
    """By how much the drawing is darker than the tone, seen through a blur of the mean spacing, two spacings inside its border, (h, w).

    On the border itself objects that lie whole in the canvas leave a little white.
    """
    spacing = np.sqrt(tone.size[0] * tone.size[1] / len(sheet.marks))
    h, w = (round(4 * side / spacing) for side in reversed(tone.size))
    there = measure.rendered(sheet.marks, tone.size, (h, w))
    return (gaussian_filter(there, 4) - gaussian_filter(likeness.asked(tone, (h, w)), 4))[8:-8, 8:-8]


@pytest.mark.parametrize("objects", shapes.names())
def test_objects_keep_their_gap(objects):
    sheet = drawn(RAMP, objects=objects, min_gap=0.1)
    assert (sheet.report["overlaps"], sheet.report["overlap_mm2"]) == (0, 0)
    assert sheet.report["objects"] == objects and sheet.report["marks"] == len(sheet.marks)
    check_apart(outlines(sheet), 0.1)


def test_the_check_of_gaps_sees_one_object_moved():
    polygons = outlines(drawn(RAMP, objects="grains", min_gap=0.1))
    with pytest.raises(AssertionError, match=r"nearer than 0\.1 mm"):
        check_apart(np.append(polygons, shapely.affinity.translate(polygons[0], 0.05)), 0.1)


# leaves, of mean breadth, and ticks side by side reach less than the ramp's end: 0.58 and 0.45
@pytest.mark.parametrize(("objects", "below"), [("grains", 0.6), ("diatoms", 0.55), ("leaves", 0.5), ("ticks", 0.35)])
def test_tone_is_kept_as_far_as_objects_reach(objects, below):
    tone = Tone(np.tile(np.linspace(0, below, 90), (60, 1)), (36.0, 24.0))
    sheet = drawn(tone, objects=objects)
    error = tone_error(sheet, tone)
    assert np.sqrt((error**2).mean()) < 0.03 and abs(error.mean()) < 0.015


def test_the_measure_of_tone_sees_a_tenth_of_the_objects_missing():
    sheet = drawn(RAMP, objects="grains")
    fewer = replace(sheet, layers=(Layer(sheet.layers[0].ink, sheet.marks.take(np.arange(len(sheet.marks)) % 10 > 0)),))
    assert abs(tone_error(fewer, RAMP).mean()) > 0.02


def test_what_is_too_dark_is_as_dark_as_it_gets_and_said():
    dark = Tone(np.tile(np.repeat([0.5, 0.95], 30), (40, 1)), (30.0, 20.0))
    sheet = drawn(dark, objects="grains")
    cover = measure.rendered(sheet.marks, dark.size, (1, 2))[0]
    assert cover[0] == pytest.approx(0.5, abs=0.02) and cover[1] > 0.64
    assert sheet.report["coverage_missing"] > 0.1 and "is not reached; --overlap" in sheet.report["warnings"][0]


def test_objects_that_may_overlap_are_as_dark_as_asked():
    dark = Tone(np.full((40, 60), 0.85), (30.0, 20.0))
    sheet = drawn(dark, objects="grains", overlap=True)
    assert sheet.report["ink_placed_mm2"] == pytest.approx(dark.ink, rel=0.03)
    union = shapely.union_all(outlines(sheet)).area
    assert sheet.report["ink_placed_mm2"] == pytest.approx(union, rel=1e-3)
    assert sheet.report["overlap_mm2"] == pytest.approx(shapely.area(outlines(sheet)).sum() - union, rel=0.01)
    assert sheet.report["overlaps"] > 50


def test_larger_objects_are_fewer_and_lie_where_it_is_darker():
    sheet = drawn(RAMP, objects="grains", size=1.5)
    marks = sheet.marks
    assert len(drawn(RAMP, objects="grains").marks) < len(marks)
    left, right = (np.mean(marks.scale[(marks.xy[:, 0] > 18) == side]) for side in (False, True))
    assert right > 1.2 * left
    assert sheet.report["size_mm"] == pytest.approx(1.5, rel=0.25)


def test_objects_as_drawn_keep_their_sizes_and_only_their_number_follows():
    sheet = drawn(GREY, objects="leaves", size_by="drawn", size=2.4)
    own = np.sqrt([motif.area for motif in shapes.load("leaves").motifs])[sheet.marks.glyph]
    ratio = sheet.marks.scale / own
    assert np.mean(np.abs(ratio / np.median(ratio) - 1) < 0.01) > 0.95  # those in one another's way are smaller
    assert sheet.report["size_mm"] == pytest.approx(2.4, rel=0.03)


def test_a_number_of_objects_is_met():
    sheet = drawn(GREY, objects="leaves", dots=123)
    assert len(sheet.marks) == 123 and sheet.report["ink_placed_mm2"] == pytest.approx(GREY.ink, rel=0.02)


def test_every_object_is_used_as_often_as_any_other():
    counts = np.bincount(drawn(GREY, objects="leaves", dots=123).marks.glyph)
    assert sorted(counts) == [12] * 7 + [13] * 3


def turned(sheet: Sheet, objects: str) -> Any:
    """How each mark is turned from how it was drawn, rad."""
    drawn_at = np.array([motif.turn for motif in shapes.load(objects).motifs])
    return sheet.marks.angle - drawn_at[sheet.marks.glyph]


def along(angle: Any, way: float) -> float:
    """The mean of cos 2 (angle - way): 1 where all lie along it, 0 where they lie any way."""
    return float(np.cos(2 * (angle - way)).mean())


def test_objects_that_keep_their_turn_lie_as_they_were_drawn():
    angle = turned(drawn(GREY, objects="leaves", turn="keep"), "leaves")
    assert np.abs((angle + np.pi) % (2 * np.pi) - np.pi).max() < 1e-4  # kept to a 65536th of a turn


def test_objects_turned_by_chance_lie_any_way():
    angle = drawn(GREY, objects="leaves", turn="free").marks.angle
    assert np.hypot(np.cos(2 * angle).mean(), np.sin(2 * angle).mean()) < 0.2 and abs(np.exp(1j * angle).mean()) < 0.2


def test_objects_turn_along_stripes():
    x, y = np.meshgrid(np.arange(120) / 4, np.arange(80) / 4)
    tone = Tone(0.3 + 0.2 * np.sin((y * np.cos(0.6) - x * np.sin(0.6)) * 2), (30.0, 20.0))
    angle = drawn(tone, objects="ticks").marks.angle
    assert along(angle, 0.6) > 0.95
    assert abs(np.exp(1j * angle).mean()) < 0.2  # heads lie either way


def test_objects_turn_along_strokes_of_a_file(tmp_path):
    (tmp_path / "way.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 6"><path d="M1 1L5 5"/></svg>')
    sheet = drawn(GREY, objects="ticks", field=str(tmp_path / "way.svg"))
    assert along(sheet.marks.angle, np.pi / 4) > 0.99


def test_objects_turn_into_the_room_they_have():
    canvas = shapely.box(0, 0, 30, 2.5)
    long = Tone(np.full((40, 60), 0.35), (30.0, 20.0), canvas)
    assert along(drawn(long, objects="leaves", turn="region", size=4.0).marks.angle, 0) > 0.3


def test_objects_lie_whole_in_the_canvas_or_with_their_centres():
    star = shapely.Polygon([(15 + r * np.cos(k), 10 + r * np.sin(k)) for k in range(10) for r in [9.5 if k % 2 else 3.5]]).buffer(0)
    tone = Tone(np.full((40, 60), 0.4), (30.0, 20.0), star)
    whole, centre = (drawn(tone, objects="leaves", inside=inside) for inside in ("whole", "centre"))
    near = shapely.buffer(star, 2e-3)  # places and scales are in whole micrometres
    assert shapely.covers(near, outlines(whole)).all() and not shapely.covers(near, outlines(centre)).all()
    assert tone.holds(centre.marks.xy).all()


def test_objects_are_finer_where_it_is_important():
    wish = np.where(np.arange(60) < 30, 0.75, 0.25) * np.ones((40, 1))
    tone = Tone(GREY.coverage, GREY.size, importance=wish)
    marks = drawn(tone, objects="grains", size=1.0).marks
    left = marks.xy[:, 0] < 15
    assert marks.scale[left].mean() == pytest.approx(0.5 * marks.scale[~left].mean(), rel=0.2)
    assert (marks.scale**2)[left].sum() == pytest.approx((marks.scale**2)[~left].sum(), rel=0.1)
    said = drawn(tone, objects="grains", size_by="drawn").report["warnings"]
    assert any("importance is not heeded" in warning for warning in said)


def test_areas_with_holes_and_lines_are_drawn_as_such(tmp_path):
    file = tmp_path / "mixed.svg"
    file.write_text(MIXED)
    sheet = drawn(Tone(np.full((40, 60), 0.12), (60.0, 40.0)), objects=str(file), size=5.0, pen=0.4, turn="region")
    assert [layer.name for layer in sheet.layers] == ["objects", "areas", "lines"] and sheet.layers[2].ink.pen == 0.4
    assert "its text are not read" in sheet.report["warnings"][0] and sheet.report["overlaps"] == 0
    assert sheet.report["ink_placed_mm2"] == pytest.approx(0.12 * 2400, rel=0.05)
    again = crowquill.load(io.BytesIO(crowquill.to_bytes(sheet, "svg")))
    assert [len(layer.art) for layer in again.layers] == [len(layer.art) for layer in sheet.layers]


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"size": 2.0, "dots": 9}, "size 2 mm and dots 9 are both given; leave one out"),
        ({"field": "a.svg", "turn": "free"}, "field 'a.svg' is of no use with turn 'free'; "),
        ({"objects": "leafs"}, "no objects 'leafs'; there are diatoms"),
        ({"max_dots": 5}, "objects, over the limit of 5; draw larger ones"),
    ],
)
def test_a_wish_that_cannot_be_met_is_answered_with_one_line(knobs, said):
    with pytest.raises(ValueError, match=said):
        crowquill.draw("objects", GREY, **knobs)


def test_more_objects_than_fit_are_made_smaller_and_said():
    sheet = drawn(Tone(np.full((9, 9), 0.9), (9.0, 9.0)), objects="ticks", dots=200, size_by="drawn")
    check_apart(outlines(sheet), 0)
    assert sheet.report["coverage_missing"] > 0.2 and sheet.report["warnings"]


def test_objects_that_had_to_be_smaller_than_planned_say_by_how_much():
    report = drawn(Tone(np.full((9, 9), 0.5), (9.0, 9.0)), objects="leaves", size=20.0).report
    assert report["size_mm"] < 0.3 * report["size_planned_mm"] < 0.3 * 20
    said = f"objects are {report['size_mm']:.3g} mm long in the mean, not {report['size_planned_mm']:.3g} as planned, to fit"
    assert said in report["warnings"]
    report = drawn(GREY, objects="grains").report
    assert report["size_mm"] == pytest.approx(report["size_planned_mm"], rel=0.05) and not report["warnings"]


def test_objects_that_are_to_stay_far_apart_are_fewer_and_none_is_lost():
    sheet = drawn(GREY, objects="grains", min_gap=2.0)
    check_apart(outlines(sheet), 2.0)
    assert len(sheet.marks) > 20 and sheet.report["removed"] == 0 and sheet.report["coverage_missing"] > 0.3


def test_the_scale_at_which_a_library_was_drawn_does_not_matter(tmp_path):
    for name, side in (("small", 0.6), ("large", 60000)):
        page = f'width="{side}mm" height="{side}mm" viewBox="0 0 60 60"'
        (tmp_path / f"{name}.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {page}><rect width="20" height="10"/></svg>')
    one, other = (drawn(GREY, objects=str(tmp_path / f"{name}.svg")).marks for name in ("small", "large"))
    assert len(one) == len(other) and np.abs(one.xy - other.xy).max() < 0.05  # chaos enlarges the last digits


def test_hairs_are_refused_that_would_take_hours(tmp_path):
    (tmp_path / "hair.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 60 60"><rect width="50" height=".02"/></svg>')
    with pytest.raises(ValueError, match="too thin for their length"):
        drawn(GREY, objects=str(tmp_path / "hair.svg"))


def test_work_says_its_stages_in_their_order():
    stages = [step.stage for step in styles.steps("objects", GREY, iterations=3)]
    assert stages == ["plan", "place", *["relax"] * (len(stages) - 4), "fit", "measure"]


def test_a_library_of_ones_own_is_a_source_of_the_recipe(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.svg").write_text(MIXED)
    Image.new("L", (30, 20), 180).save("grey.png")
    assert main(["objects", "grey.png", "a.svg", "--objects", "mine.svg", "--width", "30mm", "--iterations", "3", "--quiet"]) == 0
    assert main(["redo", "a.svg", "b.svg", "--quiet"]) == 0
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes()
    Path("mine.svg").write_text(MIXED.replace("15 5", "15 6"))
    assert main(["redo", "a.svg", "c.svg", "--quiet"]) == 2 and not Path("c.svg").exists()
