"""SVG is the project file: it comes back as the same sheet, or as its geometry once somebody edited it, or is refused."""

from __future__ import annotations

import base64
import contextlib
import functools
import io
import json
import re
import zlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from drawings import KITE, NIB, everything, file, marks, same
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill import formats, vector
from crowquill.lettering import Words
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.units import PAPERS

SVG = "{http://www.w3.org/2000/svg}"
OURS = "{urn:crowquill:drawing}"
# Elements at which a reader of HTML leaves an SVG that stands in a page (HTML standard, 13.2.6.5)
BREAKS = re.compile(
    "b|big|blockquote|body|br|center|code|dd|div|dl|dt|em|embed|h[1-6]|head|hr|i|img|li|listing|menu|meta|nobr|ol|p|pre|ruby|"
    "s|small|span|strong|strike|sub|sup|table|tt|u|ul|var|font"
)


def read(data: bytes) -> Sheet:
    return formats.load(io.BytesIO(data))


def svg(sheet: Sheet) -> bytes:
    return formats.to_bytes(sheet, "svg")


def test_a_saved_sheet_comes_back_to_the_last_bit_and_saves_the_same() -> None:
    again = read(file("svg"))
    same(again, everything())
    assert again.report == {"warnings": []}
    assert svg(again) == file("svg")


SHARES = st.floats(0, 1)
WORDS = st.text(st.characters(exclude_categories=["Cs", "Cc", "Cn"]), max_size=9)  # all that XML can say; the rest has its own test
INKS = st.builds(Ink, WORDS, st.tuples(SHARES, SHARES, SHARES, SHARES), st.none() | st.floats(0.001, 900))
POINTS = st.lists(st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)), max_size=6)
ART = st.builds(lambda rings, closed: Paths.of(rings, closed=closed), st.lists(POINTS, max_size=4), st.booleans()) | st.builds(
    lambda xy, angle, scale, glyph: Marks.of(xy, NIB, scale=scale, angle=angle, glyph=glyph),
    POINTS, st.floats(-9, 9), st.floats(0, 1e3), st.integers(0, len(NIB) - 1),
)  # fmt: skip
PLAIN = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | WORDS
SHEETS = st.builds(
    Sheet,
    st.tuples(st.floats(0.001, 1e5), st.floats(0.001, 1e5)),
    st.lists(st.builds(Layer, INKS, ART, WORDS), max_size=3).map(tuple),
    st.dictionaries(WORDS, PLAIN | st.lists(PLAIN, max_size=3) | st.dictionaries(WORDS, PLAIN, max_size=2), max_size=3),
)


@given(SHEETS)
@settings(max_examples=50)
def test_any_sheet_comes_back(sheet: Sheet) -> None:
    data = svg(sheet)
    same(read(data), sheet)
    assert svg(read(data)) == data


@pytest.mark.parametrize("word", ["a\x01b", "\x00", "\uffff", "\ud800", "\x85", "a\nb\tc\r"], ids=ascii)
def test_words_that_xml_cannot_say_come_back_or_are_refused_when_written(word: str) -> None:
    """A picture's name may hold any of these; no file is written that cannot be read again."""
    dots = marks(1)
    for sheet in (Sheet((5, 5), (Layer(Ink(word), dots),)), Sheet((5, 5), (Layer(Ink(), dots, word),)), Sheet((5, 5), (), {"a": word})):
        with contextlib.suppress(ValueError):
            data = svg(sheet)
            same(_read_or_fail(data), sheet)


def _read_or_fail(data: bytes) -> Sheet:
    try:
        return read(data)
    except ValueError as error:
        raise AssertionError(f"what was written cannot be read: {error}") from error


SHIFT = {
    "a dot moved by a micrometre": lambda s: replace_art(s, lambda m: replace(m, xy=m.xy + (np.arange(len(m)) == 3)[:, None] * 0.001)),
    "a dot turned by a step": lambda s: replace_art(s, lambda m: replace(m, angle=m.angle + (np.arange(len(m)) == 3) * 1e-4)),
    "a dot grown": lambda s: replace_art(s, lambda m: replace(m, scale=m.scale + 0.001)),
    "another glyph": lambda s: replace_art(s, lambda m: replace(m, glyph=(m.glyph + 1) % len(NIB))),
    "another order": lambda s: replace_art(s, lambda m: m.take(slice(None, None, -1))),
    "another ink": lambda s: replace(s, layers=(replace(s.layers[0], ink=Ink(pen=0.3)), *s.layers[1:])),
    "another name": lambda s: replace(s, layers=(replace(s.layers[0], name="dots"), *s.layers[1:])),
    "another recipe": lambda s: replace(s, recipe={**s.recipe, "style": "hatch"}),
    "another size": lambda s: replace(s, size=(210, 297.004)),
}


def replace_art(sheet: Sheet, change: Callable[[Marks], Marks]) -> Sheet:
    return replace(sheet, layers=(replace(sheet.layers[0], art=change(sheet.marks)), *sheet.layers[1:]))


