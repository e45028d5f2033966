"""Glyph libraries: SVG files of dots, loaded as unit glyphs. One file is one library."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crowquill.sheet import Glyph
from crowquill.vector import contents, elements, local, shapes

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Library:
    """Unit glyphs and what is known of them: pen_mm, how they were made, licence, whether they are simulated."""

    name: str
    glyphs: tuple[Glyph, ...]
    about: dict[str, Any]


def names() -> list[str]:
    """The libraries that come with the package, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.svg"))


def load(source: str | os.PathLike[str]) -> Library:
    """The library of a name from names(), or of an SVG file by its path.

    Every shape of the file is a glyph, one closed outline at true size; it is made a
    unit glyph (area 1, centroid 0, long axis on x), and its true diameter kept. Raises ValueError
    for an unknown name or a file that holds no such glyphs, OSError where it cannot be read.
    """
    path = FOLDER / f"{source}.svg" if str(source) in names() else Path(source)
    if path.suffix.lower() != ".svg":
        raise ValueError(f"no glyph library {str(source)!r}; there are {', '.join(names())}, or the path of an SVG file")
    return parsed(contents(path), str(source))


def parsed(data: bytes, name: str) -> Library:
    """The library in the bytes of an SVG file; errors call it `name`."""
    about: dict[str, Any] = {}
    for element in elements(data, name):
        if local(element) == "library":
            about = _about(element.text or "{}", name)
    glyphs = []
    for paths, shape in shapes(data, name)[1]:
        try:
            glyphs.append(Glyph.of(paths.curved()))
        except ValueError as error:
            raise ValueError(f"{name}: path {str(shape.id or len(glyphs))[:40]!r} is no glyph: {error}") from None
    if not glyphs:
        raise ValueError(f"{name}: the file has no paths; a glyph library has one closed path a dot")
    return Library(str(about.get("name", name)), tuple(glyphs), about)


def _about(text: str, name: str) -> dict[str, Any]:
    """The metadata of a library: a JSON object."""
    try:
        about = json.loads(text)
    except (ValueError, RecursionError):
        raise ValueError(f"{name}: its metadata is not JSON; mend or remove its <library> element") from None
    if not isinstance(about, dict):
        raise ValueError(f"{name}: its metadata is not a JSON object; mend or remove its <library> element")
    return about
