"""The cells style's own bars: lines where the cells are, each once, on the canvas and off the white, as much ink as asked."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely

import crowquill
from crowquill import Paths, Sheet, Tone, raster, voronoi
from crowquill.styles.cells import _corrected, _off_white, inked

Array = npt.NDArray[np.float64]
BOTH = pytest.mark.parametrize("net", [False, True], ids=["cells", "net"])
HORSESHOE = shapely.Point(10, 7.5).buffer(7) - shapely.box(8, 7, 12, 15)


def ramp(width: float, height: float, low: float, high: float) -> Tone:
    columns, rows = round(5 * width), round(5 * height)
    return Tone(np.tile(low + (high - low) * (np.arange(columns) + 0.5) / columns, (rows, 1)), (width, height))


def grey(coverage: float, canvas: shapely.Geometry | None = None) -> Tone:
    return Tone(np.full((30, 40), coverage), (20.0, 15.0), canvas)


def cells(tone: Tone, **knobs: Any) -> Sheet:
    return crowquill.draw("cells", tone, **knobs)


def ends(sheet: Sheet) -> Array:
    """The two ends of each line, (n, 2, 2)."""
    art = sheet.layers[0].art
    assert isinstance(art, Paths) and not art.closed and (np.diff(art.start) == 2).all()
    return art.xy.reshape(-1, 2, 2)


@BOTH
@pytest.mark.parametrize("pen", [0.1, 0.25])
def test_a_ramp_keeps_its_tone_in_every_band(net, pen):
    tone = ramp(400 * pen, 160 * pen, 0.1, 0.8)
    sheet = cells(tone, net=net, pen=pen)
    assert sheet.layers[0].ink.pen == pen == sheet.report["pen_mm"]
    pixel = (2 * pen, 2 * pen)
    cover = raster.covered(sheet.layers[0].art, (80, 200), pixel=pixel, pen=pen, lines=32)[10:-10]  # borders lack half a line
    bands = cover[:, 10:-10].mean(axis=0).reshape(6, 30).mean(axis=1)
    asked = np.interp((np.arange(6) * 30 + 25) * 2 * pen, [0, tone.size[0]], [0.1, 0.8])
    assert np.abs(bands - asked).max() <= 0.02, f"bands {bands.round(4)} of {asked.round(4)}"
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)


@BOTH
def test_every_line_is_drawn_once(net):
    lines = Counter(tuple(sorted(map(tuple, line.tolist()))) for line in ends(cells(grey(0.3), net=net)))
    assert len(lines) > 300 and set(lines.values()) == {1}


def test_lines_are_the_borders_of_cells_and_of_the_net_their_neighbours():
    """The sites of a net are its lines' ends: cells drawn anew from them have the same neighbours."""
    net = ends(cells(grey(0.3), net=True, dots=120))
    sites, which = np.unique(net.reshape(-1, 2), axis=0, return_inverse=True)
    assert len(sites) == 120
    drawn = {tuple(sorted(pair)) for pair in which.reshape(-1, 2).tolist()}
    again = {tuple(pair) for pair in voronoi(sites, grey(0.3).canvas).pairs.tolist()}
    assert len(drawn ^ again) <= 2  # sites are rounded to micrometres, and nearly square neighbours may swap
    borders = ends(cells(grey(0.3), dots=120))
    length = np.hypot(*(borders[:, 0] - borders[:, 1]).T).sum()
    of = voronoi(sites, grey(0.3).canvas)  # the same seed and number give the same sites
    rings = sum(shapely.length(ring) for ring in of.rings.polygons())
    assert length == pytest.approx((rings - 70) / 2, rel=1e-3)  # each border is two cells', but for the 70 mm of canvas


