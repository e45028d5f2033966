"""Relaxation in the editor: a step is the library's own, what is not meant stays to the bit, and a part has its cells of the whole."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from editing import ART, CORNER, digest, do, drawing, items, way, with_items

from crowquill import relax
from crowquill.cells import voronoi
from crowquill.editor.drawing import Drawing, Map
from crowquill.editor.items import COLUMNS
from crowquill.editor.operations import relaxing
from crowquill.moments import of_rings
from crowquill.objects import Objects
from crowquill.settling import settle

UM = 0.5e-3 + 1e-9  # mm: places are whole micrometres
MIDDLE = (40.0, 30.0)
VARIANTS = ("uniform", "weighted", "objects", "move", "turn")


def steps(of: Drawing, n: int, **params: Any) -> Drawing:
    for _ in range(n):
        of = do(of, "relax", **params)
    return of


def unmoved(before: Drawing, after: Drawing, which: Any) -> bool:
    return all((getattr(items(before), name)[which] == getattr(items(after), name)[which]).all() for name in COLUMNS)


def test_a_weighted_step_is_the_librarys():
    before = drawing(300)
    states = relax.lloyd(items(before).xy - CORNER, before.toned())
    first, second = next(states), next(states)
    made = do(before, "relax", variant="weighted")
    assert np.abs(items(made).xy - CORNER - second.sites).max() <= UM
    assert made.facts["energy"] == pytest.approx(first.energy) and made.facts["movement"] == pytest.approx(first.movement)


def test_a_uniform_step_of_one_goes_to_the_centroids_of_the_cells():
    before = drawing(300)
    cells = voronoi(items(before).xy - CORNER, before.picture.canvas)
    made = do(before, "relax", variant="uniform", step=1)
    assert np.abs(items(made).xy - CORNER - of_rings(cells.rings).centroid).max() <= UM


@pytest.mark.parametrize(("variant", "shares"), [("objects", (1, 1)), ("move", (1, 0)), ("turn", (0, 1))])
def test_a_step_of_objects_is_the_librarys(variant, shares):
    before = do(drawing(60), "swap", on="all", glyph="leaves")
    before = do(before, "resize", on="all", factor=8)
    own = items(before)
    kinds = before.kinds
    objects = Objects.of(own.xy - CORNER, tuple(kind.shape for kind in kinds), angle=own.angle, scale=own.mm, shape=own.kind)
    states = settle(objects, before.picture.canvas, move=shares[0], turn=shares[1])
    next(states)
    moved = next(states).objects
    made = items(do(before, "relax", variant=variant))
    assert np.abs(made.xy - CORNER - moved.xy).max() <= UM
    # an angle is a 65536th of a turn
    assert np.abs((made.angle - moved.angle + np.pi) % (2 * np.pi) - np.pi).max() <= np.pi / 65536 + 1e-9
    assert (made.um == own.um).all() == (variant == "turn") and (made.turn == own.turn).all() == (variant == "move")


@pytest.mark.parametrize("variant", VARIANTS)
def test_only_what_is_under_the_brush_moves_and_all_else_stays_to_the_bit(variant):
    before = drawing(1500)
    made = do(before, "relax", variant=variant, on="brush", path=way(MIDDLE), size=8)
    under = np.hypot(*(items(before).xy - MIDDLE).T) <= 4
    assert 10 < under.sum() < 60
    assert unmoved(before, made, ~under)
    changed = "turn" if variant == "turn" else "um"
    assert (getattr(items(made), changed)[under] != getattr(items(before), changed)[under]).any()


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_part_moves_as_it_would_with_all_others_looked_at(variant, monkeypatch):
    before = drawing(1500)
    params = {"variant": variant, "on": "brush", "path": way(MIDDLE, (44, 31)), "size": 8}
    part = do(before, "relax", **params)
    monkeypatch.setattr("crowquill.editor.operations.relaxing.AROUND", 1e6)
    whole = do(before, "relax", **params)
    # moments are summed about other points, so that the last digits differ, and with them a micrometre where one is just between two
    assert np.abs(items(part).um - items(whole).um).max() <= 1
    assert np.abs(items(part).turn.astype(int) - items(whole).turn).max() <= 1
    for name in part.facts:
        assert part.facts[name] == pytest.approx(whole.facts[name], abs=1e-6)


def test_a_lone_mark_far_from_others_has_its_whole_cell(monkeypatch):
    xy = np.concatenate([[[12_000, 12_000]], np.random.default_rng(0).integers((40_000, 30_000), (69_000, 49_000), (400, 2))])
    before = with_items(drawing(401), um=xy)
    params = {"variant": "uniform", "on": "brush", "path": way((12, 12)), "size": 1, "step": 1}
    part = do(before, "relax", **params)
    monkeypatch.setattr("crowquill.editor.operations.relaxing.AROUND", 1e6)
    assert np.abs(items(part).um - items(do(before, "relax", **params)).um).max() <= 1
    assert items(part).xy[0, 0] > 18  # its cell is the left third of the canvas


def test_a_part_of_large_objects_moves_as_it_would_with_all_others_looked_at(monkeypatch):
    before = do(do(drawing(600), "swap", on="all", glyph="grains"), "resize", on="all", factor=6)  # 2 mm long, 2 mm apart
    params = {"variant": "objects", "on": "brush", "path": way((18, 18)), "size": 5}
    part = do(before, "relax", **params)
    monkeypatch.setattr("crowquill.editor.operations.relaxing.AROUND", 1e6)
    whole = do(before, "relax", **params)
    assert (items(part).um != items(before).um).any()
    assert np.abs(items(part).um - items(whole).um).max() <= 1 and np.abs(items(part).turn.astype(int) - items(whole).turn).max() <= 1


def test_a_selection_relaxes_and_frozen_marks_hold_their_ground():
    before = do(drawing(400), "select", by="rectangle", path=way((20, 15), (45, 45)))
    before = do(before, "freeze", path=way((30, 30)), size=6)
    made = steps(before, 3, on="selection")
    still = ~items(before).selected | items(before).frozen
    assert unmoved(before, made, still) and items(before).frozen.any()
    assert (items(made).um != items(before).um).any(axis=1)[~still].all()


def test_strength_is_a_share_of_the_way():
    before = drawing(200)
    full, half = do(before, "relax"), do(before, "relax", strength=0.5)
    middle = (items(before).xy + items(full).xy) / 2
    assert np.abs(items(half).xy - middle).max() <= 2 * UM


def test_energy_falls_step_by_step():
    state, energy = drawing(500), [np.inf]
    for _ in range(8):
        state = do(state, "relax", variant="uniform", step=1)
        energy.append(state.facts["energy"])
    assert (np.diff(energy) < 0).all()


def test_nothing_crosses_a_wall_and_what_is_outside_takes_no_part():
    before = do(drawing(600), "wall", path=way((25, 18), (55, 18), (55, 42), (25, 42)))
    made = steps(before, 12, variant="weighted", wall="drawn")
    inside = ((items(before).xy >= (25, 18)) & (items(before).xy <= (55, 42))).all(axis=1)
    assert unmoved(before, made, ~inside)
    xy = items(made).xy[inside]
    assert ((xy >= (25, 18)) & (xy <= (55, 42))).all()
    alone = with_items(before, **{name: getattr(items(before), name)[inside] for name in COLUMNS})
    assert (items(steps(alone, 12, variant="weighted", wall="drawn")).um == items(made).um[inside]).all()
    with pytest.raises(ValueError, match="no wall is drawn"):
        do(do(made, "wall"), "relax", wall="drawn")


def test_items_of_a_layer_relax_alone_and_those_of_all_layers_make_room_for_each_other():
    both = do(drawing(300), "layer add")
    both = do(do(both, "select", by="rectangle", path=way((0, 0), (40, 60))), "layer take", layer=2)
    alone = replace(both, layers=both.layers[:1])
    assert (items(do(both, "relax", layer=1)).um == items(do(alone, "relax", layer=1)).um).all()
    locked = do(both, "layer edit", layer=2, locked=True)
    made = do(locked, "relax")
    assert made.layers[1].items is locked.layers[1].items
    together = np.concatenate([items(both, 1).xy, items(both, 2).xy]) - CORNER
    state = next(relax.lloyd(together, both.toned()))
    target = relax.moved(state, both.toned())[: len(items(both, 1))] + CORNER
    assert np.abs(items(made).xy - target).max() <= UM


def test_where_no_ink_is_asked_for_weighted_relaxation_says_why_nothing_moves():
    white = drawing(50)
    white = replace(white, tone=Map.of(np.zeros((40, 60))))
    made = do(white, "relax", variant="weighted")
    assert unmoved(white, made, slice(None)) and "take the variant uniform" in made.notes[0]
    assert not unmoved(white, do(white, "relax", variant="uniform"), slice(None))


def test_marks_off_the_canvas_stay():
    before = with_items(drawing(50), um=np.concatenate([[[2_000, 2_000]], items(drawing(50)).um[1:]]))
    assert unmoved(before, do(before, "relax"), [0])


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize(
    "xy", [np.zeros((0, 2)), [[40, 30]], [[40, 30]] * 5, [[10, 10], [70, 50], [70, 10]], [[k + 12, 30] for k in range(20)]],
    ids=["none", "one", "coincident", "corners", "row"],
)  # fmt: skip
def test_awkward_sets_of_marks_have_an_answer(variant, xy):
    before = with_items(drawing(len(xy)), um=np.round(1000 * np.reshape(xy, (-1, 2))))
    made = steps(before, 3, variant=variant)
    assert len(items(made)) == len(xy) and np.isfinite(items(made).xy).all()
    assert all(np.isfinite(value) for value in made.facts.values())


def test_a_canvas_with_a_hole_keeps_marks_out_of_it():
    hole = shapely.difference(shapely.box(0, 0, *ART), shapely.box(20, 10, 40, 30))
    made = steps(drawing(200, canvas=hole), 3, variant="uniform")
    inside = ((items(made).xy - CORNER > (20, 10)) & (items(made).xy - CORNER < (40, 30))).all(axis=1)
    before = items(drawing(200)).xy - CORNER
    began = ((before > (20, 10)) & (before < (40, 30))).all(axis=1)
    assert (inside == began).all()  # who began in the hole takes no part


def tiled(n: int = 1, **params: Any) -> Drawing:
    return do(drawing(), "tile", n, **{"side": 5, "gap": 0.4, **params})


def test_tiles_take_the_room_of_the_canvas_and_a_mosaic_step_spreads_them():
    begun = tiled()
    made = steps(begun, 10, variant="mosaic")
    tiles = items(made, 2)
    area = 60 * 40 / 5.4**2  # a tile and its grout
    assert len(items(begun, 2)) == round(area) and len(tiles) >= 0.9 * area
    far = [np.sort(np.hypot(*(part.xy[:, None] - part.xy).transpose(2, 0, 1)), axis=1)[:, 1] for part in (items(begun, 2), tiles)]
    assert far[1].min() > 2 * far[0].min() and far[1].min() > 2.7  # half a pitch
    assert (tiles.scale == 5000).all()


def test_a_step_that_does_not_push_tiles_off_edges_closes_the_gaps_along_them():
    base = drawing()
    base = replace(base, tone=Map.of(np.where(np.arange(60) < 30, 0.2, 0.8)[None].repeat(40, axis=0)))
    pushed = steps(do(base, "tile", 1, side=4, gap=0.4), 12, variant="mosaic")
    closed = steps(pushed, 3, variant="mosaic", off_edges=False)
    near = [np.sort(np.abs(items(part, 2).xy[:, 0] - 40))[:12].mean() for part in (pushed, closed)]
    assert near[1] < near[0]


def test_tiles_are_finer_where_importance_was_painted():
    base = do(drawing(), "paint", path=way((25, 30)), size=24, strength=1, falloff="flat", map="importance", value=1)
    made = steps(do(base, "tile", 2, side=5, gap=0.4), 10, variant="mosaic")
    tiles = items(made, 2)
    near = np.hypot(*(tiles.xy - (25, 30)).T) < 9
    far = np.hypot(*(tiles.xy - (25, 30)).T) > 16
    sides = tiles.mm + 0.4
    assert np.median(sides[near]) == pytest.approx(np.median(sides[far]) / 2, rel=0.1)  # importance 1 is twice as fine


def test_a_mosaic_step_under_the_brush_leaves_other_tiles():
    begun = tiled()
    made = do(begun, "relax", variant="mosaic", on="brush", path=way((25, 25)), size=12)
    under = np.hypot(*(items(begun, 2).xy - (25, 25)).T) <= 6
    kept = np.isin(items(made, 2).id, items(begun, 2).id[~under])
    assert all((getattr(items(made, 2), name)[kept] == getattr(items(begun, 2), name)[~under]).all() for name in COLUMNS)
    assert digest(made) != digest(begun)


def test_tiles_laid_in_a_region_replace_those_there():
    begun = tiled()
    made = do(begun, "tile", 3, layer=2, path=way((10, 10), (40, 10), (40, 50), (10, 50)))
    left = items(begun, 2).xy[:, 0] < 40
    assert (items(made, 2).id[: (~left).sum()] == items(begun, 2).id[~left]).all()
    assert (items(made, 2).take(slice((~left).sum(), None)).xy[:, 0] <= 40).all()
    with pytest.raises(ValueError, match="encloses nothing of the canvas"):
        do(begun, "tile", layer=2, path=way((0, 0), (5, 0), (5, 5)))


@pytest.mark.parametrize("aspect", [1.0, 2.0, 0.5])
def test_tiles_are_cut_to_stones_that_do_not_overlap_in_the_colours_beneath(aspect):
    base = drawing()
    rgb = np.zeros((40, 60, 3), np.uint8)
    rgb[:, :30, 0] = 200
    base = replace(base, picture=replace(base.picture, rgb=rgb))
    made = do(steps(do(base, "tile", 1, side=5, gap=0.4, aspect=aspect), 6, variant="mosaic"), "cut")
    stones = made.layers[1].items
    assert made.layers[1].tiling is None and made.facts["stones"] == len(stones)
    rings = np.concatenate([[made.kinds[k].paths.polygons()[0]] for k in stones.kind])
    placed = [shapely.transform(ring, lambda xy, at=at: xy + at) for ring, at in zip(rings, stones.xy, strict=True)]
    assert shapely.area(shapely.union_all(placed)) == pytest.approx(shapely.area(placed).sum(), rel=1e-9)
    assert shapely.area(placed).sum() / (60 * 40) > 0.6
    clear = np.abs(stones.xy[:, 0] - 40) > 6  # of the border between the colours, by more than a stone's reach
    red = stones.fill[clear] >> 16 & 255
    assert (red == np.where(stones.xy[clear, 0] < 40, 200, 0)).all()


def test_cells_of_the_last_step_speed_up_the_next_and_change_nothing(monkeypatch):
    known: list[bool] = []
    real = relaxing._Last.cells

    def cells(self: Any, *given: Any) -> Any:
        found = real(self, *given)
        known.append(found is not None)
        return found

    def chain() -> list[str]:
        monkeypatch.setattr(relaxing, "_LAST", relaxing._Last())
        first = drawing(300)
        found = [first := steps(first, 1, variant="weighted") for _ in range(3)]
        found.append(do(found[-1], "relax", variant="uniform"))
        found.append(do(do(found[-1], "insert", path=way(MIDDLE), size=20, rate=50), "relax"))  # others than before
        found.append(do(do(found[0], "jitter", on="all", amount=3), "relax"))  # as after an undo, and far away
        return [digest(one) for one in found]

    monkeypatch.setattr(relaxing._Last, "cells", cells)
    quick = chain()
    assert known.count(True) >= 3 and not known[0]
    monkeypatch.setattr(relaxing._Last, "cells", lambda *_: None)
    assert chain() == quick
