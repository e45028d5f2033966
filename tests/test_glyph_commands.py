"""Libraries on the command line: a page of dots is scanned, listed, shown, drawn with; what was rejected is shown with the reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import crowquill
from crowquill import contact, glyphs
from crowquill.__main__ import main
from crowquill.marks import Marks
from crowquill.paths import Paths

PIXELS = 1200 / 25.4  # to the mm
WIDE = 0.3  # mm, of the dots of the page


def page(name: str, *, dots: int = 12, dust: int = 3, pairs: int = 2, dpi: float | None = 1200) -> None:
    """A scan of discs in rows a millimetre apart, of specks, and of discs that touch, in 8 bits, blurred by a pixel's width."""
    size = (400, 400)
    y, x = np.mgrid[: size[0], : size[1]] + 0.5
    light = np.full(size, 0.9)
    places = [(1 + k % 6, 1 + k // 6) for k in range(dots)]
    discs = [(*place, WIDE) for place in places] + [(1 + k, 6, 0.05) for k in range(dust)]
    discs += [(1.5 + 1.5 * k + side, 4.5, WIDE) for k in range(pairs) for side in (-0.145, 0.145)]
    for a, b, wide in discs:
        cover = np.clip(wide / 2 * PIXELS - np.hypot(x - a * PIXELS, y - b * PIXELS) + 0.5, 0, 1)
        light = np.minimum(light, 0.9 - 0.85 * cover)
    Image.fromarray(np.round(255 * np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)).astype(np.uint8)).save(
        name, **({"dpi": (dpi, dpi)} if dpi else {})
    )


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_scan_becomes_a_library_that_draws(capsys: pytest.CaptureFixture[str]):
    page("scan.png")
    assert main(["glyphs", "scan", "scan.png", "-o", "mine.svg", "--licence", "CC0", "--show", "found.svg"]) == 0
    told = capsys.readouterr().out
    assert "12 dots of 0.30" in told and "2 merged" in told and "3 dust" in told and "1200 dpi" in told
    library = glyphs.load("mine.svg")
    assert library.name == "mine" and len(library.glyphs) == 12
    assert (library.about["pen_mm"], library.about["licence"], library.about["simulated"]) == (0.3, "CC0", False)
    assert np.array([glyph.size for glyph in library.glyphs]) == pytest.approx(WIDE, abs=0.003)  # 3 um of 300
    Image.new("L", (30, 20), 90).save("grey.png")
    assert main(["stipple", "grey.png", "out.svg", "--glyphs", "mine.svg", "--width", "20mm", "--iterations", "1", "--quiet"]) == 0
    assert len(crowquill.load("out.svg").marks.glyphs) == 12


def test_what_was_found_and_what_was_not_is_drawn_where_it_lay():
    page("scan.png")
    assert main(["glyphs", "scan", "scan.png", "-o", "mine.svg", "--show", "found.svg"]) == 0
    layers = {layer.label: layer for layer in crowquill.load("found.svg").layers if layer.name}
    assert len(layers["12 dots"].art) == 12 and {"2 merged", "3 dust"} <= set(layers)
    boxes, ink = layers["2 merged"].art, layers["2 merged"].ink
    assert isinstance(boxes, Paths) and len(boxes) == 2 and ink.cmyk != layers["3 dust"].ink.cmyk
    room = crowquill.load("found.svg").size[1] - 400 / PIXELS
    middle = np.array([ring.mean(axis=0) for ring in boxes]) - (0, room)
    assert middle == pytest.approx(np.array([[1.5, 4.5], [3, 4.5]]), abs=2 / PIXELS)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--name", "1st"], "name '1st'"),
        (["--pen", "50mm"], "pen_mm"),
        (["--invert"], "invert"),
        (["--show", "mine.svg"], "named twice"),
    ],
)
def test_what_no_library_can_be_made_of_is_refused(options: list[str], says: str, capsys: pytest.CaptureFixture[str]):
    page("scan.png")
    assert main(["glyphs", "scan", "scan.png", "-o", "mine.svg", *options]) == 2
    line = capsys.readouterr().err
    assert says in line and line.count("\n") == 1 and not Path("mine.svg").exists()


def test_a_name_is_made_of_the_files_own_where_none_is_given():
    page("scan.png", pairs=0, dust=0)
    for out, name in (("3 nib (old).svg", "nib-old-"), ("漢.svg", "dots")):
        assert main(["glyphs", "scan", "scan.png", "-o", out]) == 0
        assert glyphs.load(out).name == name


def test_the_list_has_every_library_and_says_which_are_simulated(capsys: pytest.CaptureFixture[str]):
    assert main(["glyphs", "list"]) == 0
    rows = {line.split()[0]: line for line in capsys.readouterr().out.splitlines()}
    assert set(rows) == set(glyphs.names())
    assert all(("simulated" in row) == glyphs.load(name).about["simulated"] for name, row in rows.items())


@pytest.mark.parametrize("name", glyphs.names())
def test_a_library_on_a_page_has_its_dots_at_true_size_and_enlarged_alike(name: str):
    library = glyphs.load(name)
    sheet = contact.of_library(library)
    large, true = (layer.art for layer in sheet.layers if isinstance(layer.art, Marks))
    assert len(large) == len(true) == min(len(library.glyphs), contact.MOST)
    # scales are whole micrometres
    assert true.scale == pytest.approx([glyph.size * np.sqrt(np.pi) / 2 for glyph in library.glyphs][: len(true)], abs=6e-4)
    assert large.scale / true.scale == pytest.approx(np.full(len(true), np.median(large.scale / true.scale)), rel=0.01)
    for layer in sheet.layers:
        outlines = layer.art.outlines() if isinstance(layer.art, Marks) else layer.art
        assert (outlines.xy > 0).all() and (outlines.xy < sheet.size).all()


def test_a_page_is_written_in_each_format_and_says_simulated(capsys: pytest.CaptureFixture[str]):
    assert main(["glyphs", "show", "nib-03", "-o", "a.pdf", "-o", "a.svg"]) == 0
    assert "210 x 297 mm: a.pdf, a.svg" in capsys.readouterr().out
    assert Path("a.pdf").stat().st_size > 10_000 and crowquill.load("a.svg").size == (210, 297)


def test_a_library_without_metadata_is_shown_as_what_it_is():
    Path("dot.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg"><path d="M1 0C1 1 0 1 0 0C0 -1 1 -1 1 0Z"/></svg>', encoding="utf-8"
    )
    assert main(["glyphs", "show", "dot.svg", "-o", "a.svg"]) == 0
    assert len(crowquill.load("a.svg").marks) == 1
