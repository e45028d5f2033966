"""Every glyph library found holds sound unit dots of a known pen; broken libraries are refused by name."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

from crowquill import glyphs
from crowquill.marks import Glyph
from crowquill.paths import Paths

KNOWN = {"name", "simulated", "pen_mm", "count", "made", "source", "licence"}
NIBS = [name for name in glyphs.names() if name.startswith("nib-")]
TILT = 0.01  # of a unit area: a round dot's axes differ by less than its outline's decimals tell


def moments(glyph: Glyph) -> tuple[float, np.ndarray, np.ndarray]:
    """Area, centroid and covariance of a glyph's outline."""
    m = glyph.paths.green()[0]
    x, y = m[1:3] / m[0]
    corner = glyph.paths[0][0]  # green() counts from the first point
    return m[0], np.add(corner, (x, y)), np.array([[m[3] / m[0] - x * x, m[4] / m[0] - x * y], [m[4] / m[0] - x * y, m[5] / m[0] - y * y]])


def contract(library: glyphs.Library) -> None:
    """Raises AssertionError where a library breaks what is promised of all."""
    about = library.about
    assert not (lost := KNOWN - about.keys()), f"metadata lacks {sorted(lost)}"
    assert all(isinstance(about[key], str) and about[key].strip() for key in ("name", "made", "source", "licence")), "empty metadata"
    assert isinstance(about["simulated"], bool), "simulated is not true or false"
    assert about["count"] == len(library.glyphs), "count is not the number of dots"
    sizes = np.array([glyph.size for glyph in library.glyphs])
    pen = about["pen_mm"]
    # dots of one pen differ by a twelfth or so; a mean 5 % off, or a dot of twice the pen, is another pen
    assert abs(sizes.mean() / pen - 1) < 0.05, f"mean diameter {sizes.mean():.3f} is not of a {pen} mm pen"
    assert (sizes > pen / 2).all() and (sizes < pen * 2).all(), "a dot is not of this pen"
    for k, glyph in enumerate(library.glyphs):
        sound(glyph, f"glyph {k}")


def sound(glyph: Glyph, name: str) -> None:
    assert glyph.paths.closed and len(glyph.paths) == 1, f"{name} is not one closed outline"
    area, centroid, covariance = moments(glyph)
    # made so from doubles: some tens of roundings of numbers of size 1
    assert abs(area - 1) < 1e-12, f"{name} has area {area}"
    assert np.abs(centroid).max() < 1e-12, f"{name} has its centroid at {centroid}"
    if covariance[0, 0] - covariance[1, 1] > TILT:
        assert abs(covariance[0, 1]) < 1e-12, f"{name} is tilted"
    assert covariance[0, 0] >= covariance[1, 1] - 1e-12, f"{name} has its long axis on y"
    flat = glyph.paths.flat(1e-5).polygons()[0]  # 1e-5 of a 0.3 mm dot is 3 nm
    assert flat.is_valid, f"{name} crosses itself: {shapely.is_valid_reason(flat)}"


@pytest.mark.parametrize("name", glyphs.names())
def test_every_library_keeps_the_contract(name: str) -> None:
    contract(glyphs.load(name))


@pytest.mark.parametrize("name", glyphs.names())
def test_a_library_is_named_as_its_file_and_is_itself_a_picture_at_true_size(name: str) -> None:
    path = glyphs.FOLDER / f"{name}.svg"
    root = ElementTree.fromstring(path.read_bytes())
    assert glyphs.load(name).name == name
    view = [float(part) for part in root.attrib["viewBox"].split()]
    assert root.attrib["width"].endswith("mm") and root.attrib["height"].endswith("mm")
    assert view == [0, 0, float(root.attrib["width"][:-2]), float(root.attrib["height"][:-2])]


def test_there_are_libraries_of_five_nibs_a_brush_and_a_disc() -> None:
    pens = {name: glyphs.load(name).about["pen_mm"] for name in glyphs.names()}
    assert pens == {"nib-02": 0.2, "nib-025": 0.25, "nib-03": 0.3, "nib-035": 0.35, "nib-05": 0.5, "brush": 0.5, "disc": 0.3}


