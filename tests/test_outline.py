"""Lines laid over a picture lie where they were drawn, and all other ink keeps its distance from them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from drawings import NIB
from PIL import Image

import crowquill
from crowquill import formats, raster
from crowquill.__main__ import main
from crowquill.finishing import Finish, finish
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet, outlined
from crowquill.tone import Tone

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300"><g fill="none" stroke="red">{}</g></svg>'
RING = '<circle cx="200" cy="150" r="90" stroke-width="4"/><path d="M20 280C150 20 250 300 390 30" stroke-width="8"/>'
QUICK = ["--paper", "60x50mm", "--margin", "5mm", "--width", "40mm", "--quiet", "--overwrite"]
GREY = Tone(np.full((30, 40), 0.6), (40, 30))
SQUARE = Paths.of([[(10, 10), (20, 10), (20, 20), (10, 20)]])


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder where we are: it has ramp.png, 40 by 30 pixels, and lines.svg."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(20, 230, 40).astype(np.uint8), (30, 1))).save("ramp.png")
    Path("lines.svg").write_text(SVG.format(RING), encoding="utf-8")
    return tmp_path


def run(*arguments: str) -> Sheet:
    assert main([str(argument) for argument in arguments]) == 0
    return formats.load(next(a for a in arguments if a.endswith(".svg") and a != "lines.svg"))


def ink(layer: Layer) -> Any:
    """What a layer covers, as exact as 1e-4 mm, on the outside of its curves' chords."""
    paths = outlined(layer.art).flat(1e-5)
    return raster.stroked(paths, layer.ink.pen, 1e-5).polygons() if layer.ink.pen else paths.polygons()


def distance(sheet: Sheet) -> float:
    """The least distance of edges of lines to edges of all below them, mm; lines are those of layers named outline."""
    lines = [layer for layer in sheet.layers if layer.name.startswith("outline")]
    others = [layer for layer in sheet.layers if not layer.name.startswith(("outline", "scale"))]
    near = []
    for line in lines:
        middles = np.array([shapely.LineString(path) for path in line.art])
        for layer in others:
            art = layer.art
            shapes = [shapely.LineString(path) for path in art.flat(1e-5)] if layer.ink.pen else list(ink(layer))
            found = shapely.STRtree(middles).query_nearest(shapes, return_distance=True)[1]
            near.append(found.min() - line.ink.pen / 2 - (layer.ink.pen or 0) / 2)
    return float(min(near))


@pytest.mark.parametrize(
    "drawn",
    [
        ("stipple", "--pen", "0.4mm", "--glyphs", "brush"),
        ("stipple", "--sizes", "0.3mm,0.6mm"),
        ("stipple", "--dots", "900", "--size-by", "tone"),
        ("cells", "--pen", "0.3mm"),
        ("tour", "--pen", "0.4mm", "--rounded", "--width-by", "tone"),
    ],
    ids=" ".join,
)
@pytest.mark.parametrize("gap", [0.15, 0.4])
def test_no_ink_comes_nearer_to_lines_than_the_gap(drawn: tuple[str, ...], gap: float):
    sheet = run(
        drawn[0], "ramp.png", "a.svg", *drawn[1:], "--iterations", "3", "--outline", "lines.svg", "--outline-gap", f"{gap}mm", *QUICK
    )
    assert [layer.ink.pen for layer in sheet.layers if layer.name.startswith("outline")] == [0.4, 0.8]
    assert gap - 1e-3 <= distance(sheet) < gap + 0.3, "and the nearest is about as near as it may be"


def test_the_measure_of_distance_sees_a_dot_that_is_too_near():
    dot = Layer(Ink(), Marks.of([(5.0, 5.0)], NIB[:1], scale=1.0))
    line = Layer(Ink("outline", pen=0.2), Paths.of([[(7, 0), (7, 9)]], closed=False), "outline")
    edge = outlined(dot.art).flat(1e-6).xy[:, 0].max()
    assert abs(distance(Sheet((9, 9), (dot, line))) - (7 - 0.1 - edge)) < 1e-3


def test_tone_adapts_to_the_lines_so_that_few_marks_are_left_out():
    run("stipple", "ramp.png", "a.svg", "--pen", "0.4mm", "--outline", "lines.svg", "--report", "r.json", *QUICK)
    report = json.loads(Path("r.json").read_text(encoding="utf-8"))
    assert report["finish"]["marks_left_out"] < 0.01 * report["marks"]
    assert report["coverage_missing"] < 0.02
    sheet = formats.load("a.svg")
    assert report["marks"] == len(sheet.marks)


