"""Where every printed edge grows, or tones print darker by a measured curve, the drawing is made so that the print is as planned."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image

from crowquill import curves, formats, glyphs, raster
from crowquill.__main__ import main
from crowquill.finishing import Finish, finish
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet, outlined
from crowquill.tone import Tone

SIZE = 24.0  # mm
SQUARE = Paths.of([[(4, 4), (8, 4), (8, 8), (4, 8)], [(5, 5), (5, 6), (6, 6), (6, 5)]])
QUICK = ["--paper", "60x50mm", "--margin", "5mm", "--quiet", "--overwrite", "--iterations", "1"]
DISC = glyphs.load("disc").glyphs


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder where we are: it has ramp.png and a curve.csv."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(20, 230, 40).astype(np.uint8), (30, 1))).save("ramp.png")
    Path("curve.csv").write_text("asked,measured\n0,0\n0.5,0.7\n1,1\n", encoding="utf-8")
    return tmp_path


def grown(sheet: Sheet, gain: float) -> float:
    """The coverage of the middle of a sheet where every edge grows by the gain in mm: a raster of the offset shapes.

    Two millimetres are left out at each edge, where dots have a ring of their own.
    """
    rings = []
    for layer in sheet.layers:
        paths = outlined(layer.art).flat(1e-4)
        if layer.ink.pen is None:
            rings += list(Paths.of_polygons(shapely.buffer(paths.polygons(), gain))[0])
        else:
            rings += list(raster.stroked(paths, layer.ink.pen + 2 * gain, 1e-4))
    cover = raster.covered(Paths.of(rings), (24, 24), pixel=(sheet.size[0] / 24, sheet.size[1] / 24), lines=200)
    return float(cover[2:-2, 2:-2].mean())


@pytest.mark.parametrize(("style", "knobs"), [("stipple", {"pen": 0.4}), ("stipple", {"sizes": (0.3, 0.5)}), ("cells", {}), ("tour", {})])
@pytest.mark.parametrize("gain", [0.02, 0.04])
@pytest.mark.parametrize("wanted", [0.2, 0.5])
def test_what_grows_by_the_gain_covers_what_was_planned(style: str, knobs: dict[str, Any], gain: float, wanted: float):
    from crowquill import draw

    planned = draw(style, Tone([[wanted]], (SIZE, SIZE)), **knobs)
    made = finish(Tone([[1.0]], (9, 9)), ink_gain=gain).drawn(planned)
    assert abs(grown(planned, 0) - wanted) < 0.015, "cells have no lines along borders, and more in the middle"
    assert abs(grown(made, gain) - grown(planned, 0)) < 0.01
    assert grown(made, 0) < wanted - 0.01, "and without any growth it is lighter"


@pytest.mark.parametrize("gain", [0.01, 0.05])
def test_diameters_pens_and_areas_lose_twice_the_gain(gain: float):
    marks = Marks.of([(2.0, 2.0), (2.0, 9.0)], DISC, scale=np.array([0.3, 0.5]) * np.sqrt(np.pi) / 2)
    layers = (Layer(Ink(), marks), Layer(Ink(pen=0.2), SQUARE), Layer(Ink(), SQUARE))
    made = Finish(gain=gain).drawn(Sheet((9, 9), layers, report={"warnings": []}))
    assert np.allclose(made.layers[0].art.scale * 2 / np.sqrt(np.pi), [0.3 - 2 * gain, 0.5 - 2 * gain], atol=1e-3)
    assert made.layers[1].ink.pen == pytest.approx(0.2 - 2 * gain) and np.array_equal(made.layers[1].art.xy, SQUARE.xy)
    assert np.isclose(made.layers[2].art.areas.sum(), (4 - 2 * gain) ** 2 - (1 + 2 * gain) ** 2, atol=1e-3)
    assert np.isclose(shapely.buffer(made.layers[2].art.polygons(), gain, join_style="mitre")[0].area, 16)
    assert made.report["finish"] == {"ink_gain_mm": gain, "smallest_mm": pytest.approx(0.2 - 2 * gain), "areas_left_out": 0}


def test_areas_that_vanish_among_others_are_left_out_and_it_is_said():
    thin = Paths.of([*SQUARE, [(1, 1), (3, 1), (3, 1.1), (1, 1.1)]])
    made = Finish(gain=0.06).drawn(Sheet((9, 9), (Layer(Ink(), thin),), report={"warnings": []}))
    assert len(made.layers[0].art) == 2 and made.report["finish"]["areas_left_out"] == 1
    assert "1 areas are finer" in made.report["warnings"][0]


def test_rings_of_their_own_colours_keep_them():
    colours = np.array([[0, 1, 0, 0], [1, 0, 0, 0]])
    tiles = Layer(Ink(), Paths.of([SQUARE[0], SQUARE[0] + (5, 0)]), fill=colours)
    made = Finish(gain=0.1).drawn(Sheet((20, 9), (tiles,))).layers[0]
    assert made.fill.tolist() == colours.tolist() and np.allclose(made.art.areas, 3.8**2)


@pytest.mark.parametrize(
    "layer",
    [
        Layer(Ink(), Marks.of([(2.0, 2.0), (5.0, 5.0)], DISC, scale=[0.5, 0.1 * np.sqrt(np.pi) / 2])),
        Layer(Ink(pen=0.1), SQUARE),
        Layer(Ink(), Paths.of([[(1, 1), (8, 1), (8, 1.1), (1, 1.1)]])),
        Layer(Ink(), Bitmap.of(np.ones((5, 5)), 300)),
    ],
)
def test_what_would_vanish_is_refused_in_one_line(layer: Layer):
    with pytest.raises(ValueError, match="; ") as error:
        Finish(gain=0.05).drawn(Sheet((9, 9), (layer,)))
    assert "\n" not in str(error.value) and ("leaves nothing" in str(error.value) or "pixels" in str(error.value))


@pytest.mark.parametrize(
    "more",
    [
        ["--pen", "0.1mm", "--ink-gain", "0.05mm"],
        ["--ink-gain", "0.2mm"],
        ["--ink-gain", "2mm"],
        ["--ink-gain", "-0.1mm"],
        ["--ink-gain", "nan"],
        ["--ink-gain", "0.02mm", "--for", "plotter"],
    ],
    ids=" ".join,
)
def test_a_gain_that_cannot_be_is_refused_before_the_work(more: list[str], capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", "a.svg", *QUICK, *more, "--dry-run"]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line


def test_the_report_says_the_gain_and_the_smallest_mark_left():
    assert main(["stipple", "ramp.png", "a.svg", *QUICK, "--pen", "0.5mm", "--ink-gain", "0.03mm", "--report", "r.json"]) == 0
    told = json.loads(Path("r.json").read_text(encoding="utf-8"))["finish"]
    drawn = formats.load("a.svg").marks
    assert told["ink_gain_mm"] == 0.03
    assert told["smallest_mm"] == pytest.approx(2 * drawn.scale.min() / np.sqrt(np.pi), abs=2e-3), "scales are kept in micrometres"


def curve(text: str) -> Any:
    Path("own.csv").write_text(text, encoding="utf-8")
    return curves.inverse("own.csv")


@pytest.mark.parametrize(
    "text",
    [
        "0,0\n0.5,0.7\n1,1\n",
        "asked,measured\n0,0\n.5,.7\n1,1",
        "0;0\r\n50;70\r\n100;100\r\n",
        "\ufeffasked\tmeasured\n\n# dots of 0.3 mm\n0 %\t0 %\n50 %\t70 %\n",
        '"asked","measured"\n"50","70"\n"100","100"\n',
        "25,35\n50,70\n",
    ],
)
def test_a_curve_is_read_as_shares_or_percents_with_a_heading_or_without(text: str):
    assert np.allclose(curve(text)(np.array([0, 0.35, 0.7, 0.85, 1])), [0, 0.25, 0.5, 0.75, 1])


def test_what_is_asked_by_a_curve_prints_as_wanted():
    asked, measured = np.array([0, 0.1, 0.4, 0.8, 0.97]), np.array([0.01, 0.16, 0.55, 0.9, 0.98])
    back = curve("\n".join(f"{a},{m}" for a, m in zip(asked, measured, strict=True)))
    wanted = np.linspace(0.01, 0.98, 200).reshape(20, 10)
    assert np.allclose(np.interp(back(wanted), asked, measured), wanted)


def test_what_no_ink_can_reach_is_asked_for_as_nearly_as_can_be():
    assert curve("0,5\n100,93\n")(np.array([0, 0.02, 0.95, 1])).tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "0 rows"),
        ("asked,measured\n", "0 rows"),
        ("0.5,0.6\n", "1 rows"),
        ("0,0\nhalf,0.7\n1,1\n", "line 2"),
        ("0,0\n\n0.5\n", "line 3"),
        ("0,0\n0.5,0.7,0.8\n", "line 2"),
        ("0,0\n0.5,0.7\n0.5,0.8\n", "line 3"),
        ("0,0\n0.5,0.7\n0.6,0.7\n", "line 3"),
        ("0,0\n0.5,0.7\n0.4,0.8\n", "line 3"),
        ("0,0\n50,70\n100,101\n", "line 3"),
        ("0,0\n-0.5,0.7\n", "line 2"),
        ("0,0\nnan,0.7\n", "line 2"),
        ("0,0\n1e1,0.7\n", "line 2"),
        ("0,0\n0,5,0,7\n", "line 2"),
        ("asked,measured\nasked,measured\n", "line 2"),
    ],
)
def test_a_table_that_is_no_curve_is_refused_with_its_line(text: str, why: str):
    with pytest.raises(ValueError, match=re.escape(why)) as error:
        curve(text)
    said = str(error.value)
    assert said.startswith("own.csv: ") and "; " in said and "\n" not in said


def test_a_curve_that_is_no_text_or_no_file_is_refused(capsys: pytest.CaptureFixture[str]):
    Path("raw.csv").write_bytes(b"\xff\xfe\x00\x9d")
    for name, why in (("raw.csv", "is no text"), ("absent.csv", "check the name"), ("curve", "a file with a suffix"), (".", "suffix")):
        assert main(["stipple", "ramp.png", "a.svg", *QUICK, "--tone-curve", name]) == 2
        line = capsys.readouterr().err
        assert line.startswith("crowquill: ") and line.count("\n") == 1 and why in line


def test_a_drawing_by_a_curve_asks_for_less_ink_and_is_made_again_to_the_byte(desk: Path, capsys: pytest.CaptureFixture[str]):
    def asked(*more: str) -> float:
        assert main(["stipple", "ramp.png", "a.svg", *QUICK, "--dry-run", *more]) == 0
        return float(re.search(r"ink +([\d.]+)", capsys.readouterr().out)[1])  # type: ignore[index]

    assert asked("--tone-curve", "curve.csv") < 0.85 * asked()
    assert main(["stipple", "ramp.png", "a.svg", *QUICK, "--dots", "200", "--tone-curve", "curve.csv", "--embed"]) == 0
    made, kept = formats.recipe_of(Path("a.svg"))
    assert made["tone"]["tone_curve"] == "curve.csv" and len(made["sources"]["tone_curve"]["sha256"]) == 64
    assert kept["curve.csv"] == Path("curve.csv").read_bytes()
    (desk / "far").mkdir()
    Path("a.svg").rename("far/a.svg")
    assert main(["redo", "far/a.svg", "b.svg", "--quiet"]) == 0
    assert Path("b.svg").read_bytes() == Path("far/a.svg").read_bytes()
