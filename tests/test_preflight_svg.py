"""Rules for SVG: a sound drawing has no fault, and each fault is found by its rule alone."""

from __future__ import annotations

import base64
import io

import pytest
from drawings import marks
from PIL import Image
from presses import faults, found

from crowquill import formats
from crowquill.preflight import ERROR, RULES, WARNING
from crowquill.preflight import svg as side
from crowquill.sheet import Ink, Layer, Sheet

DOT = '<circle cx="50" cy="50" r="1"/>'
SIZE = 'width="100mm" height="100mm" viewBox="0 0 100 100"'
A5 = 'width="148mm" height="210mm" viewBox="0 0 148 210"'


def drawing(body: str = DOT, size: str = SIZE) -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {size}>{body}</svg>'.encode()


def picture(pixels: int, mode: str = "L", place: str = 'x="40" y="40" width="20" height="20"') -> str:
    file = io.BytesIO()
    Image.new(mode, (pixels, pixels)).save(file, "PNG")
    return f'<image {place} xlink:href="data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"/>'


BROKEN = [
    (drawing(size='width="100" height="100" viewBox="0 0 100 100"'), "svg-size", ERROR),  # px
    (drawing(size='viewBox="0 0 100 100"'), "svg-size", ERROR),
    (drawing(size='width="100%" height="100%" viewBox="0 0 100 100"'), "svg-size", ERROR),
    (drawing(size='width="100mm" height="100mm" viewBox="0 0 100 101" preserveAspectRatio="none"'), "svg-size", ERROR),
    (drawing('<circle cx="50mm" cy="50mm" r="1mm"/>', 'width="100mm" height="100mm"'), "svg-size", WARNING),
    (drawing(DOT + '<image xlink:href="photo.png" width="9" height="9"/>'), "svg-outside", ERROR),
    (drawing("<style>@import 'house.css';</style>" + DOT), "svg-outside", ERROR),
    (drawing(DOT + '<rect x="50" y="60" width="9" height="9" fill="url(https://a.b/c)"/>'), "svg-outside", ERROR),
    (drawing(DOT + "<script>alert(1)</script>"), "svg-active", ERROR),
    (drawing(DOT.replace("<circle", '<circle onclick="alert(1)"')), "svg-active", ERROR),
    (drawing(DOT + "<text x='50' y='60'>a</text>"), "svg-text", WARNING),
    (drawing(DOT + picture(100)), "resolution", WARNING),
    (drawing(DOT + picture(400, "1")), "resolution", WARNING),
    (drawing('<circle cx="147" cy="50" r=".5"/>', A5), "safe-zone", WARNING),
    (drawing('<circle cx="50" cy="50" r=".04"/>'), "min-dot", WARNING),
    (drawing('<path d="M40 50h9" stroke="#000" stroke-width=".03"/>'), "min-line", ERROR),
    (drawing(DOT + '<circle cx="52.05" cy="50" r="1"/>'), "min-gap", WARNING),
    (drawing(DOT + '<circle cx="53" cy="50" r=".09"/>'), "half-size", WARNING),
]


@pytest.mark.parametrize(("data", "rule", "severity"), BROKEN, ids=[f"{k}-{rule}" for k, (_, rule, _) in enumerate(BROKEN)])
def test_one_fault_is_found_by_its_rule_alone(data: bytes, rule: str, severity: str) -> None:
    assert faults(data, "plate.svg") == {(rule, severity)}


def test_a_sound_drawing_has_no_fault() -> None:
    assert faults(drawing(), "plate.svg") == set()
    assert faults(drawing(DOT + picture(300)), "plate.svg") == set()  # 381 ppi


def test_a_drawing_of_ours_has_no_error() -> None:
    data = formats.to_bytes(Sheet((210, 297), (Layer(Ink(), marks(2000)),)), "svg")
    assert all(severity != ERROR for _, severity in faults(data, "plate.svg"))


def test_art_outside_the_page_is_found() -> None:
    assert ("outside", WARNING) in faults(drawing('<circle cx="101" cy="50" r="3"/>'), "plate.svg")
    assert ("bleed", WARNING) in faults(drawing('<circle cx="101" cy="50" r="3"/>'), "plate.svg")


def test_a_bitmap_is_as_fine_as_its_place_makes_it() -> None:
    half = picture(100, place='x="100" y="100" width="20" height="20"')
    turned = f'<g transform="scale(.5)">{half}</g>'
    (hit,) = found(drawing(turned), "plate.svg")["resolution"]
    assert hit.value == pytest.approx(100 / (10 / 25.4), abs=0.1)


def test_elements_and_lengths_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    assert faults(drawing(DOT * 3), "plate.svg", max_elements=3) == {("elements", WARNING)}  # with the root
    monkeypatch.setattr(side, "LONGEST", 1000)
    assert faults(drawing(f'<path d="M40 40h20v20h-20z{" " * 1000}"/>'), "plate.svg") == {("svg-longest", ERROR)}


def test_a_large_file_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(side, "LARGE", 100)
    assert faults(drawing(), "plate.svg") == {("svg-file-size", WARNING)}


def test_a_figure_that_is_no_paper_has_no_safe_zone_but_the_one_asked_for() -> None:
    near = '<circle cx="99" cy="50" r=".5"/>'
    assert faults(drawing(near), "plate.svg") == set()
    assert faults(drawing(near), "plate.svg", safe=2.0) == {("safe-zone", WARNING)}
    assert faults(drawing('<circle cx="147" cy="50" r=".5"/>', A5), "plate.svg", safe=0.0) == set()


@pytest.mark.parametrize("far", ["1e40", "1e200", "9" * 40])
def test_a_shape_that_is_nowhere_is_refused_in_one_line_with_the_name_of_the_file(far: str) -> None:
    for body in (f'<circle cx="50" cy="50" r="{far}"/>', f'<path d="M1 2C3 4 5 6 {far} 7"/>'):
        with pytest.raises(ValueError, match=r"^plate\.svg: a shape [^\n]+; [^\n]+$"):
            faults(drawing(body), "plate.svg")


def test_the_size_is_the_paper_asked_for() -> None:
    assert faults(drawing(), "plate.svg", size=(100.0, 100.05)) == set()
    assert faults(drawing(), "plate.svg", size=(210.0, 297.0)) == {("svg-size", ERROR)}


def test_colours_are_told_and_what_is_not_read_is_named() -> None:
    red, clip = '<rect x="40" y="40" width="9" height="9" fill="#ff0000"/>', '<clipPath><path d="M0 0h1v1z"/></clipPath>'
    rules = found(drawing(red + clip), "plate.svg")
    assert rules["svg-colours"][0].value == ["#ff0000"]
    assert rules["unread"][0].value == {"clipPath": 1}


def test_every_rule_for_svg_is_broken_somewhere() -> None:
    tried = {rule for _, rule, _ in BROKEN} | {"svg-longest", "svg-file-size", "svg-colours"}
    assert {rule.name for rule in RULES.values() if rule.on == "svg"} <= tried