@pytest.mark.parametrize("story", SHIFT)
def test_the_comparison_of_sheets_fails_for(story: str) -> None:
    with pytest.raises(AssertionError):
        same(SHIFT[story](everything()), everything())


@pytest.mark.parametrize("size", [*PAPERS.values(), (100.001, 50), (1234.567, 9876.543)])
def test_the_page_is_in_millimetres_and_a_unit_is_one(size: tuple[float, float]) -> None:
    root = ElementTree.fromstring(svg(Sheet(size)))
    assert root.attrib["width"].endswith("mm") and root.attrib["height"].endswith("mm")
    sides = [float(root.attrib[side][:-2]) for side in ("width", "height")]
    # a micrometre: lengths are written as such
    assert sides == pytest.approx(size, abs=1e-6)
    assert [float(part) for part in root.attrib["viewBox"].split()] == [0, 0, *sides]


def test_the_drawing_is_what_the_sheet_says() -> None:
    (nibs, kites, ring, _, strokes, curves), (size, found) = everything().layers, vector.shapes(file("svg"), "x.svg")
    assert size == pytest.approx((210, 297.003), abs=1e-3)
    drawn = [paths for paths, _ in found]
    expected = [nibs.art.outlines(), kites.art.outlines(), ring.art, strokes.art, curves.art]
    assert [(p.closed, p.cubic, len(p)) for p in drawn] == [(p.closed, p.cubic, len(p)) for p in expected]
    for one, other in zip(drawn, expected, strict=True):
        # whole micrometres, and 0.2 um of 300 mm by svgelements' rounded pixel
        np.testing.assert_allclose(one.xy, other.xy, atol=7.5e-4)
    assert [shape.stroke_width / 96 * 25.4 for _, shape in found[-2:]] == pytest.approx([0.25, 0.1], rel=1e-5)


def test_a_file_written_again_without_a_change_is_read_from_its_table() -> None:
    root = ElementTree.fromstring(file("svg"))
    root.insert(0, ElementTree.Comment("opened and saved"))
    root.find(f"{SVG}g").attrib |= {"id": "other", "{urn:editor}seen": "yes"}  # type: ignore[union-attr]
    again = read(ElementTree.tostring(root))
    same(again, everything())
    assert again.report == {"warnings": []}


EDITS = {
    "a path moved by a micrometre": (lambda data: re.sub(rb' d="m(\d+)', lambda m: b' d="m%d' % (int(m[1]) + 1), data, count=1), 0),
    "a circle added": (lambda data: data.replace(b"</svg>", b'<circle cx="30" cy="40" r="2"/></svg>'), 1),
    "a path taken away": (lambda data: re.sub(rb'<path d="m[^"]*" />', b"", data, count=1), -len(everything().marks)),
}


@pytest.mark.parametrize("story", EDITS)
def test_an_edited_file_is_read_by_its_geometry_and_says_so(story: str) -> None:
    edit, more = EDITS[story]
    sheet = read(edit(file("svg")))
    assert len(sheet.report["warnings"]) == 1 and "drawing.svg was edited" in sheet.report["warnings"][0]
    assert sum(len(layer.art) for layer in sheet.layers) == sum(len(layer.art) for layer in everything().layers) + more
    assert sheet.size == (210, 297.003) and dict(sheet.recipe) == dict(everything().recipe)
    if "moved" in story:
        art, true = sheet.layers[0].art, everything().marks.outlines()
        np.testing.assert_allclose(art.xy[:15], np.add(true.xy[:15], (0.001, 0)), atol=7.5e-4)  # the first dot of five cubics
        np.testing.assert_allclose(art.xy[-15:], np.add(true.xy[-15:], (0.001, 0)), atol=7.5e-4)  # and all drawn relative to it
    if "circle" in story:
        assert abs(sheet.layers[-1].art.areas[0]) == pytest.approx(4 * np.pi, rel=3e-4)  # its arcs by cubics
    same(read(svg(sheet)), sheet)


def said(change: Callable[[dict[str, Any]], Any]) -> bytes:
    """The file with something else said of its table."""
    root = ElementTree.fromstring(file("svg"))
    element = next(root.iter(f"{OURS}drawing"))
    about = json.loads(element.text or "")
    element.text = found if isinstance(found := change(about), str) else json.dumps(about)
    return ElementTree.tostring(root)


def table(change: Callable[[bytes], bytes], packed: bool = False) -> bytes:
    """The file with other bytes in its table, which are packed or are to be."""
    root = ElementTree.fromstring(file("svg"))
    element = next(e for e in root.iter() if e.tag.startswith(OURS) and e.tag != f"{OURS}drawing")
    text = (element.text or "").encode()
    element.text = (change(text) if packed else base64.b64encode(zlib.compress(change(zlib.decompress(base64.b64decode(text)))))).decode()
    return ElementTree.tostring(root)


