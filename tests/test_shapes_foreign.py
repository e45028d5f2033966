"""Other people's SVG files as libraries of objects: what is refused, and what is named because it is not drawn."""

import pytest

from crowquill.shapes import parsed

PAGE = 'width="100mm" height="60mm" viewBox="0 0 100 60"'
PX = 1e-5  # CSS pixels are read as 0.2645833 mm
BOX = '<rect width="2" height="1"/>'


def svg(inside: str) -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {PAGE}>{inside}</svg>'.encode()


def notes(inside: str) -> str:
    return "\n".join(parsed(svg(inside), "x.svg").notes)


def test_what_is_not_read_is_named():
    inside = '<style>g > a{}</style><text>hi</text><rect width="2" height="1" fill="url(#g)" clip-path="url(#c)" filter="url(#f)"/>'
    said = notes(inside)
    assert said.startswith("x.svg: its text, ") and all(word in said for word in ("clips", "filters", "gradients", "style sheets beyond"))
    assert "pictures" not in said and "\n" not in said


@pytest.mark.parametrize(
    ("inside", "word"),
    [
        ('<path d="M0 0h9" stroke="red" stroke-width="3"/>', "stroke widths"),
        ('<path d="M0 0h9" stroke="red" style="stroke-dasharray:1 2"/>', "dashes"),
        (f'<g>{BOX}<circle r=".2" fill="#fff"/></g><g/>', "white fills"),
        (f'<g fill-opacity=".5">{BOX}</g>', "opacity"),
        ('<rect width="2" height="1" fill="#ff000080"/>', "opacity"),
        (f'<g stroke="red">{BOX}</g>', "strokes around areas"),
        (f"<switch>{BOX}<circle r='9'/></switch>", "choices of a switch"),
        (f"{BOX}<style>rect{{fill:none}}</style>", "style sheets beyond rules for one tag, class or id"),
        (f"<style>@media print {{rect{{fill:red}}}}</style>{BOX}", "style sheets beyond"),
    ],
)
def test_what_black_and_one_pen_do_not_give_is_named(inside, word):
    assert word in notes(inside) and not notes(BOX)


def test_a_style_sheet_of_plain_rules_is_heeded():
    rules = "/* , > */ .a{display:none} rect, path.b{fill:none; stroke:#000} #c {fill:red; stroke:none}"
    library = parsed(svg(f'<style>{rules}</style><path class="a" d="M0 0h9v9z"/>{BOX}<rect id="c" width="3" height="2"/>'), "x.svg")
    assert [(len(motif.rings), len(motif.lines)) for motif in library.motifs] == [(0, 1), (1, 0)]
    assert library.notes == ("x.svg: nothing is seen of shape 1 (<path>): no area or length, no fill or stroke, or hidden; left out",)


def test_of_a_switch_the_first_part_without_a_condition_is_drawn():
    library = parsed(svg(f'<switch><circle systemLanguage="de" r="5"/>{BOX}<circle r="9"/></switch>'), "x.svg")
    assert library.motifs[0].area == pytest.approx(2, rel=PX)


@pytest.mark.parametrize(
    "idle",
    [
        'rect id="it" width="0" height="3"/',
        'path id="it" d="M1 1L1 1"/',
        'path id="it" d="M1 1L5 1L3 1Z"/',
        'path id="it" d="M nan nan h3"/',
        'path id="it" fill="none" d="M1 1h3"/',
        'path id="it" fill-opacity="0" d="M1 1h3v3z"/',
        'path id="it" fill="none" stroke="red" stroke-width="0" d="M1 1h3"/',
        'rect id="it" display="none" width="3" height="3"/',
        'use id="it" xlink:href="#missing"/',
    ],
)
def test_what_draws_nothing_is_left_out_and_named(idle):
    library = parsed(svg(f"<{idle}>{BOX}"), "x.svg")
    assert len(library.motifs) == 1 and library.motifs[0].area == pytest.approx(2, rel=PX)
    assert "x.svg: nothing is seen of 'it': no area or length, no fill or stroke, or hidden" in library.notes[0]


