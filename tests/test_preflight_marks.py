"""Sizes of marks, the same from PDF and from SVG: dots, lines, gaps, by hand and by drawings of ours."""

from __future__ import annotations

import io

import numpy as np
import pikepdf
import pytest
from drawings import marks
from pikepdf import Dictionary, Name
from presses import add, broken, disc, faults, found, page, saved, separation

from crowquill import formats
from crowquill.paths import Paths
from crowquill.preflight import ERROR, WARNING, check
from crowquill.preflight import marks as sizes
from crowquill.preflight.document import opened
from crowquill.preflight.svg import opened as opened_svg
from crowquill.preflight.walker import page as walked
from crowquill.sheet import Ink, Layer, Sheet

FINE = 0.005  # mm: an outline strays by 0.002 from its chords, on both sides of a gap
Measured = sizes.Measured


def of_pdf(data: bytes, reach: float = 0.2) -> Measured:
    with opened(data, "plate.pdf") as pdf:
        return sizes.measured(walked(pdf.pages[0], 1)[1].art, reach)


def of_svg(data: bytes, reach: float = 0.2) -> Measured:
    return sizes.measured(opened_svg(data, "plate.svg").drawing.art, reach)


def svg(body: str) -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">{body}</svg>'.encode()


def both(content: str, body: str, reach: float = 0.2) -> list[Measured]:
    """The same drawn as content of a PDF and as elements of an SVG."""
    return [of_pdf(page(content), reach), of_svg(svg(body), reach)]


def circle(x: float, y: float, diameter: float) -> str:
    return f'<circle cx="{x}" cy="{y}" r="{diameter / 2}"/>'


@pytest.mark.parametrize("diameter", [0.03, 0.1, 0.3, 5.0])
def test_a_disc_is_a_dot_of_its_diameter(diameter: float) -> None:
    for found_ in both(disc(20, 20, diameter) + "f", circle(20, 20, diameter)):
        assert found_.dots == pytest.approx([diameter], rel=1e-3)  # four cubics are so near to a circle
        assert found_.dots_at == pytest.approx(np.array([[20, 20]]), abs=1e-3) and not len(found_.lines)


def test_a_disc_turned_and_scaled_keeps_its_scaled_diameter() -> None:
    for found_ in both(f"q 0.3 0.4 -0.4 0.3 50 50 cm {disc(0, 0, 2)} f Q", '<g transform="matrix(.3 .4 -.4 .3 50 50)"><circle r="1"/></g>'):
        assert found_.dots == pytest.approx([1.0], rel=1e-3)


def test_a_narrow_rectangle_is_a_line_of_its_width() -> None:
    for found_ in both("10 10 20 0.08 re f", '<path d="M10 10h20v.08h-20z"/>'):
        assert found_.lines == pytest.approx([0.08], abs=1e-6) and not len(found_.dots)


def test_a_stroke_is_as_wide_as_its_pen_the_narrower_way() -> None:
    assert of_pdf(page("q 2 0 0 0.5 0 0 cm 0.4 w 5 20 m 25 20 l S Q")).lines == pytest.approx([0.2])
    body = '<g transform="scale(.5)"><path d="M5 20h20" stroke="#000" stroke-width=".4"/></g>'
    assert of_svg(svg(body)).lines == pytest.approx([0.2], rel=1e-5)


def test_a_pen_without_width_is_an_error() -> None:
    assert ("min-line", ERROR) in faults(page("0 w 20 20 m 40 40 l S"))


def test_a_stroke_of_no_length_with_round_ends_is_a_dot_and_without_them_nothing() -> None:
    for found_ in both(
        "1 J 0.3 w 20 20 m 20 20 l S", '<path d="M20 20h0" stroke="#000" stroke-width=".3" stroke-linecap="round" fill="none"/>'
    ):
        assert found_.dots == pytest.approx([0.3], rel=1e-5) and not len(found_.lines)
    assert not len(of_pdf(page("0 J 0.3 w 20 20 m 20 20 l S")).dots)


def test_the_gap_of_two_discs_is_their_distance_without_their_radii() -> None:
    for found_ in both(disc(20, 20, 1) + disc(21.12, 20, 1) + "f", circle(20, 20, 1) + circle(21.12, 20, 1)):
        assert found_.gaps == pytest.approx([0.12], abs=FINE)
        assert found_.gaps_at == pytest.approx(np.array([[20.56, 20]]), abs=0.05)


def test_the_gap_of_two_strokes_is_that_between_their_edges() -> None:
    line = '<path d="M20 {}h30" stroke="#000" stroke-width=".5"/>'
    for found_ in both("0.5 w 20 20 m 50 20 l S 20 20.6 m 50 20.6 l S", line.format(20) + line.format(20.6)):
        assert found_.gaps == pytest.approx([0.1], abs=1e-5)


@pytest.mark.parametrize("more", [disc(20.56, 20, 0.3) + "f", "0.4 w 20.56 19 m 20.56 21 l S"], ids=["dot", "stroke"])
def test_white_that_a_third_mark_covers_is_no_gap(more: str) -> None:
    two = disc(20, 20, 1) + "f " + disc(21.12, 20, 1) + "f "
    assert len(of_pdf(page(two)).gaps) == 1 and not len(of_pdf(page(two + more)).gaps)