def laid(svg: str, tone: Tone = GREY, frame: tuple[float, ...] = (0, 0, 1, 1), **knobs: Any) -> Finish:
    Path("other.svg").write_text(svg, encoding="utf-8")
    return finish(tone, frame, outline="other.svg", **knobs)  # type: ignore[arg-type]


def test_the_page_is_laid_over_the_picture_and_widths_are_in_proportion():
    (found,) = laid(SVG.format('<path d="M100 0V300" stroke-width="5"/>')).lines.items()
    assert found[0] == 0.5 and found[1].bounds == (10, 0, 10, 30)


def test_a_width_given_goes_for_all_lines():
    assert list(laid(SVG.format(RING), outline_width=0.3).lines) == [0.3]


def test_a_filled_shape_is_drawn_as_its_outline_and_what_nobody_sees_is_not():
    shapes = '<path d="M0 0H80V80Z" fill="blue" stroke="none"/><path d="M9 9H30" stroke="none"/><path d="M9 9H30" stroke-width="0"/>'
    (found,) = laid(SVG.format(shapes)).lines.items()
    assert found[0] == 0.25 and found[1].equals(shapely.MultiLineString([[(0, 0), (8, 0), (8, 8), (0, 0)]]))


def test_lines_go_with_crop_and_fit():
    line = '<path d="M200 150H400" stroke-width="4"/>'
    Path("lines.svg").write_text(SVG.format(line), encoding="utf-8")
    page = ("--paper", "40x40mm", "--margin", "0mm", "--pen", "0.5mm", "--outline", "lines.svg", "--iterations", "1", "--quiet")

    def ends(name: str, *more: str) -> list[list[float]]:
        (found,) = [layer for layer in run("stipple", "ramp.png", name, *page, *more).layers if layer.name == "outline"]
        return np.round(found.art.xy, 3).tolist()

    assert ends("a.svg", "--crop", "0.25,0.25,0.5,0.5") == [[20, 20], [40, 20]]  # 20 x 15 pixels, drawn 40 x 30 mm
    assert ends("b.svg", "--width", "30mm", "--height", "30mm", "--fit", "cover") == [[20, 20], [35, 20]]
    assert ends("c.svg", "--width", "30mm", "--height", "30mm", "--fit", "stretch") == [[20, 20], [35, 20]]


def test_strokes_are_cut_and_filled_areas_too():
    over = laid(SVG.format('<path d="M0 150H400" stroke-width="4"/>'), outline_gap=0.3)
    line = Layer(Ink(pen=0.2), Paths.of([[(5, 0), (5, 30)]], closed=False))
    ring = Layer(Ink(pen=0.2), SQUARE)
    whole = Layer(Ink(), SQUARE.moved(np.eye(2), (10, 0)).curved())
    made = over.drawn(Sheet((40, 30), (line, ring, whole), report={"warnings": [], "ink_placed_mm2": 112.0, "ink_asked_mm2": 112.0}))
    half = 0.2 + 0.3 + 1e-3  # of the line, the gap, and what rounding may take
    cut = 2 * (half + 0.1)
    assert np.allclose(np.sort(made.layers[0].art.xy[:, 1]), [0, 15 - cut / 2, 15 + cut / 2, 30], atol=1e-3)
    assert len(made.layers[1].art) == 2 and not made.layers[1].art.closed
    assert np.isclose(made.layers[2].art.areas.sum(), 100 - 10 * 2 * half, atol=0.02)
    assert np.isclose(made.report["finish"]["cut_mm"], 3 * cut, atol=0.01)
    assert np.isclose(made.report["finish"]["cut_mm2"], 3 * cut * 0.2 + 20 * half, atol=0.02)
    assert np.isclose(made.report["ink_placed_mm2"], 112 - made.report["finish"]["cut_mm2"])