@BOTH
def test_lines_lie_on_the_canvas_and_off_the_white(net):
    coverage = np.tile(np.linspace(-0.2, 0.7, 80).clip(0), (60, 1))
    coverage[20:30, 40:70] = 0.01
    tone = Tone(coverage, (20.0, 15.0), HORSESHOE)
    lines = ends(cells(tone, net=net))
    assert len(lines) > 200
    assert shapely.covers(shapely.buffer(HORSESHOE, 1e-3), shapely.linestrings(lines)).all()  # ends are rounded to micrometres
    inside = lines[:, 0] + 0.5 * (lines[:, 1] - lines[:, 0])
    places = np.concatenate([lines[:, 0] + t * (lines[:, 1] - lines[:, 0]) for t in np.linspace(0, 1, 21)])
    assert (tone.at(inside) < 0.02).mean() < 0.02 and (tone.at(places) < 0.02).mean() < 0.02  # some cross a narrow white


def test_ends_on_white_are_cut_and_lines_mostly_on_white_are_left_out():
    blank = np.array([[True, False, False, True, False, True, True, True, True, False]])  # pixels of a millimetre
    tone = Tone(np.where(blank, 0.0, 0.5), (10.0, 1.0))
    lines = np.array([[(0, 0.5), (6, 0.5)], [(6.2, 0.5), (8.6, 0.5)], [(4.5, 0.2), (9.5, 0.2)], [(1.5, 0.1), (2.5, 0.9)]])
    found = _off_white(lines, tone, blank, 0.1)
    assert found.tolist() == [[[1.0, 0.5], [5.0, 0.5]], [[1.5, 0.1], [2.5, 0.9]]]


@BOTH
def test_dots_give_the_number_of_cells_and_none_is_too_few_for_a_line(net):
    report = cells(grey(0.4), dots=200, net=net).report
    assert report["cells"] == 200 and report["ink_asked_mm2"] == pytest.approx(120)
    one = cells(grey(0.4), dots=1, net=net)
    assert len(one.layers[0].art) == 0 and "no lines" in one.report["warnings"][0]
    assert len(cells(grey(0.4), dots=2, net=net).layers[0].art) == 1


def test_importance_is_said_not_to_be_heeded():
    asked = cells(replace(grey(0.3), importance=np.linspace(0, 1, 1200).reshape(30, 40)))
    assert (ends(asked) == ends(cells(grey(0.3)))).all()
    assert "importance is not heeded" in asked.report["warnings"][0]


def test_black_is_said_not_to_be_reached_and_too_many_cells_are_refused():
    report = cells(grey(1.0)).report
    assert report["coverage_missing"] == pytest.approx(0.15, abs=0.01)
    assert "not reached" in report["warnings"][0]
    with pytest.raises(ValueError, match="over the limit of 100"):
        cells(grey(0.5), max_dots=100)
    with pytest.raises(ValueError, match="wider than the canvas"):
        cells(grey(0.5), pen=16)


def test_the_ink_of_lines_is_the_area_that_shapely_joins():
    rng = np.random.default_rng(0)
    for count in (1, 40, 400):
        xy = rng.random((count, 2, 2)) * 8
        lines = Paths(xy.reshape(-1, 2), np.arange(0, 2 * count + 1, 2), closed=False)
        joined = shapely.union_all(shapely.buffer(shapely.linestrings(xy), 0.1, quad_segs=32)).area
        assert inked(lines, 0.2) == pytest.approx(joined, rel=1e-3)
    assert inked(Paths.of([], closed=False), 0.2) == 0


def test_the_number_of_cells_is_corrected_towards_the_ink():
    ink = {count: 0.9 * math.sqrt(count) for count in range(1, 20_000)}
    first = _corrected([(4000, ink[4000])], 60.0)
    second = _corrected([(4000, ink[4000]), (first, ink[first])], 60.0)
    assert abs(ink[second] - 60) < abs(ink[first] - 60) < abs(ink[4000] - 60)
    assert _corrected([(10, 1e-9)], 60.0) == 20 and _corrected([(2, 1e9)], 60.0) == 2
