"""From a recipe and its sources to a sheet, the first time and again."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from crowquill import formats, layout, recipe, styles
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


def laid_out(wanted: Recipe, paths: Paths) -> tuple[tuple[float, float], Tone]:
    """The paper's sides in mm, and the tone in its place on it."""
    full = wanted.with_paths(paths)
    return layout.placed(layout.lit(paths[PICTURE], **full.tone), **full.paper)


def steps(wanted: Recipe, paths: Paths, size: tuple[float, float], tone: Tone) -> Work:
    """The work that the recipe asks for on what laid_out() gave: a generator of Steps that returns the sheet on its paper."""
    recipe.check_names(wanted)
    full = wanted.with_paths(paths)
    sheet = yield from styles.steps(full.style, tone, seed=full.seed, **full.knobs)
    sheet = layout.on_paper(sheet, size, wanted.paper["margin"], wanted.paper["check_bar"])
    made = {key: sheet.recipe[key] for key in sorted(recipe.RESULTS)}
    sheet = replace(sheet, recipe={**wanted.data(), "version": version("crowquill"), **made})
    return recipe.attached(sheet, wanted, paths, embed=wanted.files.get("embed", False))


def found(file: Path, given: Paths, folder: Path) -> tuple[Recipe, dict[str, Path]]:
    """The recipe that a drawing keeps, or that a TOML file is, and where its sources are: given, inside it, or beside it.

    What the file keeps inside is put into `folder`.

    Raises ValueError where one is missing or is not what the drawing was made from.
    """
    wanted, kept = read(file)
    if PICTURE not in wanted.sources and PICTURE in given:
        wanted = replace(wanted, sources={PICTURE: Source(given[PICTURE].name), **wanted.sources})
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
            raise ValueError(f"{file}: its {key} {source.name!r} is not in {os.fspath(path.parent)}; say where it is with --{key}")
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
