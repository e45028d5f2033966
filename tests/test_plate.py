"""Plates: every panel, letter, bar and caption where the plate says, to the micrometre and at true size."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from rendering import Window, dots, pdfium, poppler, resvg

from crowquill import formats, lettering, plate
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.plate.journals import JOURNALS
from crowquill.plate.wording import caption
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.units import POINT

UM = 1e-3  # mm
FINE, BAR = 100.0, 50.0  # pixels to the mm: 2540 dpi, and the 1270 dpi at which bars are promised
SEEN = {"svg": resvg, "pdf": pdfium}
FACES = {"regular": "regular", "italic": "italic", "bold": "bold"}
DISC = '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10"><circle cx="10" cy="5" r="4"/></svg>'
QUICK = {"dots": 60, "iterations": 2}
Table = dict[str, Any]


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a grey picture of 40 x 30 pixels, a white one, and an SVG of 20 x 10 mm with a disc."""
    monkeypatch.chdir(tmp_path)
    for name, level in (("grey.png", 150), ("white.png", 255)):
        Image.fromarray(np.full((30, 40), level, np.uint8)).save(name)
    Path("disc.svg").write_text(DISC)
    return tmp_path


def picture(**more: Any) -> Table:
    return {"picture": "grey.png", "knobs": QUICK, **more}


def drawn(*panels: Table, width: float = 100.0, **more: Any) -> Sheet:
    page = {"width": width, "margin": 0, **more.pop("page", {})}
    return plate.drawn({"page": page, "panel": list(panels), **more})


def layer(sheet: Sheet, name: str) -> Layer:
    (found,) = [each for each in sheet.layers if each.name == name]
    return found


def disc(sheet: Sheet, format: str) -> tuple[float, float, float]:
    """Where the one disc of a page lies and its diameter, as a renderer shows it, in mm."""
    window = Window(0, 0, *np.ceil(sheet.size).astype(int).tolist())
    data = formats.to_bytes(Sheet(window[2:], sheet.layers), format)
    ((x, y),), (wide,) = dots(SEEN[format](data, window, FINE), window, FINE)
    return x, y, wide


@pytest.mark.parametrize("format", ["svg", "pdf"])
@pytest.mark.parametrize(("at", "width"), [((31.234, 17), None), ((10, 5.001), 12.345)])
def test_a_drawing_lies_where_the_plate_puts_it_within_a_micrometre(format: str, at: tuple[float, float], width: float | None) -> None:
    panel = {"drawing": "disc.svg", "at": list(at), "letter": "", **({"width": width} if width else {})}
    x, y, wide = disc(drawn(panel, width=60, page={"height": 40}), format)
    times = (width or 20) / 20
    assert (x, y) == pytest.approx((at[0] + 10 * times, at[1] + 5 * times), abs=UM)
    assert wide == pytest.approx(8 * times, abs=2 * UM)  # pdfium draws discs 1.5 um too large


def test_the_ruler_sees_a_drawing_that_is_two_micrometres_off() -> None:
    sheet = drawn({"drawing": "disc.svg", "at": [10.002, 5], "letter": ""}, width=40, page={"height": 20})
    assert disc(sheet, "pdf")[0] - 20 > UM


