"""Another paper: all of a drawing goes with it, to the micrometre or by one factor, and files of it open again over their picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pikepdf
import pytest
import shapely
from editing import digest, do, drawing, items, picture, way

from crowquill import formats
from crowquill.__main__ import main
from crowquill.editor.drawing import Drawing, Layer, Map, Picture, Tiling, sheet_of
from crowquill.editor.items import Items
from crowquill.editor.session import Session
from crowquill.lettering import Words
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.recipe import Recipe
from crowquill.sheet import Bitmap, Ink, Sheet
from crowquill.sheet import Layer as Printed


def full() -> Drawing:
    """Marks, some frozen, a locked layer of strokes, tiles, importance and a wall."""
    found = do(drawing(50, 3), "freeze", path=way((40, 30)), size=20)
    found = do(found, "wall", path=way((20, 20), (60, 20), (60, 40)))
    found = do(do(found, "paint", path=way((40, 30)), map="importance"), "tile", side=8)
    return do(do(found, "layer add", pen=0.4), "layer edit", layer=3, locked=True)


def test_all_of_a_drawing_goes_to_the_middle_of_the_paper_to_the_micrometre():
    before = full()
    after = do(before, "paper", paper="101x90.5mm", margin=4)
    assert after.size == (101, 90.5) and after.margin == 4
    offset = (10_500, 15_250)
    for was, now in zip(before.layers, after.layers, strict=True):
        assert (now.items.um - was.items.um == offset).all() and (now.items.scale == was.items.scale).all()
        assert now.tiling == was.tiling and now.ink == was.ink
    assert np.allclose(after.picture.corner, before.picture.corner + np.array(offset) / 1000) and after.picture.size == before.picture.size
    assert after.wall and before.wall and np.allclose(after.wall.xy - before.wall.xy, np.array(offset) / 1000)
    assert after.tone is before.tone and after.wish is before.wish
    back = do(after, "paper", paper="80x60mm")
    assert [(layer.items.um == was.items.um).all() for layer, was in zip(back.layers, before.layers, strict=True)] == [True] * 3


def test_a_drawing_that_is_scaled_fills_its_room_and_keeps_its_tone():
    before = full()
    after = do(before, "paper", paper="40x60mm", margin=5, scale=True)  # 60 x 40 mm become 30 x 20
    assert after.picture.size == pytest.approx((30, 20)) and after.picture.corner.tolist() == [5, 20]
    for was, now in zip(before.layers, after.layers, strict=True):
        assert np.abs(now.items.xy - (was.items.xy - 10) / 2 - (5, 20)).max(initial=0) <= 0.5e-3 + 1e-9
        assert np.abs(now.items.mm - was.items.mm / 2).max(initial=0) <= 0.5e-3 + 1e-9
    assert after.layers[1].tiling == Tiling(4, before.layers[1].tiling.aspect, before.layers[1].tiling.gap / 2)  # type: ignore[union-attr]
    assert after.layers[2].ink.pen == 0.2
    assert after.picture.placed.bounds == pytest.approx((5, 20, 35, 40))
    assert after.toned().ink == pytest.approx(before.toned().ink / 4)


def test_the_paper_is_turned_alone():
    after = do(drawing(), "paper", orientation="portrait")
    assert after.size == (60, 80) and after.picture.corner.tolist() == [0, 20]


def test_on_white_paper_all_the_paper_is_drawn_on_and_what_was_painted_stays_where_it_was():
    painted = np.zeros((60, 80), np.uint16)
    painted[10:12, 20:22] = 7
    before = replace(drawing(), picture=Picture(np.zeros(2), (80, 60), shapely.box(0, 0, 80, 60)), tone=Map(painted))
    wider = do(before, "paper", paper="100x60mm")
    assert wider.picture.size == (100, 60) and wider.tone.values.shape == (60, 100)
    assert wider.tone.values[10:12, 30:32].tolist() == [[7, 7]] * 2 and wider.tone.values.sum() == painted.sum()
    assert do(wider, "paper", paper="80x60mm").tone.values.tolist() == painted.tolist()
    with_dot = before.added(before.layers[0], Items.of(0, np.array([[3.0, 3.0]]), scale=1))
    with pytest.raises(ValueError, match="1 marks would lie off a paper of 60 x 60 mm"):
        do(with_dot, "paper", paper="60x60mm")
    assert items(do(with_dot, "paper", paper="40x30mm", scale=True)).um.tolist() == [[1500, 1500]]


STILL = {
    "marks": Marks.of([[10, 20]], drawing().kinds[0].glyph and (drawing().kinds[0].glyph,), scale=1),  # type: ignore[arg-type]
    "paths": Paths.of([[(10, 20), (11, 20), (11, 22)]]),
    "words": Words.of([("Tafel", 10, 20)], size=4),
    "bitmap": Bitmap.of(np.ones((4, 8)), 254, (10, 20)),
}


@pytest.mark.parametrize("art", STILL.values(), ids=STILL)
@pytest.mark.parametrize("scale", [False, True])
def test_what_is_shown_and_not_edited_goes_along(art: Any, scale: bool):
    still = Printed(Ink(), art)
    before = replace(drawing(), layers=(Layer(1, "", Ink(), Items.none(), still=still),))
    after = do(before, "paper", paper="160x120mm", margin=20, scale=scale)  # 60 x 40 mm lie at 50, 40; or become 120 x 80 at 20, 20
    was, now = (sheet_of(one).layers[0].art for one in (before, after))
    corner = [np.asarray(one.corner if isinstance(one, Bitmap) else one.xy[0]) for one in (was, now)]
    assert np.allclose(corner[1], 2 * (corner[0] - 10) + 20 if scale else corner[0] + (40, 30), atol=1e-3)
    if scale:
        sides = [
            one.size if isinstance(one, Bitmap) else np.ptp(getattr(one, "outlines", lambda one=one: one)().xy, axis=0)
            for one in (was, now)
        ]
        assert np.allclose(sides[1], 2 * np.asarray(sides[0]), rtol=2e-3)


def test_a_picture_just_opened_fills_another_paper_too_and_a_check_bar_keeps_its_length(tmp_path: Path):
    path = picture(tmp_path / "ramp.png")
    session = Session(path, Recipe("stipple", paper={"paper": "80x60mm", "margin": 10, "check_bar": True}))
    bar = session.drawing.layers[1].items
    assert session.apply("paper", {"paper": "160x110mm", "margin": 5}, None, 1)
    found = session.drawing
    assert found.picture.size == pytest.approx((150, 100)) and found.picture.corner.tolist() == [5, 5]
    assert (found.layers[1].items.um - bar.um == (-5_000, 52_500)).all()  # from 10, 55 to 5, 107.5
    assert (found.layers[1].items.scale == bar.scale).all()
    assert not session.apply("paper", {}, None, 2)  # nothing asked, nothing kept
    session.close()


def test_a_drawing_on_another_paper_is_written_opened_replayed_and_undone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    session = Session(picture(Path("ramp.png")), Recipe("stipple", paper={"paper": "80x60mm", "margin": 10}))
    first = digest(session.drawing)
    for k, (op, params) in enumerate(
        [
            ("redraw stipple", {"dots": 60, "iterations": 1}),
            ("paper", {"paper": "50x50mm", "margin": 5, "scale": True}),
            ("layer edit", {"layer": 1, "spot": "Gold", "cmyk": [0, 0.2, 0.6, 0.1]}),
            ("jitter", {"on": "all"}),
        ]
    ):
        assert session.apply(op, params, None, k + 1)
    session.journal.write()
    session.export(["a.svg", "a.pdf"], {})
    drawn = digest(session.drawing)
    assert session.undo(4) == 4 and digest(session.drawing) == first and session.drawing.size == (80, 60)
    assert session.redo(4) == 4 and digest(session.drawing) == drawn and session.drawing.size == (50, 50)
    session.journal.write()
    session.close()
    assert main(["replay", "ramp.png.edits", "b.svg", "b.pdf"]) == 0
    assert all(Path(f"a.{suffix}").read_bytes() == Path(f"b.{suffix}").read_bytes() for suffix in ("svg", "pdf"))
    again = Session(Path("ramp.png"))
    assert digest(again.drawing) == drawn and again.drawing.size == (50, 50)
    again.close()
    over = Session(Path("a.svg"))
    assert over.drawing.size == (50, 50) and over.drawing.layers[0].ink.name == "Gold"
    assert over.drawing.picture.size == pytest.approx((40, 40 * 2 / 3)) and over.drawing.picture.rgb is not None
    over.close()
    sheet: Sheet = formats.load(Path("a.svg"))
    assert sheet.size == (50, 50) and sheet.layers[0].ink.spot
    with pikepdf.open("a.pdf") as pdf:
        assert [float(side) * 25.4 / 72 for side in pdf.pages[0].MediaBox] == pytest.approx([0, 0, 50, 50], abs=1e-3)
        spaces = pdf.pages[0].Resources.ColorSpace
        assert ["/Separation", "/Gold"] in [[str(part) for part in list(space)[:2]] for space in spaces.values()]  # type: ignore[operator]