@pytest.mark.parametrize("name", [*NIBS, "brush"])
def test_a_simulated_scan_says_so_and_keeps_its_grey(name: str) -> None:
    path, library = glyphs.FOLDER / f"{name}.svg", glyphs.load(name)
    assert library.about["simulated"] is True
    assert "SIMULATED" in "".join(ElementTree.fromstring(path.read_bytes()).find("{http://www.w3.org/2000/svg}desc").itertext())
    kept = library.about["patches"]
    grey = np.frombuffer(zlib.decompress(base64.b64decode(kept["grey"])), np.uint8)
    areas = np.prod(kept["shape"], axis=1)
    assert len(areas) == len(library.glyphs)
    ink = np.add.reduceat(grey / 255.0, np.cumsum(areas) - areas) * kept["pixel_mm"] ** 2
    full = ink / (np.pi / 4 * np.array([glyph.size for glyph in library.glyphs]) ** 2)
    # full ink takes 0.62 of the light, each dot's a little more or less; the paper's noise is kept where it is dark
    assert 0.6 < np.median(full) < 0.68 and (abs(full - 0.64) < 0.1).all()
    assert path.stat().st_size < 100_000


def test_the_disc_is_round() -> None:
    (disc,) = glyphs.load("disc").glyphs
    radius = np.hypot(*disc.paths.flat(1e-6).xy.T)
    # four cubics stray 2.7e-4 of the radius, and the file has 1e-5 mm decimals: 7e-5 of it
    np.testing.assert_allclose(radius, 1 / np.sqrt(np.pi), rtol=4e-4)


def test_a_library_can_be_loaded_by_its_path(tmp_path: Path) -> None:
    copy = tmp_path / "mine.svg"
    copy.write_bytes((glyphs.FOLDER / "nib-03.svg").read_bytes())
    for mine, ours in zip(glyphs.load(copy).glyphs, glyphs.load("nib-03").glyphs, strict=True):
        np.testing.assert_array_equal(mine.paths.xy, ours.paths.xy)


def library(*outlines: str, about: object = None) -> bytes:
    text = f'<metadata><library xmlns="urn:crowquill:library">{json.dumps(about)}</library></metadata>' if about else ""
    page = 'width="10mm" height="10mm" viewBox="0 0 10 10"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {page}>{text}{"".join(f"<path {d}/>" for d in outlines)}</svg>'.encode()


SQUARE = "M 1,1 C 1,2 1,3 1,4 C 2,4 3,4 4,4 C 4,3 4,2 4,1 C 3,1 2,1 1,1 Z"


def test_numbers_may_be_parted_as_svg_allows() -> None:
    tight = "M1 1C1 2,1 3 1 4C2 4 3 4 4 4C4,3,4,2,4,1C3 1 2 1 1 1Z"
    for d in (SQUARE, tight, SQUARE.replace("4", "+.4e1").replace("C", "\nC\t")):
        (glyph,) = glyphs.parsed(library(f'd="{d}"'), "x.svg").glyphs
        assert glyph.size == pytest.approx(2 * np.sqrt(9 / np.pi), rel=1e-6)  # 3 mm square; svgelements knows the mm to six digits


@pytest.mark.parametrize(
    "shape",
    [
        '<path d="M1 1h3v3h-3z"/>',
        '<path d="m1,1 c0,1 0,2 0,3 c1,0 2,0 3,0 c0,-1 0,-2 0,-3 c-1,0 -2,0 -3,0z"/>',
        '<rect x="1" y="1" width="3" height="3"/>',
        '<g transform="scale(3)"><path d="M0 0H1V1H0z"/></g>',
        '<clipPath id="c"><path d="M0 0h9v9z"/></clipPath><path d="M1 1h3v3h-3z"/>',
    ],
    ids=["straight lines", "relative data", "a rectangle", "a scaled group", "beside a clip"],
)
def test_a_dot_may_be_drawn_in_any_way_that_svg_has(shape: str) -> None:
    (glyph,) = glyphs.parsed(library().replace(b"</svg>", f"{shape}</svg>".encode()), "x.svg").glyphs
    assert (
        glyph.size == pytest.approx(2 * np.sqrt(9 / np.pi), rel=1e-6) and glyph.paths.cubic
    )  # 3 mm square; svgelements knows the mm to six digits


