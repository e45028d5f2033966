"""Operations of the editor: each does what it says to what is meant, leaves all else as it is to the bit, and refuses what is none."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from editing import CORNER, SIZE, digest, do, drawing, items, way, with_items

from crowquill import knobs, styles
from crowquill.editor.drawing import Drawing, sheet_of
from crowquill.editor.items import COLUMNS, Items, Kind
from crowquill.editor.operations import every
from crowquill.editor.session import same
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink

MIDDLE = (40.0, 30.0)
BRUSH = {"path": way(MIDDLE), "size": 10.0}
ALIKE = {  # with what to try each operation on the drawing of `full`
    "insert": {**BRUSH, "layer": 1, "rate": 50, "gap": 0.02},
    "erase": BRUSH,
    "swap": {**BRUSH, "glyph": "grains"},
    "freeze": BRUSH,
    "push": {"path": way(MIDDLE, (42, 31)), "size": 10},
    "attract": BRUSH,
    "jitter": BRUSH,
    "resize": BRUSH,
    "turn": BRUSH,
    "move": {"dx": 1.5, "angle": 20},
    "duplicate": {},
    "select": {"by": "rectangle", "path": way((20, 20), (30, 30))},
    "relax": {"on": "brush", **BRUSH},
    "wall": {"path": way((20, 20), (60, 20), (60, 40), (20, 40))},
    "tile": {"side": 6},
    "cut": {},
    "paint": BRUSH,
    "layer add": {"name": "second", "cmyk": [1, 0, 0, 0]},
    "layer edit": {"layer": 1, "name": "first", "locked": True},
    "layer remove": {"layer": 1},
    "layer order": {"layer": 1, "to": 1},
    "layer take": {"layer": 2},
    "paper": {"paper": "100x90mm"},
    "redraw stipple": {"dots": 60, "iterations": 2, "path": way((15, 15), (60, 15), (60, 45), (15, 45))},
}
OTHERS = {f"redraw {style}" for style in styles.names()} - set(ALIKE)  # one style stands for all


@pytest.fixture(scope="module")
def full() -> Drawing:
    """Dots, some selected and some frozen, and a layer of tiles."""
    found = do(drawing(400, 3), "select", by="rectangle", path=way((30, 20), (45, 45)))
    found = do(found, "freeze", path=way((38, 28)), size=4)
    return do(found, "tile", side=8, seed=1)


def rows(of: Drawing, within: float, at: tuple[float, float] = MIDDLE) -> Any:
    return np.hypot(*(items(of).xy - at).T) <= within


def unchanged(a: Items, b: Items, which: Any) -> bool:
    return all((getattr(a, name)[which] == getattr(b, name)[which]).all() for name in COLUMNS)


def test_every_operation_is_tried_here():
    assert set(every()) == set(ALIKE) | OTHERS


@pytest.mark.parametrize("name", ALIKE)
def test_an_operation_is_a_function_of_drawing_parameters_and_seed(full, name):
    before = digest(full)
    once, again = do(full, name, 5, **ALIKE[name]), do(full, name, 5, **ALIKE[name])
    assert digest(once) == digest(again) and digest(full) == before
    assert not same(once, full)


@pytest.mark.parametrize("name", ALIKE)
def test_frozen_items_and_items_of_locked_layers_never_change(full, name):
    if name in ("freeze", "layer remove", "paper"):  # another paper moves all there is
        return
    held = items(full).frozen
    made = do(full, name, 5, **ALIKE[name])
    kept = {id: k for k, id in enumerate(items(made).id.tolist())}
    at = [kept[id] for id in items(full).id[held].tolist()]
    assert at and all(
        (getattr(items(full), column)[held] == getattr(items(made), column)[at]).all() for column in COLUMNS if column != "selected"
    )
    locked = full.with_layers(*(replace(layer, locked=True) for layer in full.layers))
    try:
        made = do(locked, name, 5, **ALIKE[name])
    except ValueError:
        return
    assert all(any(layer.items is now.items for now in made.layers) for layer in locked.layers)


@pytest.mark.parametrize("name", ALIKE)
def test_helps_and_knobs_of_an_operation_are_whole(name):
    one = every()[name]
    assert one.about.endswith((".", ")")) or name.startswith("redraw")
    assert one.group in ("brush", "select", "relax", "map", "layer", "paper", "style")
    assert all(knob.takes.help for knob in one.knobs.values())
    own = knobs.of(getattr(one.function, "func", one.function))
    assert list(one.knobs) == [*one.common, *own, *one.more()]


def test_insert_keeps_the_gap_to_all_and_tells_how_many_found_room():
    before = drawing(200)
    made = do(before, "insert", path=way(MIDDLE), size=20, rate=1000, gap=0.2, glyph="disc", diameter=0.5)
    n = len(items(made)) - 200
    assert n == made.facts["inserted"] > 100
    new = items(made).take(slice(200, None))
    reach = before.reach[items(before).kind] * items(before).mm
    apart = np.hypot(*(new.xy[:, None] - items(before).xy[None]).transpose(2, 0, 1))
    # 0.25 mm is the new dot's radius; its reach is a thousandth larger, and places are whole micrometres
    assert (apart - reach[None] - 0.25).min() > 0.2 - 2e-3
    among = np.hypot(*(new.xy[:, None] - new.xy[None]).transpose(2, 0, 1)) + 9 * np.eye(n)
    assert 0.7 - 1e-9 <= among.min() < 0.75
    assert (np.hypot(*(new.xy - MIDDLE).T) <= 10 + 1e-3).all()


def test_insert_with_a_brush_of_no_size_puts_marks_on_the_points():
    made = do(drawing(), "insert", path=way((20, 20), (25, 21)), size=0, rate=1)
    assert items(made).xy.tolist() == [[20, 20], [25, 21]]


def test_marks_that_may_overlap_are_all_inserted_and_none_off_the_paper():
    made = do(drawing(), "insert", path=way((1, 1)), size=10, rate=1000, gap=-50)
    xy = items(made).xy
    assert 200 < len(xy) < 500  # a quarter of the brush is on the paper, and some more
    assert (xy >= 0).all()


def test_erase_takes_all_under_a_flat_brush_and_a_share_by_strength():
    before = drawing(2000)
    made = do(before, "erase", **BRUSH, falloff="flat")
    assert not rows(made, 5).any() and len(items(made)) == 2000 - rows(before, 5).sum()
    half = do(before, "erase", path=way(MIDDLE), size=30, strength=0.5, falloff="flat")
    gone = 1 - rows(half, 15).sum() / rows(before, 15).sum()
    assert 0.4 < gone < 0.6  # of some 590: four standard deviations are 0.08


def test_pressure_is_strength():
    made = do(drawing(2000), "erase", path=way(MIDDLE, pressure=0.0), size=30)
    assert len(items(made)) == 2000


def test_pressure_runs_straight_between_points_and_a_way_back_over_itself_counts_once():
    before = do(drawing(1500), "resize", path=way((20, 30)) + way((60, 30), pressure=0.0), size=12, falloff="flat", factor=2)
    grown = np.log2(items(before).mm / 0.3)
    x, y = items(before).xy.T
    under = (np.abs(y - 30) < 5.9) & (x > 20) & (x < 60)
    # scales are whole micrometres of 300
    assert np.abs(grown[under] - (1 - (x[under] - 20) / 40)).max() < 0.01 and (grown[np.abs(y - 30) > 6.1] == 0).all()
    once = do(drawing(1500), "resize", path=way((20, 30), (60, 30)), size=12, falloff="flat", factor=2)
    twice = do(drawing(1500), "resize", path=way((20, 30), (60, 30), (20, 30), (20, 30)), size=12, falloff="flat", factor=2)
    assert (items(once).scale == items(twice).scale).all()


def test_push_drags_by_the_way_at_full_weight():
    before = with_items(drawing(1), um=np.array([[40_000, 30_000]]))
    made = do(before, "push", path=way(MIDDLE, (41.5, 30.5)), size=5, falloff="flat")
    assert items(made).xy.tolist() == [[41.5, 30.5]]


def test_push_carries_along_what_stays_under_the_brush():
    before = with_items(drawing(1), um=np.array([[40_000, 30_000]]))
    far = do(before, "push", path=way(*((40 + k, 30) for k in range(11))), size=4, falloff="flat")
    assert items(far).xy.tolist() == [[50, 30]]


def test_jitter_is_as_strong_as_it_says_and_goes_no_way_on_the_mean():
    before = drawing(4000)
    made = do(before, "jitter", on="all", amount=0.2)
    off = items(made).xy - items(before).xy
    assert np.allclose(off.std(axis=0), 0.2, rtol=0.05) and np.abs(off.mean(axis=0)).max() < 0.02


def test_attract_moves_to_the_ink_and_stays_where_there_is_none():
    before = drawing(300)
    made = do(before, "attract", on="all", reach=2)
    inner = (np.abs(items(before).xy - CORNER - (30, 20)) < (24, 10)).all(axis=1)
    way_there = (items(made).xy - items(before).xy)[inner]
    # the tone rises by 0.8 in 60 mm; the mean of a Gaussian over a ramp lies variance times slope over value to the right
    value = 0.1 + 0.8 * (items(before).xy[inner, 0] - CORNER[0]) / 60
    assert np.allclose(way_there[:, 0], 4 * 0.8 / 60 / value, rtol=0.05, atol=2e-3)
    assert np.abs(way_there[:, 1]).max() < 2e-3
    white = replace(before, tone=type(before.tone)(np.zeros((40, 60), np.uint16)))
    assert same(do(white, "attract", on="all"), white)


def test_resize_and_turn_go_by_their_weight():
    before = do(drawing(50), "select", by="all")
    larger = do(before, "resize", on="selection", factor=2)
    assert (items(larger).scale == 600).all()
    half = do(before, "resize", on="selection", factor=4, strength=0.5)
    assert (items(half).scale == 600).all()
    turned = do(before, "turn", on="selection", angle=90)
    assert (items(turned).turn == 16384).all()


def test_turn_along_the_flow_lays_long_axes_across_the_slope_and_along_a_stroke_on_it():
    before = with_items(drawing(50), turn=np.full(50, 3000))
    flow = do(before, "turn", on="all", by="flow")  # the tone changes along x, so that it changes least along y
    assert np.abs(np.abs(np.sin(items(flow).angle)) - 1).max() < 0.02
    stroke = do(before, "turn", by="stroke", path=way((10, 10), (50, 50)), size=200, falloff="flat")
    assert (items(stroke).turn == 8192).all()


def test_move_turns_the_selection_as_a_whole_and_duplicate_copies_it():
    before = with_items(drawing(2), um=np.array([[30_000, 30_000], [40_000, 30_000]]))
    before = do(before, "select", by="all")
    made = do(before, "move", dx=5, dy=-2, angle=90)
    assert items(made).xy.tolist() == [[40, 23], [40, 33]]
    assert (items(made).turn == 16384).all()
    copied = do(before, "duplicate", dx=1, dy=1)
    assert items(copied).id.tolist() == [0, 1, 2, 3] and items(copied).selected.tolist() == [False, False, True, True]
    assert items(copied).xy[2:].tolist() == [[31, 31], [41, 31]]


def test_items_stay_on_the_paper():
    before = do(drawing(100), "select", by="all")
    made = do(before, "move", dx=1000, dy=-1000)
    assert (items(made).xy == (SIZE[0], 0)).all()


@pytest.mark.parametrize(
    ("params", "meant"),
    [
        ({"by": "all"}, lambda xy: xy[:, 0] > 0),
        ({"by": "rectangle", "path": way((50, 40), (20, 15))}, lambda xy: ((xy >= (20, 15)) & (xy <= (50, 40))).all(axis=1)),
        ({"by": "lasso", "path": way((10, 10), (50, 10), (10, 50))}, lambda xy: xy.sum(axis=1) <= 60),
        ({"by": "brush", "path": way(MIDDLE), "size": 12}, lambda xy: np.hypot(*(xy - MIDDLE).T) <= 6),
        ({"by": "tone", "low": 0.5, "high": 1}, lambda xy: np.floor(xy[:, 0] - 10) >= 30),  # pixels are 1 mm
    ],
)
def test_selection_takes_what_it_says(params, meant):
    before = drawing(500)
    made = do(before, "select", **params)
    assert (items(made).selected == meant(items(before).xy)).all() and items(made).selected.any()
    rest = do(do(before, "select", by="all"), "select", mode="remove", **params)
    assert (items(rest).selected == ~items(made).selected).all()
    assert (items(do(made, "select", by="invert")).selected == items(rest).selected).all()
    assert not items(do(made, "select", by="none")).selected.any()


def test_pick_takes_the_nearest_and_nothing_where_none_is_near():
    before = with_items(drawing(2), um=np.array([[30_000, 30_000], [31_000, 30_000]]))
    assert items(do(before, "select", by="pick", path=way((30.9, 30)))).selected.tolist() == [False, True]
    far = do(do(before, "select", by="all"), "select", by="pick", path=way((60, 50)))
    assert not items(far).selected.any()


def test_paint_changes_the_tone_under_the_brush_only():
    before = drawing()
    made = do(before, "paint", path=way(MIDDLE), size=10, strength=1, falloff="flat", value=0.25)
    y, x = np.mgrid[0:40, 0:60] + 0.5
    under = np.hypot(x + 10 - 40, y + 10 - 30) <= 5
    assert (made.tone.values[under] == round(65535 / 4)).all()
    assert (made.tone.values[~under] == before.tone.values[~under]).all()
    wished = do(before, "paint", path=way(MIDDLE), size=10, strength=1, falloff="flat", map="importance")
    assert wished.wish and (wished.wish.values[under] == 65535).all() and (wished.wish.values[~under] == 32767).all()
    assert wished.tone is before.tone
    assert same(do(before, "paint", path=way((1, 1)), size=2), before)


def test_layers_are_added_changed_ordered_filled_and_removed():
    found = do(drawing(10), "layer add", name="blue\n", cmyk=[1, 1, 0, 0], pen=0.5)
    assert [layer.name for layer in found.layers] == ["", "blue?"] and found.layers[1].ink.pen == 0.5
    found = do(found, "select", by="rectangle", path=way((0, 0), (40, 60)))
    chosen = items(found).id[items(found).selected].tolist()
    found = do(found, "layer take", layer=2)
    assert items(found, 2).id.tolist() == chosen and len(items(found)) == 10 - len(chosen)
    found = do(found, "layer edit", layer=2, hidden=True, pen=0)
    assert found.layers[1].hidden and found.layers[1].ink.pen is None and len(sheet_of(found).layers) == 1
    found = do(found, "layer order", layer=2, to=0)
    assert [layer.id for layer in found.layers] == [2, 1]
    found = do(do(found, "layer remove", layer=2), "layer add")
    assert [layer.id for layer in found.layers] == [1, 3]


def test_a_spot_ink_keeps_its_name_until_a_mix_alone_is_given():
    found = do(drawing(3), "layer edit", layer=1, spot="PANTONE 185 C", cmyk=[0, 0.9, 0.8, 0], pen=0.3)
    assert found.layers[0].ink == Ink("PANTONE 185 C", (0, 0.9, 0.8, 0), 0.3, spot=True)
    assert sheet_of(do(found, "layer edit", layer=1, pen=0)).layers[0].ink == Ink("PANTONE 185 C", (0, 0.9, 0.8, 0), spot=True)
    assert do(found, "layer edit", layer=1, spot="Gold").layers[0].ink == Ink("Gold", (0, 0.9, 0.8, 0), 0.3, spot=True)
    assert do(found, "layer edit", layer=1, spot="").layers[0].ink == Ink("c0 m90 y80 k0", (0, 0.9, 0.8, 0), 0.3)
    assert do(found, "layer edit", layer=1, cmyk=[0, 0, 0, 1]).layers[0].ink == Ink("black", pen=0.3)
    assert do(drawing(), "layer add", spot="Gold").layers[1].ink == Ink("Gold", spot=True)


def test_swap_keeps_place_and_size():
    before = drawing(100)
    made = do(before, "swap", on="all", glyph="diatoms/2")
    assert (items(made).um == items(before).um).all() and (items(made).scale == items(before).scale).all()
    assert {made.kinds[k].name for k in items(made).kind} == {"diatoms/2"}


def test_a_layer_of_glyphs_is_written_as_marks_and_of_lines_as_paths():
    found = do(drawing(5), "swap", on="all", glyph="grains")
    assert isinstance(sheet_of(found).layers[0].art, Marks)
    cross, at = found.with_kinds([Kind(Paths.of([[(-1, 0), (1, 0)], [(0, -1), (0, 1)]], closed=False))])
    lines = do(with_items(cross, kind=np.full(5, at[0])), "layer edit", layer=1, pen=0.2)
    (layer,) = sheet_of(lines).layers
    assert isinstance(layer.art, Paths) and len(layer.art) == 10 and not layer.art.closed and layer.ink.pen == 0.2


def test_redraw_replaces_what_lies_in_the_region_and_nothing_else():
    before = drawing(500)
    region = {"path": way((15, 15), (40, 15), (40, 45), (15, 45))}
    made = do(before, "redraw stipple", dots=50, iterations=3, **region)
    inside = ((items(before).xy > (15, 15)) & (items(before).xy < (40, 45))).all(axis=1)
    old, new = items(made).take(items(made).id < 500), items(made).take(items(made).id >= 500)
    assert (old.id == items(before).id[~inside]).all() and unchanged(old, items(before).take(~inside), slice(None))
    assert len(new) == 50 and ((new.xy >= (15, 15)) & (new.xy <= (40, 45))).all()


def test_every_style_draws_over_a_picture_with_colours():
    base = drawing()
    rgb = np.full((40, 60, 3), 120, np.uint8)
    base = replace(base, picture=replace(base.picture, rgb=rgb))
    made = do(base, "redraw stipple", dots=5000, iterations=0)  # over a site a pixel
    assert len(items(made)) > 4000


def test_redraw_all_over_is_what_the_style_draws_by_itself():
    from crowquill import styles

    before = drawing(20)
    made = do(before, "redraw stipple", 7, dots=80, iterations=3)
    (layer,) = styles.run(styles.steps("stipple", before.toned(), seed=7, dots=80, iterations=3)).layers
    assert isinstance(layer.art, Marks)
    own = layer.art.moved(CORNER).snapped()
    art = sheet_of(made).layers[0].art
    assert isinstance(art, Marks)
    for name in ("xy", "angle", "scale"):
        assert (getattr(art, name) == getattr(own, name)).all()


@pytest.mark.parametrize(
    ("name", "params", "says"),
    [
        ("erace", {}, "did you mean erase"),
        ("erase", {"syze": 3}, "did you mean size"),
        ("erase", {}, "path has 0 numbers"),
        ("erase", {"path": [1, 2]}, "path has 2 numbers"),
        ("erase", {"path": [1, 2, 3]}, "pressure outside 0 to 1"),
        ("erase", {"path": [1, 2, float("nan")]}, "path is nan"),
        ("erase", {"path": "brush"}, "path is 'brush'"),
        ("erase", {"path": way(MIDDLE), "size": -1}, "size is -1"),
        ("erase", {"path": way(MIDDLE), "size": True}, "size is True"),
        ("erase", {"on": "everything"}, "no on 'everything'"),
        ("erase", {"on": "all", "layer": 9}, "there is no layer 9"),
        ("turn", {"on": "all", "by": "stroke"}, "takes a brush with a way"),
        ("insert", {"path": way(MIDDLE), "glyph": "../nib-03"}, "no library '..'"),
        ("insert", {"path": way(MIDDLE), "glyph": "nib-03/400"}, "it has 0 to"),
        ("insert", {"path": way(*[MIDDLE] * 200), "rate": 1000}, "over 100000"),
        ("select", {"by": "lasso", "path": way(MIDDLE, (41, 30))}, "encloses nothing"),
        ("relax", {"on": "all", "wall": "drawn"}, "no wall is drawn"),
        ("relax", {"on": "all", "variant": "mosaic"}, "there are no tiles here"),
        ("cut", {}, "there are no tiles to cut"),
        ("tile", {"layer": 1}, "has no tiles"),
        ("layer remove", {"layer": 4}, "there is no layer 4"),
        ("layer add", {"cmyk": [1, 2, 0, 0]}, "cmyk is 2"),
        ("layer edit", {"layer": 1, "spot": "black"}, "may not be a process ink's"),
        ("layer add", {"spot": "Gold/Silver"}, "plain letters, digits"),
        ("paper", {"paper": "a11"}, "no paper 'a11'"),
        ("paper", {"paper": "a5", "margin": 80}, "leaves no room"),
        ("paper", {"paper": "70x50mm", "margin": 10}, "does not fit a paper of 70 x 50 mm"),
        ("redraw stipple", {"pen": 1000}, "pen is 1000"),
        ("redraw stipple", {"path": way((1, 1), (5, 1), (5, 5))}, "encloses nothing of the canvas"),
    ],
)
def test_what_is_no_operation_is_refused_by_name(name, params, says):
    with pytest.raises(ValueError, match=says):
        do(drawing(10), name, **params)


def test_a_drawing_holds_no_more_marks_than_it_may(monkeypatch):
    monkeypatch.setattr("crowquill.editor.operations.MOST", 300)
    with pytest.raises(ValueError, match="over the limit of 300"):
        do(drawing(290), "insert", path=way(MIDDLE), size=30, rate=500)
