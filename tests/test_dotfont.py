"""Dots as characters of a font: the same picture as outlines, in a tenth of the bytes, and sound to those who check."""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pikepdf
import pytest
import shapely
from drawings import KITE, NIB, everything, marks
from fontTools import cffLib
from fontTools.pens.boundsPen import ControlBoundsPen
from fontTools.pens.recordingPen import RecordingPen
from rendering import COARSE, FINE, Window, check_true_size, ghostscript, pdfium, poppler, run
from test_pdf import content, plates
from test_true_size import DIAMETER, POSITION, specimen, windows

from crowquill import formats, glyphs
from crowquill.formats import _dotfont
from crowquill.formats._dotfont import FULL, SLIP
from crowquill.marks import Glyph, Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.units import PAPERS

(DISC,) = glyphs.load("disc").glyphs
COG = Glyph.of(Paths.of([[(r * np.cos(t), r * np.sin(t)) for t, r in zip(np.arange(90) * np.pi / 45, [1, 1.2, 1.1] * 30, strict=True)]]))
UNIT = 0.0011  # mm: points of characters are whole micrometres, as those of outlines are: 0.71 each way, and curves no more
FLAT = 1e-4  # mm, of curves that are compared
TEXT = {"q", "Q", "cm", "g", "Tr", "d", "BT", "ET", "Tm", "Tf", "Td", "Tj"}


def sheet(*arts: Marks | Paths, ink: Ink | None = None) -> Sheet:
    return Sheet(PAPERS["a4"], tuple(Layer(ink or Ink(), art) for art in arts))


def pdf(drawing: Sheet, *, compact: bool = True) -> bytes:
    return formats.to_bytes(drawing, "pdf", compact=compact)


@functools.cache
def dense(compact: bool) -> bytes:
    """Dots that touch and overlap, as characters or as outlines."""
    return pdf(sheet(marks(60_000)), compact=compact)


def sized(n: int, sizes: int, shapes: tuple[Glyph, ...] = NIB) -> Marks:
    """Marks of so many scales, whatever their glyph, 0.1 to 0.5 mm."""
    rng = np.random.default_rng(4)
    made = marks(n, shapes=shapes)
    return replace(made, scale=rng.choice(np.linspace(0.1, 0.5, sizes), len(made)))


def rewritten(data: bytes, old: bytes, new: Callable[[re.Match[bytes]], bytes]) -> bytes:
    """The file with something else in its page, once."""
    said = content(data)
    assert re.sub(old, new, said, count=1) != said
    with pikepdf.open(io.BytesIO(data)) as document:
        document.pages[0].Contents = document.make_stream(re.sub(old, new, said, count=1))
        document.save(buffer := io.BytesIO())
        return buffer.getvalue()


def fonts(data: bytes) -> dict[str, tuple[dict[str, Any], bytes, bytes]]:
    """By name in the page: what is said of a font, its program, its ToUnicode map."""
    found = {}
    with pikepdf.open(io.BytesIO(data)) as document:
        for key, font in document.pages[0].obj.Resources.get("/Font", {}).items():
            (below,) = font.DescendantFonts
            about = below.FontDescriptor
            names = [str(name) for name in (font.BaseFont, below.BaseFont, about.FontName)]
            said = {"key": key[1:], "names": names, "box": [int(edge) for edge in about.FontBBox], "width": int(below.DW)}
            found[key[1:]] = said, about.FontFile3.read_bytes(), font.ToUnicode.read_bytes()
    return found


def program(data: bytes) -> Any:
    """A font program as fontTools reads it."""
    whole = cffLib.CFFFontSet()
    whole.decompile(io.BytesIO(data), None, isCFF2=False)
    return whole[0]


