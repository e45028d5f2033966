"""Plate files that cannot be: one line that says where and what would be right, exit code 2, and nothing new in the folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from crowquill import plate
from crowquill.__main__ import main

GREY = 'picture = "grey.png"\nknobs = { dots = 50 }\n'
ONE = f"[[panel]]\n{GREY}"
PAGE = '[page]\nwidth = "100 mm"\nmargin = 0\n'
ABOVE = PAGE + ONE + "[[panel]]\n"  # a second panel follows

PANELS = {  # what is wrong with a second panel
    "captoin = 'x'\n" + GREY: "panel 2: no key 'captoin'; did you mean caption?",
    GREY + "caption = 5": "panel 2: caption is 5; it takes a text",
    GREY + "seed = true": "panel 2: seed is True; it takes a whole number",
    GREY + "seed = -1": "panel 2: seed is -1; it takes 0 or more",
    GREY + "cell = [0, 1]": "panel 2: cell: number 1 is 0; it takes 1 or more",
    GREY + "cell = [1]": "panel 2: cell: has no number 2; give one",
    GREY + "cell = [1, 2]": "panel 2: is outside a grid 1 wide; give another cell",
    GREY + "fit = 'fill'": "panel 2: fit is 'fill'; it takes one of 'contain', 'cover' or 'stretch'",
    GREY + "width = true": "panel 2: width: True is no length; write a number of mm",
    GREY + "width = '12'": "panel 2: width: length '12' has no unit; write 12mm",
    GREY + "width = '12 parsec'": "panel 2: width: length '12 parsec' is not understood",
    GREY + "width = 0": "panel 2: width: 0 is no length that can be drawn",
    GREY + "width = 1e300": "panel 2: width: 1e+300 is no length",
    GREY + "width = '200 mm'": "panel 2: it is 200 x 150 mm and has a room of 100 x 150 mm",
    GREY + "size = [1, 2]": "panel 2: a size goes with at;",
    GREY + "at = [0, 0]": "panel 2: it does not say how large it is drawn; give size or width",
    GREY + "at = [0, 0]\ncell = [1, 1]": "panel 2: it is placed by at and by cell or span; leave out one",
    GREY + "at = [-1, 0]\nsize = [9, 9]": "panel 2: at: -1 is outside every page",
    GREY + "at = [95, 80]\nsize = [9, 5]": "panel 2: reaches 2.834 mm over a page of 100 x 85 mm; move it",
    GREY + "at = [9, 9]\nsize = [9, 9]": "panel 1 and panel 2 overlap; move one",
    GREY + "cell = [1, 1]": "panel 1 and panel 2 overlap; move one",
    GREY + "scale = 'banana'": "panel 2: scale 'banana' is not understood; write 1 mm = 250 um",
    GREY + "scale = '1 mm = 0 um'": "panel 2: length '0 um' of a specimen; it takes a number over 0",
    GREY + "scale = '1 mm = -5 um'": "panel 2: length '-5 um' of a specimen; it takes a number over 0",
    GREY + "scale = '0:1'": "panel 2: scale '0:1' is none that can be drawn",
    GREY + "pixel = '3 px'": "panel 2: length '3 px' of a specimen is not understood",
    GREY + "scale = '1:1'\nscale_bar = '5 m'": "panel 2: a scale bar of 5 m is 5000 mm long in a room of 100 mm",
    GREY + "scale_bar = '5 mm'": "panel 2: a scale bar of an unknown scale; give scale",
    GREY + "pixel = '1 um'\nfit = 'stretch'": "panel 2: pixel is for pictures that are not stretched; say scale",
    GREY + "pixel = '1 um'\nscale = '1:1'\nwidth = 3": "panel 2: scale and pixel together say how large it is drawn",
    GREY + "scale = '1:1'\nfinish = { scale_bar = 'auto', scale = '1:1' }": "panel 2: its settings draw a scale bar already",
    GREY + f"caption = '{'W' * 60}'": f"panel 2: caption: '{'W' * 60}' is 167 mm wide in a room of 100 mm",
    GREY + "tone = { gama = 2 }": "panel 2: table tone has no knob 'gama'; did you mean gamma?",
    GREY + "finish = { ink_gian = 2 }": "panel 2: table finish has no knob 'ink_gian'; did you mean ink_gain?",
    GREY + "style = 'stiple'": "panel 2: no style 'stiple'; did you mean stipple?",
    GREY + "ink = 'ocher'": "panel 2: no ink 'ocher'; there are black",
    GREY + "recipe = 'r.toml'": "panel 2: its recipe says its knobs already; leave one of them out",
    GREY + "drawing = 'd.svg'": "panel 2: a drawing is there already and has no picture; leave one of them out",
    GREY + "layer = 7": "panel 2: layer is 7; it takes a list",
    GREY + "layer = [{ inc = 'x' }]": "panel 2: layer 1: no key 'inc'; did you mean ink?",
    GREY + "layer = [{ knobs = { pen = 'thick' } }]": "panel 2: layer 1: pen: length 'thick' is not understood",
    "picture = 'grey.png'\nknobs = { dotz = 2 }": "panel 2: style stipple has no knob 'dotz'; did you mean dots?",
    "caption = 'x'": "panel 2: there is nothing to draw; give a picture, a recipe or a drawing",
    "picture = 'nothing.png'": "panel 2: there is no file 'nothing.png' in the plate's folder; check the name",
    "picture = '../grey.png'": "panel 2: '../grey.png' is no file of the plate's folder",
    "picture = '/etc/passwd'": "panel 2: '/etc/passwd' is no file of the plate's folder",
    "picture = 'link.png'": "panel 2: 'link.png' is a link out of the plate's folder; put the file itself there",
    "picture = 'inner/deep.png'": "panel 2: 'inner/deep.png' is a link out of the plate's folder",
    "picture = 'plate.toml'": "panel 2: plate.toml: not a picture that can be read",
    "picture = 'inner'": "panel 2: inner: is a folder; give a file",
    "drawing = 'grey.png'": "panel 2: grey.png is no SVG; draw it as one, or give it as a picture",
    "drawing = 'bad.svg'": "panel 2: bad.svg: not sound SVG",
    "recipe = 'grey.png'": "panel 2: grey.png: not sound TOML",
    "recipe = 'r.toml'": "panel 2: r.toml names no picture; give one with picture",
    "recipe = 'plot.toml'\npicture = 'grey.png'": "panel 2: plot.toml is for a plotter, which draws no plates",
}

PLATES = {  # what is wrong with a plate
    "": "has no panel; give at least one [[panel]]",
    "panel = []": "panel is []; it takes 1 at least",
    ONE.replace("panel", "panle"): "no key 'panle'; did you mean panel?",
    "[[panel": "not sound TOML",
    "a = " + "[" * 5000: "not sound TOML",
    "a = " + "9" * 5000: "not sound TOML",
    "#" * 300_000: "300000 bytes are no plate file; it has at most 262144",
    "when = 2026-01-01\n" + ONE: "holds what is no text, number, list or table",
    "seed = nan\n" + ONE: "holds what is no text, number, list or table",
    "schema = 2\n" + ONE: "made by a newer crowquill (plate schema 2); update this one",
    "style = 'stipple'\n" + ONE: "style is 'stipple'; it takes one of 'plate'",
    ONE * 201: "has 201 panels; it takes 200 at most",
    ONE + "[[panel.layer]]\nseed = 1\n" * 21: "panel 1: has 21 layers; it takes 20 at most",
    "[page]\njournal = 'spriner'\n" + ONE: "page: journal: no journal 'spriner'; did you mean springer?",
    "[page]\npaper = 'a9'\n" + ONE: "page: paper: no paper 'a9'; there are a4, a5, letter",
    "[page]\npaper = 'a4'\njournal = 'aiaa'\n" + ONE: "page: paper has a width and a height of its own; leave out paper",
    "[page]\ncolumns = 2\n" + ONE: "page: columns are a journal's; name one with journal",
    "[page]\njournal = 'aiaa'\ncolumns = 2\n" + ONE: "page: journal aiaa has a width for 1 columns; give fewer",
    "[page]\nheight = 30\n" + ONE: "page: height is given without a width; give both",
    "[page]\nmargin = '200 mm'\n" + ONE: "page: a margin of 200 mm leaves no room; make it smaller",
    PAGE + f"height = 90\ncaption = '{'word ' * 3000}'\n" + ONE: "page: its caption is",
    PAGE + "height = 2\n" + ONE * 3: "grid: its rows have a room of 2 mm",
    PAGE + "[grid]\nwidths = [8, 8]\n" + ONE: "grid: widths has 2 lengths for 1 columns; give one for each",
    PAGE + "[grid]\ncolumns = 2\nwidths = [80, 80]\n" + ONE: "grid: its columns have a room of 100 mm",
    PAGE + "[grid]\ngutter = '-1 mm'\n" + ONE: "grid: gutter: '-1 mm' is outside every page",
    PAGE + "[letters]\nstyle = 'B'\n" + ONE: "letters: style is 'B'; it takes one of 'A', 'a' or 'none'",
    PAGE + "[letters]\nfont = 'blod'\n" + ONE: "letters: no font 'blod'; there are regular, bold, italic",
    PAGE + "[text]\nfont = 'grey.png'\n" + ONE: "text: grey.png: not a font that can be read",
    PAGE + "[letters]\nsize = 120\n" + ONE: "panel 1: its letter 'A' is 92.9 x 87.6 mm and has no room; make letters smaller",
    (PAGE + "[bars]\nposition = 'inside'\nsize = 20\n[letters]\nstyle = 'none'\n" + ONE + "scale = '1:1'\nat = [0, 0]\n"
     "size = [90, 18]\nfit = 'cover'"): (
        "panel 1: its scale bar is 15.9 mm high and has no room; put bars below"
    ),
    PAGE + "[bars]\nink = 'x'\n" + ONE: "bars: no ink 'x'; there are black",
    "[inks.a]\n" + ONE: "inks: a: has no cmyk; give one",
    "[inks.a]\ncmyk = [0, 0, 0, 2]\n" + ONE: "inks: a: cmyk (0.0, 0.0, 0.0, 2.0) of ink 'a' is not four shares from 0 to 1",
    "[inks.\"b\\u0007\"]\ncmyk = [0, 0, 0, 1]\nspot = true\n" + ONE: "inks: b?: spot ink 'b\\x07': presses take plain letters",
    "[files]\ncompackt = true\n" + ONE: "table files has no knob 'compackt'; did you mean compact?",
    "[files]\nicc = 'x.icc'\n" + ONE: "files: there is no file 'x.icc' in the plate's folder",
    f"[sources]\n'grey.png' = '{'0' * 64}'\n" + ONE: "panel 1: 'grey.png' is not the file that the plate was drawn from",
}  # fmt: skip


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with what the cases name, which is where we are; a picture lies outside it."""
    (tmp_path / "desk").mkdir()
    monkeypatch.chdir(tmp_path / "desk")
    for path in ("grey.png", "../grey.png"):
        Image.fromarray(np.full((30, 40), 150, np.uint8)).save(path)
    Path("link.png").symlink_to("../grey.png")
    Path("inner").mkdir()
    Path("inner/deep.png").symlink_to("../../grey.png")
    Path("bad.svg").write_text("<svg")
    Path("r.toml").write_text('style = "stipple"')
    Path("plot.toml").write_text('style = "stipple"\n[plot]\npurpose = "plotter"')
    return Path()


