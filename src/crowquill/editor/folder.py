"""The folder that a drawing was opened in: which files requests may name, by their bare names, and that they are what they were."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from crowquill import glyphs, shapes
from crowquill.knobs import Knob, Text
from crowquill.vector import contents


def within(folder: Path, name: Any) -> Path:
    """The path of a file in a folder. ValueError for anything but a bare name, and for links that lead elsewhere."""
    if not isinstance(name, str) or not name or name in (".", "..") or any(mark in name for mark in "/\\\0:"):
        raise ValueError(f"{str(name)[:100]!r} is not the name of a file in the folder; give one without folders")
    path = folder / name
    if Path(os.path.realpath(path)) != Path(os.path.realpath(folder)) / name:
        raise ValueError(f"{name!r} is a link to another place; give a file of the folder")
    return path


def named(folder: Path, takes: Mapping[str, Knob], values: Mapping[str, Any]) -> dict[str, Path]:
    """The files that values of knobs name, by their keys. A word, such as that of a library that comes along, names none.

    Raises ValueError for a file that is not of the folder.
    """
    files = [key for key, knob in takes.items() if isinstance(knob.takes, Text) and knob.takes.file]
    return {key: within(folder, values[key]) for key in files if isinstance(values.get(key), str) and _is_file(values[key])}


def _is_file(value: str) -> bool:
    """Whether a value might be read as a file: whatever is no plain word, and words that a file is called by."""
    book = value.partition("/")[0]
    if not Path(value).suffix and (book in glyphs.names() or book in shapes.names()):
        return False
    return bool(Path(value).suffix) or any(mark in value for mark in "/\\\0:") or Path(value).exists()


def digests(folder: Path, takes: Mapping[str, Knob], values: Mapping[str, Any]) -> dict[str, str]:
    """The SHA-256 of each file that values of knobs name. Raises what named() does, and OSError for what cannot be read."""
    return {path.name: hashlib.sha256(contents(path)).hexdigest() for path in named(folder, takes, values).values()}


def located(folder: Path, takes: Mapping[str, Knob], values: Mapping[str, Any], known: Mapping[str, str]) -> dict[str, Any]:
    """The values with paths for names of files. Raises ValueError for a file that is not what is known of it, by its SHA-256."""
    found = dict(values)
    for key, path in named(folder, takes, values).items():
        if hashlib.sha256(contents(path)).hexdigest() != known.get(path.name):
            raise ValueError(f"{path}: is not the file that was read (its SHA-256 differs); give the same")
        found[key] = str(path)
    return found
