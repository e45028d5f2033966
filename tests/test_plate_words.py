"""Words of plates: what their fonts lack is said by panel and refused where a PDF needs it; and they stand by their pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fontTools.ttLib import TTFont
from PIL import Image

from crowquill import formats, lettering, plate
from crowquill.sheet import Layer, Sheet

UM = 1e-3  # mm
QUICK = {"dots": 60, "iterations": 2}
BOXES = "; empty boxes stand there, and no PDF can be written: choose other words, or another font"
Table = dict[str, Any]


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The current folder, with a grey picture of 40 x 30 pixels, and a font without the letters that are no ASCII."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.full((30, 40), 150, np.uint8)).save("grey.png")
    font = TTFont(lettering.file("regular"))
    for table in font["cmap"].tables:
        table.cmap = {code: glyph for code, glyph in table.cmap.items() if code < 127}
    font.save("plain.ttf")


def picture(**more: Any) -> Table:
    return {"picture": "grey.png", "knobs": QUICK, **more}


def table(*panels: Table, width: float = 100.0, **more: Any) -> Table:
    return {"page": {"width": width, "margin": 0, **more.pop("page", {})}, "panel": list(panels), **more}


def layer(sheet: Sheet, name: str) -> Layer:
    (found,) = [each for each in sheet.layers if each.name == name]
    return found


def test_letters_that_a_font_lacks_are_each_told_once_in_order() -> None:
    assert lettering.lacking("Möwe 鷗鷗ζ", "regular") == "ζ鷗"
    assert lettering.lacking("", "bold") == ""


LACKING: list[tuple[Table, str]] = [
    (table(picture(), page={"caption": "菊石 ζ"}), "page: caption: font regular has no ζ (U+03B6), 石 (U+77F3), 菊 (U+83CA)"),
    (table(picture(), picture(caption="of *ζ* only")), "panel 2: caption italic: font italic has no ζ (U+03B6)"),
    (table(picture(caption="of **β** only")), "panel 1: caption bold: font bold has no β (U+03B2)"),
    (table(picture(letter="β")), "panel 1: letter: font bold has no β (U+03B2)"),
    (
        table(picture(scale="1:1", scale_bar="9000 um"), text={"font": "plain.ttf"}),
        "panel 1: scale bar 9000 µm: font plain.ttf has no µ (U+00B5)",
    ),
    (table(picture(caption="".join(map(chr, range(0x4E00, 0x4E20))))), "panel 1: caption: font regular has no 一 (U+4E00), "),
]


@pytest.mark.parametrize(("data", "says"), LACKING, ids=[says.split(":")[1].strip() + str(k) for k, (_, says) in enumerate(LACKING)])
def test_letters_that_a_face_lacks_are_refused_before_a_pdf_and_noted_for_other_formats(data: Table, says: str) -> None:
    opened = plate.opened(data)
    with pytest.raises(ValueError, match="; ") as error:
        opened.foresee_pdf()
    said = str(error.value)
    assert said.startswith(f"plate: {says}") and said.count("\n") == 0 and len(said) < 240
    sheet = plate.drawn(data)
    (note,) = [note for note in sheet.report["warnings"] if "empty boxes" in note]
    assert note.startswith(says) and note.endswith(BOXES)
    assert formats.to_bytes(sheet, "svg")
    with pytest.raises(ValueError, match="is not in font"):  # and so says the format, which knows no panels
        formats.to_bytes(sheet, "pdf")


def test_a_plate_file_with_words_that_its_fonts_have_is_made_into_a_pdf() -> None:
    opened = plate.opened(table(picture(caption="Möwe *µ* **ß**", scale="1:1", letter="Å")))
    opened.foresee_pdf()
    assert not opened.composition.notes


def test_a_font_that_no_pdf_may_hold_is_refused_before_the_work() -> None:
    font = TTFont(lettering.file("regular"))
    font["OS/2"].fsType = 2
    font.save("own.ttf")
    Path("my.toml").write_text('[page]\nwidth = 50\n[text]\nfont = "own.ttf"\n[[panel]]\npicture = "grey.png"\n')
    with pytest.raises(ValueError, match=r"^my\.toml: own\.ttf: its licence forbids embedding; give another font$"):
        plate.opened("my.toml").foresee_pdf()


def test_equal_pictures_in_a_column_are_equal_where_one_has_a_caption() -> None:
    panels = [picture(), picture(caption="A caption."), picture()]
    sheet = plate.drawn({"page": {"journal": "nature", "columns": 1, "height": "160 mm"}, "panel": panels})
    sizes = np.array([each["art_mm"] for each in sheet.report["panels"]])
    assert np.ptp(sizes, axis=0).max() < UM and sizes[0, 1] < 88 * 3 / 4
    assert sheet.size == (89, 160)


def test_pictures_on_a_page_that_is_too_low_shrink_by_one_factor() -> None:
    panels = [picture(), picture(caption="A caption. " * 9), picture(span=[1, 2], letter=""), picture(width="20 mm", letter="")]
    words = {"grid": {"columns": 2, "widths": [40, 56]}, "letters": {"position": "above"}}
    free, low = (plate.drawn(table(*panels, page=page, **words)) for page in ({}, {"height": "100 mm"}))
    sizes = [np.array([each["art_mm"] for each in sheet.report["panels"]]) for sheet in (free, low)]
    factors = (sizes[1] / sizes[0])[:3]
    assert np.ptp(factors) < 2e-4 and factors.max() < 0.9, "of micrometres to a side of 20 mm and more"
    assert sizes[1][3].tolist() == [20, 15], "what has a stated size keeps it"
    assert low.size == (100, 100)


def test_a_page_with_no_room_but_for_words_is_refused() -> None:
    panels = [picture(caption="word " * 90) for _ in range(3)]
    with pytest.raises(ValueError, match=r"^plate: grid: its rows have a room of 42 mm and their words take .* mm; make the page higher"):
        plate.opened(table(*panels, page={"height": "50 mm"}))


def test_letter_and_caption_stand_at_the_left_of_a_picture_that_is_smaller_than_its_cell() -> None:
    above = {"letters": {"position": "above"}}
    sheet = plate.drawn(table(picture(width="30 mm", caption="Short."), **above))
    assert sheet.report["panels"][0]["at_mm"][0] == 35
    assert layer(sheet, "A letter").art.xy[0, 0] == layer(sheet, "A caption").art.xy[0, 0] == 35


def test_a_caption_wider_than_its_picture_stays_in_its_cell() -> None:
    sheet = plate.drawn(table(picture(width="30 mm", caption="some words " * 20)))
    ink = layer(sheet, "A caption").art.outlines().flat(1e-3).xy[:, 0]
    assert 0 <= ink.min() < 35 and 95 < ink.max() <= 100


def test_no_picture_gives_way_to_its_scale_bar_unless_that_is_asked_for() -> None:
    panel = picture(scale="1:1", scale_bar="10 mm")
    below, inside = (plate.drawn(table(panel, width=60, **more)) for more in ({}, {"bars": {"position": "inside"}}))
    bottom = below.report["panels"][0]["art_mm"][1]
    assert layer(below, "A scale bar").art.xy[:, 1].min() > bottom > layer(inside, "A scale bar").art.xy[:, 1].max()


def test_a_plate_of_ready_drawings_counts_their_marks() -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm"><circle cx="5" cy="5" r="4"/><rect width="3" height="2"/></svg>'
    Path("two.svg").write_text(svg)
    sheet = plate.drawn(table({"drawing": "two.svg"}))
    formats.save(plate.drawn(table(picture(), width=20)), "ours.svg")
    both = plate.drawn(table({"drawing": "two.svg"}, {"drawing": "ours.svg"}))
    assert sheet.report["marks"] == 2 and both.report["marks"] >= 62