def test_rings_of_their_own_colours_keep_them_and_have_no_holes():
    over = laid(SVG.format('<circle cx="150" cy="150" r="20" stroke-width="4"/>'))
    colours = np.array([[0, 1, 0, 0], [1, 0, 0, 0.5]])
    tiles = Layer(Ink(), Paths.of([*SQUARE, *SQUARE.moved(np.eye(2), (15, 0))]), fill=colours)
    made = over.drawn(Sheet((40, 30), (tiles,))).layers[0]
    assert made.art.areas.min() > 0 and len(made.art) > 2
    for colour, left in zip(colours, (10, 25), strict=True):
        area = made.art.areas[(made.fill == colour).all(axis=1)].sum()
        ring = np.pi * ((2 + 0.2 + 0.15 + 1e-3) ** 2 - (2 - 0.2 - 0.15 - 1e-3) ** 2)
        assert np.isclose(area, 100 - (ring if left == 10 else 0), atol=0.02)


def test_marks_that_reach_too_near_go_and_it_is_said():
    over = laid(SVG.format('<path d="M200 0V300" stroke-width="4"/>'))
    marks = Marks.of([(19.0, 5), (19.6, 9), (20.0, 12), (25.0, 15)], crowquill.glyphs.load("disc").glyphs, scale=0.6)  # type: ignore[attr-defined]
    made = over.drawn(Sheet((40, 30), (Layer(Ink(), marks),), report={"warnings": [], "marks": 4, "ink_placed_mm2": 4.0}))
    assert made.marks.xy[:, 0].tolist() == [19, 25] and made.report["marks"] == 2
    assert "2 marks" in made.report["warnings"][0] and np.isclose(made.report["ink_placed_mm2"], 2 * 0.36, atol=1e-3)


def test_pixels_cannot_be_cut():
    over = laid(SVG.format(RING))
    with pytest.raises(ValueError, match="leave out outline"):
        over.drawn(Sheet((40, 30), (Layer(Ink(), Bitmap.of(np.ones((5, 5)), 300)),)))


def test_without_lines_a_drawing_stays_as_it_is():
    plain = finish(GREY)
    sheet = Sheet((40, 30), (Layer(Ink(), SQUARE),))
    assert plain.drawn(sheet) is sheet and plain.freed(GREY, 0.3) is GREY


def test_a_plotter_draws_lines_with_a_pen_of_their_own():
    more = ("--outline", "lines.svg", "--outline-width", "0.3mm", "--pen", "0.3mm", "--for", "plotter")
    sheet = run("stipple", "ramp.png", "a.svg", "--iterations", "1", *more, *QUICK)
    assert [layer.name for layer in sheet.layers] == ["1 black 0.3", "2 outline 0.3"]
    assert all(layer.ink.pen == 0.3 for layer in sheet.layers)


