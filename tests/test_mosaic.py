"""Mosaics as sheets: stones with grout of its width between them, in colours or in one ink, and what is said when that cannot be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import crowquill
from crowquill import Sheet, Tone, laying, vector
from crowquill.sheet import on_screen
from crowquill.tiles import met

SIZE = (30.0, 24.0)
ROW, COLUMN = np.mgrid[0:96, 0:120] / 4 + 0.125
DISC = np.where(np.hypot(COLUMN - 15, ROW - 12) < 7, 0.8, 0.2)
TONE = Tone(DISC, SIZE)
CIRCLE = '<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="24mm" viewBox="0 0 30 24"><circle cx="15" cy="12" r="7"/></svg>'


def drawn(tone: Tone = TONE, **knobs: Any) -> Sheet:
    return crowquill.draw("mosaic", tone, **{"tile": 1.2, **knobs})


def stones(sheet: Sheet) -> np.ndarray:
    return sheet.layers[0].art.polygons()


@pytest.mark.parametrize("mode", list(laying.WAYS))
def test_in_the_file_no_two_stones_are_nearer_than_the_grout(mode):
    sheet = drawn(mode=mode, grout=0.15)
    _, found = vector.shapes(crowquill.to_bytes(sheet, "svg"), "mosaic.svg")
    rings = crowquill.Paths.of([np.round(ring, 3) for paths, _ in found for ring in paths])
    assert len(rings) == sheet.report["marks"] > 250
    assert shapely.is_valid(rings.polygons()).all()
    overlap, nearest = met(rings)
    assert overlap == 0 and nearest >= 0.15 - 1e-9  # of reading millimetres as pixels and back
    assert sheet.report["grout_least_mm"] == pytest.approx(nearest) and sheet.report["overlap_mm2"] == 0


@pytest.mark.parametrize("mode", list(laying.WAYS))
def test_stones_fill_the_canvas_but_for_grout_and_edges(mode):
    sheet = drawn(mode=mode)
    found = stones(sheet)
    assert shapely.is_valid(found).all()
    assert shapely.covers(shapely.box(0.06, 0.06, SIZE[0] - 0.06, SIZE[1] - 0.06), found).all()  # half a grout inside
    assert sheet.report["coverage"] == pytest.approx(shapely.area(found).sum() / 720) and sheet.report["coverage"] > 0.7
    assert shapely.area(found).min() >= 0.3 * 1.2**2 * 0.7  # rows make stones shorter to close


@pytest.mark.parametrize("mode", list(laying.WAYS))
def test_no_stone_lies_across_an_edge(mode, tmp_path):
    (tmp_path / "edges.svg").write_text(CIRCLE)
    circle = shapely.Point(15, 12).buffer(7, quad_segs=200).boundary
    found = stones(drawn(mode=mode, edges=str(tmp_path / "edges.svg")))
    across = shapely.intersects(found, circle)
    # curves are drawn straight within 1/50 of a tile, and a line that ends in a stone cuts nothing: this one has no end
    assert shapely.length(shapely.intersection(found[across], circle)).sum() < 0.01 * circle.length
    assert shapely.area(found[shapely.contains(shapely.Polygon(circle.coords), found)]).sum() > 0.65 * np.pi * 49


def test_edges_are_found_and_stones_on_either_side_have_its_tone():
    found = drawn(grout=0.1).layers[0].fill[:, 3]
    mixed = (found > 0.25) & (found < 0.75)
    assert mixed.mean() < 0.03
    blind = drawn(grout=0.1, edges="none").layers[0].fill[:, 3]
    assert ((blind > 0.25) & (blind < 0.75)).mean() > 3 * mixed.mean()


def test_stones_without_anything_to_follow_follow_the_canvas_and_it_is_said():
    sheet = drawn(Tone(np.full((20, 20), 0.5), (20.0, 20.0)), mode="rows")
    assert any("no edges were found" in warning for warning in sheet.report["warnings"])
    edge = np.concatenate([np.diff(ring[[*range(len(ring)), 0]], axis=0) for ring in sheet.layers[0].art])
    long = np.hypot(*edge.T) > 0.6
    off = (np.degrees(np.arctan2(*edge[long].T)) + 45) % 90 - 45
    assert np.mean(np.abs(off) < 1) > 0.8  # where rows meet on the diagonals, stones are cut
    assert sheet.report["coverage"] > 0.75


@pytest.mark.parametrize("mode", list(laying.WAYS))
@pytest.mark.parametrize("count", [200, 900])
def test_a_number_of_stones_is_kept_to(mode, count):
    sheet = drawn(mode=mode, tile=None, tiles=count, edges="none")
    assert sheet.report["marks"] == pytest.approx(count, rel=0.12)  # slivers go and hollows are filled


def test_stones_are_finer_where_it_matters():
    wish = np.where(np.hypot(COLUMN - 15, ROW - 12) < 7, 1.0, 0.5)
    sheet = drawn(Tone(np.full(DISC.shape, 0.5), SIZE, importance=wish), edges="none", grout=0.01)
    far = np.hypot(*(shapely.get_coordinates(shapely.centroid(stones(sheet))) - (15, 12)).T)
    area = shapely.area(stones(sheet))
    assert area[far < 6].mean() == pytest.approx(area[far > 8].mean() / 4, rel=0.15)


def test_long_stones_are_long_along_the_rows():
    sheet = drawn(Tone(np.full((20, 20), 0.5), (20.0, 20.0)), mode="rows", aspect=3.0, grow=1.0)
    top = [ring for ring in sheet.layers[0].art if ring[:, 1].max() < 1]
    assert len(top) > 5 and np.median([np.ptp(ring[:, 0]) / np.ptp(ring[:, 1]) for ring in top]) == pytest.approx(3, rel=0.25)


def test_a_stone_has_the_mean_colour_of_the_picture_under_it():
    rgb = np.stack([np.where(DISC > 0.5, 200, 20), np.where(DISC > 0.5, 60, 90), np.where(DISC > 0.5, 40, 160)], axis=-1)
    sheet = drawn(Tone(DISC, SIZE, rgb=rgb.astype(np.uint8)))
    inside = shapely.contains(shapely.Point(15, 12).buffer(6.5), stones(sheet))
    outside = shapely.disjoint(shapely.Point(15, 12).buffer(7.5), stones(sheet))
    shown = on_screen(sheet.layers[0].fill)
    assert (shown[inside] == (200, 60, 40)).all() and (shown[outside] == (20, 90, 160)).all()
    assert inside.sum() > 50 and outside.sum() > 150


def test_a_palette_is_kept_to_and_one_of_one_colour_is_remarked_on():
    sheet = drawn(palette="#202020,#c0c0c0")
    assert set(map(tuple, on_screen(sheet.layers[0].fill).tolist())) == {(0x20,) * 3, (0xC0,) * 3}
    single = drawn(palette="#aa3322")
    assert any("palette of one colour" in warning for warning in single.report["warnings"])
    assert set(map(tuple, on_screen(single.layers[0].fill).tolist())) == {(0xAA, 0x33, 0x22)}


@pytest.mark.parametrize("mode", list(laying.WAYS))
def test_in_one_ink_stones_are_as_large_as_the_tone_asks(mode):
    tone = Tone(DISC * 0.6, SIZE)
    sheet = drawn(tone, mode=mode, one_ink=True)
    assert sheet.layers[0].fill is None
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)
    middle = shapely.area(shapely.intersection(stones(sheet), shapely.Point(15, 12).buffer(6))).sum() / (np.pi * 36)
    assert middle == pytest.approx(0.48, rel=0.06)  # whole stones on the circle's edge


def test_stones_in_colours_miss_no_ink():
    assert drawn(Tone(np.ones(DISC.shape), SIZE)).report["coverage_missing"] == 0


def test_in_one_ink_what_is_too_dark_is_said():
    sheet = drawn(Tone(np.ones((20, 20)), (20.0, 20.0)), one_ink=True)
    assert sheet.report["coverage_missing"] > 0.1
    assert any("is not reached" in warning for warning in sheet.report["warnings"])


def test_white_paper_gets_no_stones():
    half = Tone(np.where(COLUMN < 15, 0.0, 0.5), SIZE)
    sheet = drawn(half)
    assert sheet.layers[0].art.xy[:, 0].min() > 14.5  # a stone over the border holds less than the cutoff
    empty = drawn(Tone(np.zeros((5, 5)), SIZE))
    assert empty.report["marks"] == 0 and "no ink" in empty.report["warnings"][0]


def test_the_white_cutoff_is_of_coverage_however_strong_a_colour_is():
    red = np.full((*DISC.shape, 3), (255, 0, 0), np.uint8)
    strong = Tone(np.full(DISC.shape, 0.6), SIZE, rgb=red)
    assert drawn(strong, white=0.5).report["marks"] > 250
    none = drawn(strong, white=1.0)
    assert none.report["marks"] == 0 and "no ink" in none.report["warnings"][0]
    assert drawn(Tone(np.ones(DISC.shape), SIZE), white=1.0).report["marks"] > 250  # black is not below it


def test_on_a_canvas_of_pixels_outlines_in_the_file_are_sound():
    disc = np.hypot(COLUMN - 15, ROW - 12) < 11
    row, column = np.nonzero(disc)
    canvas = shapely.union_all(shapely.box(column / 4, row / 4, column / 4 + 0.25, row / 4 + 0.25))
    sheet = drawn(Tone(DISC, SIZE, canvas, importance=np.where(COLUMN < 15, 0.3, 0.8)), iterations=5)
    _, found = vector.shapes(crowquill.to_bytes(sheet, "svg"), "mosaic.svg")
    rings = [shapely.Polygon(np.round(ring, 3)) for paths, _ in found for ring in paths]
    assert len(rings) == sheet.report["marks"] > 200 and shapely.is_valid(rings).all()
    assert shapely.covers(canvas, rings).all() and shapely.distance(rings, canvas.boundary).min() >= 0.06


@pytest.mark.parametrize("mode", list(laying.WAYS))
@pytest.mark.parametrize(
    "canvas",
    [
        shapely.Point(15, 12).buffer(11) - shapely.Point(15, 12).buffer(9),
        shapely.MultiPolygon([shapely.box(1, 1, 8, 8), shapely.box(12, 8, 29, 23)]),
        shapely.Polygon([(1, 1), (29, 1), (15, 6), (29, 23), (1, 23), (10, 12)]),
    ],
    ids=["ring", "islands", "horns"],
)
def test_stones_stay_on_any_canvas_half_a_grout_inside(mode, canvas):
    sheet = drawn(Tone(DISC, SIZE, canvas), mode=mode, iterations=8)
    found = stones(sheet)
    assert shapely.covers(canvas, found).all() and shapely.distance(found, canvas.boundary).min() >= 0.06
    assert sheet.report["coverage"] == pytest.approx(shapely.area(found).sum() / canvas.area) and sheet.report["coverage"] > 0.5
    assert sheet.report["overlap_mm2"] == 0 and sheet.report["grout_least_mm"] >= 0.12


def test_a_mosaic_can_be_of_one_stone():
    assert drawn(Tone(np.full((5, 5), 0.5), (3.0, 3.0)), tile=2.5, mode="cells").report["marks"] == 1


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"tile": 100.0}, "tile 100 mm is larger than the canvas of 30 x 24 mm; take smaller ones"),
        ({"grout": 2.0}, "grout 2 mm is as wide as the stones of 1.2 mm; take less"),
        ({"grout": 5.0, "tile": None, "tiles": 100}, "grout 5 mm is as wide as the stones"),
        ({"grout": 0.9, "aspect": 4.0}, "grout 0.9 mm is as wide as the stones of 0.6 mm; take less"),
        ({"tiles": 100}, "tile 1.2 mm and tiles 100 are both given; leave one out"),
        ({"palette": "red"}, "palette 'red' has no colours; give some as"),
        ({"palette": "#ffffff", "one_ink": True}, "is of no use with one-ink; leave one out"),
        ({"edges": "somewhere"}, "no edges 'somewhere'; there are found and none, or give an SVG file"),
        ({"tile": 0.1, "max_tiles": 1000}, "over the limit of 1000; use larger ones, or raise max-tiles"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(knobs, said):
    with pytest.raises(ValueError) as error:
        drawn(**knobs)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_edges_without_lines_are_refused(tmp_path):
    (tmp_path / "none.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="10mm" height="10mm"/>')
    with pytest.raises(ValueError, match=r"none\.svg: has no lines for stones to follow; draw some"):
        drawn(edges=str(tmp_path / "none.svg"))
