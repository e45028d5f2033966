"""PDF for printers: exact boxes, black as black ink alone, sound to those who check, and the drawing to the micrometre."""

from __future__ import annotations

import io
import re
from decimal import Decimal

import numpy as np
import pikepdf
import pytest
from drawings import KITE, everything, file, marks
from rendering import Array, run

from crowquill import formats
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.units import PAPERS

MM = 25.4 / 72  # of a point
NUMBER = re.compile(rb"[-+]?(\d+\.?\d*|\.\d+)")  # PDF 32000-1, 7.3.3: no exponents
OPERATORS = {b"cm", b"q", b"Q", b"m", b"l", b"c", b"h", b"f", b"S", b"g", b"G", b"k", b"K", b"w", b"J", b"j"}
SQUARE = Paths.of([[(1, 1), (9, 1), (9, 9), (1, 9)]])


def pdf(sheet: Sheet) -> bytes:
    return formats.to_bytes(sheet, "pdf")


def content(data: bytes) -> bytes:
    with pikepdf.open(io.BytesIO(data)) as document:
        (page,) = document.pages
        page.contents_coalesce()
        return page.Contents.read_bytes()


def black(n: int = 500) -> Sheet:
    return Sheet(PAPERS["a4"], (Layer(Ink(), marks(n)),))


def check_operators(code: bytes, allowed: set[bytes]) -> None:
    """Raises AssertionError where page content has an operator that is not allowed, or what is neither number nor operator."""
    for token in code.split():
        assert token in allowed or NUMBER.fullmatch(token), f"{token!r} in the page"


@pytest.mark.parametrize("size", [*PAPERS.values(), (100.001, 50.0), (1234.567, 3210.987)], ids=str)
def test_the_boxes_are_the_sheet_to_the_micrometre(size: tuple[float, float]) -> None:
    with pikepdf.open(io.BytesIO(pdf(Sheet(size)))) as document:
        (page,) = document.pages
        for box in ("/MediaBox", "/TrimBox"):
            left, bottom, right, top = (float(Decimal(str(edge))) for edge in page.obj[box])
            assert (left, bottom) == (0, 0)
            assert (right * MM, top * MM) == pytest.approx(size, abs=1e-3)
        assert page.obj.get("/Rotate", 0) == 0 and not {"/UserUnit", "/CropBox"} & set(page.obj.keys())  # seen as it is


def test_black_is_one_ink_and_nothing_else_is_said() -> None:
    code = content(pdf(black()))
    check_operators(code, OPERATORS - {b"k", b"K", b"G", b"S", b"w", b"J", b"j"})
    assert re.findall(rb"(\S+) g\b", code) == [b"0"]


@pytest.mark.parametrize("bad", [b"0 0 0 rg", b"0 0 0 RG", b"/Cs1 cs", b"/F1 12 Tf", b"1e-05 w", b"nan 0 m", b"/GS0 gs", b"/X Do"])
def test_the_check_of_operators_fails_for(bad: bytes) -> None:
    check_operators(b"q 1 0 0 -1 0.5 +.5 cm 0 g 1 2 m -3 4. l h f Q", OPERATORS)
    with pytest.raises(AssertionError):
        check_operators(b"q " + bad, OPERATORS)


def test_no_font_no_rgb_and_no_transparency_is_in_the_file() -> None:
    for sheet in (black(), everything(), Sheet((10, 10))):
        with pikepdf.open(io.BytesIO(pdf(sheet))) as document:
            said = document.pages[0].obj["/Resources"].unparse(resolved=True)
            assert not re.search(rb"/Font|/ColorSpace|/XObject|/ExtGState|/DeviceRGB", said), said
            every = b"".join(entry.unparse() for entry in document.objects if not isinstance(entry, pikepdf.Stream))
            assert not re.search(rb"/Font\b|/DeviceRGB|/Group|/SMask|/Trans\b", every), every
            assert [len(bytes(part)) for part in document.trailer["/ID"]] == [16, 16]
            assert not {"/Author", "/Keywords"} & set(document.docinfo.keys())


def test_two_drawings_have_two_file_ids() -> None:
    found = set()
    for sheet in (black(500), black(501), Sheet((10, 10))):
        with pikepdf.open(io.BytesIO(pdf(sheet))) as document:
            found.add(bytes(document.trailer["/ID"][0]))
    assert len(found) == 3


@pytest.mark.parametrize("sheet", [black(), everything(), Sheet((10, 10))], ids=["dots", "everything", "nothing"])
def test_qpdf_finds_no_fault(sheet: Sheet) -> None:
    with pikepdf.open(io.BytesIO(pdf(sheet))) as document:
        assert list(document.check_pdf_syntax()) == []


def test_qpdf_finds_a_fault_where_there_is_one() -> None:
    broken = pdf(black()).replace(b"endstream", b"endstrea ", 1)
    with pikepdf.open(io.BytesIO(broken)) as document:
        assert list(document.check_pdf_syntax()) != []


