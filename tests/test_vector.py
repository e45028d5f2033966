"""Other people's SVG: lengths come out in millimetres, shapes as drawn, and bad files are refused by name."""

from __future__ import annotations

import gzip
from typing import Any

import numpy as np
import pytest
import shapely

from crowquill import vector
from crowquill.paths import Paths

MM = 'width="100mm" height="50mm" viewBox="0 0 100 50"'
NEAR = 1e-4  # mm: svgelements takes 3.7795296 px to the mm, which is 0.05 um in 100 mm


def svg(body: str, head: str = MM) -> bytes:
    space = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    return f"<svg {space} {head}>{body}</svg>".encode()


def paths(data: bytes) -> list[Paths]:
    return [found for found, _ in vector.shapes(data, "x.svg")[1]]


def points(data: bytes) -> Any:
    """The points of a file's only shape."""
    (only,) = paths(data)
    return only.xy


@pytest.mark.parametrize(
    ("head", "size", "unit"),
    [
        (MM, (100, 50), 1),
        ('width="10cm" height="5cm" viewBox="0 0 100 50"', (100, 50), 1),
        ('width="100mm" height="50mm" viewBox="0 0 200 100"', (100, 50), 0.5),
        ('width="2in" height="1in"', (50.8, 25.4), 25.4 / 96),
        ('width="192" height="96"', (50.8, 25.4), 25.4 / 96),
        ('width="192px" height="96px" viewBox="0 0 2 1"', (50.8, 25.4), 25.4),
        ('width="144pt" height="72pt" viewBox="0 0 144 72"', (50.8, 25.4), 25.4 / 72),
    ],
)
def test_lengths_of_every_unit_are_millimetres(head: str, size: tuple[float, float], unit: float) -> None:
    data = svg('<rect x="1" y="0.5" width="0.25" height="0.125"/>', head)
    page, _ = vector.shapes(data, "x.svg")
    assert page == pytest.approx(size, abs=NEAR)
    corners = np.array([(1, 0.5), (1.25, 0.5), (1.25, 0.625), (1, 0.625)]) * unit
    np.testing.assert_allclose(points(data), corners, atol=NEAR)


DRAWN = {
    "a polygon": ('<polygon points="1,2 3,4 5,2"/>', True, [(1, 2), (3, 4), (5, 2)]),
    "a polyline": ('<polyline points="1,2 3,4 5,2"/>', False, [(1, 2), (3, 4), (5, 2)]),
    "a line": ('<line x1="1" y1="2" x2="3" y2="4"/>', False, [(1, 2), (3, 4)]),
    "a path": ('<path d="M1 2H3V4L5 6"/>', False, [(1, 2), (3, 2), (3, 4), (5, 6)]),
    "a closed path": ('<path d="m1 2h2v2z"/>', True, [(1, 2), (3, 2), (3, 4)]),
    "a closed path that comes back": ('<path d="m1 2h2v2L1 2z"/>', True, [(1, 2), (3, 2), (3, 4)]),
    "a group turned about": ('<g transform="translate(9 0) rotate(90)"><path d="M1 2h3"/></g>', False, [(7, 1), (7, 4)]),
    "groups in groups": ('<g transform="scale(2)"><g transform="translate(1 2)"><path d="M0 0h1"/></g></g>', False, [(2, 4), (4, 4)]),
    "a copy": ('<defs><path id="a" d="M0 0h1"/></defs><use xlink:href="#a" x="5" y="1"/>', False, [(5, 1), (6, 1)]),
}


@pytest.mark.parametrize("story", DRAWN)
def test_a_shape_is_read_as_drawn(story: str) -> None:
    body, closed, xy = DRAWN[story]
    (found,) = paths(svg(body))
    assert (found.closed, found.cubic, len(found)) == (closed, False, 1)
    np.testing.assert_allclose(found.xy, xy, atol=NEAR)


