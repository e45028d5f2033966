"""Every script of the gallery is one picture: short, whole, on its paper, and the one that README shows."""

from __future__ import annotations

import ast
import io
import re
import runpy
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pypdfium2 import PdfDocument

from crowquill import Ink, Layer, Paths, Sheet, load, to_bytes
from crowquill.sheet import Bitmap, outlined
from crowquill.units import POINT, paper

GALLERY = Path(__file__).resolve().parents[1] / "gallery"
SCRIPTS = sorted(GALLERY.glob("*.py"))
# at their own sizes, in mm, they take ten seconds and more
SMALLER = {"plate": {"width": 50.0}, "sizes": {"width": 50.0}, "duotone": {"width": 40.0}}
SMALLER |= {"four_inks": {"width": 30.0}, "two_inks": {"width": 30.0}}
SMALLER |= {"figure_3_11": {"width": 40.0}, "figure_3_12": {"tile": 5.0}, "mixed_plate": {"tile": 4.0}, "stone_plate": {"tile": 4.0}}
SMALLER |= {"figure_3_13": {"width": 40.0}, "ink_dots": {"width": 30.0}}
SMALLER |= {"journal_plate": {"pen": 0.6}, "outline": {"pen": 0.8}}
SMALLER |= {"hedcut": {"pen": 0.9}, "isophote": {"pen": 0.9}, "edges": {"fine": 0.6, "broad": 0.9, "iterations": 3}}
SMALLER |= {"contrast": {"dots": 900}, "frontier": {"every": 900}}
SMALLER |= {"wall": {"width": 60.0}}
SMALLER |= {"comparison": {"dots": 600, "styles": ("stipple", "contrast")}}
COLOURED = {"measures", "plotter", "duotone", "figure_3_12", "editor", "editor_objects", "four_inks", "two_inks", "still_life"}
KILOBYTES = {"plate": 900, "specimen": 2500}  # of a PNG; 400 for the others
SAVED = """if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
"""


def check_script(source: str) -> None:
    """Under 40 lines; a docstring with size and source; make() -> Sheet and nothing else defined; saved as every other is."""
    tree = ast.parse(source)
    about = ast.get_docstring(tree) or ""
    made = [node for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.Lambda, ast.AsyncFunctionDef))]
    names = [getattr(node, "name", "lambda") for node in made]
    assert len(source.splitlines()) < 40, f"{len(source.splitlines())} lines"
    assert re.search(r"\.\n.*^Size on paper: .*\.\n^Source: .*\.$", about, re.DOTALL | re.MULTILINE), f"docstring says {about!r}"
    assert [name for name in names if name != "lambda"] == ["make"], f"it defines {names}"
    assert "def make(" in source and ") -> Sheet:" in source, "make does not say that it gives a Sheet"
    assert source.endswith(SAVED), "it does not end in the lines that save it"


def check_on_paper(sheet: Sheet) -> None:
    """There are layers, each has art, and all of it, the width of its strokes too, lies on the paper."""
    assert sheet.layers, "the sheet has no layers"
    for layer in sheet.layers:
        assert len(layer.art), f"layer {layer.label!r} is empty"
        ends = [layer.art.corner, layer.art.corner + layer.art.size] if isinstance(layer.art, Bitmap) else outlined(layer.art).xy
        half = (layer.ink.pen or 0.0) / 2
        low, high = np.min(ends, axis=0) - half, np.max(ends, axis=0) + half
        assert (low >= 0).all() and (high <= sheet.size).all(), f"layer {layer.label!r} runs from {low} to {high} on {sheet.size}"


def stated_size(source: str) -> tuple[float, float]:
    """Width and height in mm that a script's docstring gives its paper."""
    size = re.search(r"Size on paper: (A\d|[\d.]+ x [\d.]+ mm)", ast.get_docstring(ast.parse(source)) or "")
    assert size, "no size such as 90 x 90 mm"
    return paper(size[1].replace(" ", ""))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_is_short_and_says_what_it_shows(script: Path) -> None:
    check_script(script.read_text(encoding="utf-8"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_makes_the_sheet_it_promises(script: Path) -> None:
    sheet = runpy.run_path(str(script))["make"](**SMALLER.get(script.stem, {}))
    assert isinstance(sheet, Sheet)
    check_on_paper(sheet)
    assert sheet.size == pytest.approx(stated_size(script.read_text(encoding="utf-8")), abs=0.5)  # mm: whole ones are stated
    page = PdfDocument(to_bytes(sheet, "pdf"))[0]
    assert np.array(page.get_size()) * POINT == pytest.approx(sheet.size, abs=1e-3)  # mm: points are written with 9 decimals
    again = load(io.BytesIO(to_bytes(sheet, "svg")))
    assert again.size == sheet.size and [len(layer.art) for layer in again.layers] == [len(layer.art) for layer in sheet.layers]


def test_a_script_that_is_run_saves_beside_itself(tmp_path: Path) -> None:
    copy = shutil.copy(GALLERY / "figure_3_5a.py", tmp_path)
    runpy.run_path(copy, run_name="__main__")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"figure_3_5a.pdf", "figure_3_5a.svg"}


def test_every_script_has_its_picture_and_every_picture_its_place() -> None:
    page = (GALLERY / "README.md").read_text(encoding="utf-8")
    pictures = {path.stem: path for path in GALLERY.glob("*.png")}
    assert set(pictures) == {path.stem for path in SCRIPTS} | {
        "plate_detail",
        "specimen",
        "portrait",
        "still_life",
        "editor",
        "editor_objects",
    }
    assert set(re.findall(r"!\[.+\]\((.+)\.png\)", page)) == set(pictures)
    assert set(re.findall(r"^## \[.+\.py\]\((.+)\.py\)$", page, re.MULTILINE)) == {path.stem for path in SCRIPTS}


@pytest.mark.parametrize("picture", sorted(GALLERY.glob("*.png")), ids=lambda path: path.stem)
def test_a_picture_is_small_and_grey(picture: Path) -> None:
    assert picture.stat().st_size < 1000 * KILOBYTES.get(picture.stem, 400)
    with Image.open(picture) as image:
        grey = image.mode == "I;16" or not np.ptp(np.asarray(image.convert("RGB")), axis=2).any()
        assert grey != (picture.stem in COLOURED)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda source: source.replace("\n\n", "\n\n\n\n\n"), "lines"),
        (lambda source: source.replace("Source: ", "By: "), "docstring"),
        (lambda source: source.replace("def make", "def help():\n    pass\n\n\ndef make"), "defines"),
        (lambda source: source.replace(" -> Sheet", ""), "gives a Sheet"),
        (lambda source: source.replace(".svg", ".gcode"), "save"),
    ],
    ids=["long", "no source", "a helper", "no type", "saved otherwise"],
)
def test_a_script_that_breaks_a_rule_is_found(change, found: str) -> None:
    with pytest.raises(AssertionError, match=found):
        check_script(change((GALLERY / "figure_3_5a.py").read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("layers", "found"),
    [
        ((), "no layers"),
        ((Layer(Ink(), Paths.of([])),), "is empty"),
        ((Layer(Ink(), Paths.of([[(1, 1), (11, 1), (1, 2)]])),), "runs from"),
        ((Layer(Ink(pen=0.4), Paths.of([[(0.1, 1), (5, 1)]], closed=False)),), "runs from"),
    ],
    ids=["nothing", "no art", "off the paper", "half a stroke off"],
)
def test_art_that_is_not_on_the_paper_is_found(layers: tuple[Layer, ...], found: str) -> None:
    with pytest.raises(AssertionError, match=found):
        check_on_paper(Sheet((10, 10), layers))