def plates(data: bytes) -> list[float]:
    """The share of the page that ghostscript puts on each of cyan, magenta, yellow and black."""
    said = run("gs", ["-q", "-dBATCH", "-dNOPAUSE", "-sDEVICE=inkcov", "-r300", "-sOutputFile=-", "a.pdf"], {"a.pdf": data})
    return [float(part) for part in said.split()[:4]]


def test_black_dots_are_on_the_black_plate_alone() -> None:
    cyan, magenta, yellow, key = plates(pdf(black()))
    assert (cyan, magenta, yellow) == (0, 0, 0)
    assert key > 0


@pytest.mark.parametrize("pen", [None, 0.5])
def test_a_colour_is_on_the_plates_that_it_names(pen: float | None) -> None:
    for plate in range(4):
        share = tuple(float(k == plate) for k in range(4))
        found = plates(pdf(Sheet((10, 10), (Layer(Ink("one", share, pen), SQUARE),))))
        assert [amount > 0 for amount in found] == [k == plate for k in range(4)]


@pytest.mark.parametrize(
    ("ink", "says"),
    [
        (Ink(), b"0 g"),
        (Ink("half", (0, 0, 0, 0.5)), b"0.5 g"),
        (Ink("sky", (0.7, 0.2, 0, 0.05)), b"0.7 0.2 0 0.05 k"),
        (Ink("line", (0, 0, 0, 1), 0.25), b"0 G 250 w 1 J 1 j"),
        (Ink("red", (0, 1, 1, 0), 0.3), b"0 1 1 0 K 300 w 1 J 1 j"),
    ],
)
def test_an_ink_is_said_by_shares_of_the_plates_and_round_pens_in_micrometres(ink: Ink, says: bytes) -> None:
    code = content(pdf(Sheet((10, 10), (Layer(ink, SQUARE),))))
    assert b"\n" + says + b"\n" in code
    assert (b"f" in code.split()) == (ink.pen is None) and (b"S" in code.split()) == (ink.pen is not None)


@pytest.mark.parametrize("share", [0, 1e-300, 1e-7, 1e-5, 1 / 3, 1 - 1e-5, 1 - 1e-16, 1])
def test_every_share_of_ink_is_a_number_that_pdf_can_say(share: float) -> None:
    for cmyk in ((0, 0, 0, share), (share, 1 - share, 0, share)):
        check_operators(content(pdf(Sheet((10, 10), (Layer(Ink("any", cmyk), SQUARE),)))), OPERATORS)


@pytest.mark.parametrize("pen", [1e-9, 1e-3, 1 / 3, 123.456789, 999.9999])
def test_every_pen_is_a_number_that_pdf_can_say(pen: float) -> None:
    check_operators(content(pdf(Sheet((10, 10), (Layer(Ink(pen=pen), SQUARE),)))), OPERATORS)


def drawn(data: bytes, height: float) -> list[Array]:
    """The points of everything painted, in mm from the top left corner, by the file's own matrices."""
    matrix = np.array([(MM, 0), (0, -MM), (0, height)])  # rows: where x, y and the origin go
    stack: list[Array] = []
    path: list[Array] = []
    found = []
    with pikepdf.open(io.BytesIO(data)) as document:
        for operands, operator in pikepdf.parse_content_stream(document.pages[0]):
            numbers = np.array([float(number) for number in operands])
            match str(operator):
                case "q":
                    stack.append(matrix)
                case "Q":
                    matrix = stack.pop()
                case "cm":
                    new = numbers.reshape(3, 2)
                    matrix = np.vstack([new[:2] @ matrix[:2], new[2] @ matrix[:2] + matrix[2]])
                case "m" | "l" | "c":
                    path.append(numbers.reshape(-1, 2) @ matrix[:2] + matrix[2])
                case "f" | "S":
                    found.append(np.concatenate(path))
                    path = []
    assert not stack and not path
    return found


def test_every_point_is_where_the_sheet_has_it() -> None:
    nibs, kites, ring, _, strokes, curves = (layer.art for layer in everything().layers)
    rings = [np.vstack([outline, outline[:1]]) for outline in nibs.outlines()]  # a closed curve comes back to its first point
    expected = [np.concatenate(rings), kites.outlines().xy, ring.xy, strokes.xy, curves.xy]
    for one, other in zip(drawn(file("pdf"), 297.003), expected, strict=True):
        np.testing.assert_allclose(one, other, atol=5.01e-4)  # mm: whole micrometres are written


def test_a_dot_of_five_or_six_cubics_takes_120_bytes() -> None:
    sheet = Sheet(PAPERS["a4"], (Layer(Ink(), marks(24_000)),))
    assert len(pdf(sheet)) / len(sheet.marks) <= 120


def test_a_crowd_of_dots_is_few_paths() -> None:
    code = content(pdf(Sheet((420, 594), (Layer(Ink(), marks(100_000, 390, 564, shapes=(KITE,))),))))
    assert 1 < len(re.findall(rb"\bf\b", code)) < 2000
