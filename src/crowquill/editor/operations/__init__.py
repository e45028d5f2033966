"""Operations: all that changes a drawing, by name. Each is a pure function of a drawing, chance and its parameters.

An operation is a function `name(drawing, rng, *, knob=...)` below `@operation(group)`; its knobs are declared as a style's are,
and its docstring's first line is its help. It returns the drawing it makes, or yields Steps on the way to it.
"""

from __future__ import annotations

import importlib
import inspect
import numbers
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from crowquill import styles
from crowquill.editor.drawing import Drawing
from crowquill.knobs import Knob, checked, of, unknown
from crowquill.sheet import Step

MODULES = ("marking", "moving", "selecting", "relaxing", "mosaics", "painting", "layering", "redrawing")
MOST = 1_000_000  # items of a drawing
STYLE = "redraw "  # before the name of a style

Work = Generator[Step, None, Drawing]


@dataclass(frozen=True, eq=False)
class Operation:
    """An operation: its group says where a page puts its control; `more` are knobs beside those of its signature."""

    name: str
    group: str
    function: Callable[..., Drawing | Work]
    about: str
    more: Callable[[], dict[str, Knob]] = dict

    @cached_property
    def knobs(self) -> dict[str, Knob]:
        """What it takes, in its order."""
        return of(getattr(self.function, "func", self.function)) | self.more()


_FOUND: dict[str, Operation] = {}


def operation(group: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Makes an operation of a function; a _ in its name is a space."""

    def made(function: Callable[..., Any]) -> Callable[..., Any]:
        name = function.__name__.strip("_").replace("_", " ")
        add(Operation(name, group, function, (function.__doc__ or name).splitlines()[0]))
        return function

    return made


def add(one: Operation) -> None:
    """Adds an operation."""
    _FOUND[one.name] = one


@cache
def every() -> dict[str, Operation]:
    """All operations by name, in the order of their modules."""
    for name in MODULES:
        importlib.import_module(f"crowquill.editor.operations.{name}")
    return _FOUND


def check(name: str, values: Mapping[str, Any], seed: int) -> tuple[Operation, dict[str, Any]]:
    """The operation of a name and all its knobs' values. Raises ValueError for what is unknown or of a wrong type or range."""
    if name not in every():
        raise ValueError(f"no {unknown('operation', name, every())}")
    if isinstance(seed, bool) or not isinstance(seed, numbers.Integral) or not 0 <= seed < 2**53:
        raise ValueError(f"seed is {seed!r}; it takes a whole number, 0 or more")
    found = every()[name]
    return found, checked(found.knobs, values, f"operation {name}")


def work(drawing: Drawing, name: str, values: Mapping[str, Any], seed: int) -> Work:
    """An operation at work: Steps, and the drawing that it makes. Who stops iterating has cancelled.

    Raises ValueError for what is unknown or out of range, and for what the drawing has not.
    """
    found, chosen = check(name, values, seed)
    begun: Any = found.function(replace(drawing, facts={}, notes=()), np.random.default_rng(seed), **chosen)
    made: Drawing = (yield from begun) if inspect.isgenerator(begun) else begun
    count = sum(len(layer.items) for layer in made.layers)
    if count > MOST:
        raise ValueError(f"the drawing would have {count} marks, over the limit of {MOST}; draw fewer")
    return made


def applied(drawing: Drawing, name: str, values: Mapping[str, Any], seed: int = 0) -> Drawing:
    """The drawing that an operation makes."""
    return styles.run(work(drawing, name, values, seed))
