"""A drawing gets its scale bar and its ink from one table of its recipe, and nothing else touches them."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image

from crowquill import formats, glyphs, inks, options, recipe, styles
from crowquill.__main__ import main
from crowquill.finishing import INSET, SURROUND, Finish, finish
from crowquill.lettering import Words
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.recipe import Recipe, parsed, read_toml
from crowquill.sheet import Ink, Layer, Sheet, outlined
from crowquill.tone import Tone

GREY = Tone(np.full((30, 40), 0.6), (60, 45))
LINE = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 30"><path d="M0 28H40" fill="none" stroke="black" stroke-width=".2"/></svg>'
QUICK = ["--paper", "80x65mm", "--margin", "5mm", "--width", "60mm", "--iterations", "2", "--quiet", "--overwrite"]


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder where we are: it has ramp.png, 40 by 30 pixels, and line.svg near its lower edge."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(20, 200, 40).astype(np.uint8), (30, 1))).save("ramp.png")
    Path("line.svg").write_text(LINE, encoding="utf-8")


def run(*arguments: str) -> Sheet:
    assert main([str(argument) for argument in arguments]) == 0
    return formats.load("a.svg")


def bar_of(sheet: Sheet) -> tuple[Any, Any]:
    """The bar's own box, and that of all its ink with its label, left, top, right, bottom in mm."""
    bar, words = (layer.art for layer in sheet.layers if layer.name.startswith("scale bar"))
    ink = np.concatenate([bar.xy, outlined(words).flat(1e-3).xy])
    return np.concatenate([bar.xy.min(0), bar.xy.max(0)]), np.concatenate([ink.min(0), ink.max(0)])


@pytest.mark.parametrize(
    ("how", "long", "label"),
    [
        (("--scale", "1 mm = 250 um", "--scale-bar", "auto"), 12, "3 mm"),
        (("--scale", "1 mm in the figure = 250 um in the specimen", "--scale-bar", "3 mm"), 12, "3 mm"),
        (("--scale", "1:50", "--scale-bar", "auto"), 15, "750 mm"),
        (("--pixel-size", "1.5 um", "--scale-bar", "20um"), 20, "20 µm"),  # 60 mm of 40 pixels
    ],
)
@pytest.mark.parametrize("style", ["stipple", "cells"])
def test_a_scale_bar_lies_in_the_corner_as_long_as_it_says_and_all_keeps_clear_of_it(
    how: tuple[str, ...], long: float, label: str, style: str
):
    sheet = run(style, "ramp.png", "a.svg", "--pen", "0.5mm", *how, *QUICK)
    bar, box = bar_of(sheet)
    assert np.isclose(bar[2] - bar[0], long, atol=1e-3) and sheet.layers[-1].name == f"scale bar {label}"
    assert np.allclose(box[2:], (70 - INSET, 55 - INSET), atol=2e-3), "the drawing is 60 x 45 mm, 10 from the paper's corner"
    for layer in sheet.layers[:-2]:
        paths = outlined(layer.art).flat(1e-4)
        shapes = [shapely.LineString(path) for path in paths] if layer.ink.pen else paths.polygons()
        clear = shapely.distance(shapely.box(*box), shapes).min() - (layer.ink.pen or 0) / 2
        assert SURROUND - 2e-3 < clear < SURROUND + 0.6


def test_a_crop_does_not_change_what_a_pixel_is():
    sheet = run("stipple", "ramp.png", "a.svg", "--crop", "0,0,0.5,1", "--height", "45mm", "--pixel-size", "1.5um", "--scale-bar", "5um",
                "--pen", "1mm", *QUICK[:4], *QUICK[6:])  # fmt: skip
    bar, _ = bar_of(sheet)
    assert np.isclose(bar[2] - bar[0], 5, atol=1e-3), "20 x 30 pixels, 30 x 45 mm"


def test_lines_end_before_the_bar():
    sheet = run("stipple", "ramp.png", "a.svg", "--pen", "1mm", "--outline", "line.svg", "--scale", "1:1", "--scale-bar", "20 mm", *QUICK)
    (lines,) = [layer for layer in sheet.layers if layer.name == "outline"]
    _, box = bar_of(sheet)
    gaps = shapely.distance(shapely.box(*box), [shapely.LineString(path) for path in lines.art]) - lines.ink.pen / 2
    assert np.isclose(gaps.min(), SURROUND, atol=2e-3)


