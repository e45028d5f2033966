"""From a recipe and its sources to a sheet, the first time and again."""

from __future__ import annotations

import math
import os
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from crowquill import curves, finishing, formats, inking, layout, nibs, plotting, recipe, stippling, styles, units
from crowquill.finishing import Finish
from crowquill.marks import Marks
from crowquill.recipe import PICTURE, Recipe, Source
from crowquill.sheet import Sheet
from crowquill.styles import Work
from crowquill.tone import Tone
from crowquill.vector import contents, regular

Paths = Mapping[str, Path]  # of sources, by what they are for


def named(wanted: Recipe, paths: Paths) -> Recipe:
    """The recipe with bare names for its files, and what these hold."""
    bare = wanted.with_paths({key: Path(path.name) for key, path in paths.items()})
    return replace(bare, sources={key: Source.of(path) for key, path in paths.items()})


def laid_out(wanted: Recipe, paths: Paths, *, colour: bool = False) -> tuple[tuple[float, float], Tone, Finish]:
    """The paper's sides in mm, the tone in its place on it, on what lines and a scale bar leave free, and these.

    colour  keep the picture's colours, whatever the style
    """
    full = wanted.with_paths(paths)
    coloured, light = colour or styles.coloured(full.style), dict(full.tone)
    if toned := full.inks["inks"] is not None:  # the press's curve is each ink's, once they are separated
        coloured, light["tone_curve"] = coloured or full.inks["ink_match"] != "lightness", None
    size, tone = layout.placed(layout.lit(paths[PICTURE], coloured, toned, **light), **full.paper)
    over = _finish(full, paths, tone)
    return size, over.freed(tone, _widest(wanted, tone)), over


def steps(wanted: Recipe, paths: Paths, size: tuple[float, float], tone: Tone, over: Finish) -> Work:
    """The work that the recipe asks for on what laid_out() gave: a generator of Steps that returns the sheet on its paper."""
    recipe.check_names(wanted)
    full = wanted.with_paths(paths)
    chosen = {**full.knobs, **_timed(wanted, tone)}
    curve = curves.inverse(full.tone["tone_curve"]) if full.inks["inks"] and full.tone["tone_curve"] else None
    sheet = yield from inking.steps(full.style, tone, full.seed, chosen, curve, **full.inks)
    sheet = layout.on_paper(over.drawn(sheet), size, wanted.paper["margin"], wanted.paper["check_bar"])
    made = {key: sheet.recipe[key] for key in sorted(recipe.RESULTS)}
    settings = {key: value for key, value in wanted.plot.items() if key not in ("purpose", "plot_time")}
    if over.lines or over.bar:  # have pens of their own: dots are named for theirs
        sheet = _named_for(sheet, wanted.knobs.get("pen"))
    else:
        settings["nib"] = settings["nib"] or wanted.knobs.get("pen")  # who draws for a pen plots with it
    sheet = recipe.finished(sheet, settings, purpose=wanted.plot["purpose"])
    sheet = replace(sheet, recipe={**wanted.data(), "version": version("crowquill"), **made})
    return recipe.attached(sheet, wanted, paths, embed=wanted.files.get("embed", False))


def _finish(full: Recipe, paths: Paths, tone: Tone) -> Finish:
    """What comes over the drawing of a tone in its place, by a recipe with its paths."""
    if full.inks["inks"] is not None and full.finish["ink"] != "black":
        raise ValueError(f"ink {full.finish['ink']!r} and inks {full.inks['inks']!r} are both given; leave one out")
    if full.finish["ink_gain"] and full.plot["purpose"] == "plotter":
        raise ValueError("ink-gain makes strokes finer than the pen that plots them; leave it out, or leave out --for plotter")
    if full.finish["outline"] is None:
        return finishing.finish(tone, **full.finish)
    frame = layout.frame(tone, paths[PICTURE], full.tone["crop"], full.tone["max_pixels"])
    return finishing.finish(tone, frame, **full.finish)


def _widest(wanted: Recipe, tone: Tone) -> float:
    """The width of the largest dots or strokes to come in mm, as far as the settings tell it, else 0."""
    knobs, module = wanted.knobs, sys.modules[styles.style(wanted.style).__module__]
    if "pen" not in knobs:
        return 0.0
    if knobs.get("sizes"):
        return float(max(knobs["sizes"]))
    if knobs["pen"] is None and knobs.get("dots") and "dots" in getattr(module, "EITHER", ()):
        return 2 * math.sqrt(tone.ink / knobs["dots"] / math.pi)  # on average
    pen = knobs["pen"] or getattr(module, "PEN", stippling.PEN)
    follows = [knobs[key] for key in ("size_by", "width_by") if key in knobs]
    if not follows:
        return float(pen * getattr(module, "SPAN", (1.0, 1.0))[1])
    return float(pen * (getattr(module, "SPAN", nibs.SPAN)[1] if "tone" in follows else 1))