BROKEN: dict[str, tuple[Callable[[], bytes], str]] = {
    "of a newer schema": (lambda: said(lambda a: a.update(schema=99)), "newer crowquill"),
    "without a schema": (lambda: said(lambda a: a.pop("schema") and None), "broken"),
    "without layers": (lambda: said(lambda a: a.pop("layers") and None), "broken"),
    "not JSON": (lambda: said(lambda _: "{"), "broken"),
    "JSON without end": (lambda: said(lambda _: "[" * 100_000), "broken"),
    "a list": (lambda: said(lambda _: "[]"), "broken"),
    "of one length": (lambda: said(lambda a: a.update(size_mm=[1])), "broken"),
    "of no size": (lambda: said(lambda a: a.update(size_mm=[0, 1])), "broken"),
    "with a dot less": (lambda: said(lambda a: a["layers"][0].update(marks=a["layers"][0]["marks"] - 1)), "broken"),
    "with less than none": (lambda: said(lambda a: a["layers"][0].update(marks=-1)), "broken"),
    "with more than there are": (lambda: said(lambda a: a["layers"][0].update(marks=10**30)), "broken"),
    "with an ink of three shares": (lambda: said(lambda a: a["layers"][0]["ink"].update(cmyk=[0, 0, 0])), "broken"),
    "without glyphs": (lambda: said(lambda a: a["layers"][0].update(glyphs=[])), "broken"),
    "cut in the middle": (lambda: table(lambda t: t[: len(t) // 8 * 4], packed=True), "broken"),
    "cut by a letter": (lambda: table(lambda t: t[:-1], packed=True), "broken"),
    "empty": (lambda: table(lambda _: b"", packed=True), "broken"),
    "of a hundred bytes": (lambda: table(lambda t: t[:100]), "broken"),
    "of noise": (lambda: table(lambda t: np.random.default_rng(1).bytes(len(t))), "broken"),
    "in half a file": (lambda: file("svg")[: len(file("svg")) // 2], "not sound SVG"),
    "with entities": (lambda: file("svg").replace(b"<svg", b'<!DOCTYPE svg [<!ENTITY a "b">]><svg', 1), "declares entities"),
    "not there": (lambda: b'<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0h1"/></svg>', "no table of marks"),
}


@pytest.mark.parametrize("story", BROKEN)
def test_a_table_is_refused_by_the_name_of_its_file_when_it_is(story: str) -> None:
    data, says = BROKEN[story]
    with pytest.raises(ValueError, match=rf"^drawing\.svg: .*{says}.*; \w+"):
        read(data())


def test_a_file_can_stand_in_a_page_of_html() -> None:
    names = {vector.local(element).lower() for element in ElementTree.fromstring(file("svg")).iter()}
    assert [name for name in names if BREAKS.fullmatch(name)] == []


@functools.cache
def crowd() -> bytes:
    return svg(Sheet((420, 594), (Layer(Ink(), marks(300_000, 390, 564)),)))


def test_300_000_dots_are_few_elements_of_a_length_that_readers_bear() -> None:
    count = longest = text = 0
    for _, element in ElementTree.iterparse(io.BytesIO(crowd())):
        count += 1
        longest = max(longest, *map(len, element.attrib.values()), 0)
        text = max(text, len(element.text or ""))
    assert 20 < count < 2000
    assert longest < 2_000_000  # bytes; readers built on libxml2 stop at 10 MB
    assert text < 10_000_000


def test_a_dot_of_five_or_six_cubics_takes_145_bytes_with_its_table() -> None:
    sheet = Sheet(PAPERS["a4"], (Layer(Ink(), marks(24_000)),))
    assert len(svg(sheet)) / len(sheet.marks) <= 145


def test_large_dots_keep_the_length_of_attributes_too() -> None:
    big = marks(20_000, 3000, 3000, shapes=(KITE,) * 2)
    for shapes in (NIB, (KITE,)):
        sheet = Sheet((3030, 3030), (Layer(Ink(), Marks.of(big.xy, shapes, scale=15, angle=big.angle)),))
        root = ElementTree.fromstring(svg(sheet))
        assert max(len(path.attrib["d"]) for path in root.iter(f"{SVG}path")) < 2_000_000


def test_words_and_spot_inks_come_back():
    ink = Ink("PANTONE 124 C", (0, 0.3, 0.9, 0), spot=True, overprint=True)
    words = Words.of([("500 \u00b5m", 10, 5), ("b", 3, 3)], size=2.5, font="bold")
    sheet = Sheet((20, 10), (Layer(ink, words, "letters"),))
    data = formats.to_bytes(sheet, "svg")
    back = formats.load(io.BytesIO(data)).layers[0]
    assert back.ink == ink
    assert isinstance(back.art, Words)
    assert (back.art.text, back.art.font) == (words.text, "bold")
    assert np.allclose(back.art.xy, words.xy, atol=5e-4)  # mm: whole micrometres are kept
    assert formats.to_bytes(Sheet((20, 10), (back,)), "svg") == data