@pytest.mark.parametrize(
    "more",
    [
        ["--scale-bar", "auto"],
        ["--scale", "1:50"],
        ["--pixel-size", "1um"],
        ["--scale-bar", "auto", "--scale", "1:50", "--pixel-size", "1um"],
        ["--scale-bar", "auto", "--scale", "1:0"],
        ["--scale-bar", "auto", "--scale", "50"],
        ["--scale-bar", "auto", "--pixel-size", "0um"],
        ["--scale-bar", "auto", "--pixel-size", "2"],
        ["--scale-bar", "2 parsec", "--scale", "1:50"],
        ["--scale-bar", "nan mm", "--scale", "1:50"],
        ["--scale-bar", "99 m", "--scale", "1:50"],
        ["--scale-bar", "1 nm", "--scale", "1:50"],
        ["--scale-bar", "auto", "--scale", "1:1", "--height", "20mm", "--fit", "stretch"],
        ["--scale-bar", "auto", "--scale", "1:1", "--width", "6mm"],
        ["--scale-bar", "auto", "--scale", "1:1", "--height", "4mm", "--fit", "cover"],
        ["--scale-bar", "auto", "--scale", "1:1", "--width", "3mm"],
        ["--ink", "puce"],
        ["--ink", "black=0,0,0"],
        ["--ink", "x=0,0,0,2"],
        ["--ink", "x=0,0,0,nan"],
        ["--ink", "x=0,0,0,0"],
        ["--ink", "=0,0,0,1"],
        ["--ink", "spot:Black=0,0,0,1"],
        ["--ink", "spot:Ä=0,0,0,1"],
        ["--ink", "spot:x"],
        ["--outline-width", "0.2mm"],
        ["--outline-gap", "-1mm"],
    ],
    ids=" ".join,
)
def test_what_cannot_be_is_refused_in_one_line(more: list[str], capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", "a.svg", *QUICK, *more]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line, line
    assert not Path("a.svg").exists()


@pytest.mark.parametrize(
    ("text", "ink"),
    [
        ("black", Ink()),
        ("Magenta", Ink("magenta", (0, 1, 0, 0))),
        ("sepia=0,0.3,0.6,0.5", Ink("sepia", (0, 0.3, 0.6, 0.5))),
        ("spot:PANTONE 124 C=0,0.3,0.9,0", Ink("PANTONE 124 C", (0, 0.3, 0.9, 0), spot=True)),
        ("spot:White=0,0,0,0", Ink("White", (0, 0, 0, 0), spot=True)),
    ],
)
def test_an_ink_is_a_name_a_mix_or_a_spot_ink(text: str, ink: Ink):
    assert inks.one(text) == ink


def test_the_ink_is_that_of_the_drawing_and_not_of_lines_and_bars():
    more = ("--ink", "spot:PANTONE 124 C=0,0.3,0.9,0", "--outline", "line.svg", "--scale", "1:1", "--scale-bar", "5 mm")
    sheet = run("stipple", "ramp.png", "a.svg", "--pen", "1mm", *more, *QUICK)
    assert [(layer.ink.name, layer.ink.spot) for layer in sheet.layers] == [
        ("PANTONE 124 C", True), ("outline", False), ("scale bar", False), ("scale bar", False)
    ]  # fmt: skip
    assert all(layer.ink.cmyk == (0, 0, 0, 1) for layer in sheet.layers[1:])


def test_inks_that_a_style_chose_stay_and_it_is_said():
    red = Layer(Ink("red", (0, 1, 1, 0)), Paths.of([[(1, 1), (2, 1), (2, 2)]]))
    made = Finish(ink=inks.one("cyan")).drawn(Sheet((9, 9), (red,)))
    assert made.layers[0].ink == red.ink and "not used" in made.report["warnings"][0]


@pytest.mark.parametrize("style", styles.names())
def test_no_name_of_a_knob_is_in_two_tables(style: str):
    tables = {table: set(recipe.takes_of(table, style)) for table in recipe.TABLES}
    for one, other in itertools.combinations(tables, 2):
        assert not tables[one] & tables[other], f"{one} and {other}"
    assert set(options.PANELS) == set(recipe.TABLES)


def test_a_recipe_of_before_there_was_the_table_reads_as_one_that_leaves_it_alone():
    data = Recipe("stipple", 3, knobs={"pen": 0.3}).data()
    old = {key: value for key, value in data.items() if key != "finish"}
    assert parsed(old, "old").data() == data


def test_the_table_comes_back_from_toml():
    made = Recipe("stipple", finish={"scale_bar": "500 µm", "scale": "1:50", "ink_gain": "0.02mm", "ink": "spot:Gold=0,0.2,0.6,0.2"})
    assert read_toml(made.toml().encode(), "r.toml").data() == made.data() and made.finish["ink_gain"] == 0.02
    with pytest.raises(ValueError, match="did you mean ink_gain"):
        Recipe("stipple", finish={"ink_gian": 0.02})


def test_a_drawing_with_all_of_it_is_made_again_to_the_byte():
    more = ("--ink", "cyan", "--ink-gain", "0.05mm", "--outline", "line.svg", "--scale", "1:1", "--scale-bar", "auto")
    run("stipple", "ramp.png", "a.svg", "a.pdf", "--pen", "1mm", *more, *QUICK, "--report", "r.json")
    assert main(["redo", "a.svg", "b.svg", "b.pdf", "--quiet"]) == 0
    assert all(Path(f"a.{kind}").read_bytes() == Path(f"b.{kind}").read_bytes() for kind in ("svg", "pdf"))
    told = json.loads(Path("r.json").read_text(encoding="utf-8"))["finish"]
    assert told["scale_bar"] == "15 mm" and set(told) >= {"marks_left_out", "ink_gain_mm", "smallest_mm"}


def test_a_bar_by_itself_is_above_the_dots_and_its_words_are_text():
    dots = Layer(Ink(), Marks.of([(55.0, 41.0), (5.0, 5.0)], glyphs.load("disc").glyphs, scale=1.0))
    made = finish(GREY, scale_bar="10 mm", scale="1:1").drawn(Sheet((60, 45), (dots,)))
    assert [type(layer.art) for layer in made.layers] == [Marks, Paths, Words] and len(made.marks) == 1
