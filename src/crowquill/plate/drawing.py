"""A plate drawn, panel by panel, each drawing by the road that single drawings go."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from crowquill import making
from crowquill.formats._letters import faces
from crowquill.knobs import Text
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.plate.composing import Composition, Placed, composed
from crowquill.plate.parts import Part, inked, scaled
from crowquill.plate.platefile import SCHEMA, Plate, named
from crowquill.plate.sources import Folder
from crowquill.recipe import takes_of
from crowquill.sheet import Layer, Sheet, Step, shifted
from crowquill.styles import Work
from crowquill.tone import Tone

FREE = 0.6  # mm around letters and bars that no drawing enters
EDGE = 2.0  # mm: a strip that would be left along the border is free too
SUMS = ("marks", "ink_asked_mm2", "ink_placed_mm2")  # of reports


@dataclass(frozen=True)
class Opened:
    """A plate with its plain data, its folder and all in its place; errors call it `name`, `files` are knobs of formats."""

    name: str
    data: Mapping[str, Any]
    folder: Folder
    composition: Composition
    files: Mapping[str, Any]

    @classmethod
    def of(cls, plate: Plate, data: Mapping[str, Any], name: str, root: Path, given: Mapping[str, Path] | None = None) -> Opened:
        """The plate with the files of its folder. Raises ValueError for what is wrong or missing, in one line that begins with `name`."""
        folder = Folder(root, plate.sources, given)
        try:
            with named("files"):
                paths = {key: str(folder.file(value)) for key, value in named_files(plate.files).items()}
            return cls(name, data, folder, composed(plate, folder), {**plate.files, **paths})
        except ValueError as error:
            said = str(error)
            raise ValueError(f"{name}: {said if '; ' in said else f'{said}; mend it'}") from None

    def foresee_pdf(self) -> None:
        """Raises the ValueError that a PDF of its words would raise: for letters that a font lacks, and fonts it may not hold."""
        for line in self.composition.lacking[:1]:
            raise ValueError(f"{self.name}: {line}, which a PDF takes from its font; choose other words, or another font")
        panels = [layer for placed in self.composition.panels for layer in placed.words]
        with named(self.name):
            faces([*panels, *self.composition.words])

    @property
    def version(self) -> str:
        """The version that drew it, or this one's where it is new."""
        return self.composition.plate.version or version("crowquill")

    @property
    def recipe(self) -> dict[str, Any]:
        """All that makes it, as plain data that its files keep: the plate file's own, the version, and its files' SHA-256."""
        about = {"schema": SCHEMA, "version": version("crowquill"), "style": "plate"}
        own = {key: value for key, value in self.data.items() if key not in about}
        return {**about, **own, "sources": dict(sorted(self.folder.digests.items()))}


def steps(opened: Opened, *, embed: bool = False) -> Work:
    """The plate at work: a generator of Steps, whose stages begin with the panel's letter, that returns the sheet."""
    composition = opened.composition
    layers: list[Layer] = []
    reports = []
    warnings = list(composition.notes)
    for placed in composition.panels:
        told = []
        for part in placed.content.parts:
            with named(f"{opened.name}: {placed.name}"):
                made, report, notes = yield from _drawn(part, placed)
            layers += made
            told.append(report)
            warnings += [f"{placed.name}: {note}" for note in notes]
        about = {"panel": placed.label, "at_mm": [placed.art.left, placed.art.top], "art_mm": [placed.art.width, placed.art.height]}
        reports.append({**about, "scale": placed.ratio, "layers": told})
    layers += [layer for placed in composition.panels for layer in placed.words] + list(composition.words)
    boxes = [placed.art for placed in composition.panels]
    left, top = min(box.left for box in boxes), min(box.top for box in boxes)
    art = [round(max(box.right for box in boxes) - left, 3), round(max(box.bottom for box in boxes) - top, 3)]
    report = {"style": "plate", "version": version("crowquill"), "seed": composition.plate.seed, "art_mm": art}
    report |= {"panels": reports, **_summed(reports), "warnings": warnings}
    kept = opened.folder.contents() if embed else {}
    return Sheet(composition.size, tuple(layers), {**opened.recipe, "paper_mm": list(composition.size)}, report, kept)


def foretold(opened: Opened) -> Iterator[tuple[Placed, Part, Mapping[str, float]]]:
    """What each drawing of a plate says of the work to come, panel by panel."""
    for placed in opened.composition.panels:
        for part in placed.content.parts:
            with named(f"{opened.name}: {placed.name}"):
                yield placed, part, {} if part.sheet is not None else next(_work(part, placed)[1]).facts