def _named_for(sheet: Sheet, pen: float | None) -> Sheet:
    """The sheet with the pen's width as the name of each layer of dots that has none: a plotter takes it from there."""
    if pen is None:
        return sheet
    layers = [replace(layer, name=f"{pen:.4g} mm") if isinstance(layer.art, Marks) and not layer.name else layer for layer in sheet.layers]
    return replace(sheet, layers=tuple(layers))


def _timed(wanted: Recipe, tone: Tone) -> dict[str, int]:
    """The number of dots that a plotter has time for, where a time is given."""
    if wanted.plot["plot_time"] is None:
        return {}
    if "dots" not in wanted.knobs:
        raise ValueError(f"style {wanted.style} has no number of dots to choose; leave out plot-time")
    dots = plotting.dots_for(units.duration(wanted.plot["plot_time"]), inked(tone), **plotter(wanted))
    if dots < 1:
        raise ValueError(f"plot-time {wanted.plot['plot_time']} is too short for a dot; give more")
    return {"dots": dots}


def inked(tone: Tone) -> float:
    """The area on which a tone asks for any ink, mm^2."""
    return tone.mapped(lambda c: np.where(c > 0, 1.0, 0.0)).ink or 1.0


def plotter(wanted: Recipe) -> dict[str, Any]:
    """What a recipe says of nib, dots and machine, as plotting.expected takes it."""
    plot = wanted.plot
    machine = plotting.Machine(plot["speed_down"], plot["speed_up"], plot["lift"], plot["dwell"])
    return {"nib": plot["nib"] or plotting.NIB, "dot": plot["dot"], "machine": machine}


def found(file: Path, given: Paths, folder: Path) -> tuple[Recipe, dict[str, Path]]:
    """The recipe that a drawing keeps, or that a TOML file is, and where its sources are: given, inside it, or beside it.

    What the file keeps inside is put into `folder`.

    Raises ValueError where one is missing or is not what the drawing was made from.
    """
    wanted, kept = read(file)
    if PICTURE not in wanted.sources and PICTURE in given:
        wanted = replace(wanted, sources={PICTURE: Source(given[PICTURE].name), **wanted.sources})
    return located(wanted, kept, file, given, folder)


def located(wanted: Recipe, kept: Mapping[str, bytes], file: Path, given: Paths, folder: Path) -> tuple[Recipe, dict[str, Path]]:
    """The recipe that a file has, with its sources' hashes, and where they are: given, `kept` inside the file, or beside it.

    What is kept inside is put into `folder`. Raises ValueError where one is missing or is not what the drawing was made from.
    """
    if PICTURE not in wanted.sources:
        why = (
            "give one with --picture" if file.suffix.lower() == ".toml" else "it was drawn from an array, and only its program can redo it"
        )
        raise ValueError(f"{file}: its recipe names no picture; {why}")
    paths, sources = {}, {}
    for key, source in wanted.sources.items():
        path = given.get(key, file.parent / source.name)
        if key not in given and source.name in kept:
            path = folder / source.name
            path.write_bytes(kept[source.name])
        if not path.exists():
            if key in given:
                raise ValueError(f"{path}: there is no such file; check the name")
            option = key.replace("_", "-")
            raise ValueError(f"{file}: its {key} {source.name!r} is not in {os.fspath(path.parent)}; say where it is with --{option}")
        digest = Source.of(path).sha256
        if source.sha256 not in ("", digest):
            raise ValueError(f"{path}: is not the {key} that {file.name} was drawn from (its SHA-256 differs); give the same file")
        paths[key], sources[key] = path, replace(source, sha256=digest)
    return replace(wanted, sources=sources), paths


def read(file: Path) -> tuple[Recipe, dict[str, bytes]]:
    """The recipe that a drawing keeps, or that a TOML file is, and the sources kept with it."""
    regular(file)
    if file.suffix.lower() == ".toml":
        return recipe.read_toml(contents(file), str(file)), {}
    data, kept = formats.recipe_of(file)
    return recipe.parsed(data, str(file)), kept


def redo(file: str | os.PathLike[str], *, picture: str | os.PathLike[str] | None = None) -> Sheet:
    """The sheet of a drawing made again from the recipe in its SVG or PDF, of a picture beside it, inside it, or given.

    Raises ValueError for a file without a recipe, and for a picture that is missing or another.
    """
    with tempfile.TemporaryDirectory() as folder:
        wanted, paths = found(Path(file), {PICTURE: Path(picture)} if picture is not None else {}, Path(folder))
        return styles.run(steps(wanted, paths, *laid_out(wanted, paths)))
