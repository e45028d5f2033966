"""Styles: how a Tone becomes a Sheet. One file of this folder is one style; its signature is its only schema.

A style is a generator `draw(tone, rng, *, knob=...)`: it yields Steps and returns its Sheet.
"""

from __future__ import annotations

import ast
import importlib
import numbers
import sys
from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from importlib.metadata import entry_points, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from crowquill.knobs import Knob, checked, of, unknown

if TYPE_CHECKING:
    from crowquill.sheet import Sheet, Step
    from crowquill.tone import Tone

Work = Generator["Step", None, "Sheet"]
Found = TypeVar("Found")


def names() -> list[str]:
    """The styles there are, sorted: files of this folder, and plug-ins of the group crowquill.styles."""
    own = {path.stem for path in Path(__file__).parent.glob("[a-z]*.py")}
    return sorted(own | {entry.name for entry in entry_points(group="crowquill.styles")})


def summary(name: str) -> str:
    """The first line of a style's module, read without importing it."""
    path = Path(__file__).parent / f"{name}.py"
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) if path.exists() else None
    return (text or name).splitlines()[0]


def style(name: str) -> Callable[..., Work]:
    """The generator function of a style, or a ValueError that names those there are."""
    for entry in entry_points(group="crowquill.styles"):
        if entry.name == name:
            function: Callable[..., Work] = entry.load()
            return function
    if name not in names():
        raise ValueError(f"no {unknown('style', name, names())}")
    function = importlib.import_module(f"crowquill.styles.{name}").draw
    return function


def says(name: str, what: str, otherwise: Any) -> Any:
    """What a style's module says of it under this name, or else `otherwise`.

    COLOUR  True: it draws by the picture's colours
    INKS    False: it cannot draw one ink of several, nor white on black
    turned  a function: of an ink of several its dots are not moved clear of others; these are its knobs, turned by so many degrees
    """
    return getattr(sys.modules[style(name).__module__], what, otherwise)


def coloured(name: str) -> bool:
    """Whether a style draws by the picture's colours."""
    return bool(says(name, "COLOUR", False))


def knobs(name: str) -> dict[str, Knob]:
    """The knobs of a style, read from its signature, in its order."""
    return of(style(name))


def steps(name: str, tone: Tone, *, seed: int = 0, **values: Any) -> Work:
    """A style at work on a tone: a generator of Steps that returns the Sheet. Who stops iterating has cancelled.

    values  knobs of the style; unknown names and values out of range are ValueErrors, before any work
    """
    chosen = checked(knobs(name), values, f"style {name}")
    if isinstance(seed, bool) or not isinstance(seed, numbers.Integral) or seed < 0:
        raise ValueError(f"seed is {seed!r}; it takes a whole number, 0 or more")
    return _recorded(name, tone, int(seed), chosen)


def _recorded(name: str, tone: Tone, seed: int, chosen: dict[str, Any]) -> Work:
    """The style's own work; its sheet gets the recipe, and the report the fields that every style shares."""
    import numpy as np

    sheet = yield from style(name)(tone, np.random.default_rng(seed), **chosen)
    made = recipe(name, seed, chosen, sheet.size)
    shared = {key: made[key] for key in ("style", "version", "seed", "art_mm")}
    return replace(sheet, recipe=made, report={**shared, **sheet.report})


def recipe(name: str, seed: int, values: Mapping[str, Any], size: tuple[float, float]) -> dict[str, Any]:
    """What made a sheet of this size by itself, as plain data: a style, its knobs and a seed."""
    chosen = checked(knobs(name), values, f"style {name}")
    kept = {key: list(value) if isinstance(value, tuple) else value for key, value in chosen.items() if value is not None}
    return {"style": name, "version": version("crowquill"), "seed": seed, "knobs": kept, "art_mm": list(size)}


def run(work: Generator[Step, None, Found], watch: Callable[[Step], None] | None = None) -> Found:
    """What work returns, a style's its Sheet, run to its end; `watch` sees each Step."""
    while True:
        try:
            step = next(work)
        except StopIteration as stop:
            found: Found = stop.value
            return found
        if watch:
            watch(step)