def test_curves_are_cubics_and_their_lines_too() -> None:
    (found,) = paths(svg('<path d="M1 1C2 1 3 2 3 3Q3 5 1 5V1z"/>'))
    quarter = [(1, 1), (2, 1), (3, 2), (3, 3)]
    bow = [(3, 3 + 4 / 3), (3 - 2 / 3, 5), (1, 5)]  # a quadratic's control counts for two thirds on either side
    assert found.closed and found.cubic
    np.testing.assert_allclose(found.xy, [*quarter, *bow, (1, 5 - 4 / 3), (1, 1 + 4 / 3)], atol=NEAR)


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<circle cx="30" cy="20" r="10"/>', np.pi * 100),
        ('<ellipse cx="30" cy="20" rx="10" ry="5"/>', np.pi * 50),
        ('<path d="M20 20A10 10 0 0 1 40 20A10 10 0 0 1 20 20z"/>', np.pi * 100),
        ('<rect x="5" y="5" width="20" height="30" rx="5"/>', 20 * 30 - (4 - np.pi) * 25),
    ],
)
def test_arcs_keep_their_area(body: str, area: float) -> None:
    (found,) = paths(svg(body))
    # arcs of 30 degrees by svgelements' own formula, good to some 1e-4 of the radius
    assert abs(found.areas[0]) == pytest.approx(area, rel=3e-4)


def test_open_and_closed_parts_of_a_shape_come_apart() -> None:
    closed, opened = paths(svg('<path d="M1 1h2v2z M5 5h1v1z M7 7l1 1"/>'))
    assert closed.closed and len(closed) == 2
    assert not opened.closed and len(opened) == 1


@pytest.mark.parametrize(
    "body",
    [
        '<path d="M0 0h1v1z" display="none"/>',
        '<path d="M0 0h1v1z" style="display:none"/>',
        '<g display="none"><path d="M0 0h1v1z"/></g>',
        '<path d="M0 0h1v1z" visibility="hidden"/>',
        '<defs><path d="M0 0h1v1z"/></defs>',
        '<text x="1" y="1">ink</text>',
        '<image xlink:href="http://example.org/a.png" width="9" height="9"/>',
    ],
)
def test_what_is_not_seen_or_not_a_shape_is_not_read(body: str) -> None:
    data = svg('<path d="M4 4h1"/>' + body)
    np.testing.assert_allclose(points(data), [(4, 4), (5, 4)], atol=NEAR)


BOMB = '<!DOCTYPE svg [<!ENTITY a "3"><!ENTITY b "&a;&a;&a;&a;">]>'
RECT = '<rect width="1" height="1"/>'
TENFOLD = '<path id="a0"/>' + "".join(f'<g id="a{k + 1}">{f"""<use xlink:href="#a{k}"/>""" * 10}</g>' for k in range(7))
BAD = {
    "empty": (b"", "not sound SVG"),
    "text": (b"a shell", "not sound SVG"),
    "another XML": (b"<html/>", "not an SVG file"),
    "cut short": (svg(RECT)[:-3], "not sound SVG"),
    "packed": (gzip.compress(svg(RECT)), "not sound SVG"),
    "entities": (BOMB.encode() + svg(RECT), "declares entities"),
    "entities in small letters": (BOMB.replace("ENTITY", "entity").encode() + svg(RECT), "entities|not sound SVG"),
    "an entity from a file": (b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + svg("<text>&a;</text>"), "declares entities"),
    "entities in UTF-16": (f'<?xml version="1.0" encoding="utf-16"?>{BOMB}{svg(RECT).decode()}'.encode("utf-16"), "entities"),
    "nested without end": (svg("<g>" * 300 + "</g>" * 300), "nested over 200 deep"),
    "a copy of itself": (svg('<g id="a"><use xlink:href="#a"/></g>'), "a <use> in it is a loop"),
    "copies of copies": (svg(TENFOLD), "draws [0-9]+ elements, copies counted, over the limit of 1000000; "),
    "a transform that is none": (
        svg('<g transform="foo(1)"><rect width="1" height="1"/></g>'),
        r"transform='foo\(1\)' is not a transform; ",
    ),
    "a transform a number short": (svg('<rect width="1" height="1" transform="matrix(1 2)"/>'), ""),
    "a length that is none": (svg('<circle cx="9" cy="9" r="half"/>'), ""),
    "a length without end": (svg('<circle cx="9" cy="9" r="1e999"/>'), ""),
    "a length of letters": (svg('<circle cx="9" cy="9" r="1em"/>'), ""),
}