def check_font(said: dict[str, Any], data: bytes, unicode: bytes) -> None:
    """Raises AssertionError where parts of a font do not agree: names, order, widths, box, what is copied."""
    font = program(data)
    names = font.charset
    assert names == [".notdef", *(f"cid{code:05}" for code in range(1, len(names)))], "codes are not the characters' order"
    tagged = f"/{said['key']}+Dots"
    assert re.fullmatch("[A-Z]{6}", said["key"]) and said["names"] == [f"{tagged}-Identity-H", tagged, tagged], f"names {said['names']}"
    bounds = [(0, 0, 0, 0)]
    for name in names:
        pen, shape = ControlBoundsPen(None), font.CharStrings[name]
        shape.draw(pen)
        assert shape.width == said["width"], f"{name} is {shape.width} wide, and the file says {said['width']}"
        bounds += [pen.bounds] if pen.bounds else []
    box = [*np.min(bounds, axis=0)[:2], *np.max(bounds, axis=0)[2:]]
    assert said["box"] == font.FontBBox == box, f"the box {said['box']} is not the characters' {box}"
    read = re.findall(rb"<(\w{2})(\w{2})> <(\w{2})(\w{2})> \[((?:<2022>)+)\]", unicode)
    counts = [len(to) // 6 for *_, to in read]
    assert sum(counts) == len(names) and all(one == other for one, _, other, *_ in read), f"{sum(counts)} bullets, {len(names)} characters"
    assert counts == [int(hi, 16) - int(lo, 16) + 1 for _, lo, _, hi, _ in read], "ranges of bullets are not as long as said"


def shown(data: bytes) -> tuple[Array, list[Paths]]:
    """Places (n, 2) and outlines about them, in mm, of every character shown, read from page and fonts."""
    shapes = {key: program(file).CharStrings for key, (_, file, _) in fonts(data).items()}
    at, places, outlines = np.zeros(2), [], []
    for part in re.findall(r"1 0 0 -1 0 0 Tm|/\w+ \S+ Tf|\S+ \S+ Td<\w+>Tj", content(data).decode()):
        words = part.split()
        if part.endswith("Tm"):
            at = np.zeros(2)
        elif part.endswith("Tf"):
            font, size = words[0][1:], float(words[1])
        else:
            at = at + np.array([float(words[0]), -float(words[1])])
            shapes[font][f"cid{int(words[2][3:7], 16):05}"].draw(pen := RecordingPen())
            points = np.array([point for _, points in pen.value for point in points]) * (1, -1) * size / 1e6
            cubic = pen.value[1][0] == "curveTo"
            places.append(at / 1000)
            outlines.append(Paths.of([points[:-1] if cubic else points], cubic=cubic))
    return np.reshape(places, (-1, 2)), outlines


def check_outlines(data: bytes, art: Marks) -> None:
    """Raises AssertionError unless each mark is shown once, in its place, its outline off by SLIP and a unit at most."""
    places, outlines = shown(data)
    mine, theirs = np.lexsort(np.round(art.xy, 3).T), np.lexsort(places.T)
    assert len(mine) == len(theirs), f"{len(theirs)} characters for {len(mine)} marks"
    np.testing.assert_allclose(places[theirs], np.round(art.xy, 3)[mine], atol=1e-9)
    for i, j in zip(mine, theirs, strict=True):
        one, other = (shapely.LinearRing(ring.flat(FLAT)[0]) for ring in (_outline(art, i), outlines[j]))
        off = shapely.hausdorff_distance(one, other)
        assert off <= SLIP + UNIT + FLAT, f"an outline is {off * 1000:.2f} um off"


def _outline(art: Marks, i: int) -> Paths:
    cos, sin = art.scale[i] * np.cos(art.angle[i]), art.scale[i] * np.sin(art.angle[i])
    return art.glyphs[art.glyph[i]].paths.moved([(cos, -sin), (sin, cos)])


@pytest.mark.parametrize(("render", "paper"), [(pdfium, "a4"), (ghostscript, "a4"), (poppler, "a4"), (pdfium, "letter")])
def test_every_dot_is_in_its_place_and_of_its_size(render: Any, paper: str) -> None:
    check_true_size(render, pdf(specimen(paper)), specimen(paper).marks, windows(paper), FINE, POSITION, DIAMETER)


MAR = {
    "moved by 10 um": (rb"\n(-?\d+)( -?\d+ Td<\w+>Tj\nET)", lambda m: b"\n%d%s" % (int(m[1]) + 10, m[2]), r"(9|10)\..* um out of place"),
    "taken away": (rb"<\w+>Tj", lambda _: b"", "missing"),
    "a bitmap on whole pixels": (rb"2 Tr", lambda _: b"0 Tr", "[567].* um out of place"),
    "of the wrong size": (rb"(\S+) Tf", lambda m: b"%d Tf" % (float(m[1]) * 1.1), "off in diameter"),
}


@pytest.mark.parametrize("mar", MAR)
def test_the_ruler_finds_a_dot_that_is(mar: str) -> None:
    old, new, says = MAR[mar]
    with pytest.raises(AssertionError, match=says):
        check_true_size(pdfium, rewritten(pdf(specimen("a5")), old, new), specimen("a5").marks, windows("a5"), FINE, POSITION, DIAMETER)


@pytest.mark.parametrize(("render", "alike"), [(pdfium, 1e-3), (poppler, 1e-3), (ghostscript, 5e-3)])
def test_dark_tones_are_as_dark_as_outlines(render: Any, alike: float) -> None:
    """Ghostscript paints every pixel that a path touches: what outlines have too much, characters have less of."""
    window = Window(60, 100, 20, 20)
    one, other = (render(dense(compact), window, FINE).mean() for compact in (False, True))
    assert 0.07 < one < 0.13 and other == pytest.approx(one, abs=alike)


def test_a_page_of_everything_looks_the_same() -> None:
    page = Window(0, 0, *PAPERS["a4"])
    one, other = (pdfium(pdf(everything(), compact=compact), page, COARSE) for compact in (False, True))
    assert np.abs(one - other).max() < 0.12  # of a pixel of 0.1 mm: 4 um along its sides, and rounding to 255 steps
    assert one.mean() == pytest.approx(other.mean(), abs=1e-5)
    assert len(fonts(pdf(everything()))) == 2  # nibs and kites; fills and strokes are outlines


@pytest.mark.parametrize(
    "art",
    [
        marks(300),
        sized(300, 150),
        marks(200, shapes=(KITE,)),
        sized(200, 3, (KITE, COG)),
        sized(200, 150, (DISC,)),
        sized(99, 9, (DISC, KITE)),
    ],
    ids=["nibs", "nibs of 150 sizes", "kites", "cogs of 90 points", "discs", "curves and lines"],
)
def test_every_outline_is_where_the_sheet_has_it(art: Marks) -> None:
    check_outlines(pdf(sheet(art)), art)


def test_the_check_of_outlines_finds_a_turn_that_is_off() -> None:
    art = marks(50, shapes=(KITE,))
    with pytest.raises(AssertionError, match="um off"):
        check_outlines(pdf(sheet(replace(art, angle=art.angle + 0.1))), art)
    with pytest.raises(AssertionError, match="characters for"):
        check_outlines(pdf(sheet(art.take(slice(1, None)))), art)


def test_a_disc_is_one_character_and_larger_dots_turn_in_more_steps() -> None:
    counts = [
        len(program(file).charset) - 1
        for shape, size in ((DISC, 0.3), (NIB[0], 0.3), (NIB[0], 3.0))
        for _, file, _ in fonts(pdf(sheet(Marks.of(np.zeros((9999, 2)), (shape,), scale=size, angle=np.linspace(0, 7, 9999))))).values()
    ]
    assert counts[0] == 1 and 20 < counts[1] < 200 and counts[2] == pytest.approx(10 * counts[1], rel=0.02)


@pytest.mark.parametrize("size", [1e-3, 5.0, 40.0, 400.0])
def test_dots_of_any_size_are_drawn(size: float) -> None:
    art = Marks.of([(50, 60), (60, 70)], (NIB[3], KITE), scale=size, glyph=[0, 1], angle=1.0)
    if size < 10:  # above, a unit is more than a micrometre: numbers of a charstring end at 32767
        check_outlines(pdf(sheet(art)), art)
    assert run("pdftoppm", ["-r", "20", "a.pdf"], {"a.pdf": pdf(sheet(art))})


@pytest.mark.parametrize("n", [100_000, 300_000])
def test_a_dot_of_a_plate_takes_10_bytes(n: int) -> None:
    drawing = sheet(marks(n))
    assert len(pdf(drawing)) / len(drawing.marks) <= 10


def test_dots_of_hundreds_of_sizes_take_15_bytes() -> None:
    assert len(pdf(sheet(sized(100_000, 400)))) / 100_000 <= 15


def test_fonts_are_sound_and_named_by_what_they_hold() -> None:
    data = pdf(sheet(marks(400), marks(400, seed=2), marks(400)))
    found = fonts(data)
    assert len(found) == 2  # the first and the last layer share one
    for parts in found.values():
        check_font(*parts)
    assert pdf(sheet(marks(400), marks(400, seed=2), marks(400))) == data
    listed = run("pdffonts", ["a.pdf"], {"a.pdf": data}).decode().splitlines()[2:]
    assert len(listed) == 2 and all(line.split()[1:8] == ["CID", "Type", "0C", "Identity-H", "yes", "yes", "yes"] for line in listed)
    with pikepdf.open(io.BytesIO(data)) as document:
        assert list(document.check_pdf_syntax()) == []


@pytest.mark.parametrize(
    ("spoiled", "says"),
    [({"width": 500}, "is 0 wide"), ({"box": [0, 0, 1, 1]}, "the box"), ({"key": "DOTSDO"}, "names"), ({"key": "abcdef"}, "names")],
)
def test_the_check_of_fonts_finds(spoiled: dict[str, Any], says: str) -> None:
    ((said, file, unicode),) = fonts(pdf(sheet(marks(50)))).values()
    with pytest.raises(AssertionError, match=says):
        check_font(said | spoiled, file, unicode)
    with pytest.raises(AssertionError, match="bullets"):
        check_font(said, file, unicode.replace(b"<2022>", b"", 1))


def test_bullets_and_nothing_else_are_copied() -> None:
    assert set(run("pdftotext", ["a.pdf", "-"], {"a.pdf": pdf(specimen("a5"))}).decode().split()) == {"•"}


def test_black_is_one_ink_and_colours_are_on_their_plates() -> None:
    with pikepdf.open(io.BytesIO(dense(True))) as document:
        assert {str(operator) for _, operator in pikepdf.parse_content_stream(document.pages[0])} == TEXT
    assert [amount > 0 for amount in plates(dense(True))] == [False, False, False, True]
    for plate in range(4):
        ink = Ink("one", tuple(float(k == plate) for k in range(4)))
        assert [amount > 0 for amount in plates(pdf(sheet(marks(50), ink=ink)))] == [k == plate for k in range(4)]


def test_outlines_stay_unless_asked_and_where_characters_cannot_be() -> None:
    line = Glyph(Paths.of([[(-1, 0), (1, 0), (0, 0.5)]], closed=False), 1.0)
    for drawing in (sheet(marks(9), ink=Ink(pen=0.1)), sheet(Marks.of([(9, 9)], (line,), scale=1)), sheet(KITE.paths), sheet()):
        assert pdf(drawing) == formats.to_bytes(drawing, "pdf")
    assert fonts(formats.to_bytes(everything(), "pdf")) == {}


def test_nothing_one_dot_and_dots_without_ink() -> None:
    none = Marks.of([], NIB, scale=1)
    faint = Marks.of([(10, 10), (20, 20), (30, 30)], NIB, scale=[0, 0.3, 0])
    assert not fonts(pdf(sheet(none))) and not fonts(pdf(sheet(replace(faint, scale=[0, 0, 0]))))
    check_outlines(pdf(sheet(none, faint)), faint.take([1]))
    check_outlines(pdf(sheet(faint.take([1]))), faint.take([1]))


def test_characters_that_do_not_go_in_a_font_go_in_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_dotfont, "FULL", 100)
    for art in (marks(400), sized(400, 20)):
        data = pdf(sheet(art))
        assert len(fonts(data)) >= 4
        check_outlines(data, art)
        for parts in fonts(data).values():
            check_font(*parts)


def test_a_font_can_be_as_full_as_we_say() -> None:
    font = _dotfont._font([([np.array([(0, 0), (9, 0), (0, 9)])], False)] * FULL)
    assert len(program(font.program).charset) == FULL + 1 == 65_535
