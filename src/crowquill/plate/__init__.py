"""Plates: several drawings on one page at true size, with letters, scale bars and captions, from a TOML file or a table."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from crowquill import formats, styles
from crowquill.plate import reading
from crowquill.plate.drawing import Opened, named_files
from crowquill.plate.drawing import steps as steps
from crowquill.recipe import RESULTS
from crowquill.sheet import Sheet, Step

Source = str | os.PathLike[str] | Mapping[str, Any]


def opened(source: Source, *, folder: str | os.PathLike[str] | None = None, **files: Any) -> Opened:
    """A plate with its files found and all in its place: from a TOML file, or from a table with the same keys.

    folder  where its files are: that of the TOML file, or the current one
    files   knobs of formats that go before its own; paths among them may lie elsewhere

    Raises ValueError in one line for what is unknown, of a wrong type, missing, off the page, overlapping or outside the folder.
    """
    if isinstance(source, Mapping):
        name, root = "plate", Path()
        found, data = reading.parsed(source, name)
    else:
        path = Path(source)
        name, root = str(path), path.parent
        found, data = reading.read(reading.contents(path), name)
    given = {Path(value).name: Path(value) for key, value in files.items() if key in named_files(files)}
    if files:
        own = {key: Path(value).name if key in named_files(files) else value for key, value in files.items()}
        found, data = reading.parsed({**data, "files": {**found.files, **own}}, name)
    return Opened.of(found, data, name, Path(folder) if folder is not None else root, given)


def drawn(source: Source, *, folder: str | os.PathLike[str] | None = None, watch: Callable[[Step], None] | None = None) -> Sheet:
    """The sheet of a plate, from a TOML file or a table; `watch` sees each Step. Raises what opened() raises."""
    return styles.run(steps(opened(source, folder=folder)), watch)


def kept(file: Path) -> tuple[dict[str, Any], dict[str, bytes]] | None:
    """The plate that a drawing keeps, or that a TOML file printed from one is, as plain data, and the files inside; None for others."""
    import tomllib

    if file.suffix.lower() == ".toml":
        try:
            data: dict[str, Any] = tomllib.loads(reading.contents(file).decode("utf-8"))
            inside: dict[str, bytes] = {}
        except (ValueError, RecursionError):  # others say what is wrong with it
            return None
    else:
        data, inside = formats.recipe_of(file)
    return (data, inside) if data.get("style") == "plate" else None


def again(file: Path, data: Mapping[str, Any], attached: Mapping[str, bytes], *, folder: Path | None = None, inside: Path) -> Opened:
    """The plate that a drawing keeps, by kept(), to be drawn once more, with the files of a folder: that given, or its own.

    A drawing that keeps its files has them put into `inside`. Raises ValueError for files that are missing or not what it was
    drawn from.
    """
    plate, plain = reading.parsed(data, str(file))
    if folder is None and plate.files.get("embed") and plate.sources.keys() <= attached.keys():
        for name in plate.sources:
            _put(inside, name, attached[name])
        folder = inside
    return Opened.of(plate, plain, str(file), folder or file.parent)


def redo(file: str | os.PathLike[str], *, folder: str | os.PathLike[str] | None = None) -> Sheet:
    """The sheet of a plate drawn again from what its SVG, PDF, PNG or TIFF keeps, and the files beside it, inside it, or given.

    Raises ValueError for a drawing of no plate, and what again() raises.
    """
    path = Path(file)
    found = kept(path)
    if found is None:
        raise ValueError(f"{file}: keeps no plate; give a drawing of one")
    with tempfile.TemporaryDirectory() as inside:
        opened = again(path, *found, folder=Path(folder) if folder is not None else None, inside=Path(inside))
        return styles.run(steps(opened, embed=bool(opened.files.get("embed"))))


def toml(data: Mapping[str, Any]) -> str:
    """The plate in plain data as TOML."""
    import tomli_w

    plain = {key: value for key, value in data.items() if key not in RESULTS}
    return "# A plate of crowquill: crowquill plate FILE OUT...\n" + tomli_w.dumps(plain)


def _put(folder: Path, name: str, contents: bytes) -> None:
    """A file into a folder, under a name that does not lead out of it."""
    path = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts or "\0" in name:
        raise ValueError(f"{name!r} is no file of a plate's folder; give the drawing as it was drawn")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(contents)
