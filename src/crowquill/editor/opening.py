"""How a drawing begins: from a picture, a drawing of ours, or any SVG of objects; and the header that says so."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from crowquill import formats, making, recipe
from crowquill.editor.drawing import Drawing, Layer, Map, Picture
from crowquill.editor.items import Items
from crowquill.editor.reading import itemised, outlined
from crowquill.formats import svg
from crowquill.halftone.averages import averaged
from crowquill.recipe import PICTURE, Recipe, Source
from crowquill.sheet import Ink, Sheet, check_bar
from crowquill.tone import Tone
from crowquill.units import UM
from crowquill.vector import contents

SCHEMA = 1  # a reader refuses a newer one
PIXELS = 2_000_000  # of the maps that are painted on; finer pictures are averaged
BLANK = 0.25  # mm: a pixel where there is no picture
SUFFIX = ".edits"
STYLE = "stipple"  # whose settings of paper and tone a picture is opened with: those of all styles


@dataclass(frozen=True)
class Header:
    """What a log begins with: the file that was opened, and, as a recipe's data, how its picture was laid out; none without one."""

    file: Source
    picture: Mapping[str, Any] = field(default_factory=dict)
    version: str = field(default_factory=lambda: version("crowquill"))

    def data(self) -> dict[str, Any]:
        """The header as JSON can hold it."""
        file = {"name": self.file.name, "sha256": self.file.sha256}
        return {"crowquill": "edits", "schema": SCHEMA, "version": self.version, "file": file, "picture": dict(self.picture)}

    @classmethod
    def parsed(cls, data: Any, name: str) -> Header:
        """The header in plain data; errors call it `name`. ValueError for what is none, and for a newer one."""
        if not isinstance(data, Mapping) or data.get("crowquill") != "edits":
            raise ValueError(f"{name}: is no log of the editor; give one, such as drawing.svg{SUFFIX}")
        schema = data.get("schema")
        if isinstance(schema, bool) or not isinstance(schema, int) or schema < 1:
            raise ValueError(f"{name}: its schema is {schema!r}; it takes 1 to {SCHEMA}")
        if schema > SCHEMA:
            raise ValueError(f"{name}: made by a newer crowquill (schema {schema} of edits); update this one")
        file, picture, made = data.get("file"), data.get("picture"), data.get("version")
        if not isinstance(file, Mapping) or not all(isinstance(file.get(key), str) and file[key] for key in ("name", "sha256")):
            file = None
        if file is None or not isinstance(picture, Mapping) or not isinstance(made, str):
            raise ValueError(f"{name}: its first line does not say what was edited; it is broken")
        if Path(file["name"]).name != file["name"] or file["name"] in ("..", "."):
            raise ValueError(f"{name}: names the file {file['name']!r}; it takes a bare name")
        return cls(Source(file["name"], file["sha256"]), picture, made)


def opened(file: Path, settings: Recipe | None = None) -> tuple[Header, Drawing]:
    """The header and the drawing that a file begins with.

    A picture lies on its paper by the settings of a recipe; a drawing of ours lies over its picture, if that is
    beside it or inside; any other SVG's shapes are objects. Raises ValueError for other files, OSError for what cannot be read.
    """
    source = Source.of(file)
    if file.suffix.lower() in (".pdf", ".tif", ".tiff", ".png") and settings is None and _is_drawn(file):
        raise ValueError(f"{file}: is a drawing as a {file.suffix[1:].upper()}; edit its SVG, or its picture")
    if file.suffix.lower() == ".svg":
        data = contents(file)
        if settings is not None:
            raise ValueError(f"{file}: is a drawing, which is laid out already; settings of paper and tone are for pictures")
        if svg.SPACE.encode() in data:
            return _drawing(file, source)
        return Header(source), _objects(file, data)
    wanted = settings or Recipe(STYLE)
    paths = {PICTURE: file, **{key: Path(value) for key, value in recipe.files_of(wanted).items()}}
    for key, path in paths.items():
        if path.parent.resolve() != file.parent.resolve():
            raise ValueError(f"{path}: the log names its files without folders; put the {key.replace('_', ' ')} beside {file.name}")
    told = making.named(wanted, paths).data()
    return Header(source, told), _begun(wanted, paths)


def again(header: Header, file: Path) -> Drawing:
    """The drawing that a log began with, from the file that was opened and what lies beside it.

    Raises ValueError where one of them is missing or another.
    """
    if not file.exists():
        raise ValueError(f"{file}: there is no such file, and the edits are of it; put it beside its log")
    if Source.of(file).sha256 != header.file.sha256:
        raise ValueError(f"{file}: is not the file that was edited (its SHA-256 differs); give the same, or move the log away")
    if file.suffix.lower() == ".svg":
        if header.picture or svg.SPACE.encode() in contents(file):
            return _over(file, header.picture)
        return _objects(file, contents(file))
    with tempfile.TemporaryDirectory() as folder:
        wanted, paths = making.located(recipe.parsed(header.picture, str(file)), {}, file, {PICTURE: file}, Path(folder))
        return _begun(wanted, paths)


def _is_drawn(file: Path) -> bool:
    """Whether a file keeps a recipe of ours, or cannot be a picture."""
    try:
        return file.suffix.lower() == ".pdf" or bool(formats.recipe_of(file)[0])
    except ValueError:
        return False