BROKEN = {
    "no path": (library(), "no paths"),
    "no data": (library('id="a"'), "cannot be read"),
    "empty data": (library('id="a" d=""'), "no paths"),
    "two outlines in a path": (library(f'id="a" d="{SQUARE} {SQUARE}"'), "path 'a' is no glyph"),
    "not closed": (library(f'id="a" d="{SQUARE.replace(" Z", "")}"'), "path 'a' is no glyph"),
    "a number short": (library(f'id="a" d="{SQUARE.replace("4,4 C", "4 C")}"'), "path 'a' is no glyph"),
    "no area": (library('id="a" d="M 1,1 C 1,2 1,3 1,4 C 1,3 1,2 1,1 Z"'), "path 'a' is no glyph.*area"),
    "endless number": (library(f'id="a" d="{SQUARE.replace("4", "1e999")}"'), "cannot be read"),
    "metadata a list": (library(f'd="{SQUARE}"', about=["no", "object"]), ""),
    "metadata cut short": (library(f'd="{SQUARE}"').replace(b"<path", b"<library>{</library><path"), ""),
    "file cut short": (b"<svg", "not sound SVG"),
    "not an SVG": (b"<html/>", "not an SVG file"),
    "empty file": (b"", "not sound SVG"),
}


@pytest.mark.parametrize("story", BROKEN)
def test_a_broken_library_is_refused_by_name(story: str) -> None:
    data, says = BROKEN[story]
    with pytest.raises(ValueError, match=f"^x.svg: .*{says}"):
        glyphs.parsed(data, "x.svg")


def test_an_unknown_library_is_refused_and_the_known_ones_are_named() -> None:
    with pytest.raises(ValueError, match=r"no glyph library 'nib-30'; there are .*disc.*nib-03"):
        glyphs.load("nib-30")
    with pytest.raises(FileNotFoundError, match="gone"):
        glyphs.load("gone.svg")


@pytest.mark.parametrize(
    ("glyph", "says"),
    [
        (Glyph(Paths.of([[(-1, -0.5), (1, -0.5), (1, 0.5), (-1, 0.5)]]), 0.3), "has area 2"),
        (Glyph(Paths.of([[(0, 0), (2, 0), (2, 0.5), (0, 0.5)]]), 0.3), "centroid at"),
        (Glyph(Paths.of([[(-0.25, -1), (0.25, -1), (0.25, 1), (-0.25, 1)]]), 0.3), "long axis on y"),
        (Glyph(Paths.of([[(-1, -0.5), (0, -0.5), (1, 0.5), (0, 0.5)]]), 0.3), "tilted"),
        (Glyph.of(Paths.of([[(0, 0), (3, 0), (3, 1), (1, -1), (1, 1), (0, 1)]])), "crosses itself"),
        (Glyph(Paths.of([[(0, 0), (1, 0), (1, 1)]], closed=False), 0.3), "not one closed outline"),
    ],
)
def test_the_check_of_a_glyph_fails_on_one_that(glyph: Glyph, says: str) -> None:
    with pytest.raises(AssertionError, match=says):
        sound(glyph, "it")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"licence": None}, "empty metadata"),
        ({"source": " "}, "empty metadata"),
        ({"simulated": "yes"}, "simulated"),
        ({"count": 39}, "count"),
        ({"pen_mm": 0.35}, "not of a 0.35 mm pen"),
    ],
)
def test_the_check_of_a_library_fails_on_metadata_that_lie(change: dict[str, object], says: str) -> None:
    nib = glyphs.load("nib-03")
    with pytest.raises(AssertionError, match=says):
        contract(glyphs.Library(nib.name, nib.glyphs, {**nib.about, **change}))
    with pytest.raises(AssertionError, match="lacks"):
        contract(glyphs.Library(nib.name, nib.glyphs, {key: nib.about[key] for key in nib.about if key not in change}))


def test_the_check_of_a_library_fails_on_a_blot() -> None:
    nib = glyphs.load("nib-03")
    blot = Glyph(nib.glyphs[0].paths, 0.61)
    with pytest.raises(AssertionError, match="not of this pen"):
        contract(glyphs.Library(nib.name, (blot, *nib.glyphs[1:]), nib.about))