def refused(text: str, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Raises AssertionError unless the plate is refused in a line that says this, and leaves nothing."""
    Path("plate.toml").write_text(text)
    before = sorted(map(str, Path().rglob("*")))
    code = main(["plate", "plate.toml", "new.svg", "new.pdf", "--quiet"])
    told = capsys.readouterr()
    assert (code, told.out) == (2, ""), told
    assert told.err.startswith(f"crowquill: plate.toml: {says}"[:140]) and told.err.count("\n") == 1 and "; " in told.err
    assert sorted(map(str, Path().rglob("*"))) == before


@pytest.mark.parametrize(("panel", "says"), PANELS.items(), ids=range(len(PANELS)))
def test_a_panel_that_cannot_be_is_refused_in_one_line(panel: str, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    refused(ABOVE + panel, says, capsys)


@pytest.mark.parametrize(("text", "says"), PLATES.items(), ids=range(len(PLATES)))
def test_a_plate_that_cannot_be_is_refused_in_one_line(text: str, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    refused(text, says, capsys)


def test_a_refusal_is_seen_to_fail_where_a_plate_is_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(AssertionError):
        refused(PAGE + ONE, "", capsys)


@pytest.mark.parametrize("table", [{"panel": [{"picture": Path("grey.png")}]}, {"panel": "grey.png"}], ids=str)
def test_tables_from_a_program_are_checked_alike(table: Any) -> None:
    with pytest.raises(ValueError, match=r"^plate: .*; "):
        plate.drawn(table)
