"""Words and pixels in PDF: text that is found and copied, in fonts that are embedded; pixels where they belong."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pikepdf
import pytest
from fontTools.ttLib import TTFont
from PIL import Image
from printing import square
from rendering import Window, pdfium, run
from scipy import ndimage
from test_pdf import content

from crowquill import formats, lettering
from crowquill.lettering import Words
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet

LINES = ["Ammonites, ×2,5", "Größe 12 µm — Möwe & “Ente”", "fi ffl WAVE To. Ω ﬁ"]
DPMM = 50.0  # pixels to the mm


def words(size: float = 4.0, font: str = "regular", lines: list[str] = LINES) -> Words:
    return Words.of([(line, 5, 10 + 8 * k) for k, line in enumerate(lines)], size=size, font=font)


def sheet(*layers: Words | Bitmap | Layer) -> Sheet:
    return Sheet((80, 40), tuple(part if isinstance(part, Layer) else Layer(Ink(), part) for part in layers))


def pdf(*layers: Words | Bitmap | Layer, **knobs: object) -> bytes:
    return formats.to_bytes(sheet(*layers), "pdf", **knobs)


def test_words_are_copied_as_they_were_typed() -> None:
    said = run("pdftotext", ["-layout", "-enc", "UTF-8", "a.pdf", "-"], {"a.pdf": pdf(words())}).decode()
    assert [line.strip() for line in said.splitlines() if line.strip()] == LINES


def test_every_font_is_embedded_once_a_face_with_the_letters_in_use() -> None:
    data = pdf(words(lines=["one"]), words(lines=["zwei", "ENOT"], size=2), words(font="bold"), words(font="italic", lines=["one"]))
    table = run("pdffonts", ["a.pdf"], {"a.pdf": data}).decode().splitlines()[2:]
    assert [line.split()[0].split("+")[1] for line in table] == [
        "BitstreamVeraSans-Bold", "BitstreamVeraSans-Oblique", "BitstreamVeraSans-Roman",
    ]  # fmt: skip
    assert all(re.search(r"CID TrueType +Identity-H +yes yes yes", line) for line in table)
    with pikepdf.open(io.BytesIO(data)) as document:
        fonts = {str(font.BaseFont).split("-")[-1]: font.DescendantFonts[0] for font in document.pages[0].Resources.Font.values()}
        program = TTFont(io.BytesIO(fonts["Roman"].FontDescriptor.FontFile2.read_bytes()))
        widths = [float(width) for width in fonts["Roman"].W[1]]
    assert program["maxp"].numGlyphs == 1 + len(set("onezweiENOT"))  # and the box of letters that are missing
    assert widths == [round(1000 * program["hmtx"][name][0] / 2048) for name in program.getGlyphOrder()]
    assert set(program.keys()) - {"GlyphOrder"} == {"glyf", "head", "hhea", "hmtx", "loca", "maxp"}


@pytest.mark.parametrize("said", [0, 1200])
def test_the_height_of_capitals_is_the_fonts_own(said: int, tmp_path: Path) -> None:
    """As the font says in OS/2, and of one that does not, as its H is, though no H is shown."""
    program = TTFont(lettering.file("regular"))
    high = program["glyf"][program.getBestCmap()[ord("H")]].yMax
    if said:
        program["OS/2"].version, program["OS/2"].sCapHeight, program["OS/2"].sxHeight = 2, said, 1000
        program["OS/2"].usDefaultChar = program["OS/2"].usBreakChar = program["OS/2"].usMaxContext = 0
    program.save(tmp_path / "own.ttf")
    with pikepdf.open(io.BytesIO(pdf(words(font=str(tmp_path / "own.ttf"), lines=["ammonite"])))) as document:
        (font,) = document.pages[0].Resources.Font.values()
        descriptor = font.DescendantFonts[0].FontDescriptor
    assert descriptor.CapHeight == round(1000 * (said or high) / 2048) < descriptor.Ascent


@pytest.mark.parametrize("font", ["regular", "bold", "italic"])
@pytest.mark.parametrize("pen", [None, 0.1])
def test_words_look_as_their_outlines_do(font: str, pen: float | None) -> None:
    text = words(font=font)
    shown = [pdfium(pdf(Layer(Ink(pen=pen), art)), Window(0, 0, 80, 40), DPMM) for art in (text, text.outlines())]
    both = [ink > 0.5 for ink in shown]
    assert shown[0].sum() == pytest.approx(shown[1].sum(), rel=0.01)
    # a pixel is 20 um; widths are in thousandths of 4 mm, and outlines in whole micrometres
    border = ndimage.binary_dilation(both[1]) & ~ndimage.binary_erosion(both[1])
    assert not ((both[0] ^ both[1]) & ~border).any()


def test_the_place_of_each_line_is_said_to_the_micrometre() -> None:
    text = Words(("a", "b"), np.array([[12.345, 6.789], [0.001, 39.999]]), np.array([3.217, 0.5]))
    found = re.findall(rb"/\w+ (\d+) Tf 1 0 0 -1 (\d+) (\d+) Tm", content(pdf(text)))
    assert [tuple(map(int, line)) for line in found] == [(3217, 12345, 6789), (500, 1, 39999)]


@pytest.mark.parametrize(("letter", "code"), [("字", "U+5B57"), ("🦀", "U+1F980"), ("\n", "U+000A"), ("\u202e", "U+202E")])
def test_a_letter_that_the_font_lacks_is_refused_by_name(letter: str, code: str) -> None:
    with pytest.raises(ValueError, match=re.escape(f"letter {letter!r} ({code}) is not in font regular; choose other words")) as error:
        pdf(words(lines=["Tür " + letter]))
    assert "\n" not in str(error.value)


def changed(tmp_path: Path, change: Callable[[TTFont], None]) -> str:
    """A font of the user's own: Vera with something else in it."""
    font = TTFont(lettering.file("regular"))
    change(font)
    path = tmp_path / "mine.ttf"
    font.save(path)
    return str(path)