def test_a_mark_on_another_has_no_gap_to_its_edge() -> None:
    assert not len(of_pdf(page("0.5 g 10 10 20 20 re f 0 g " + disc(10.6, 20, 1) + "f")).gaps)


def test_marks_that_touch_have_no_gap() -> None:
    assert not len(of_pdf(page(disc(20, 20, 1) + disc(20.9, 20, 1) + "f")).gaps)


@pytest.mark.parametrize("rule", ["f*", "f"])
def test_a_hole_counts_as_white_as_wide_as_itself(rule: str) -> None:
    hole = "20 20 m 20 20.06 l 20.06 20.06 l 20.06 20 l h "  # the other way round than re goes
    found_ = of_pdf(page("15 15 10 10 re " + hole + rule))
    assert found_.gaps == pytest.approx([2 * 0.06 / np.sqrt(np.pi)], rel=1e-6)  # the circle of a square's area
    assert len(found_.dots) == 1  # the square; the hole is none
    same = "20 20 0.06 0.06 re "
    assert len(of_pdf(page("15 15 10 10 re " + same + "f")).gaps) == 0  # wound the same way it is no hole


def test_a_dot_in_a_hole_has_a_gap_to_its_rim() -> None:
    ring = disc(20, 20, 4) + disc(20, 20, 2)
    assert of_pdf(page(ring + "f* " + disc(20, 20, 1.8) + "f")).gaps == pytest.approx([0.1], abs=FINE)


def test_white_paint_and_what_a_clip_hides_are_no_marks() -> None:
    found_ = of_pdf(page("1 g 10 10 0.01 0.01 re f 0 g q 50 50 10 10 re W n " + disc(20, 20, 0.01) + "f Q"))
    assert not len(found_.dots) and not len(found_.lines)


def test_limits_are_where_they_say() -> None:
    for diameter, expected in (
        (0.1, set()),
        (0.095, {("min-dot", WARNING)}),
        (0.051, {("min-dot", WARNING)}),
        (0.045, {("min-dot", ERROR)}),
    ):
        assert {one for one in faults(page(disc(50, 50, diameter) + "f")) if one[0] == "min-dot"} == expected
    assert ("min-dot", WARNING) in faults(page(disc(50, 50, 0.3) + "f"), min_dot=0.4)
    assert ("min-gap", WARNING) in faults(page(disc(50, 50, 1) + disc(51.05, 50, 1) + "f"))
    assert ("min-line", WARNING) in faults(page("0.08 w 50 50 m 70 50 l S"))


@pytest.mark.parametrize("least", [0.1, 0.3])
def test_every_size_below_a_limit_is_in_one_row(least: float) -> None:
    """Outlines are read to 0.002 mm, and so much below a limit its row begins."""
    small = np.concatenate([np.linspace(0.4, 0.6, 41), np.linspace(0.9, 1.1, 11)]) * least + 1e-5
    dots = "".join(disc(10 + 1.5 * k, 20, size) + "f " for k, size in enumerate(small))
    lines = "".join(f"{size} w 10 {40 + k} m 30 {40 + k} l S " for k, size in enumerate(small))
    rules = found(page(dots + lines), min_dot=least, min_line=least, min_gap=0.01)
    errors, below = (int((small < limit - 0.002).sum()) for limit in (least / 2, least))
    assert errors > 5 and below - errors > 20
    for rule in ("min-dot", "min-line"):
        assert {one.severity: int(one.message.split()[0]) for one in rules[rule]} == {ERROR: errors, WARNING: below - errors}


def test_a_pen_without_width_is_an_error_whatever_the_limit() -> None:
    assert ("min-line", ERROR) in faults(page("0 w 20 20 m 40 40 l S"), min_line=0.001)


def test_half_size_counts_what_falls_below_the_limits() -> None:
    rows = "".join(disc(20 + 3 * k, 20, 0.15) for k in range(5)) + "".join(disc(20 + 3 * k, 40, 0.25) for k in range(7))
    (hit,) = found(page(rows + "f 0.15 w 20 60 m 50 60 l S"))["half-size"]
    assert hit.value == {"dots": 5, "lines": 1, "gaps": 0}


def test_what_is_cut_off_is_not_measured() -> None:
    """In mm from the left: the trim begins at 10, the bleed at 7; without a bleed box, all beyond the trim is cut off."""

    def rules(code: str, *gone: str) -> set[str]:
        def breaks(pdf: pikepdf.Pdf) -> None:
            add(pdf, code, ColorSpace={"All": separation("All", 1, 1, 1, 1)})
            for key in gone:
                del pdf.pages[0].obj[key]

        return {rule for rule, _ in faults(broken("x1a", breaks))} & {"min-dot", "min-line", "min-gap", "half-size"}

    thin, fair, pair = "0.03 w {0} 50 m {0} 60 l S", "0.15 w {0} 50 m {0} 60 l S", "{0} 50 0.5 1 re {0} 51.05 0.5 1 re f"
    for code, fault in ((thin, {"min-line"}), (fair, {"half-size"}), (pair, {"min-gap"})):
        assert rules(code.format(3)) == set()
        assert rules(code.format(8)) == rules(code.format(30)) == fault
        assert rules(code.format(8), "/BleedBox") == set()
        crop = "/All CS 1 SCN /All cs 1 scn " + code
        assert rules(crop.format(8)) == set() and rules(crop.format(30)) == fault


