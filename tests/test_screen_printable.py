"""What a press and a pen can draw of a screen: dashes keep the tone of lines thinner than the pen; no neck, slit or sliver is left."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from test_screen import covered, grey, screen

import crowquill
from crowquill import Tone
from crowquill.__main__ import main
from crowquill.preflight import Limits, check
from crowquill.printable import CELL, ROUND, dashes, opened

PEN = 0.3
BOX = shapely.box(0, 0, 10, 10)


def ink(strokes: Any, pen: float = PEN) -> float:
    """Of strokes that do not meet: their lengths and their round ends, in mm^2."""
    return float((np.diff(strokes).sum() + len(strokes) * ROUND * pen) * pen)


@pytest.mark.parametrize("coverage", [0.16, 0.2, 0.3, 0.4, 0.5, 0.58])
def test_a_pen_wider_than_the_lines_keeps_the_tone(coverage):
    sheet = screen(grey(coverage), lpi=50, pen=PEN)  # lines of 0.27 to 0.98 pens
    asked = 1200 * coverage
    assert sheet.report["ink_placed_mm2"] == pytest.approx(asked, rel=0.02)  # round ends hang over the edge
    assert covered(sheet).mean() == pytest.approx(coverage, rel=0.02)
    assert sheet.report["warnings"] == [] and sheet.report["left_out"] == 0


def test_tone_that_changes_along_dashes_is_kept_place_by_place():
    tone = Tone(np.tile(np.linspace(0.2, 0.55, 40), (30, 1)), (40.0, 30.0))
    cover = covered(screen(tone, lpi=50, pen=PEN, angles=(0.0,)), (3, 4))  # 10 mm, four dashes of 20 lines
    asked = tone.coverage.reshape(3, 10, 4, 10).mean(axis=(1, 3))
    assert np.abs(cover - asked)[:, 1:-1].max() < 0.015


def test_a_line_thinner_than_a_quarter_of_the_pen_is_left_out_and_said():
    report = screen(grey(0.07), pitch=1.0, pen=PEN).report
    assert report["marks"] == 0 and report["left_out"] == pytest.approx(1, abs=0.01) and "thinner than 0.075 mm" in report["warnings"][0]
    assert screen(grey(0.1), pitch=1.0, pen=PEN).report["marks"] > 0


def test_more_ink_than_asked_for_is_said():
    report = screen(grey(0.3), pitch=0.2, pen=PEN).report  # strokes wider than the pitch overlap, and reach over the next gap
    assert report["excess"] == pytest.approx(report["ink_placed_mm2"] / report["ink_asked_mm2"] - 1) and report["excess"] > 0.02
    assert any("times the ink asked for is placed" in said for said in report["warnings"])


@pytest.mark.parametrize("pen", [0.3, 0.8])
def test_black_is_solid_under_a_pen_and_not_called_a_fault(pen):
    sheet = screen(grey(0.95), pitch=0.508, pen=pen)
    assert covered(sheet)[1:-1, 1:-1].min() > 0.999
    assert pen > 0.5 or not any("coarser" in said for said in sheet.report["warnings"])  # round ends of 0.8 mm hang over by 5 %


@pytest.mark.parametrize("share", [0.25, 0.4, 0.6, 0.9, 0.95])
@pytest.mark.parametrize("stagger", [0.0, 0.37])
def test_dashes_have_the_ink_of_their_line_and_stay_a_pen_apart(share, stagger):
    place = (np.arange(4000) + 0.5) * 0.01
    strokes = dashes(place, 0.01, np.full(4000, share), PEN, stagger)
    assert ink(strokes) == pytest.approx(40 * share * PEN, rel=0.01)
    assert (strokes[1:, 0] - strokes[:-1, 1] >= PEN - 1e-9).all() and (np.diff(strokes) > 0).all()
    assert strokes.min() >= 0 and strokes.max() <= 40 + 1e-9
    assert len(strokes) == pytest.approx(40 / (CELL * PEN), abs=1)


def test_full_shares_run_on_as_one_stroke_and_none_draws_nothing():
    place = (np.arange(1000) + 0.5) * 0.01
    assert dashes(place, 0.01, np.ones(1000), PEN, 0.2) == pytest.approx(np.array([[0.0, 10.0]]))
    assert dashes(place, 0.01, np.zeros(1000), PEN, 0.2).shape == (0, 2)
    assert dashes(place[:1], 0.01, np.ones(1), PEN, 0.2).shape == (0, 2)  # a hundredth of a millimetre is less than half a dot


def test_dashes_of_neighbours_do_not_lie_side_by_side():
    (layer,) = screen(grey(0.3), lpi=50, pen=PEN, angles=(0.0,)).layers
    ends = np.array([line[0] for line in layer.art])
    first = [np.sort(ends[np.isclose(ends[:, 1], y, atol=2e-3), 0])[3] for y in np.unique(ends[:, 1].round(3))[5:15]]
    assert np.ptp(np.array(first) % (CELL * PEN)) > PEN


def test_opening_drops_necks_and_slivers_and_closing_fills_slits():
    neck = shapely.union_all([BOX, shapely.box(10, 5, 20, 5.05), shapely.box(20, 0, 30, 10)])
    kept, filled = opened([neck], 0.1, 0.0)
    assert len(kept) == 2 and shapely.area(kept).sum() == pytest.approx(200, abs=0.02)  # corners are rounded by 0.05 mm
    kept, filled = opened([BOX, shapely.box(10.05, 0, 20, 10), shapely.box(0, 20, 10, 20.05)], 0.1, 0.1)
    assert len(kept) == 2 and len(filled) == 1 and shapely.area(filled).sum() == pytest.approx(200, abs=0.02)


def test_lengths_of_nothing_leave_shapes_as_they_are():
    kept, filled = opened([BOX, shapely.box(10.001, 0, 20, 10)], 0.0, 0.0)
    assert len(kept) == len(filled) == 2 and shapely.area(filled).sum() == pytest.approx(199.99)


def found(sheet: Any) -> set[str]:
    """Of lines and gaps, what a check of the sheet's PDF finds below 0.1 mm."""
    told = check(crowquill.to_bytes(sheet, "pdf"), "a.pdf", Limits(min_line=0.1, min_gap=0.1))
    return {finding.rule for finding in told.findings} & {"min-line", "min-gap"}


