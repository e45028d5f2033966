"""Sheets to be pasted together: every dot is on each sheet that shows it, at its place, and sheets join by their marks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pikepdf
import pytest
from PIL import Image

import crowquill
from crowquill import pasting
from crowquill.__main__ import main
from crowquill.marks import Marks, together
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet
from crowquill.units import POINT

UM = 1e-3


def dots(size: tuple[float, float], n: int = 400, seed: int = 0) -> Sheet:
    """Dots of .5 mm at random, some of them over every edge."""
    from crowquill import glyphs

    places = np.random.default_rng(seed).random((n, 2)) * size
    return Sheet(size, (Layer(Ink(), Marks.of(places, glyphs.load("disc").glyphs, scale=0.5)),))


def wanted(size: tuple[float, float], sheets: str, overlap: float = 10.0) -> pasting.Cut:
    found = pasting.cut(size, sheets=sheets, sheet_overlap=overlap)
    assert found is not None
    return found


def shown(cut: pasting.Cut, drawing: Sheet, place: pasting.Place) -> Any:
    """The places of a sheet's dots on the whole drawing (n, 2) mm."""
    layers = [layer.art for layer in cut.sheet(drawing, place).layers if isinstance(layer.art, Marks)]
    return (together(layers).xy if layers else np.zeros((0, 2))) - pasting.MARGIN + cut.corner(place)


@pytest.mark.parametrize("overlap", [0.0, 10.0, 35.0])
def test_each_dot_is_whole_on_every_sheet_that_shows_any_of_it_and_on_no_other(overlap):
    drawing = dots((300.0, 260.0))
    cut = wanted(drawing.size, "120x110mm", overlap)
    radius, every = 0.5 / np.sqrt(np.pi), drawing.marks.xy
    met = set()
    for place in cut.places:
        low = cut.corner(place)
        high = np.minimum(low + cut.room, drawing.size)
        outside = np.hypot(*np.maximum(0, np.maximum(low - every, every - high)).T)
        found = {tuple(xy) for xy in np.round(shown(cut, drawing, place), 3)}
        assert {tuple(xy) for xy in every[outside < radius - UM]} <= found
        assert found <= {tuple(xy) for xy in every[outside < radius * np.sqrt(2) + UM]}
        met |= found
    assert len(met) == len(every)


@pytest.mark.parametrize(
    ("size", "paper", "overlap"), [((300, 260), (120, 110), 10), ((1430, 1080), (210, 297), 15), ((96, 86), (120, 110), 10)]
)
def test_sheets_cover_all_and_share_the_overlap(size, paper, overlap):
    cut = pasting.Cut(size, paper, overlap)
    columns, rows = cut.shape
    last = cut.corner((columns - 1, rows - 1)) + cut.room
    assert (last >= np.array(size) - UM).all()
    assert (last - cut.room + overlap <= np.array(size) + UM).all(), "a sheet more than it takes"
    if columns > 1:
        assert cut.corner((0, 0))[0] + cut.room[0] - cut.corner((1, 0))[0] == pytest.approx(overlap, abs=UM)


def test_a_paper_with_a_name_lies_as_makes_the_fewest_sheets():
    assert wanted((270.0, 180.0), "a4").paper == (297.0, 210.0)
    assert wanted((270.0, 180.0), "a4").shape == (1, 1)
    assert wanted((180.0, 270.0), "a4").paper == (210.0, 297.0)
    assert wanted((270.0, 180.0), "210x297mm").paper == (210.0, 297.0)


def test_ticks_of_neighbours_meet_when_they_lie_on_each_other():
    drawing = dots((300.0, 100.0))
    cut = wanted(drawing.size, "120x140mm")
    ticks = []
    for column in (0, 1):
        (layer,) = [layer for layer in cut.sheet(drawing, (column, 0)).layers if layer.label == "sheet marks"]
        assert isinstance(layer.art, Paths)
        rings = [ring for ring in layer.art if len(ring) == 4 and np.ptp(ring[:, 0]) < 0.2]
        ticks.append({round(float(ring[:, 0].mean() - pasting.MARGIN + cut.corner((column, 0))[0]), 3) for ring in rings})
    shared = {round(float(cut.corner((1, 0))[0]), 3), round(float(cut.corner((0, 0))[0] + cut.room[0]), 3)}
    assert shared <= ticks[0] & ticks[1]


def test_lines_end_where_a_sheet_does():
    line = Layer(Ink(pen=0.2), Paths.of([[(1.0, 50.0), (299.0, 51.0)]], closed=False))
    drawing = Sheet((300.0, 100.0), (line,))
    cut = wanted(drawing.size, "120x140mm")
    long = 0.0
    for place in cut.places:
        found = cut.sheet(drawing, place).layers[0].art
        assert isinstance(found, Paths)
        x = found.xy[:, 0]
        assert pasting.MARGIN - UM <= x.min() <= x.max() <= pasting.MARGIN + cut.room[0] + UM
        long += float(np.ptp(x))
    assert long == pytest.approx(298 + (len(cut.places) - 1) * cut.overlap, abs=0.01)


