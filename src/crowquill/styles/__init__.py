"""Styles: how a Tone becomes a Sheet. One file of this folder is one style; its signature is its only schema.

A style is a generator `draw(tone, rng, *, knob=...)`: it yields Steps and returns its Sheet. One that minds how files show it may
have `suited(knobs, files)`, the knobs that it draws best with for them, and `remarks(report, files)`, what is to be said of them.
"""

from __future__ import annotations

import ast
import importlib
import numbers
import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import EntryPoints, entry_points, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from crowquill.knobs import Knob, checked, of, unknown

if TYPE_CHECKING:
    from crowquill.sheet import Sheet, Shown, Step
    from crowquill.tone import Tone

Work = Generator["Step", None, "Sheet"]
Found = TypeVar("Found")


@cache
def plugins() -> EntryPoints:
    """The styles of other packages, looked for once: that takes 15 ms, and a recipe asks twenty times."""
    return entry_points(group="crowquill.styles")


def names() -> list[str]:
    """The styles there are, sorted: files of this folder, and plug-ins of the group crowquill.styles."""
    own = {path.stem for path in Path(__file__).parent.glob("[a-z]*.py")}
    return sorted(own | {entry.name for entry in plugins()})


def summary(name: str) -> str:
    """The first line of a style's module, read without importing it."""
    path = Path(__file__).parent / f"{name}.py"
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) if path.exists() else None
    return (text or name).splitlines()[0]


def style(name: str) -> Callable[..., Work]:
    """The generator function of a style, or a ValueError that names those there are."""
    for entry in plugins():
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


def suited(name: str, values: Mapping[str, Any], files: Sequence[Shown]) -> Mapping[str, Any]:
    """A style's knobs as they suit the files that will be written."""
    own = getattr(sys.modules[style(name).__module__], "suited", None)
    found: Mapping[str, Any] = own(values, files) if own and files else values
    return found


def remarks(report: Mapping[str, Any], files: Sequence[Shown]) -> list[str]:
    """What is to be said of files that show a drawing otherwise than it was drawn for, and of the drawings on a plate alike."""
    found = [line for panel in report.get("panels", ()) for own in panel["layers"] for line in remarks(own, files)]
    if report.get("style") in names():
        own = getattr(sys.modules[style(report["style"]).__module__], "remarks", None)
        found += own(report, files) if own else []
    return found


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
    still = {"iterations": 0, "energy": 0.0, "movement": 0.0}  # of styles where nothing moves
    return replace(sheet, recipe=made, report={**shared, **still, **sheet.report})


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
