"""What files keep beside the drawing: recipe and sources in SVG and PDF, dots apart for retouching, and what notebooks show."""

from __future__ import annotations

import io
import json
import subprocess
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pikepdf
import pytest
from drawings import everything, marks, same
from PIL import Image
from rendering import require

from crowquill import formats
from crowquill.paths import Paths
from crowquill.sheet import SHOWN, Ink, Layer, Sheet

SVG = "{http://www.w3.org/2000/svg}"
FILES = {
    'Möwe & "Ente" <3>.png': bytes(range(256)) * 20_000,  # 5 MB: seven elements of SVG
    "empty.svg": b"",
    "two\nlines.toml": b"a = 1\n",
}
BOTH = pytest.mark.parametrize("format", ["svg", "pdf"])


def kept(sheet: Sheet, format: str, folder: Path) -> tuple[dict[str, object], dict[str, bytes]]:
    """What a file of the sheet keeps, read back from a folder."""
    path = folder / f"a.{format}"
    path.write_bytes(formats.to_bytes(sheet, format))
    return formats.recipe_of(path)


@BOTH
def test_recipe_and_files_come_back_as_they_were(format: str, tmp_path: Path):
    sheet = replace(everything(), attached=FILES)
    recipe, files = kept(sheet, format, tmp_path)
    assert recipe == json.loads(json.dumps(dict(sheet.recipe))) and files == FILES


@BOTH
def test_a_sheet_without_files_keeps_none(format: str, tmp_path: Path):
    assert kept(everything(), format, tmp_path)[1] == {}


def test_a_sheet_loaded_has_its_files_and_saves_the_same_bytes():
    data = formats.to_bytes(replace(everything(), attached=FILES), "svg")
    again = formats.load(io.BytesIO(data))
    assert dict(again.attached) == FILES and formats.to_bytes(again, "svg") == data


def test_no_element_of_an_svg_is_longer_than_readers_bear():
    data = formats.to_bytes(replace(everything(), attached=FILES), "svg")
    assert max(len(element.text or "") for element in ElementTree.fromstring(data).iter()) <= 1_000_000


def test_a_pdf_says_its_recipe_in_sound_xmp_without_dates(tmp_path: Path):
    path = tmp_path / "a.pdf"
    path.write_bytes(formats.to_bytes(replace(everything(), attached=FILES), "pdf"))
    told = subprocess.run([require("pdfinfo"), "-meta", str(path)], capture_output=True, check=True).stdout
    packet = ElementTree.fromstring(told.strip())
    found = packet.find(".//{urn:crowquill:drawing}recipe")
    assert found is not None and json.loads(found.text or "")["style"] == "stipple"
    with pikepdf.open(path) as pdf:
        assert "/Filter" not in pdf.Root.Metadata  # readers look for it plain
        for spec in pdf.attachments.values():
            assert "/CreationDate" not in spec.get_file().obj.Params and "/ModDate" not in spec.get_file().obj.Params
    assert not pikepdf.open(path).check_pdf_syntax()


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda data: data[:400], "not a sound PDF"),
        (lambda data: data.replace(b"<crowquill:recipe>{", b"<crowquill:recipe>["), "recipe is broken"),
        (lambda data: data.replace(b"</rdf:RDF>", b"</rdf:RDX>"), "recipe is broken"),
        (lambda data: data.replace(b"<rdf:RDF", b"<!DF:RDF"), "recipe is broken"),
        (lambda data: data.replace(b"crowquill:recipe>", b"crowquill:recipX>"), "keeps no recipe"),
    ],
    ids=["cut short", "not JSON", "not XML", "a declaration", "another's"],
)
def test_a_pdf_spoilt_is_refused_by_name(spoil, says: str, tmp_path: Path):
    path = tmp_path / "a.pdf"
    data = formats.to_bytes(everything(), "pdf")
    path.write_bytes(spoil(data))
    assert spoil(data) != data
    with pytest.raises(ValueError, match=rf"a\.pdf: .*{says}.*; "):
        formats.recipe_of(path)


def test_an_attachment_that_swells_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "a.pdf"
    path.write_bytes(formats.to_bytes(replace(everything(), attached={"zeros": bytes(10_000_000)}), "pdf"))
    monkeypatch.setattr("crowquill.formats._kept.LIMIT", 1_000_000)
    with pytest.raises(ValueError, match="too large"):
        formats.recipe_of(path)


def dots(n: int) -> Sheet:
    frame = Paths.of([[(5, 5), (45, 5), (45, 45), (5, 45)], [(10, 10), (10, 20), (20, 20), (20, 10)]])
    return Sheet((210, 297), (Layer(Ink(), marks(n)), Layer(Ink("grey", (0, 0, 0, 0.5)), frame)))


def test_separate_dots_are_an_element_each_and_shapes_with_holes_stay_whole():
    sheet = dots(500)
    data = formats.to_bytes(sheet, "svg", separate=True)
    paths = [len(group.findall(f".//{SVG}path")) for group in ElementTree.fromstring(data).findall(f"{SVG}g")]
    assert paths == [len(sheet.marks), 1]
    same(formats.load(io.BytesIO(data)), sheet)
    edited = formats.load(io.BytesIO(data.replace(b'fill="#808080"', b'fill="#808081"')))
    read = edited.layers[0].art
    assert isinstance(read, Paths)
    assert np.allclose(read.areas, sheet.marks.scale**2, rtol=0.02)  # whole micrometres of dots of 300


def test_more_separate_dots_than_editors_bear_are_refused():
    with pytest.raises(ValueError, match="20000; draw fewer"):
        formats.to_bytes(dots(20_500), "svg", separate=True)


def test_a_notebook_shows_an_svg_of_few_dots_and_a_picture_of_any():
    few, many = dots(100), dots(SHOWN + 600)
    assert (few._repr_svg_() or "").startswith("<?xml") and many._repr_svg_() is None
    for sheet in (few, many):
        with Image.open(io.BytesIO(sheet._repr_png_())) as image:
            assert abs(max(image.size) - 900) <= 1 and 200 < np.asarray(image.convert("L")).mean() < 255
