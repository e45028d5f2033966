"""From a recipe and its sources to the bytes of files, watched on the way: for who writes them elsewhere, or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crowquill import formats, making, styles
from crowquill.recipe import Recipe
from crowquill.sheet import Sheet, Step

Planned = Callable[[tuple[float, float], Mapping[str, float]], None]


@dataclass(frozen=True)
class Delivered:
    """The bytes of each file by its name, and what came of the drawing as plain data: the sheet's report, paper_mm and all warnings."""

    files: Mapping[str, bytes]
    report: Mapping[str, Any]


def delivered(
    wanted: Recipe,
    paths: Mapping[str, Path],
    names: Sequence[str],
    *,
    planned: Planned = lambda *_: None,
    watch: Callable[[Step], None] | None = None,
    drawn: Callable[[Sheet], None] = lambda _: None,
) -> Delivered:
    """What the recipe draws of its sources, as files of these names, whose suffixes are their formats: the bytes that saving gives.

    planned  is called once it is known what will be drawn, before the work, with the paper's sides in mm and the first Step's facts
    watch    sees each Step, and `drawn` the sheet before it is written; what any of them raises ends the work

    Raises the ValueError of a setting, a source or a format that cannot be followed.
    """
    modules = {name: formats.module(Path(name).suffix[1:].lower(), name) for name in names}
    for name, module in modules.items():
        if getattr(module, "STROKES", False) and wanted.plot["purpose"] != "plotter":
            raise ValueError(f"{name}: takes strokes only, and the recipe is not for a plotter; write an SVG or a PDF")
    size, tone, over = making.laid_out(wanted, paths)
    work = making.steps(wanted, paths, size, tone, over)
    first, files = next(work), wanted.with_paths(paths).files
    taken = {name: _taken(name, files) for name in names}
    for name in names:
        formats.foresee([Path(name)], size, int(first.facts.get("dots", 0)), taken[name])
    planned(size, first.facts)
    if watch:
        watch(first)
    sheet = styles.run(work, watch)
    drawn(sheet)
    made = {name: formats.to_bytes(sheet, Path(name).suffix[1:].lower(), **taken[name]) for name in names}
    remarks = styles.remarks(sheet.report, [formats.shown(Path(name), files) for name in names])
    warnings = [*tone.notes, *sheet.report["warnings"], *remarks]
    return Delivered(made, {**sheet.report, "paper_mm": list(sheet.size), "warnings": warnings})


def _taken(name: str, files: Mapping[str, Any]) -> dict[str, Any]:
    """Those knobs that the format of a file has."""
    own = formats.knobs(Path(name).suffix[1:].lower())
    return {key: value for key, value in files.items() if key in own}