def restrict(font: TTFont) -> None:
    font["OS/2"].fsType = 2


def unname(font: TTFont) -> None:
    for table in ("name", "OS/2"):
        del font[table]


def test_a_font_of_the_users_own_is_embedded_whatever_it_says_of_itself(tmp_path: Path) -> None:
    data = pdf(words(font=changed(tmp_path, unname)))
    assert re.search(r"[A-Z]{6}\+Font +CID TrueType +Identity-H +yes yes yes", run("pdffonts", ["a.pdf"], {"a.pdf": data}).decode())
    assert str(tmp_path).encode() not in data


def test_fonts_that_cannot_be_embedded_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"mine\.ttf: its licence forbids embedding; give another font"):
        pdf(words(font=changed(tmp_path, restrict)))
    broken = tmp_path / "broken.ttf"
    broken.write_bytes(lettering.file("regular").read_bytes()[:3000])
    lines = Words(("a",), np.array([[1.0, 1.0]]), np.array([3.0]), str(broken))
    with pytest.raises(ValueError, match=r"broken\.ttf: not a font that can be read .*; give a TrueType font"):
        pdf(lines)
    with pytest.raises(ValueError, match="no font 'fraktur'; there are regular, bold, italic"):
        pdf(replace(lines, font="fraktur"))


def test_no_words_and_empty_lines_take_no_font() -> None:
    for lines in ([], ["", ""]):
        data = pdf(words(lines=lines))
        assert b"Font" not in data and b"TJ" not in content(data)


def noise(height: int, width: int, dpi: float, corner: tuple[float, float]) -> Bitmap:
    return Bitmap.of(np.random.default_rng(2).random((height, width)) < 0.4, dpi, corner)


@pytest.mark.parametrize("dpi", [254.0, 508.0])
def test_pixels_are_painted_each_at_its_place(dpi: float) -> None:
    bitmap = noise(101, 203, dpi, (10, 5))
    flags = ["-q", "-dBATCH", "-dNOPAUSE", "-sDEVICE=tiffg4", f"-r{dpi:g}", "-sOutputFile=a.tif", "a.pdf"]
    with Image.open(io.BytesIO(run("gs", flags, {"a.pdf": pdf(bitmap)}, "a.tif"))) as image:
        ink = ~np.asarray(image)
    expected = np.zeros_like(ink)
    left, top = (round(edge * dpi / 25.4) for edge in (10, 5))
    expected[top : top + 101, left : left + 203] = bitmap.rows(0, 101)
    assert (ink == expected).all()


def test_the_size_of_pixels_is_exact_and_its_numbers_are_those_that_pdfa_takes() -> None:
    bitmap = noise(3, 2999, 1199.99, (1.234, 5.678))
    code = content(pdf(bitmap))
    said = re.search(rb"1000 0 0 1000 1234 5678 cm\n(\S+) 0 0 -(\S+) 0 (\S+) cm\n/\w+ Do", code)
    assert said and [float(part) for part in said.groups()] == pytest.approx([*bitmap.size, bitmap.size[1]], abs=1e-8)  # mm
    fractions = [abs(float(part)) for part in re.findall(rb"-?\d+\.\d+", code)]
    assert max(fractions) < 32768


def test_pixels_are_a_mask_in_their_ink_and_kept_once() -> None:
    bitmap = noise(9, 17, 300, (1, 1))
    sky = Ink("sky", (0.7, 0.2, 0, 0))
    data = pdf(Layer(sky, bitmap), Layer(Ink(), bitmap.moved((0, 0))), compact=True)
    assert b"0.7 0.2 0 0 k" in content(data)
    with pikepdf.open(io.BytesIO(data)) as document:
        for mask in document.pages[0].Resources.XObject.values():
            assert mask.ImageMask is True and mask.BitsPerComponent == 1 and "/ColorSpace" not in mask and "/Interpolate" not in mask
            assert mask.read_bytes() == bitmap.bits.tobytes() and list(mask.Decode) == [1, 0]
    with pytest.raises(ValueError, match="pixels of a device have no outlines"):
        pdf(Layer(Ink(pen=0.3), bitmap))


def test_rings_in_colours_of_their_own_are_said_in_runs() -> None:
    rings = Paths.of([square(x, 1, 2, 2)[0] for x in (1, 4, 7, 10)])
    fill = np.array([(0, 0, 0, 0.5), (0, 0, 0, 0.5), (0.25, 0, 1, 0), (0, 0, 0, 0)])
    code = content(pdf(Layer(Ink("mosaic"), rings, fill=fill)))
    assert re.findall(rb"(?m)^([\d. ]+ [gk])$", code) == [b"0.5 g", b"0.25 0 1 0 k", b"1 g"] and len(re.findall(rb"\bf\b", code)) == 3
    over = content(pdf(Layer(Ink("mosaic", overprint=True), rings, fill=fill)))
    assert b"/Over gs" in over and b"0 0 0 0.5 k" in over