def bar_length(sheet: Sheet, format: str) -> float:
    """The length of the ink along the middle of a scale bar, as a renderer shows it at 1270 dpi, in mm."""
    middle = layer(sheet, "A scale bar").art.xy[:, 1].mean()
    window = Window(0, round(middle, 2) - 0.1, 100, 0.2)
    data = formats.to_bytes(sheet, format)
    ink = resvg(data, window, BAR) if format == "svg" else poppler(data, window, BAR)  # pdfium snaps rectangles to pixels
    return float(ink[len(ink) // 2].sum() / BAR)


@pytest.mark.parametrize("format", ["svg", "pdf"])
@pytest.mark.parametrize(
    ("said", "length"),
    [
        ({"scale": "1 mm = 250 um", "scale_bar": "2 mm"}, 8.0),
        ({"scale": "1 mm in the figure = 2.5 um in the specimen", "scale_bar": "30 µm"}, 12.0),
        ({"pixel": "1.3 um", "scale_bar": "10 um"}, 96 / 40 * 10 / 1.3),  # 96 mm for 40 pixels
    ],
    ids=["a scale", "a long scale", "a pixel"],
)
def test_a_scale_bar_is_as_long_as_it_says_within_ten_micrometres(format: str, said: Table, length: float) -> None:
    sheet = drawn({"picture": "white.png", **said}, page={"margin": "2 mm"})
    assert bar_length(sheet, format) == pytest.approx(length, abs=0.01)


def test_the_ruler_sees_a_bar_that_is_too_long() -> None:
    sheet = drawn({"picture": "white.png", "scale": "1:1", "scale_bar": "10.02 mm"}, page={"margin": "2 mm"})
    assert bar_length(sheet, "svg") - 10 > 0.01


def test_poppler_shows_the_words_where_the_sheet_has_them() -> None:
    sheet = drawn(picture(picture="white.png", letter="B"), page={"height": "80 mm"}, letters={"size": "6 mm"})
    ink = poppler(formats.to_bytes(sheet, "pdf"), Window(0, 0, 20, 20), 20)
    rows, columns = np.nonzero(ink > 0.5)
    outline = layer(sheet, "B letter").art.outlines().flat(1e-3).xy
    assert np.array([columns.min(), rows.min()]) / 20 == pytest.approx(outline.min(axis=0), abs=0.06)  # a pixel is .05 mm


@pytest.mark.parametrize(("name", "columns", "width"), [(name, k + 1, w) for name, j in JOURNALS.items() for k, w in enumerate(j.widths)])
def test_a_figure_is_as_wide_as_the_journals_columns(name: str, columns: int, width: float) -> None:
    sheet = plate.drawn({"page": {"journal": name, "columns": columns}, "panel": [picture()]})
    assert sheet.size[0] == width
    assert sheet.size[1] == pytest.approx((width - 1) * 3 / 4 + 1, abs=UM)
    letter = layer(sheet, "a letter" if JOURNALS[name].letters == "a" else "A letter").art
    least = JOURNALS[name].least
    assert (letter.font, letter.size[0] >= (least or 0)) == ("bold", True)


def test_widths_are_those_that_journals_state() -> None:
    widths = {name: journal.widths for name, journal in JOURNALS.items()}
    assert widths == {
        "springer": (84, 174), "elsevier": (90, 190), "micropaleontology": (178,), "aalas": (89, 187),
        "amnh": (70, 145), "aiaa": (82,), "nature": (89, 183),
    }  # fmt: skip
    assert JOURNALS["amnh"].height == 203 and JOURNALS["micropaleontology"].height == 241
    assert all(journal.source for journal in JOURNALS.values())


def test_a_plate_of_tall_panels_is_no_higher_than_the_journals_page() -> None:
    panels = [picture(caption="*Genus species*, seen from above") for _ in range(3)]
    sheet = plate.drawn({"page": {"journal": "amnh"}, "panel": panels})
    assert sheet.size == (145, 203)
    heights = [each["art_mm"][1] for each in sheet.report["panels"]]
    assert max(heights) - min(heights) < UM and heights[0] < 145 * 3 / 4


def test_lettering_that_is_too_small_for_the_journal_is_said() -> None:
    sheet = plate.drawn({"page": {"journal": "aalas"}, "letters": {"size": "6 pt"}, "panel": [picture()]})
    assert sheet.report["warnings"][0] == "letters of 6 pt is smaller than aalas takes, 11.7 pt"


def test_panels_go_into_rows_and_columns_with_gutters_and_spans() -> None:
    wide, cell = picture(span=[1, 2]), picture(cell=[3, 2])
    sheet = drawn(picture(), wide, picture(), cell, grid={"columns": 2, "gutter": 6})
    at = [each["at_mm"] for each in sheet.report["panels"]]
    small, high = 47 * 3 / 4, 100 * 3 / 4
    rows = [0, small + 6, small + 6 + high + 6]
    assert np.ravel(at) == pytest.approx([0, rows[0], 0, rows[1], 0, rows[2], 53, rows[2]], abs=UM)
    assert sheet.size[1] == pytest.approx(rows[2] + small, abs=UM)


def test_layers_are_named_by_letter_and_style_and_stay_apart() -> None:
    two = {"layer": [{"ink": "red", "tone": {"gamma": 2}, "knobs": QUICK}, {"style": "cells", "knobs": QUICK}], "picture": "grey.png"}
    sheet = drawn(picture(letter="C1"), two, picture(letter=""), inks={"red": {"cmyk": [0, 1, 1, 0], "spot": True, "overprint": True}})
    names = [each.name for each in sheet.layers]
    assert names[0] == "C1 stipple" and names[1] == "A stipple" and names[2].startswith("A cells") and "3 stipple" in names
    assert layer(sheet, "A stipple").ink == Ink("red", (0, 1, 1, 0), spot=True, overprint=True)
    assert layer(sheet, "C1 stipple").ink == Ink()
    assert isinstance(layer(sheet, "A stipple").art, Marks)


def test_layers_of_one_picture_have_seeds_of_their_own_and_a_stated_seed_is_kept() -> None:
    both = [{"knobs": QUICK}, {"knobs": QUICK}, {"knobs": QUICK, "seed": 0}]
    sheet = drawn({"picture": "grey.png", "layer": both, "letter": ""})
    first, second, third = (each.art.xy for each in sheet.layers)
    assert first.tolist() == third.tolist() != second.tolist()


def test_a_panel_draws_what_a_single_drawing_of_its_recipe_is() -> None:
    from crowquill.making import laid_out, steps
    from crowquill.recipe import PICTURE, Recipe
    from crowquill.styles import run

    sheet = drawn(picture(seed=7, letter=""), page={"height": "80 mm"})
    wanted = Recipe("stipple", 7, paper={"paper": "100x75mm", "margin": 0.0}, knobs=QUICK)
    paths = {PICTURE: Path("grey.png")}
    alone = run(steps(wanted, paths, *laid_out(wanted, paths)))
    assert sheet.layers[0].art.xy.tolist() == alone.layers[0].art.xy.tolist()


def test_no_dot_lies_under_letter_or_bar() -> None:
    panel = {"picture": "grey.png", "knobs": {"pen": 0.5}, "scale": "1:1", "scale_bar": "10 mm"}
    sheet = drawn(panel, width=60, bars={"position": "inside"})
    art = layer(sheet, "A stipple").art
    assert len(art) > 1000
    reach = art.scale.max() / 2
    for name in ("A letter", "A scale bar", "A scale bar 10 mm"):
        words = layer(sheet, name).art
        xy = words.xy if isinstance(words, Paths) else words.outlines().flat(1e-3).xy
        inside = ((art.xy > xy.min(axis=0) - reach) & (art.xy < xy.max(axis=0) + reach)).all(axis=1)
        assert not inside.any(), name


def test_letters_and_bars_above_and_below_take_room_of_their_own() -> None:
    words = {"letters": {"position": "above", "style": "a"}, "bars": {"position": "below"}}
    sheet = drawn(picture(scale="1:1", scale_bar="10 mm", caption="Below."), **words)
    ((_, top),) = [each["at_mm"] for each in sheet.report["panels"]]
    bottom = top + sheet.report["panels"][0]["art_mm"][1]
    assert layer(sheet, "a letter").art.outlines().flat(1e-3).xy[:, 1].min() >= 0 and layer(sheet, "a letter").art.xy[0, 1] < top
    bar, below = layer(sheet, "a scale bar 10 mm").art.outlines().flat(1e-3).xy, layer(sheet, "a caption").art
    assert bar[:, 1].min() > bottom and below.outlines().flat(1e-3).xy[:, 1].min() > layer(sheet, "a scale bar").art.xy[:, 1].max()
    assert sheet.size[1] > below.xy[0, 1]


def test_a_picture_with_pixel_and_scale_has_the_size_they_give() -> None:
    sheet = drawn(picture(pixel="2 um", scale="1 mm = 4 um"))
    assert sheet.report["panels"][0]["art_mm"] == [20, 15]  # 40 pixels of 2 um at 250:1


def test_captions_wrap_within_their_width_and_stars_choose_the_face() -> None:
    text = "Fig. 2. *Hoplites dentatus*, lateral; **b** more words that take a second line and a third"
    found = caption(text, 40.0, 8 * POINT, FACES)
    for line in found.lines:
        assert all(x + lettering.width(words, found.size, FACES[face]) <= 40 + 1e-9 for words, face, x in line)
    pieces = [(words, face) for line in found.lines for words, face, _ in line]
    assert ("Fig. 2. ", "regular") in pieces and pieces[1][1] == "italic" and ("b ", "bold") in pieces
    together = " ".join("".join(words for words, _, _ in line).strip() for line in found.lines)
    assert together == text.replace("*", "")


@pytest.mark.parametrize("text", ["", "  \n ", "*", "5 * 3", "**", "*a* **b**"])
def test_captions_of_any_stars_are_set(text: str) -> None:
    found = caption(text, 40.0, 3.0, FACES)
    assert found.height >= 0 and len(found.lines) == bool(text.strip())


def test_a_drawing_of_ours_comes_without_its_paper_and_says_what_it_leaves_there() -> None:
    marks = Marks.of([(3, 3), (7, 4)], drawn(picture()).layers[0].art.glyphs, scale=1.0)
    own = Sheet((10, 8), (Layer(Ink(), marks),)).on("a5")
    bar = Layer(Ink(), Paths.of([[(20, 200), (30, 200), (30, 201)]]), "check bar 10 mm")
    formats.save(Sheet(own.size, (*own.layers, bar), own.recipe), "ours.svg")
    sheet = drawn({"drawing": "ours.svg", "at": [5, 6], "letter": ""}, page={"height": 30})
    assert layer(sheet, "1 black").art.xy.tolist() == [[8, 9], [12, 10]]
    assert sheet.report["warnings"] == ["panel 1: ours.svg: check bar 10 mm stands beside the drawing on its paper and is left out"]


def test_all_words_of_a_page_are_in_its_own_font() -> None:
    Path("own.ttf").write_bytes(lettering.file("italic").read_bytes())
    panel = picture(scale="1:1", scale_bar="10 mm", caption="Below.")
    sheet = drawn(panel, page={"caption": "*Genus*"}, text={"font": "own.ttf"})
    fonts = {each.name: each.art.font for each in sheet.layers if isinstance(each.art, lettering.Words)}
    assert set(fonts) == {"A letter", "A scale bar 10 mm", "A caption", "caption italic"} and set(fonts.values()) == {"own.ttf"}
    bar, label = layer(sheet, "A scale bar").art.xy[:, 0], layer(sheet, "A scale bar 10 mm").art
    middle = label.xy[0, 0] + lettering.width("10 mm", label.size[0], "own.ttf") / 2
    assert middle == pytest.approx(bar.mean(), abs=2 * UM)
    assert sheet.report["warnings"] == ["a font of your own is given without its italic or bold, and words in stars are set like the rest"]