def test_lines_are_read_on_a_dry_run_and_nothing_is_written(capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", "a.svg", "--outline", "lines.svg", "--dry-run", "--paper", "a5"]) == 0
    free = capsys.readouterr().out
    assert main(["stipple", "ramp.png", "a.svg", "--dry-run", "--paper", "a5"]) == 0
    asked = [float(next(line for line in out.splitlines() if line.startswith("ink")).split()[1]) for out in (free, capsys.readouterr().out)]
    assert 0.8 * asked[1] < asked[0] < 0.99 * asked[1] and not Path("a.svg").exists()


def test_a_drawing_with_lines_is_made_again_to_the_byte(desk: Path):
    run("stipple", "ramp.png", "a.svg", "--outline", "lines.svg", "--dots", "200", "--iterations", "1", "--embed", *QUICK)
    (desk / "far").mkdir()
    Path("a.svg").rename("far/a.svg")
    Path("lines.svg").unlink()
    assert main(["redo", "far/a.svg", "b.svg", "--quiet"]) == 0
    assert Path("b.svg").read_bytes() == Path("far/a.svg").read_bytes()


BAD = {
    "absent.svg": "check the name",
    "lines": "give an SVG",
    "ramp.png": "give an SVG",
    "empty.svg": "has no line",
    "off.svg": "has no line",
    "page.svg": "page has no size",
    "broken.svg": "not sound SVG",
    "full.svg": "no room",
}


@pytest.mark.parametrize(("name", "why"), BAD.items())
def test_what_is_no_outline_is_refused_in_one_line(name: str, why: str, capsys: pytest.CaptureFixture[str]):
    Path("empty.svg").write_text(SVG.format(""), encoding="utf-8")
    Path("off.svg").write_text(SVG.format('<path d="M500 0V9"/>'), encoding="utf-8")
    Path("page.svg").write_text(SVG.format(RING).replace("viewBox", 'width="0" viewBox'), encoding="utf-8")
    Path("broken.svg").write_text(SVG[:40], encoding="utf-8")
    Path("full.svg").write_text(SVG.format('<path d="M0 150H400" stroke-width="400"/>'), encoding="utf-8")
    assert main(["stipple", "ramp.png", "a.svg", "--outline", name, *QUICK]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line and why in line
    assert not Path("a.svg").exists()


def test_a_width_for_no_outline_is_refused():
    with pytest.raises(ValueError, match="add outline"):
        finish(GREY, outline_width=0.3)


def test_a_crop_that_leaves_no_line_says_so():
    with pytest.raises(ValueError, match="that the crop leaves"):
        laid(SVG.format('<path d="M0 10H400"/>'), replace(GREY), (0.2, 0.2, 0.5, 0.5))


@pytest.fixture
def disc() -> str:
    """disc.png, 240 by 180 pixels: a dark disc of 60 pixels' radius on light grey, a step of 0.6."""
    far = np.hypot(*np.meshgrid(np.arange(240) - 119.5, np.arange(180) - 89.5))
    Image.fromarray(np.round(255 * (0.8 - 0.6 * np.clip(60.5 - far, 0, 1))).astype(np.uint8)).save("disc.png")
    return "disc.png"


@pytest.mark.parametrize(
    "drawn",
    [("stipple", "--pen", "0.4mm"), ("hedcut", "--pen", "0.4mm"), ("cells", "--pen", "0.3mm"), ("screen", "--lpi", "20"), ("mosaic",)],
    ids=lambda drawn: drawn[0],
)
def test_found_edges_are_drawn_over_any_style_and_its_ink_keeps_off(drawn: tuple[str, ...], disc: str):
    sheet = run(*drawn[:1], disc, "a.svg", *drawn[1:], "--outline", "edges", "--outline-width", "0.4mm", *QUICK)
    (line,) = [layer for layer in sheet.layers if layer.name == "outline"]
    assert line.ink.pen == 0.4 and len(line.art) == 1
    far = np.hypot(*(line.art.xy - sheet.size[0] / 2 - (0, (sheet.size[1] - sheet.size[0]) / 2)).T)
    assert np.abs(far - (10 - 0.25)).max() < 0.1  # mm: inside the disc by about half a stroke; pixels are 0.17 wide
    assert distance(sheet) >= 0.15 - 2e-3  # lengths are whole micrometres


def test_more_detail_finds_more_edges():
    grey = Tone(np.where(np.arange(80) < 40, 0.3, 0.38) * np.ones((60, 1)), (40, 30))
    assert list(finish(grey, outline="edges", outline_detail=0.9).lines) == [0.25]
    with pytest.raises(ValueError, match="no edges are found in the picture; give more outline-detail"):
        finish(grey, outline="edges")


def test_edges_are_found_on_the_canvas_alone():
    left = Tone(np.where(np.arange(80) // 20 % 2, 0.7, 0.1) * np.ones((60, 1)), (40, 30), shapely.box(0, 0, 15, 30))
    (lines,) = finish(left, outline="edges").lines.values()
    assert 0 < lines.length < 31 and shapely.buffer(lines, 0.12).within(left.canvas)


def test_a_drawing_with_found_edges_is_made_again_to_the_byte(disc: str):
    run("stipple", disc, "a.svg", "--outline", "edges", "--outline-detail", "0.4", "--dots", "300", "--iterations", "2", *QUICK)
    kept = formats.load("a.svg").recipe["finish"]
    assert (kept["outline"], kept["outline_detail"]) == ("edges", 0.4)
    assert main(["redo", "a.svg", "b.svg", "--quiet"]) == 0 and Path("b.svg").read_bytes() == Path("a.svg").read_bytes()


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (("--outline-detail", "0.4"), "add outline edges"),
        (("--outline", "lines.svg", "--outline-detail", "0.4"), "add outline edges"),
        (("--outline", "edges"), "no edges are found in the picture"),
        (("--outline", "edge"), "give an SVG file, or edges"),
    ],
    ids=lambda part: " ".join(part) if isinstance(part, tuple) else "",
)
def test_edges_that_cannot_be_drawn_are_refused_in_one_line(more: tuple[str, ...], why: str, capsys: pytest.CaptureFixture[str]):
    assert main(["stipple", "ramp.png", "a.svg", *more, *QUICK]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line and why in line
    assert not Path("a.svg").exists()
