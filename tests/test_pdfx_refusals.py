"""What PDF/X and PDF/A have no room for, and profiles that are none: each refused in one line with a way out."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms
from printing import SILVER, black, inked, profile, square

from crowquill import formats
from crowquill.formats import _icc, pdf
from crowquill.sheet import Ink, Layer, Sheet


def made(sheet: Sheet, **knobs: object) -> bytes:
    return formats.to_bytes(sheet, "pdf", **knobs)


@pytest.mark.parametrize(
    ("knobs", "says"),
    [
        ({"pdfx": "x1a", "pdfa": True}, "pdfx and pdfa are two kinds of file; choose one"),
        ({"output_condition": "FOGRA39"}, "output_condition is kept by PDF/X and PDF/A alone; add pdfx or pdfa"),
        ({"icc": "press.icc"}, "icc is kept by PDF/X and PDF/A alone; add pdfx or pdfa"),
        (
            {"pdfx": "x3", "output_condition": "fogra"},
            "no output_condition 'fogra' without a profile; there are FOGRA39",
        ),
        ({"pdfx": "x4", "output_condition": "FOGRA39"}, "'FOGRA39' alone is not enough for PDF/X-4; give its profile too"),
        ({"pdfx": "x4", "icc": "press"}, "no icc 'press'; give a file with a suffix"),
        ({"pdfx": "x2"}, "no pdfx 'x2'; there are x1a, x3, x4"),
        ({"bleed": -1}, "bleed is -1; it takes a number from 0 to 100 mm"),
    ],
    ids=str,
)
def test_what_does_not_go_together_is_refused_and_before_the_work_too(knobs: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says) as error:
        made(black(), **knobs)
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match=says):
        formats.foresee([Path("a.pdf")], (100, 80), 1, knobs)


@pytest.mark.parametrize("knobs", [{"pdfx": "x4"}, {"pdfa": True}], ids=str)
def test_colours_without_a_profile_are_refused_where_one_is_embedded(knobs: dict[str, object]) -> None:
    for layer in (Layer(SILVER, square(0, 0, 1, 1)), Layer(Ink("red", (0, 1, 1, 0)), square(0, 0, 1, 1))):
        with pytest.raises(ValueError, match=r"embeds a profile, and none for ink .* comes along; give the \.icc"):
            made(Sheet((50, 50), (layer,)), **knobs)
    with pytest.raises(ValueError, match="PDF/X-4 embeds a profile, and none for ink 'Yellow'"):
        fill = np.array([(0, 0, 0.1, 0)])
        made(Sheet((50, 50), (Layer(Ink(), square(0, 0, 1, 1), fill=fill),)), pdfx="x4")


@pytest.mark.parametrize("knobs", [{"pdfx": "x1a"}, {"pdfx": "x3"}, {"pdfx": "x4"}, {"pdfa": True}], ids=str)
def test_files_inside_and_pages_beyond_measure_are_refused(knobs: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="keeps no files inside, and the picture is to be embedded; leave out embed"):
        made(replace(black(), attached={"a.png": b"1"}), **knobs)
    for size in ((0.5, 100), (100, 6000)):
        with pytest.raises(ValueError, match=r"is not for PDF/.*; it takes 1\.06 to 5080 mm"):
            made(Sheet(size), **knobs)
        assert made(Sheet(size))


def spoilt(what: str) -> bytes:
    whole = profile()
    return {
        "empty": b"",
        "text": b"not a profile at all" * 20,
        "cut short": whole[:-100],
        "one byte more": whole + b"\0",
        "for screens": profile(kind=b"mntr"),
        "of a scanner": profile(kind=b"scnr"),
        "for RGB": profile(space=b"RGB "),
        "its tables missing": profile(broken=True),
        "only a header": (132).to_bytes(4, "big") + whole[4:128] + bytes(4),
    }[what]


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("empty", "is not an ICC profile"),
        ("text", "is not an ICC profile"),
        ("cut short", r"is \d+ bytes of \d+, so damaged or cut short"),
        ("one byte more", "so damaged or cut short"),
        ("for screens", r"is a profile of class 'mntr', not of a press \(prtr\)"),
        ("of a scanner", "class 'scnr'"),
        ("for RGB", "is a profile for 'RGB'"),
        ("its tables missing", "no colours can be made with this profile"),
        ("only a header", "no colours can be made with this profile"),
    ],
)
def test_a_profile_that_is_none_is_refused_by_name(what: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.icc"
    path.write_bytes(spoilt(what))
    with pytest.raises(ValueError, match=rf"bad\.icc: .*{says}.*; ") as error:
        made(inked(), pdfx="x4", icc=str(path))
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match=says.split(";")[0]):
        pdf.foresee((9, 9), 1, pdfx="x4", pdfa=False, output_condition=None, icc=str(path))


def test_profiles_that_are_missing_or_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        made(black(), pdfx="x4", icc=str(tmp_path / "none.icc"))
    (tmp_path / "folder.icc").mkdir()
    with pytest.raises(ValueError, match=r"folder\.icc: is a folder; give a file"):
        made(black(), pdfx="x4", icc=str(tmp_path / "folder.icc"))


def test_newer_and_grey_profiles_are_taken_where_they_may_be(tmp_path: Path) -> None:
    newer, grey = tmp_path / "newer.icc", tmp_path / "grey.icc"
    newer.write_bytes(profile(version=4))
    grey.write_bytes(_icc.grey().data)
    assert made(inked(), pdfx="x4", icc=str(newer)) and made(black(), pdfx="x3", icc=str(grey))
    for knobs in ({"pdfx": "x1a"}, {"pdfx": "x3"}, {"pdfa": True}):
        with pytest.raises(ValueError, match=r"newer\.icc: is a profile of version 4, and PDF/.* takes 2; give an older one, or use x4"):
            made(inked(), icc=str(newer), **knobs)
    with pytest.raises(ValueError, match=r"grey\.icc: is for GRAY, and PDF/X-1a takes CMYK"):
        made(black(), pdfx="x1a", icc=str(grey))
    with pytest.raises(ValueError, match=r"icc is for GRAY, and ink 'Gold .warm.' is no share of black; give a CMYK profile"):
        made(inked(), pdfx="x3", icc=str(grey))


def test_our_own_grey_profile_is_sound_and_shows_shares_as_screens_do() -> None:
    made = _icc.grey()
    assert made.data == _icc.grey().data and len(made.data) == int.from_bytes(made.data[:4], "big")
    opened = ImageCms.ImageCmsProfile(io.BytesIO(made.data))
    about = opened.profile
    assert (about.device_class, about.xcolor_space.strip(), about.profile_description) == ("prtr", "GRAY", made.name)
    lab = ImageCms.createProfile("LAB")
    change = ImageCms.buildTransform(opened, lab, "L", "LAB", ImageCms.Intent.RELATIVE_COLORIMETRIC)
    greys = ImageCms.applyTransform(Image.fromarray(np.array([[0, 128, 255]], np.uint8)), change)
    light = np.asarray(greys)[0, :, 0] / 2.55
    middle = 116 * ((128 / 255) ** 2.2) ** (1 / 3) - 16  # CIE lightness of a gamma of 2.2
    assert light == pytest.approx([0, middle, 100], abs=0.5)  # of lightness: a step of 8 bits is 0.4