def test_areas_keep_their_holes_and_colours():
    square = [(10.0, 10.0), (290.0, 10.0), (290.0, 90.0), (10.0, 90.0)]
    fill = np.array([(0.0, 0.5, 0.2, 0.0)])
    drawing = Sheet((300.0, 100.0), (Layer(Ink(), Paths.of([square]), fill=fill),))
    cut = wanted(drawing.size, "120x140mm", 0.0)
    parts = [cut.sheet(drawing, place).layers[0] for place in cut.places]
    assert sum(abs(float(part.art.areas.sum())) for part in parts if isinstance(part.art, Paths)) == pytest.approx(280 * 80, abs=1)
    assert all((part.fill == fill).all() for part in parts)


def test_pixels_are_not_cut():
    drawing = Sheet((300.0, 100.0), (Layer(Ink(), Bitmap.of(np.ones((4, 4)), 1.0)),))
    with pytest.raises(ValueError, match="pixels of a device are not cut to sheets; leave out sheets"):
        wanted(drawing.size, "a4").sheet(drawing, (0, 0))


@pytest.mark.parametrize(
    ("sheets", "overlap", "said"),
    [
        ("30x30mm", 10.0, "leave nothing between margins of 12 mm and an overlap of 10 mm"),
        ("a4", 190.0, "leave nothing between"),
        ("25x25mm", 0.0, "over the limit of 10000"),
        ("a9", 10.0, "no paper 'a9'"),
    ],
)
def test_what_makes_no_sheets_is_refused(sheets, overlap, said):
    with pytest.raises(ValueError, match=said):
        pasting.cut((3000.0, 2000.0), sheets=sheets, sheet_overlap=overlap)


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(40, 250, 80).astype(np.uint8), (60, 1))).save("ramp.png")
    return tmp_path


QUICK = ("--paper", "300x400mm", "--tone", "grey", "--dots", "1500", "--iterations", "2", "--quiet")


def test_a_wall_print_is_a_file_a_sheet_and_redo_gives_the_same_bytes(desk):
    assert main(["stipple", "ramp.png", "wall.pdf", "wall.svg", "--sheets", "a4", "--sheet-overlap", "12mm", *QUICK]) == 0
    names = {f"wall-{name}.{kind}" for name in ("A1", "A2", "B1", "B2") for kind in ("pdf", "svg")}
    assert {path.name for path in desk.iterdir()} == names | {"ramp.png"}
    assert main(["redo", "wall-B2.pdf", "again.pdf", "again.svg", "--quiet"]) == 0
    for name in names:
        assert Path(name).read_bytes() == Path(name.replace("wall", "again")).read_bytes()
    with pikepdf.open("wall-A1.pdf") as pdf:
        sides = [float(side) * POINT for side in pdf.pages[0].mediabox[2:]]
    assert sorted(sides) == pytest.approx([210, 297], abs=UM)
    page = crowquill.load("wall-B1.svg")
    assert page.recipe["files"] == {"sheets": "a4", "sheet_overlap": 12.0}


REFUSED = {
    "overlap alone": (["--sheet-overlap", "5mm"], "--sheet-overlap is given for no sheets; add sheets a4, or leave it out"),
    "plates": (["--sheets", "a4", "--plates", "."], "plates are of one sheet each"),
    "a file that is there": (["--sheets", "a4", "--no-overwrite"], "wall-A1.pdf: is there already"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_cut_is_refused_before_any_work(desk, capsys, name):
    Path("wall-A1.pdf").write_bytes(b"mine")
    arguments, said = REFUSED[name]
    assert main(["stipple", "ramp.png", "wall.pdf", *QUICK, *arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error
    assert Path("wall-A1.pdf").read_bytes() == b"mine"
    assert {path.name for path in desk.iterdir()} == {"ramp.png", "wall-A1.pdf"}


def test_a_plate_can_be_a_wall_print_too(desk):
    Path("plate.toml").write_text('[page]\npaper = "a5"\n[[panel]]\npicture = "ramp.png"\nknobs = { dots = 300, iterations = 1 }\n')
    assert main(["plate", "plate.toml", "plate.pdf", "--sheets", "110x140mm", "--quiet"]) == 0
    assert main(["redo", "plate-A1.pdf", "again.pdf", "--quiet"]) == 0
    names = sorted(path.name for path in desk.glob("plate-*.pdf"))
    assert names == ["plate-A1.pdf", "plate-A2.pdf", "plate-B1.pdf", "plate-B2.pdf"]
    for name in names:
        assert Path(name).read_bytes() == Path(name.replace("plate", "again")).read_bytes()
