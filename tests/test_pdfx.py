"""PDF/X and PDF/A: what each kind asks for is in the file and in accord; checkers know it. The ISO texts were not at hand."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pikepdf
import pytest
from drawings import everything, marks
from printing import black, check_archived, inked, preflight, profile
from rendering import run
from test_pdf import content, plates

from crowquill import formats
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.units import PAPERS

MM = 25.4 / 72  # of a point
SPACES = {
    "pdfxid": "http://www.npes.org/pdfx/ns/id/",
    "pdfx": "http://ns.adobe.com/pdfx/1.3/",
    "xmp": "http://ns.adobe.com/xap/1.0/",
    "xmpMM": "http://ns.adobe.com/xap/1.0/mm/",
    "pdf": "http://ns.adobe.com/pdf/1.3/",
    "dc": "http://purl.org/dc/elements/1.1/",
    "pdfaid": "http://www.aiim.org/pdfa/ns/id/",
    "rdf": "http://www.w3.org/1999/02/22-rdf-syntax-ns#",
}
KINDS = {"x1a": ("1.3", "PDF/X-1:2001"), "x3": ("1.3", "PDF/X-3:2002"), "x4": ("1.6", "PDF/X-4")}
EACH = pytest.mark.parametrize("pdfx", KINDS)


def pdf(sheet: Sheet, **knobs: object) -> bytes:
    return formats.to_bytes(sheet, "pdf", **knobs)


@pytest.fixture
def icc(tmp_path: Path) -> str:
    path = tmp_path / "press.icc"
    path.write_bytes(profile())
    return str(path)


def packet(data: bytes) -> dict[str, str]:
    """Every plain property of the XMP packet, by prefix:name; one that is said twice is an AssertionError."""
    with pikepdf.open(io.BytesIO(data)) as document:
        root = ElementTree.fromstring(bytes(document.Root.Metadata.read_bytes()))
    prefixes = {space: prefix for prefix, space in SPACES.items()}
    found: dict[str, str] = {}
    for about in root.iter(f"{{{SPACES['rdf']}}}Description"):
        for entry in about:
            space, name = entry.tag[1:].split("}")
            key = f"{prefixes.get(space, space)}:{name}"
            assert key not in found, key
            found[key] = "".join(entry.itertext()).strip()
    return found


@pytest.mark.parametrize("size", [PAPERS["a4"], PAPERS["letter"], (100.001, 50.0), (20.0, 30.0)], ids=str)
@pytest.mark.parametrize(
    ("bleed", "marked", "bar"), [(3, True, True), (3, False, False), (0, True, False), (0, False, True), (7.777, True, False)]
)
def test_boxes_are_what_was_asked_for_to_the_micrometre(size: tuple[float, float], bleed: float, marked: bool, bar: bool) -> None:
    sheet = Sheet(size, (Layer(Ink(), marks(9, 5, 5)),))
    data = pdf(sheet, bleed=bleed, marks=marked, colour_bar=bar, pdfx="x1a")
    with pikepdf.open(io.BytesIO(data)) as document:
        made = document.pages[0].obj
        boxes = {name: np.array([float(edge) for edge in made[f"/{name}Box"]]) * MM for name in ("Media", "Bleed", "Trim")}
    assert boxes["Trim"][2:] - boxes["Trim"][:2] == pytest.approx(size, abs=1e-3)
    assert boxes["Bleed"] - boxes["Trim"] == pytest.approx([-bleed, -bleed, bleed, bleed], abs=1e-3)
    assert boxes["Media"][:2].tolist() == [0, 0] and (boxes["Media"][2:] - boxes["Bleed"][2:] >= -1e-3).all()
    assert boxes["Media"][2:] - boxes["Trim"][2:] == pytest.approx(boxes["Trim"][:2], abs=1e-3)  # the trim is in the middle
    told = run("pdfinfo", ["-box", "a.pdf"], {"a.pdf": data}).decode()
    for name, box in boxes.items():  # which prints hundredths of a point: 3.5 um
        said = re.search(rf"{name}Box:(.*)", told)
        assert said and [float(edge) for edge in said[1].split()] == pytest.approx(box / MM, abs=0.0051)


def test_a_page_without_anything_around_it_stays_as_it_was() -> None:
    with pikepdf.open(io.BytesIO(pdf(black(), pdfx="x1a"))) as document:
        assert not {"/BleedBox", "/CropBox", "/ArtBox"} & set(document.pages[0].obj.keys())
        assert document.pages[0].MediaBox == document.pages[0].TrimBox
    assert content(pdf(black(), pdfx="x1a")) == content(pdf(black()))


@EACH
def test_readers_know_each_kind_of_pdfx(pdfx: str, icc: str) -> None:
    version, name = KINDS[pdfx]
    for sheet, own in ((black(), None), (inked(), icc)):
        data = pdf(sheet, pdfx=pdfx, icc=own, marks=True, bleed=3, colour_bar=True)
        told = run("pdfinfo", ["a.pdf"], {"a.pdf": data}).decode()
        assert re.search(rf"PDF version: +{version}\b", told) and re.search(rf"PDF subtype: +{name}\n", told), told
        with pikepdf.open(io.BytesIO(data)) as document:
            assert document.open_metadata().pdfx_status == name
            assert list(document.check_pdf_syntax()) == []
    assert "PDF/X" not in run("pdfinfo", ["a.pdf"], {"a.pdf": pdf(black())}).decode()


@EACH
def test_info_and_xmp_are_in_accord_and_complete(pdfx: str, icc: str) -> None:
    data = pdf(inked(), pdfx=pdfx, icc=icc)
    said = packet(data)
    with pikepdf.open(io.BytesIO(data)) as document:
        info = {key[1:]: str(value) for key, value in document.docinfo.items()}
        assert [len(bytes(part)) for part in document.trailer["/ID"]] == [16, 16] and "/Encrypt" not in document.trailer
    assert info["Title"] == said["dc:title"] and info["Producer"] == said["pdf:Producer"] and info["Creator"] == said["xmp:CreatorTool"]
    assert info["Trapped"] == "/False" and said["pdf:Trapped"] == "False"
    assert info["CreationDate"] == info["ModDate"] == "D:20000101000000Z"
    assert {said[f"xmp:{key}"] for key in ("CreateDate", "ModifyDate", "MetadataDate")} == {"2000-01-01T00:00:00Z"}
    assert said["pdfxid:GTS_PDFXVersion"] == said["pdfx:GTS_PDFXVersion"] == info["GTS_PDFXVersion"] == KINDS[pdfx][1]
    assert info.get("GTS_PDFXConformance") == said.get("pdfx:GTS_PDFXConformance") == ("PDF/X-1a:2001" if pdfx == "x1a" else None)
    assert said["xmpMM:DocumentID"].startswith("uuid:") and said["xmpMM:RenditionClass"] == "default" and said["xmpMM:VersionID"] == "1"
    assert json.loads(said["urn:crowquill:drawing:recipe"]) == {"style": "stipple"}


def intent(data: bytes) -> tuple[dict[str, str], bytes]:
    """What the only output intent says, and the profile in it."""
    with pikepdf.open(io.BytesIO(data)) as document:
        (found,) = document.Root.OutputIntents
        kept = found["/DestOutputProfile"].read_bytes() if "/DestOutputProfile" in found else b""
        return {key[1:]: str(value) for key, value in found.items() if key != "/DestOutputProfile"}, kept


def test_the_printing_condition_is_said_by_the_registry_or_by_its_profile(icc: str) -> None:
    for asked, known in ((None, "FOGRA39"), ("fogra 51", "FOGRA51"), ("CGATS TR001", "CGATS TR 001")):
        said, kept = intent(pdf(inked(), pdfx="x3", output_condition=asked))
        assert said["OutputConditionIdentifier"] == known and said["RegistryName"] == "http://www.color.org" and not kept
        assert said["S"] == "/GTS_PDFX" and said["OutputCondition"] and said["Info"]
    said, kept = intent(pdf(inked(), pdfx="x4", icc=icc))
    assert said["OutputConditionIdentifier"] == "Custom" and said["Info"] == "A press by hand" and kept == profile()
    said, kept = intent(pdf(inked(), pdfx="x4", icc=icc, output_condition="Our press, Tuesdays"))
    assert said["OutputConditionIdentifier"] == "Our press, Tuesdays" and "RegistryName" not in said and kept == profile()
    said, kept = intent(pdf(black(), pdfx="x4"))
    assert said["OutputConditionIdentifier"] == "Custom" and kept[12:20] == b"prtrGRAY"


@EACH
def test_no_device_colours_but_grey_cmyk_and_separations_and_nothing_forbidden(pdfx: str, icc: str) -> None:
    data = pdf(inked(), pdfx=pdfx, icc=icc, marks=True, colour_bar=True)
    code = re.sub(rb"<[0-9a-f]*>", b"", content(data)).split()
    assert not {b"rg", b"RG", b"sc", b"SC", b"ri", b"sh", b"BI"} & set(code)
    with pikepdf.open(io.BytesIO(data)) as document:
        every = b"\n".join(entry.unparse() for entry in document.objects if not isinstance(entry, pikepdf.Stream))
        filters = {str(entry.get("/Filter")) for entry in document.objects if isinstance(entry, pikepdf.Stream)}
        alternates = {str(space[2]) for space in document.pages[0].Resources.ColorSpace.values()}
    for banned in (
        b"DeviceRGB",
        b"ICCBased",
        b"/Lab",
        b"/CalRGB",
        b"/SMask",
        b"/BM",
        b"/ca",
        b"/CA",
        b"/TR",
        b"/HT",
        b"/OPI",
        b"/Annots",
        b"/AA",
    ):
        assert not re.search(banned + rb"\b", every), banned
    assert filters <= {"/FlateDecode", "None"} and alternates == {"/DeviceCMYK", "/DeviceGray"}


def test_black_art_is_on_the_black_plate_alone() -> None:
    cyan, magenta, yellow, key = plates(pdf(black(), pdfx="x1a", bleed=3))
    assert (cyan, magenta, yellow) == (0, 0, 0) and key > 0.01


@pytest.mark.parametrize(
    ("sheet", "knobs"),
    [
        (black(), {}),
        (black(), {"marks": True, "colour_bar": True, "bleed": 3.0, "compact": True}),
        (Sheet((30, 30)), {}),
        (inked(), {"marks": True, "colour_bar": True, "icc": True}),
        (everything(), {"icc": True}),
    ],
    ids=["black", "black, dots as characters, with marks", "nothing", "spot inks, with marks", "everything"],
)
def test_pdfbox_finds_valid_pdfa(sheet: Sheet, knobs: dict[str, object], icc: str) -> None:
    data = pdf(sheet, pdfa=True, **(knobs | ({"icc": icc} if "icc" in knobs else {})))
    check_archived(data)
    assert (packet(data)["pdfaid:part"], packet(data)["pdfaid:conformance"]) == ("1", "B")


def spoiled(data: bytes, what: str) -> bytes:
    with pikepdf.open(io.BytesIO(data)) as document:
        if what == "font":
            for font in document.pages[0].Resources.Font.values():
                del font.DescendantFonts[0].FontDescriptor.FontFile2
        else:
            del document.Root[f"/{what}"]
        document.save(buffer := io.BytesIO())
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("what", "says"), [("OutputIntents", "without Color Profile"), ("Metadata", "Metadata"), ("font", "FontFile entry is missing")]
)
def test_the_check_of_pdfa_fails_for_a_file_without(what: str, says: str) -> None:
    data = spoiled(pdf(black(), pdfa=True), what)
    assert says in preflight(data)
    with pytest.raises(AssertionError, match="not a valid"):
        check_archived(data)


MADE = """
import hashlib, sys
sys.path.insert(0, "tests")
from printing import inked
from crowquill import formats
for knobs in ({"pdfx": "x1a", "marks": True, "colour_bar": True}, {"pdfx": "x3"}, {"compact": True}):
    print(hashlib.sha256(formats.to_bytes(inked(), "pdf", **knobs)).hexdigest())
"""


def test_bytes_are_the_same_in_other_time_zones_and_for_other_hash_seeds() -> None:
    told = [
        subprocess.run(
            [sys.executable, "-c", MADE],
            cwd=Path(__file__).parent.parent,
            env={"TZ": zone, "PYTHONHASHSEED": seed, "LC_ALL": "C", "HOME": "/nonexistent", "PATH": "/usr/bin:/bin"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for zone, seed in (("Pacific/Kiritimati", "1"), ("America/Los_Angeles", "77"))
    ]
    assert told[0] == told[1] and len(set(told[0].split())) == 3


def test_a_build_may_say_its_own_date_and_nothing_else_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    before = pdf(black(), pdfx="x1a")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1780000000")
    after = pdf(black(), pdfx="x1a")
    assert packet(after)["xmp:CreateDate"] == "2026-05-28T20:26:40Z" and content(after) == content(before)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH is 'yesterday'; it takes seconds"):
        pdf(black(), pdfx="x1a")