BAD = {
    "nothing": ("", "has no shapes"),
    "only text": ("<text>a</text>", "has no shapes"),
    "a point": ('<path id="dot" d="M1 1L1 1"/>', "nothing is seen of 'dot': no area or length"),
    "many flat ones": ('<path d="M1 1L5 1L3 1Z"/>' * 5, r"shape 1 \(<path>\), .* \(<path>\) and 2 more: no area or length"),
    "a hair": (
        '<rect id="hair" width="40" height=".001"/>',
        r"object 'hair' is too thin for an area \(0\.04 mm2 at 40 mm\); draw it as a line",
    ),
    "no fill, no stroke": ('<rect fill="none" width="4" height="1"/>', "no fill or stroke"),
    "a loop": ('<g id="a"><use xlink:href="#a"/></g>', "a <use> in it is a loop"),
    "a crowd": ('<rect width="1" height="1"/>' * 2000, "draws 2001 elements, copies counted, over the limit of 2000"),
    "a crowd of copies": (f'<g id="a">{"<path/>" * 50}</g>' + '<use xlink:href="#a"/>' * 40, "over the limit of 2000"),
    "a bad transform": ('<rect width="1" height="1" transform="foo(1)"/>', r"transform='foo\(1\)' is not a transform"),
    "a way to a script": ('<a href=" java\tscript:alert(1)"><rect width="1" height="1"/></a>', "has a script"),
    "a stroke beside": ('<rect width="1" height="1" stroke="url(http://x/#a)"/>', r"refers to another file \('http://x/#a'\)"),
    "a filter beside": ('<rect width="1" height="1" filter="url( \'http://x/#a\' )"/>', r"refers to another file \('http://x/#a'\)"),
    "a style sheet called for": ("<style>@import url(http://x/y.css);</style>", r"refers to another file \('http://x/y.css'\)"),
    "a script": ('<script>1</script><rect width="1" height="1"/>', "has a script"),
    "a handler": ('<rect onclick="f()" width="1" height="1"/>', "has a script"),
    "another file": ('<use xlink:href="http://a.example/b.svg#c"/>', "refers to another file"),
    "a picture beside": ('<image xlink:href="b.png" width="1" height="1"/>', "refers to another file"),
    "a style beside": ('<style>@import "a.css";</style><rect width="1" height="1"/>', "refers to another file"),
    "metadata": ('<metadata><library xmlns="urn:x">[1]</library></metadata><rect width="1" height="1"/>', "not a JSON object"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_library_is_answered_with_one_line(name):
    inside, said = BAD[name]
    with pytest.raises(ValueError, match=said) as error:
        parsed(svg(inside), "x.svg")
    assert str(error.value).startswith("x.svg: ") and "\n" not in str(error.value) and "; " in str(error.value)


def test_entities_are_refused():
    with pytest.raises(ValueError, match="declares entities"):
        parsed(b'<!DOCTYPE svg [<!ENTITY a "b">]>' + svg("&a;"), "x.svg")


OWN = b'<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'


@pytest.mark.parametrize("head", [b"<?xml-stylesheet href='http://x/y'?>", b"<!DOCTYPE svg SYSTEM 'http://x/y'>", b"<?xml-stylesheet?>"])
def test_a_head_that_names_another_file_is_refused_but_not_that_of_the_w3c(head):
    with pytest.raises(ValueError, match=r"refers to another file \('(http://x/y|xml-stylesheet)'\); put"):
        parsed(head + svg(BOX), "x.svg")
    assert len(parsed(OWN + b"<?xpacket begin=''?>" + svg(BOX), "x.svg").motifs) == 1


def test_a_link_that_only_leads_elsewhere_may_stay():
    assert parsed(svg(f'<a href="http://x/">{BOX}</a>'), "x.svg").motifs[0].area == pytest.approx(2, rel=PX)
