"""What a plate's panels show: each drawing with its files found, its settings checked, and the size it has by itself."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from crowquill import formats, picture, recipe, scale
from crowquill.formats.svg import drawn
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.plate.platefile import Drawn, Panel, Plate, named
from crowquill.plate.sources import Folder
from crowquill.recipe import PICTURE, Recipe
from crowquill.sheet import Art, Bitmap, Ink, Layer, Sheet, shifted
from crowquill.vector import contents

Size = tuple[float, float]
BEFORE = 1000  # seeds from one panel to the next: those between are its layers'


@dataclass(frozen=True)
class Part:
    """One drawing of a panel: a recipe and the paths of its sources, or a sheet; `ink` in place of its own, and what it is called."""

    name: str
    ink: Ink | None
    recipe: Recipe | None = None
    paths: Mapping[str, Path] | None = None
    sheet: Sheet | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Content:
    """All that a panel shows, from the bottom up, and the shape of the first.

    shape   its width and height, of no particular unit
    fixed   the size it must have, mm, or None where it takes what room there is
    ratio   mm drawn to a mm of the specimen, for each mm that it is wide where `by_width`; None where it is not said
    """

    parts: tuple[Part, ...]
    shape: Size
    fixed: Size | None
    ratio: float | None
    by_width: bool = False

    def ratio_at(self, size: Size) -> float | None:
        """The scale of the panel in this size; a picture that covers it may be cut."""
        width = max(size[0], size[1] * self.shape[0] / self.shape[1])
        return self.ratio and self.ratio * (width if self.by_width else 1.0)


def content(plate: Plate, rank: int, folder: Folder) -> Content:
    """What a panel shows, by its place among the panels. Raises ValueError for what is missing or cannot be read."""
    panel = plate.panel[rank]
    parts = []
    for k, one in enumerate(panel.drawn):
        with named(f"layer {k + 1}") if panel.layer else nullcontext():
            parts.append(_part(one, plate, plate.seed + BEFORE * rank + k, folder, barred=panel.barred))
    first = parts[0]
    if first.sheet is not None:
        width, height = first.sheet.size
        fixed = (panel.width, round(panel.width * height / width, 3)) if panel.width else first.sheet.size
        return Content(tuple(parts), first.sheet.size, fixed, scale.parsed(panel.scale) if panel.scale else None)
    return _of_picture(panel, tuple(parts))


def _of_picture(panel: Panel, parts: tuple[Part, ...]) -> Content:
    """The content whose first part is a picture: its pixels give the shape, and may give the scale."""
    first = parts[0]
    assert first.recipe is not None and first.paths is not None
    tone = first.recipe.tone
    rows, columns = picture.window(picture.shape(first.paths[PICTURE], tone["max_pixels"]), tone["crop"])
    shape = float(columns.stop - columns.start), float(rows.stop - rows.start)
    width, ratio, by_width = panel.width, scale.parsed(panel.scale) if panel.scale else None, False
    if panel.pixel:
        pixel = scale.length(panel.pixel)
        if ratio is not None:
            width = round(shape[0] * pixel * ratio, 3)
        else:
            ratio, by_width = scale.of_pixel(panel.pixel, 1 / shape[0]), True
    fixed = (width, max(0.001, round(width * shape[1] / shape[0], 3))) if width else None
    return Content(parts, shape, fixed, ratio, by_width)


def _part(one: Drawn, plate: Plate, seed: int, folder: Folder, *, barred: bool) -> Part:
    ink = plate.ink(one.ink) if one.ink else None
    if one.drawing:
        sheet, notes = _unframed(_loaded(folder.file(one.drawing), one.drawing), one.drawing)
        return Part("", _one_ink(sheet, ink), sheet=sheet, notes=notes)
    beside, wanted, own = None, None, one.picture
    if one.recipe:
        beside = folder.file(one.recipe)
        wanted = recipe.read_toml(contents(beside), one.recipe)
        wanted = replace(wanted, seed=wanted.seed if one.seed is None else one.seed)
        if own is None and PICTURE not in wanted.sources:
            raise ValueError(f"{one.recipe} names no picture; give one with picture")
    else:
        style, own_seed = one.style or "stipple", seed if one.seed is None else one.seed
        wanted = Recipe(style, own_seed, tone=one.tone or {}, knobs=one.knobs or {}, finish=one.finish or {})
    paths = {key: folder.file(name, beside) for key, name in recipe.files_of(wanted).items()}
    paths[PICTURE] = folder.file(own) if own else folder.file(wanted.sources[PICTURE].name, beside)
    for key in paths:
        source = wanted.sources.get(key)
        if source and source.name == paths[key].name and source.sha256 not in ("", folder.digest(paths[key])):
            raise ValueError(f"{source.name} is not the {key} that {one.recipe} names (its SHA-256 differs); give the same file")
    if wanted.plot["purpose"] != "print":
        raise ValueError(f"{one.recipe} is for a plotter, which draws no plates; make it one for print")
    if barred and wanted.finish["scale_bar"] is not None:
        raise ValueError("its settings draw a scale bar already; leave out scale_bar there, or scale and pixel here")
    return Part(wanted.style, ink, wanted, paths)


def _loaded(path: Path, name: str) -> Sheet:
    """The sheet of an SVG: ours with its marks, or any other."""
    if path.suffix.lower() != ".svg":
        raise ValueError(f"{name} is no SVG; draw it as one, or give it as a picture")
    data = contents(path)
    return formats.load(path) if b"urn:crowquill:drawing" in data else drawn(data, name)


def _unframed(sheet: Sheet, name: str) -> tuple[Sheet, tuple[str, ...]]:
    """A drawing of ours without the paper around it, and a note of what stood on that; any other as it is."""
    notes = tuple(sheet.report.get("warnings", ()))
    at, size = sheet.recipe.get("art_at_mm"), sheet.recipe.get("art_mm")
    if not (at and size):
        return sheet, notes
    inside = [layer for layer in sheet.layers if not _outside(layer.art, at, size)]
    if len(inside) < len(sheet.layers):
        left = ", ".join(layer.label for layer in sheet.layers if layer not in inside)
        notes += (f"{name}: {left} stands beside the drawing on its paper and is left out",)
    layers = tuple(replace(layer, art=shifted(layer.art, -np.array(at, np.float64))) for layer in inside)
    return Sheet((size[0], size[1]), layers), notes


def _outside(art: Art, at: Size, size: Size) -> bool:
    """Whether art lies wholly beside a rectangle."""
    xy = art.corner[None] if isinstance(art, Bitmap) else art.xy
    low, high = xy.min(axis=0, initial=np.inf), xy.max(axis=0, initial=-np.inf)
    return bool(len(xy) and ((high < at) | (low > np.add(at, size))).any())


def _one_ink(sheet: Sheet, ink: Ink | None) -> Ink | None:
    if ink and len({layer.ink.cmyk for layer in sheet.layers}) > 1:
        raise ValueError(f"it has inks of its own and cannot be all in {ink.name}; leave out ink")
    return ink


def inked(layer: Layer, ink: Ink | None, *, whole: bool) -> Layer:
    """The layer in another ink, with the pen of its own; of inks that a style chose by itself only black is replaced."""
    if ink is None or (not whole and replace(layer.ink, pen=None, overprint=False) != Ink()):
        return layer
    return replace(layer, ink=replace(ink, pen=layer.ink.pen))


def scaled(layer: Layer, factor: float) -> Layer:
    """The layer so many times as large, its pen too."""
    art, ink = layer.art, layer.ink
    larger: Art
    if isinstance(art, Paths):
        larger = art.moved(factor * np.eye(2))
    elif isinstance(art, Marks):
        larger = replace(art, xy=art.xy * factor, scale=art.scale * factor)
    elif isinstance(art, Bitmap):
        larger = replace(art, corner=art.corner * factor, dpi=art.dpi / factor)
    else:
        larger = replace(art, xy=art.xy * factor, size=art.size * factor)
    return replace(layer, art=larger, ink=replace(ink, pen=ink.pen and ink.pen * factor))