@pytest.mark.parametrize(("combine", "coverage"), [("mean", 0.5), ("max", 0.5), ("product", 0.6)])
def test_a_check_finds_no_line_and_no_gap_below_the_limits(combine, coverage):
    knobs = {"angles": (30.0, 75.0), "combine": combine, "lpi": 40, "seed": 1}
    sheet = screen(Tone([[coverage]], (20.0, 20.0)), min_line=0.1, min_gap=0.1, **knobs)
    assert found(sheet) == set()
    report = sheet.report
    balance = report["ink_asked_mm2"] - report["left_out_mm2"] + report["closed_mm2"]
    assert report["left_out_mm2"] > 0 and report["ink_placed_mm2"] == pytest.approx(balance, rel=0.01)


def test_the_check_sees_necks_slits_and_slivers_that_are_kept():
    sheet = screen(Tone([[0.5]], (20.0, 20.0)), min_line=0.0, min_gap=0.0, angles=(30.0, 75.0), combine="mean", lpi=40, seed=1)
    assert found(sheet) == {"min-line", "min-gap"}


def test_more_dots_than_are_looked_at_are_said(monkeypatch):
    monkeypatch.setattr("crowquill.styles.screen.SHAPED", 100)
    (said,) = screen(grey(0.3), combine="mean").report["warnings"]
    assert said.startswith("necks and gaps between more than 100 dots are not looked at")
    assert screen(grey(0.3), combine="mean", min_line=0.0, min_gap=0.0).report["warnings"] == []


def test_rules_of_two_cross_by_themselves_and_near_angles_are_said_to_beat():
    assert screen(grey(0.3), combine="max").report["phase"] != screen(grey(0.3)).report["phase"]
    assert len(screen(grey(0.3), combine="max").report["phase"]) == 2 and len(screen(grey(0.3)).report["phase"]) == 1
    (said,) = screen(grey(0.3), angles=(30.0, 40.0)).report["warnings"]
    assert said == "angles 30 and 40 beat every 2.9 mm, a moire; 30 degrees apart or more would help"  # 0.508 / 2 / sin(5 degrees)


def test_a_list_of_no_numbers_is_refused_in_its_own_words(tmp_path, capsys):
    Image.new("L", (8, 8), 128).save(tmp_path / "a.png")
    assert main(["screen", str(tmp_path / "a.png"), str(tmp_path / "a.svg"), "--angles", ","]) == 2
    said = capsys.readouterr().err
    assert "numbers parted by commas: degrees in which lines run" in said and "0.8" not in said