def test_a_bleed_inside_the_trim_hides_nothing_and_a_page_with_nothing_on_it_is_measured() -> None:
    def breaks(pdf: pikepdf.Pdf) -> None:
        add(pdf, "0.03 w 30 50 m 30 60 l S")
        pdf.pages[0].obj.BleedBox = pikepdf.Array([200, 200, 300, 300])

    assert {("boxes", ERROR), ("min-line", ERROR)} <= faults(broken("x1a", breaks))
    assert faults(page("0.03 w -30 50 m -30 60 l S")) == set()


def test_crop_marks_of_ours_are_not_measured() -> None:
    sheet = Sheet((60, 60), (Layer(Ink(), Paths.of([np.array([[20.0, 20], [30, 20], [30, 30], [20, 30]])])),))
    marked = formats.to_bytes(sheet, "pdf", pdfa=True, marks=True)
    assert faults(marked) == set()


def test_a_plate_says_the_same_as_svg_as_pdf_and_as_characters() -> None:
    """Our own dots, curves of scanned shapes: outlines, the table of the SVG, and glyphs of an embedded font."""
    sheet = Sheet((210, 297), (Layer(Ink(), marks(3000)),))
    plain, compact, drawn = (formats.to_bytes(sheet, "pdf"), formats.to_bytes(sheet, "pdf", compact=True), formats.to_bytes(sheet, "svg"))
    measured = [of_pdf(plain), of_pdf(compact), of_svg(drawn), of_svg(drawn.replace(b"urn:crowquill", b"urn:other"))]
    areas = np.sort(np.abs(sheet.marks.outlines().areas))
    for one in measured:
        assert np.sort(one.dots) == pytest.approx(2 * np.sqrt(areas / np.pi), abs=0.002)  # whole micrometres
        assert len(one.gaps) == pytest.approx(len(measured[0].gaps), rel=0.02)  # those at the limit go either way
        assert np.sort(one.gaps)[:20] == pytest.approx(np.sort(measured[0].gaps)[:20], abs=0.01)
    assert not any(one.severity == ERROR for one in check(compact, "plate.pdf").findings)


def test_gaps_of_a_grid_are_those_of_its_neighbours() -> None:
    at = np.stack(np.meshgrid(np.arange(10, 60, 0.4), np.arange(10, 60, 0.4)), axis=-1).reshape(-1, 2)
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rings = Paths.of([0.15 * np.column_stack([np.cos(turn), np.sin(turn)]) + xy for xy in at])
    data = formats.to_bytes(Sheet((100, 100), (Layer(Ink(), rings),)), "pdf")
    n = 125
    assert len(at) == n * n and len(of_pdf(data, 0.15).gaps) == 2 * n * (n - 1)  # 0.1 mm along rows and columns, 0.27 across
    assert of_pdf(data, 0.15).gaps == pytest.approx(0.1, abs=0.003)


def test_of_very_many_marks_a_sample_is_measured_and_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    data = page("".join(disc(10 + 1.05 * k, 10 + 1.05 * j, 1) for k in range(40) for j in range(40)) + "f")
    assert of_pdf(data).share == 1
    monkeypatch.setattr(sizes, "MOST", 100)
    assert 0 < of_pdf(data).share < 1
    (said, *_) = [hit for hit in found(data)["min-gap"] if hit.severity == "information"]
    assert "sample" in said.message


def test_ink_is_summed_with_what_lies_under_an_overprint() -> None:
    over = Dictionary(O=Dictionary(op=True))
    under = "1 1 0 0 k 20 20 20 20 re f 0 0 1 0.5 k "
    assert ("total-ink", ERROR) not in faults(page(under + "20 20 9 9 re f", ExtGState=over))
    (hit,) = found(page(under + "/O gs 20 20 9 9 re f", ExtGState=over))["total-ink"]
    assert hit.value == 350 and "overprints" in hit.message


def test_the_ink_of_a_bitmap_is_that_of_its_darkest_pixel() -> None:
    inline = b"q 9 0 0 9 20 20 cm /X Do Q"
    with pikepdf.open(io.BytesIO(page(inline))) as pdf:
        image = pdf.make_stream(bytes([0] * 396 + [255] * 4) * 100, Width=100, Height=100, BitsPerComponent=8)
        image.Subtype, image.ColorSpace = Name.Image, Name.DeviceCMYK
        pdf.pages[0].obj.Resources = Dictionary(XObject=Dictionary(X=image))
        (hit,) = found(saved(pdf))["total-ink"]
    assert hit.value == 400
