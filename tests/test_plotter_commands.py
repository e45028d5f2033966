"""For a plotter, on the command line: strokes in their order, named pens, the time it takes and the dots it has time for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import crowquill
from crowquill import plotting, units
from crowquill.__main__ import main
from crowquill.commands.preview import preview
from crowquill.paths import Paths

QUICK = ["--paper", "60x50mm", "--margin", "5mm", "--iterations", "2", "--for", "plotter"]


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(60, 255, 40).astype(np.uint8), (30, 1))).save("ramp.png")


def strokes(name: str) -> list[Paths]:
    """The art of a drawing's layers, all of them strokes."""
    sheet = crowquill.load(name)
    assert all(layer.ink.pen is not None and isinstance(layer.art, Paths) for layer in sheet.layers)
    return [layer.art for layer in sheet.layers if isinstance(layer.art, Paths)]


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    capsys.readouterr()
    assert main(list(arguments)) == 0
    return capsys.readouterr().out


def test_a_drawing_for_a_plotter_is_strokes_of_the_pen_and_says_how_long_it_takes(capsys: pytest.CaptureFixture[str]):
    told = said(capsys, "stipple", "ramp.png", "a.svg", "a.gcode", "a.hpgl", *QUICK, "--pen", "0.8mm", "--report", "r.json")
    plot = json.loads(Path("r.json").read_text(encoding="utf-8"))["plot"]
    (art,) = strokes("a.svg")
    assert len(art) == plot["strokes"] == plot["dots"] == plot["lifts"] > 100
    assert crowquill.load("a.svg").layers[0].ink.pen == 0.8 and crowquill.load("a.svg").layers[0].label == "1 black 0.8"
    assert f"{plot['strokes']} strokes" in told and "of plotting" in told
    assert Path("a.gcode").read_text(encoding="ascii").count("M3") == plot["strokes"]


def test_several_nibs_are_a_pen_each(capsys: pytest.CaptureFixture[str]):
    said(capsys, "stipple", "ramp.png", "a.svg", *QUICK, "--sizes", "0.5mm,1mm", "--codes", "axidraw")
    names = [layer.label for layer in crowquill.load("a.svg").layers]
    assert len(names) == 2 and names[0].startswith("1") and names[1].startswith("!2")
    assert [layer.ink.pen for layer in crowquill.load("a.svg").layers] == [0.5, 1.0]


@pytest.mark.parametrize("kind", ["svg", "pdf"])
def test_a_plotters_drawing_is_made_again_to_the_byte(kind: str, capsys: pytest.CaptureFixture[str]):
    said(capsys, "stipple", "ramp.png", f"a.{kind}", *QUICK, "--pen", "2mm", "--nib", "0.5mm", "--dot", "spiral", "--check-bar")
    said(capsys, "redo", f"a.{kind}", f"b.{kind}", "--quiet")
    assert Path(f"a.{kind}").read_bytes() == Path(f"b.{kind}").read_bytes()


def test_a_plot_time_decides_the_number_of_dots_and_a_dry_run_says_the_time(capsys: pytest.CaptureFixture[str]):
    said(capsys, "stipple", "ramp.png", "a.svg", *QUICK, "--plot-time", "10min", "--report", "r.json", "--quiet")
    plot = json.loads(Path("r.json").read_text(encoding="utf-8"))["plot"]
    assert plot["seconds"] == pytest.approx(600, rel=0.15)  # the way between dots is foreseen by their number alone
    rows = dict(
        line.split(maxsplit=1)
        for line in said(capsys, "stipple", "ramp.png", "b.svg", *QUICK, "--plot-time", "10min", "--dry-run").splitlines()
    )
    assert rows["plot"] == "about 10 min" and int(rows["dots"]) == plot["dots"] and not Path("b.svg").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["a.svg", "--plot-time", "10"], "90min"),
        (["a.svg", "--plot-time", "0.1s"], "too short"),
        (["a.svg", "--nib", "0.001mm"], "nib"),
        (["a.svg", "--nib", "15mm", "--paper", "14x100mm", "--margin", "1mm"], "nib"),
        (["a.svg", "--speed-up", "0"], "speed-up"),
        (["a.svg", "--dot", "star"], "no dot"),
        (["a.gcode", "--profile", "lathe"], "lathe"),
        (["a.hpgl", "--bed", "40x40mm"], "bed"),
    ],
)
def test_what_no_plotter_can_do_is_refused(options: list[str], says: str, capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", *QUICK[:4], *QUICK[4:], "--dots", "50", *options]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "; " in line and says in line.replace("_", "-"), line
    assert [path.name for path in Path().iterdir()] == ["ramp.png"]


@pytest.mark.parametrize(("options", "says"), [(["a.svg", "--dot", "tick"], "--for plotter"), (["a.gcode"], "--for plotter")])
def test_what_is_for_plotters_says_so(options: list[str], says: str, capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", "--dots", "50", *options]) == 2
    assert says in capsys.readouterr().err


def test_a_preview_shows_every_stroke_and_the_ways_between(capsys: pytest.CaptureFixture[str]):
    said(capsys, "stipple", "ramp.png", "a.svg", *QUICK, "--dots", "60")
    told = said(capsys, "preview", "a.svg", "p.png", "p.svg")
    assert "60 strokes" in told
    page, n, up = preview(crowquill.load("a.svg"))
    ways = page.layers[-1].art
    assert isinstance(ways, Paths) and n == len(ways) == 60
    (art,) = strokes("a.svg")
    assert (ways.xy[1::2] == art.xy[art.start[:-1]]).all() and (ways.xy[2::2] == art.xy[art.start[1:-1] - 1]).all()
    assert up == pytest.approx(np.hypot(*(ways.xy[1::2] - ways.xy[::2]).T).sum())
    with Image.open("p.png") as image:
        red = np.asarray(image.convert("RGB"), int)
        assert (red[..., 0] - red[..., 1] > 60).sum() > 50 and (red.sum(axis=-1) < 60).sum() > 50


def test_a_drawing_for_print_has_no_preview(capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", "a.svg", "--dots", "50", "--iterations", "1", "--quiet"]) == 0
    assert main(["preview", "a.svg", "p.png"]) == 2
    assert "--for plotter" in capsys.readouterr().err


@pytest.mark.parametrize(("text", "seconds"), [("90min", 5400), ("1.5h", 5400), ("30 s", 30)])
def test_a_time_has_its_unit(text: str, seconds: float):
    assert units.duration(text) == seconds
    for wrong in ("", "90", "-1h", "1d", "0min", "h"):
        with pytest.raises(ValueError, match="such as 90min"):
            units.duration(wrong)


def test_dots_and_time_answer_each_other():
    for dots in (1, 100, 50_000):
        assert plotting.dots_for(plotting.expected(dots, 1e4), 1e4) == dots
