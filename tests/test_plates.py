"""Plates as files: one an ink, the same as Ghostscript makes of the page whose inks are together."""

from __future__ import annotations

import io
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pikepdf
import pytest
from drawings import marks
from PIL import Image
from printing import GOLD, SILVER, black, inked, square
from rendering import LIMIT, require
from scipy import ndimage

from crowquill import formats, forme
from crowquill.__main__ import main
from crowquill.formats import _plates
from crowquill.forme import THIN
from crowquill.sheet import Ink, Layer, Sheet

DPI = 508.0  # 20 pixels to the mm
QUICK = ("--paper", "60x50mm", "--margin", "5mm", "--tone", "grey", "--dots", "80", "--iterations", "2", "--quiet")
Plates = dict[str, npt.NDArray[np.bool_]]


def solid() -> Sheet:
    """Two spot inks, of which one overprints, under black dots; none in tints."""
    return Sheet((100, 80), (*inked().layers[:2], Layer(Ink(), marks(300, 70, 50))), {"style": "stipple"})


def planned(sheet: Sheet, kind: str = "pdf", **values: object) -> dict[str, bytes]:
    """What each file of the plan holds, by its name."""
    found = {}
    for path, fill in _plates.plan(sheet, Path(), "a", kind=kind, values=values):
        fill(buffer := io.BytesIO())
        found[path.name] = buffer.getvalue()
    return found


def ghostscript(data: bytes, device: str, name: str = "out.tif") -> Plates:
    """The pictures that a device of Ghostscript makes of a page, true for ink."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.pdf").write_bytes(data)
        flags = ["-q", "-dBATCH", "-dNOPAUSE", "-dSAFER", f"-sDEVICE={device}", f"-r{DPI:g}", f"-sOutputFile={name}"]
        subprocess.run([require("gs"), *flags, "a.pdf"], cwd=folder, check=True, capture_output=True, timeout=LIMIT)
        found = {}
        for path in sorted(Path(folder).glob("*.tif")):
            with Image.open(path) as image:
                found[path.stem.removeprefix("out")[1:-1]] = ~np.asarray(image.convert("1"))
    return found


def separations(data: bytes) -> Plates:
    """The plates that Ghostscript makes of a page, those without anything but marks left out by their ink."""
    return ghostscript(data, "tiffsep1")


def test_only_the_inks_asked_for_are_on_the_plates_of_a_duotone() -> None:
    duotone = Sheet((60, 50), (Layer(GOLD, square(5, 5, 30, 30)), Layer(Ink(overprint=True), square(20, 20, 30, 20))))
    found = {name: float(ink.mean()) for name, ink in separations(formats.to_bytes(duotone, "pdf")).items()}
    assert set(found) == {"Cyan", "Magenta", "Yellow", "Black", GOLD.name}
    assert found["Cyan"] == found["Magenta"] == found["Yellow"] == 0
    assert found["Black"] == pytest.approx(600 / 3000, abs=2e-3)  # a pixel more on each side
    assert found[GOLD.name] == pytest.approx(900 / 3000, abs=2e-3)  # black overprints: nothing is left out


def test_ink_that_does_not_overprint_leaves_paper_on_the_plate_below() -> None:
    below = Layer(SILVER, square(5, 5, 30, 30))
    for over, left in ((False, 900 - 225), (True, 900)):
        page = Sheet((60, 50), (below, Layer(Ink(overprint=over), square(20, 20, 30, 20))))
        assert separations(formats.to_bytes(page, "pdf"))[SILVER.name].mean() == pytest.approx(left / 3000, abs=2e-3)


def test_our_plates_are_those_that_ghostscript_separates() -> None:
    page = formats.to_bytes(solid(), "pdf", marks=True, bleed=3.0)
    theirs, ours = separations(page), planned(solid(), bleed=3.0)
    assert list(ours) == ["a-Black.pdf", "a-PANTONE_877_C.pdf", "a-Gold_warm.pdf"]
    for name, data in zip(("Black", SILVER.name, GOLD.name), ours.values(), strict=True):
        (mine,) = ghostscript(data, "tiffg4").values()
        assert mine.shape == theirs[name].shape
        assert (mine == theirs[name]).all(), name


def test_plates_in_pixels_are_those_in_pdf() -> None:
    pixels, pages = planned(solid(), "tiff", dpi=DPI, bleed=3.0), planned(solid(), bleed=3.0)
    for (name, data), page in zip(pixels.items(), pages.values(), strict=True):
        with Image.open(io.BytesIO(data)) as image:
            assert image.mode == "1" and image.info["dpi"] == pytest.approx((DPI, DPI))
            mine = ~np.asarray(image)
        (theirs,) = ghostscript(page, "tiffg4").values()
        assert mine.shape == theirs.shape and name.endswith(".tiff")
        # Ghostscript paints every pixel that is touched: ours differ along borders, and nowhere else
        border = ndimage.binary_dilation(theirs, np.ones((3, 3))) & ~ndimage.binary_erosion(theirs, np.ones((3, 3)), border_value=1)
        assert not ((mine ^ theirs) & ~border).any() and border.mean() < 0.02


@pytest.mark.parametrize("kind", ["pdf", "tiff"])
def test_registration_marks_are_at_the_same_place_on_each_plate(kind: str) -> None:
    found = []
    for plate in planned(solid(), kind, dpi=DPI).values():
        (ink,) = [~np.asarray(Image.open(io.BytesIO(plate)))] if kind == "tiff" else ghostscript(plate, "tiffg4").values()
        slug = round(forme.locked(solid(), marks=True).slug * DPI / 25.4)
        found.append(ink[-slug:])  # below the sheet there are marks alone
    assert all((one == found[0]).all() for one in found)
    assert found[0].sum() > 4 * 6 * THIN * (DPI / 25.4) ** 2


def test_a_plate_says_which_it_is_and_keeps_boxes_and_no_picture() -> None:
    for name, data in planned(Sheet(solid().size, solid().layers, {}, {}, {"a.png": b"1"}), bleed=3.0, pdfx="x1a").items():
        with pikepdf.open(io.BytesIO(data)) as document:
            title, page = str(document.docinfo["/Title"]), document.pages[0]
            assert "GTS_PDFX" not in str(document.docinfo) and "/OutputIntents" not in document.Root  # plain: it is no whole page
            assert title.split(": ")[1].replace(" ", "_").replace("(", "").replace(")", "") == name.split("-", 1)[1].removesuffix(".pdf")
            assert [float(edge) * 25.4 / 72 for edge in page.TrimBox] == pytest.approx([11, 11, 111, 91], abs=1e-3)
            assert len(document.attachments) == 0


@pytest.mark.parametrize(
    ("inks", "names"),
    [
        (["Black", "PANTONE 877 C"], ["Black", "PANTONE_877_C"]),
        (["Red", "red", "RED"], ["Red", "red_2", "RED_3"]),
        (["A & B", "A + B", "A_B"], ["A_B", "A_+_B", "A_B_2"]),
        (["a..", "1 (2)"], ["a", "1_2"]),
    ],
)
def test_names_of_files_are_safe_and_differ_whatever_their_case(inks: list[str], names: list[str]) -> None:
    assert _plates.named(inks) == names


def test_what_pixels_cannot_hold_is_refused_with_a_way_out() -> None:
    for sheet, values, said in (
        (black(), {}, "plate 'Black' has 30 % of its ink, and pixels are full or empty; draw in full ink, or write plates as pdf"),
        (solid(), {"colour_bar": True}, "plate 'Black' has 75 % .*; leave out colour-bar, or write plates as pdf"),
        (Sheet((9, 9)), {}, "the drawing has no ink, and so no plates; leave out plates"),
        (Sheet((9, 9), (Layer(Ink(), square(0, 0, 1, 1), fill=np.array([[0, 0, 0, 0.5]])),)), {}, "has 50 % of its ink"),
    ):
        with pytest.raises(ValueError, match=said):
            _plates.plan(sheet, Path(), "a", kind="tiff", values=values)
    with pytest.raises(ValueError, match=r"dpi 4800 makes .* pixels"):
        _plates.foresee((900, 900), kind="tiff", values={"dpi": 4800})


Run = Callable[..., tuple[int, str]]


def films() -> list[str]:
    return sorted(path.name for path in Path("films").iterdir())


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """crowquill stipple ramp.png with these arguments, in a folder that has it: exit code and what stderr says."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(120, 255, 40), (30, 1)).astype(np.uint8)).save("ramp.png")
    (tmp_path / "films").mkdir()

    def ran(*arguments: str) -> tuple[int, str]:
        capsys.readouterr()
        return main(["stipple", "ramp.png", *arguments, *QUICK]), capsys.readouterr().err

    return ran


