"""Glyph libraries: SVG files of dots, loaded as unit glyphs. One file is one library."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crowquill.paths import Paths
from crowquill.sheet import Glyph
from crowquill.vector import contents, elements, local

FOLDER = Path(__file__).parent
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


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

    Every path of the file with M, C and Z alone is a glyph, in mm at true size; it is made a
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
    glyphs = []
    for element in elements(data, name):
        if local(element) == "library":
            about = _about(element.text or "{}", name)
        if local(element) == "path":
            try:
                glyphs.append(Glyph.of(_outline(element.get("d", ""))))
            except ValueError as error:
                raise ValueError(f"{name}: path {element.get('id', str(len(glyphs)))[:40]!r} is no glyph: {error}") from None
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


def _outline(d: str) -> Paths:
    """The one cubic ring of path data of absolute M, C and Z."""
    parts = re.findall(rf"[A-Za-z]|{NUMBER}", d)
    letters = [part for part in parts if part.isalpha()]
    numbers = np.array([float(part) for part in parts if not part.isalpha()])
    if not letters or letters[0] != "M" or letters[-1] != "Z" or set(letters[1:-1]) != {"C"} or len(numbers) % 6 != 2:
        raise ValueError("its data is not one M, then C, then Z; convert it to absolute cubic curves")
    points = numbers.reshape(-1, 2)
    if not np.allclose(points[0], points[-1], atol=1e-4):  # mm: the decimals such files are written with
        raise ValueError("its outline does not end where it begins; close it")
    return Paths.of([points[:-1]], cubic=True)