def named_files(files: Mapping[str, Any]) -> dict[str, str]:
    """Those knobs of formats that name files."""
    takes = takes_of("files", "")
    found = {key: str(value) for key, value in files.items() if key in takes and isinstance(value, (str, Path)) and Path(value).suffix}
    return {key: value for key, value in found.items() if isinstance(kind := takes[key].takes, Text) and kind.file}


def _work(part: Part, placed: Placed) -> tuple[Tone, Work]:
    """The tone of a picture in its place, and its style at work on it."""
    assert part.recipe is not None and part.paths is not None
    art = placed.art
    paper = {"paper": f"{art.width:.3f}x{art.height:.3f}mm", "margin": 0.0, "fit": placed.panel.fit}
    wanted = replace(part.recipe, paper=paper, files={})
    size, tone, over = making.laid_out(wanted, part.paths)
    return tone, making.steps(wanted, part.paths, size, _freed(tone, placed), over)


def _drawn(part: Part, placed: Placed) -> Generator[Step, None, tuple[list[Layer], dict[str, Any], list[str]]]:
    """The layers of one drawing in its place, its report, and what is to be said of it.

    A sheet takes the panel's width, and of its report there is the number of its marks, an outline being one.
    """
    art = placed.art
    offset = np.array([art.left, art.top])
    if part.sheet is not None:
        factor = art.width / part.sheet.size[0]
        own = [layer if factor == 1 else scaled(layer, factor) for layer in part.sheet.layers]
        shapes = sum(len(layer.art) for layer in own if isinstance(layer.art, (Marks, Paths)))
        return _named(own, part, placed.label, offset), {"marks": shapes}, list(part.notes)
    tone, work = _work(part, placed)
    while True:
        try:
            step = next(work)
        except StopIteration as stop:
            sheet: Sheet = stop.value
            break
        yield replace(step, stage=f"{placed.label} {step.stage}", sheet=None)
    report = {key: value for key, value in sheet.report.items() if key != "warnings"}
    return _named(list(sheet.layers), part, placed.label, offset), report, [*tone.notes, *sheet.report["warnings"]]


def _named(layers: list[Layer], part: Part, label: str, offset: Any) -> list[Layer]:
    """The layers in their place and ink, called by the panel's letter, what drew them, and their own name."""
    found = []
    for layer in layers:
        own = layer.name or (layer.ink.name if part.sheet else "")
        name = " ".join(word for word in (label, part.name, own if own != part.name else "") if word)
        found.append(replace(inked(layer, part.ink, whole=part.sheet is not None), art=shifted(layer.art, offset), name=name))
    return found


def _freed(tone: Tone, placed: Placed) -> Tone:
    """The tone without the places of letter and bar, where it asks for ink there."""
    canvas, corner = tone.canvas, np.array([placed.art.left, placed.art.top])
    for left, top, right, bottom in placed.free:
        low, high = np.array([left, top]) - FREE - corner, np.array([right, bottom]) + FREE - corner
        low, high = np.where(low < EDGE, 0.0, low), np.where(high > np.array(tone.size) - EDGE, tone.size, high)
        box = shapely.box(*low, *high)
        if _asks(tone, box.bounds):
            canvas = shapely.difference(canvas, box)
    if canvas is tone.canvas:
        return tone
    parts = [part for part in shapely.get_parts(canvas) if part.geom_type == "Polygon"]
    if not parts:
        raise ValueError("letter and scale bar leave no room to draw in; draw it larger")
    return replace(tone, canvas=shapely.multipolygons(parts))


def _asks(tone: Tone, bounds: tuple[float, ...]) -> bool:
    """Whether a tone asks for ink in a rectangle (left, top, right, bottom) mm."""
    (h, w), (dx, dy) = tone.coverage.shape, tone.pixel
    x, y = (np.clip(np.array([bounds[k], bounds[k + 2]]) / side, 0, most) for k, side, most in ((0, dx, w), (1, dy, h)))
    return bool(tone.coverage[int(y[0]) : int(np.ceil(y[1])), int(x[0]) : int(np.ceil(x[1]))].any())


def _summed(reports: list[dict[str, Any]]) -> dict[str, Any]:
    """Marks, ink and seconds of all panels."""
    every = [layer for report in reports for layer in report["layers"]]
    sums: dict[str, Any] = {key: sum(layer.get(key, 0) for layer in every) for key in SUMS}
    seconds: dict[str, float] = {}
    for layer in every:
        for stage, time in layer.get("seconds", {}).items():
            seconds[stage] = round(seconds.get(stage, 0.0) + time, 3)
    return {**sums, "seconds": seconds}