@pytest.mark.parametrize("story", BAD)
def test_a_bad_file_is_refused_by_name(story: str) -> None:
    data, says = BAD[story]
    with pytest.raises(ValueError, match=f"^x.svg: .*({says})"):
        vector.shapes(data, "x.svg")


def test_a_file_over_the_limit_is_refused_unread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vector, "LIMIT", 100)
    with pytest.raises(ValueError, match=r"^x.svg: .* over the limit of"):
        list(vector.elements(b"<" * 101, "x.svg"))  # no XML: found too large before it is found broken
    with pytest.raises(ValueError, match="not sound SVG"):
        list(vector.elements(b"<" * 100, "x.svg"))


def test_a_doctype_and_a_mark_of_byte_order_do_no_harm() -> None:
    doctype = b'<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    for start in (doctype, b"\xef\xbb\xbf", b"<!-- a note -->"):
        np.testing.assert_allclose(points(start + svg('<path d="M1 2h3"/>')), [(1, 2), (4, 2)], atol=NEAR)


def test_elements_come_in_the_order_of_the_file_by_plain_names() -> None:
    found = vector.elements(svg('<g><path/><rect/></g><x:y xmlns:x="urn:x"/>'), "x.svg")
    assert [vector.local(element) for element in found] == ["svg", "g", "path", "rect", "y"]


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<rect width="100" height="50"/>', 5000),
        ('<rect width="100" height="50"/><rect x="10" y="10" width="10" height="10"/>', 4900),
        ('<path d="M0 0h100v50H0zM10 10h10v10H10z"/>', 4900),
        ('<rect x="10" y="10" width="10" height="10"/><rect width="100" height="50"/>', 4900),
        ('<rect width="40" height="40"/><rect x="10" y="10" width="20" height="20"/><rect x="15" y="15" width="9" height="9"/>', 1281),
        ('<rect width="10" height="10"/><rect x="50" width="10" height="10"/>', 200),
        ('<path d="M0 0L10 10V0L0 10z"/>', 50),
        ('<rect width="10" height="10"/><line x1="0" y1="0" x2="90" y2="40"/>', 100),
    ],
    ids=["page", "hole", "hole in a path", "hole drawn first", "island in a hole", "islands", "crossing itself", "a stray line"],
)
def test_a_canvas_is_what_closed_shapes_enclose(body: str, area: float) -> None:
    found = vector.canvas(svg(body), "x.svg", (100, 50))
    assert shapely.is_valid(found)
    assert found.area == pytest.approx(area, rel=1e-5)


@pytest.mark.parametrize("page", [1, 10, 1000])
def test_a_canvas_is_laid_over_the_picture_whatever_its_page(page: float) -> None:
    head = f'width="{page}mm" height="{page / 2}mm" viewBox="0 0 100 50"'
    found = vector.canvas(svg('<circle cx="30" cy="20" r="15"/>', head), "x.svg", (200, 100))
    true = shapely.Point(60, 40).buffer(30, quad_segs=256)
    # held to a thousandth of the picture's width, 0.2 mm here
    assert shapely.hausdorff_distance(found, true, densify=0.05) < 0.2


def test_a_canvas_of_another_shape_is_stretched() -> None:
    found = vector.canvas(svg('<rect x="50" y="25" width="50" height="25"/>'), "x.svg", (100, 100))
    assert found.bounds == pytest.approx((50, 50, 100, 100), abs=NEAR)


@pytest.mark.parametrize(
    "data",
    [
        svg(""),
        svg('<line x1="1" y1="2" x2="3" y2="4"/>'),
        svg('<path d="M0 0h10h-5z"/>'),
        svg('<rect width="9" height="9"/>' * 2),
        svg('<rect width="9" height="9"/>', 'width="0" height="0"'),
    ],
    ids=["nothing", "a line", "no area", "a shape twice", "no page"],
)
def test_a_canvas_that_encloses_nothing_is_refused_by_name(data: bytes) -> None:
    with pytest.raises(ValueError, match=r"^x\.svg: encloses no area; draw"):
        vector.canvas(data, "x.svg", (100, 50))
