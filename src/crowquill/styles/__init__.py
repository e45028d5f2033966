"""Styles: how a Tone becomes a Sheet. One file of this folder is one style; its signature is its only schema.

A style is a generator `draw(tone, rng, *, knob=...)`: it yields Steps and returns its Sheet.
"""

from __future__ import annotations

import ast
import difflib
import importlib
import inspect
import math
import numbers
import os
import typing
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from importlib.metadata import entry_points, version
from pathlib import Path
from typing import Any

if typing.TYPE_CHECKING:
    from crowquill.sheet import Sheet, Step
    from crowquill.tone import Tone

Work = Generator["Step", None, "Sheet"]


@dataclass(frozen=True)
class Range:
    """A number from low to high; unit "mm" makes it a length on the command line."""

    low: float
    high: float
    unit: str
    help: str


@dataclass(frozen=True)
class Choice:
    """One of some names."""

    names: tuple[str, ...]
    help: str


@dataclass(frozen=True)
class Text:
    """A name or a path."""

    help: str


@dataclass(frozen=True)
class Knob:
    """One keyword of a style: what it takes, its default, and whether None (left to the style) will do."""

    name: str
    takes: Range | Choice | Text
    default: Any
    whole: bool

    def checked(self, value: Any) -> Any:
        """The value in the knob's own type, or a ValueError that says what would be right."""
        if value is None and self.default is None:
            return None
        if isinstance(self.takes, Choice):
            if value not in self.takes.names:
                raise ValueError(f"no {self.name} {value!r}; there are {', '.join(self.takes.names)}")
        elif isinstance(self.takes, Range):
            number = isinstance(value, numbers.Real) and not isinstance(value, bool) and math.isfinite(value)
            if not number or not self.takes.low <= value <= self.takes.high or (self.whole and value != int(value)):
                kind = "whole number" if self.whole else "number"
                unit = f" {self.takes.unit}" if self.takes.unit else ""
                raise ValueError(f"{self.name} is {value!r}; it takes a {kind} from {self.takes.low:g} to {self.takes.high:g}{unit}")
            return int(value) if self.whole else float(value)
        elif not isinstance(value, (str, os.PathLike)):
            raise ValueError(f"{self.name} is {value!r}; it takes a name or a path")
        return os.fspath(value)


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
        near = difflib.get_close_matches(name, names(), 1)
        raise ValueError(f"no style {name!r}; {f'did you mean {near[0]}?' if near else 'there are ' + ', '.join(names())}")
    function = importlib.import_module(f"crowquill.styles.{name}").draw
    return function


def knobs(name: str) -> dict[str, Knob]:
    """The knobs of a style, read from its signature, in its order."""
    function = style(name)
    hints = typing.get_type_hints(function, include_extras=True)
    found = {}
    for key, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is not parameter.KEYWORD_ONLY:
            continue
        base, takes = typing.get_args(hints[key])[:2]
        kinds = typing.get_args(base) or (base,)
        found[key] = Knob(key, takes, parameter.default, int in kinds and float not in kinds)
    return found


def steps(name: str, tone: Tone, *, seed: int = 0, **values: Any) -> Work:
    """A style at work on a tone: a generator of Steps that returns the Sheet. Who stops iterating has cancelled.

    values  knobs of the style; unknown names and values out of range are ValueErrors, before any work
    """
    takes = knobs(name)
    for key in values:
        if key not in takes:
            near = difflib.get_close_matches(key, takes, 1)
            raise ValueError(f"style {name} has no knob {key!r}; {f'did you mean {near[0]}?' if near else 'there are ' + ', '.join(takes)}")
    if isinstance(seed, bool) or not isinstance(seed, numbers.Integral) or seed < 0:
        raise ValueError(f"seed is {seed!r}; it takes a whole number, 0 or more")
    chosen = {key: knob.checked(values.get(key, knob.default)) for key, knob in takes.items()}
    return _recorded(name, tone, int(seed), chosen)


def _recorded(name: str, tone: Tone, seed: int, chosen: dict[str, Any]) -> Work:
    """The style's own work; its sheet gets the recipe, and the report the fields that every style shares."""
    import numpy as np

    sheet = yield from style(name)(tone, np.random.default_rng(seed), **chosen)
    recipe = {"style": name, "version": version("crowquill"), "seed": seed, "knobs": chosen, "art_mm": list(sheet.size)}
    shared = {"style": name, "version": recipe["version"], "seed": seed, "art_mm": list(sheet.size)}
    return replace(sheet, recipe=recipe, report={**shared, **sheet.report})


def run(work: Work, watch: Callable[[Step], None] | None = None) -> Sheet:
    """The Sheet of work run to its end; `watch` sees each Step."""
    while True:
        try:
            step = next(work)
        except StopIteration as stop:
            sheet: Sheet = stop.value
            return sheet
        if watch:
            watch(step)