def _begun(wanted: Recipe, paths: Mapping[str, Path]) -> Drawing:
    """An empty layer over a picture."""
    size, tone, _ = making.laid_out(wanted, paths, colour=True)
    corner = np.round((np.array(size) - tone.size) / 2, 3)
    told = {"art_mm": list(tone.size), "art_at_mm": corner.tolist(), "paper_mm": list(size)}
    drawing = _laid(size, tone, corner, wanted.paper["margin"], told)
    drawing = replace(drawing, layers=(Layer(1, "", Ink(), Items.none()),), next_layer=2)
    if not wanted.paper["check_bar"]:
        return drawing
    margin = wanted.paper["margin"]
    drawing = _read(drawing, Sheet(size, (check_bar(margin, size[1] - margin / 2),)))
    return drawing.with_layers(replace(drawing.layers[-1], locked=True))


def _laid(size: tuple[float, float], tone: Tone, corner: Any, margin: float | None, told: Mapping[str, Any]) -> Drawing:
    """No layers over a tone with its corner at a place on the paper."""
    h, w = tone.coverage.shape
    parts = int(np.ceil(np.sqrt(h * w / PIXELS)))
    rows, columns = np.linspace(0, h, max(1, h // parts) + 1), np.linspace(0, w, max(1, w // parts) + 1)
    whole = (len(rows) - 1, len(columns) - 1)

    def coarser(values: Any) -> Map:
        return Map.of(np.clip(averaged(values, columns, rows) if whole != (h, w) else values, 0, 1))

    rgb = tone.rgb
    if rgb is not None and whole != (h, w):
        channels = [averaged(channel.astype(np.float64), columns, rows) for channel in np.moveaxis(rgb, 2, 0)]
        rgb = np.round(np.stack(channels, axis=2)).astype(np.uint8)
    picture = Picture(np.asarray(corner, np.float64), tone.size, tone.canvas, rgb)
    wish = None if tone.importance is None else coarser(tone.importance)
    return Drawing(size, picture, coarser(tone.coverage), wish=wish, margin=margin, recipe=dict(told))


def _blank(size: tuple[float, float]) -> Drawing:
    """No layers over white paper."""
    step = max(BLANK, float(np.sqrt(size[0] * size[1] / PIXELS)))
    shape = (max(1, round(size[1] / step)), max(1, round(size[0] / step)))
    picture = Picture(np.zeros(2), size, shapely.box(0, 0, *size))
    return Drawing(size, picture, Map(np.zeros(shape, np.uint16)))


def _drawing(file: Path, source: Source) -> tuple[Header, Drawing]:
    """A drawing of ours over its picture, or over white paper where that is not found."""
    made, kept = formats.recipe_of(file)
    told = made.get("edits", {}).get("picture", {}) if isinstance(made.get("edits"), Mapping) else made
    notes: tuple[str, ...] = ()
    picture: Mapping[str, Any] = {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            wanted = recipe.parsed(told, str(file))
            picture = making.located(wanted, kept, file, {}, Path(folder))[0].data()
    except ValueError as error:
        notes = (f"its picture is not beneath it: {error}",) if told else ()
    return Header(source, picture), replace(_over(file, picture), notes=notes)


def _over(file: Path, picture: Mapping[str, Any]) -> Drawing:
    """The drawing of a file of ours over the picture of a recipe's data, or over white paper."""
    sheet = formats.load(file)
    if picture:
        kept = formats.recipe_of(file)[1]
        with tempfile.TemporaryDirectory() as folder:
            wanted, paths = making.located(recipe.parsed(picture, str(file)), kept, file, {}, Path(folder))
            _, tone, _ = making.laid_out(wanted, paths, colour=True)
        if (art := sheet.recipe.get("art_mm")) and not np.allclose(art, tone.size, rtol=0, atol=UM):  # on another paper than at first
            tone = tone.fitted(art[0], art[1], "stretch")
        corner = sheet.recipe.get("art_at_mm", (np.array(sheet.size) - tone.size) / 2)
        drawing = _laid(sheet.size, tone, np.round(corner, 3), wanted.paper["margin"], {})
    else:
        drawing = _blank(sheet.size)
    told = {key: value for key, value in sheet.recipe.items() if key in recipe.RESULTS}
    return replace(_read(drawing, sheet), recipe=told, notes=tuple(sheet.report.get("warnings", ())))


def _read(drawing: Drawing, sheet: Sheet) -> Drawing:
    """The drawing with the layers of a sheet."""
    for one in sheet.layers:
        drawing, layer = itemised(drawing, one)
        drawing = replace(
            drawing, layers=(*drawing.layers, layer), next_layer=drawing.next_layer + 1, first=drawing.first + len(layer.items)
        )
    return drawing


def _objects(file: Path, data: bytes) -> Drawing:
    """Each shape of an SVG an object, in a layer for each run of one ink, on white paper of the page's size."""
    size, found = svg.painted(data, str(file))
    if not found:
        raise ValueError(f"{file}: draws nothing that can be edited; give an SVG of shapes")
    drawing = _blank(size)
    for ink, run in groupby(found, key=lambda pair: pair[0]):
        items = Items.none()
        for _, paths in run:
            drawing, part = outlined(drawing, paths, np.zeros(len(paths), np.int64))
            items = Items.joined([items, part])
            drawing = replace(drawing, first=drawing.first + len(part))
        layer = Layer(drawing.next_layer, "", ink, items)
        drawing = replace(drawing, layers=(*drawing.layers, layer), next_layer=drawing.next_layer + 1)
    return drawing


def recipe_of(header: Header, drawing: Drawing) -> dict[str, Any]:
    """What files of an edited drawing say made them: the file that was edited, and the picture beneath."""
    return {"edits": json.loads(json.dumps(header.data())), **drawing.recipe}
