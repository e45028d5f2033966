"""The judge finds what was planted: a lattice, a clump, a tone too light, a shift; and says nothing of what it cannot know."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import crowquill
from crowquill import Ink, Layer, Marks, Sheet, Tone, figure, judge, seen
from crowquill.__main__ import main
from crowquill.glyphs import load

DISC = load("disc").glyphs
FLAT = Tone(np.full((20, 20), 0.25), (40.0, 40.0))
RAMP = Tone(np.tile(np.linspace(0.05, 0.75, 80), (60, 1)), (40.0, 30.0))


@cache
def drawn(kind: str) -> Sheet:
    return crowquill.draw("stipple", FLAT if kind == "flat" else RAMP, pen=0.4)


def sheet_of(marks: Marks, tone: Tone = FLAT) -> Sheet:
    return Sheet(tone.size, (Layer(Ink(), marks),))


def facts(sheet: Sheet, tone: Tone | None = None) -> dict:
    found = judge.of(seen.of_sheet(sheet), tone)
    json.dumps(found.facts, allow_nan=False)
    return dict(found.facts)


def test_a_sound_drawing_is_found_sound():
    found = facts(drawn("flat"), FLAT)
    assert found["dots"] == len(drawn("flat").marks)
    assert found["ink"]["coverage"] == pytest.approx(0.25, abs=0.002) and found["ink"]["overlap"] < 0.01
    assert found["spacing"]["evenness"] > 0.88 and found["spacing"]["capacity_cv"] < 0.1
    first = found["tone"]["blurs"][0]
    assert abs(first["bias"]) < 0.003 and first["rmse"] < 0.02 and found["tone"]["edges_kept"] == 1.0  # no edges to lose


def test_relaxed_dots_read_as_mechanical_and_random_ones_as_hand():
    assert facts(drawn("flat"))["texture"]["verdict"] == "mechanical"
    sites = np.random.default_rng(3).random((3000, 2)) * 40
    assert facts(sheet_of(Marks.of(sites, DISC, scale=0.3)))["texture"]["verdict"] == "hand"


def test_a_lattice_is_found():
    grid = np.stack(np.meshgrid(np.arange(0.4, 40, 0.8), np.arange(0.4, 40, 0.8)), axis=-1).reshape(-1, 2)
    found = facts(sheet_of(Marks.of(grid, DISC, scale=0.35)))
    assert found["texture"]["verdict"] == "mechanical" and found["spacing"]["anisotropy"] > 3
    assert found["spacing"]["nearest_cv"] == pytest.approx(0, abs=1e-6)


def test_a_clump_is_found():
    marks = drawn("flat").marks
    xy = np.array(marks.xy)
    near = np.argsort(np.hypot(*(xy - (20, 20)).T))[:30]
    xy[near] = (20, 20) + 0.2 * (xy[near] - (20, 20))
    good, bad = facts(drawn("flat"), FLAT)["spacing"], facts(sheet_of(replace(marks, xy=xy)), FLAT)["spacing"]
    assert bad["nearest_least"] < 0.4 * good["nearest_least"] and bad["capacity_cv"] > 1.5 * good["capacity_cv"]
    assert bad["pairs_close"] > 10 * max(good["pairs_close"], 1e-6)


def test_a_tone_two_per_cent_too_light_is_found():
    marks = drawn("ramp").marks
    lighter = replace(marks, scale=marks.scale * np.sqrt(0.95))  # .02 of a mean coverage of .4
    bias = [facts(sheet_of(art, RAMP), RAMP)["tone"]["blurs"][1]["bias"] for art in (marks, lighter)]
    assert bias[0] - bias[1] == pytest.approx(0.02, abs=0.003)  # overlap in the darks gives some of it back


def test_a_shift_of_thirty_micrometres_is_found():
    y, x = np.mgrid[:120, :160] / 40
    waves = Tone(0.35 + 0.3 * np.sin(5 * x + y) * np.cos(4 * y - x), (40.0, 30.0))
    marks = crowquill.draw("stipple", waves, pen=0.2).marks
    before, after = (facts(sheet_of(art, waves), waves)["tone"]["shift_mm"] for art in (marks, marks.moved((0.03, -0.03))))
    assert np.subtract(after, before) == pytest.approx((0.03, -0.03), abs=0.005)


@pytest.mark.parametrize("n", [0, 1])
def test_a_drawing_of_fewer_than_two_dots_is_refused(n: int):
    with pytest.raises(ValueError, match=r"has (no dots|one dot); give"):
        facts(sheet_of(Marks.of(np.full((n, 2), 5.0), DISC, scale=0.3)))


@pytest.mark.parametrize("n", [2, 3, 40])
def test_few_dots_have_figures_where_there_are_any(n: int):
    sites = np.random.default_rng(n).random((n, 2)) * 30 + 5
    found = facts(sheet_of(Marks.of(sites, DISC, scale=0.3)), FLAT)
    assert found["spacing"]["nearest"] > 0 and found["spacing"]["power"] is None and found["notes"]
    assert found["texture"]["verdict"] == "unread" and found["texture"]["near"] is None


def test_coincident_dots_are_judged_too():
    found = facts(sheet_of(Marks.of(np.full((50, 2), 20.0), DISC, scale=0.3)))
    assert found["spacing"]["nearest_least"] == 0 and found["ink"]["overlap"] == pytest.approx(0.98, abs=0.001)


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with ramp.png and drawings of it: a.svg and a.png, and b.svg of other dots."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(60, 255, 80).astype(np.uint8), (60, 1))).save("ramp.png")
    common = ["--paper", "70x50mm", "--margin", "5mm", "--quiet", "--tone", "grey", "--crop", "0,0,0.75,1"]
    assert main(["stipple", "ramp.png", "a.svg", "a.png", *common, "--pen", "0.4mm"]) == 0
    assert main(["stipple", "ramp.png", "b.svg", *common, "--sizes", "0.3mm,0.6mm"]) == 0


@pytest.mark.usefixtures("desk")
def test_a_drawing_is_measured_against_its_picture_with_its_own_tone(capsys: pytest.CaptureFixture[str]):
    capsys.readouterr()
    assert main(["measure", "a.svg", "--against", "ramp.png", "--report", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert abs(found["tone"]["blurs"][0]["bias"]) < 0.005 and found["box_mm"][2:] == [40, 40]
    assert main(["measure", "a.svg", "--against", "ramp.png", "--report", "-", "--gamma", "2"]) == 0
    other = json.loads(capsys.readouterr().out)
    assert other["tone"]["blurs"][0]["bias"] > 0.05, "an option typed goes before the drawing's own"


@pytest.mark.usefixtures("desk")
def test_a_bitmap_of_ours_is_measured_as_the_drawing_is(capsys: pytest.CaptureFixture[str]):
    reports = []
    for name in ("a.svg", "a.png"):
        capsys.readouterr()
        assert main(["measure", name, "--against", "ramp.png", "--report", "-"]) == 0
        reports.append(json.loads(capsys.readouterr().out))
    one, other = reports
    assert other["ink"]["coverage"] == pytest.approx(one["ink"]["coverage"], abs=0.003)
    assert other["tone"]["blurs"][1]["rmse"] == pytest.approx(one["tone"]["blurs"][1]["rmse"], abs=0.005)


@pytest.mark.usefixtures("desk")
def test_two_drawings_stand_side_by_side_in_words_and_in_a_figure(capsys: pytest.CaptureFixture[str]):
    capsys.readouterr()
    assert main(["measure", "a.svg", "b.svg", "--against", "ramp.png", "--figure", "f.svg", "--report", "r.json"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert rows[0].split() == ["a.svg", "b.svg"] and any(row.startswith("evenness") and len(row.split()) >= 4 for row in rows)
    assert [one["file"] for one in json.loads(Path("r.json").read_text(encoding="utf-8"))] == ["a.svg", "b.svg"]
    page = crowquill.load("f.svg")
    assert page.size == (210, 297) and len(page.layers) > 20


def test_a_figure_stays_on_its_page_with_and_without_a_picture():
    for tone in (None, RAMP):
        judged = judge.of(seen.of_sheet(drawn("ramp")), tone)
        page = figure.of([judged])
        for layer in page.layers:
            assert (layer.art.xy >= 0).all() and (layer.art.xy <= page.size).all(), layer.label
        assert any(layer.ink.name == "red" for layer in page.layers) == (tone is not None)
    with pytest.raises(ValueError, match="one, or two"):
        figure.of([])


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("suffix", [".csv", ".npy"])
def test_points_are_exported_with_shares_of_the_ink(suffix: str):
    out = f"p{suffix}"
    assert main(["points", "a.svg", "-o", out, "--against", "ramp.png"]) == 0
    table = np.load(out) if suffix == ".npy" else np.loadtxt(out, delimiter=",", skiprows=1)
    marks = crowquill.load("a.svg").marks
    assert table.shape == (len(marks), 4) and table[:, :2] == pytest.approx(marks.xy) and table[:, 3].sum() == pytest.approx(1)
    assert table[:, 3].std() < 0.2 / len(marks)  # relaxed cells hold nearly equal ink