def test_the_command_line_writes_plates_beside_the_drawing(run: Run) -> None:
    assert run("a.pdf", "--plates", "films", "--bleed", "3mm", "--report", "r.json") == (0, "")
    assert run("a.svg", "--plates", "films", "--plates-as", "tiff", "--dpi", "300") == (0, "")
    assert films() == ["a-Black.pdf", "a-Black.tiff"]
    assert '"films/a-Black.pdf"' in Path("r.json").read_text()
    with Image.open("films/a-Black.tiff") as image:
        assert image.size == tuple(round((side + 22) / 25.4 * 300) for side in (60, 50))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--plates", "none"), "crowquill: none: there is no such folder; make it first"),
        (("--plates", "ramp.png"), "crowquill: ramp.png: is no folder; "),
        (("--plates", "films", "--plates-as", "gif"), "no plates-as 'gif'; there are pdf, tiff"),
        (("--plates-as", "pdf"), "--plates-as is for plates; add --plates DIR"),
        (("--plates", "films", "--plates-as", "tiff", "--colour-bar"), "leave out colour-bar"),
        (("--plates", "films", "--no-overwrite"), "is there already"),
        (("--plates", "films", "--bleed", "3"), "has no unit"),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_a_refusal_is_one_line_and_writes_nothing(run: Run, arguments: tuple[str, ...], says: str) -> None:
    Path("films/b-Black.pdf").write_text("older")
    code, told = run("b.pdf", *arguments)
    assert code == 2 and says in told and told.count("\n") == 1
    assert not Path("b.pdf").exists() and films() == ["b-Black.pdf"]
    assert Path("films/b-Black.pdf").read_text() == "older"


def test_plates_and_drawing_are_written_all_or_none(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_file: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(_plates, "plan", lambda *_, **__: [(Path("films/c-Black.pdf"), full)])
    code, told = run("c.pdf", "--plates", "films")
    assert code == 2 and "films/c-Black.pdf: no space left" in told
    assert not Path("c.pdf").exists() and films() == []
