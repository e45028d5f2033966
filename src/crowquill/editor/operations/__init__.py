"""Operations: all that changes a drawing, by name. Each is a pure function of a drawing, chance and its parameters.

An operation is a function `name(drawing, rng, *, knob=...)` below `@operation(group)`, or `name(meant, rng, *, knob=...)` below
`@on_meant(group)` where it works on what is under a brush, selected, or all; its knobs are declared as a style's are, and its
docstring's first line is its help. It returns the drawing it makes, or yields Steps on the way to it.
"""

from __future__ import annotations

import importlib
import inspect
import numbers
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from crowquill import styles
from crowquill.editor.brushes import meant
from crowquill.editor.drawing import Drawing
from crowquill.knobs import Knob, checked, of, unknown
from crowquill.sheet import Step

MODULES = ("marking", "moving", "selecting", "relaxing", "mosaics", "painting", "layering", "papering", "redrawing")
MOST = 1_000_000  # items of a drawing
STYLE = "redraw "  # before the name of a style

Work = Generator[Step, None, Drawing]


@dataclass(frozen=True, eq=False)
class Operation:
    """An operation: its group says where a page puts its control.

    common  knobs of `meant`, where it works on what is meant by them; more, those beside its signature's
    """

    name: str
    group: str
    function: Callable[..., Drawing | Work]
    about: str
    common: Mapping[str, Knob] = field(default_factory=dict)
    more: Callable[[], dict[str, Knob]] = dict

    @cached_property
    def knobs(self) -> dict[str, Knob]:
        """What it takes, in its order."""
        return {**self.common, **of(getattr(self.function, "func", self.function)), **self.more()}

    def begun(self, drawing: Drawing, rng: np.random.Generator, chosen: Mapping[str, Any]) -> Any:
        """What the function makes of a drawing and all its knobs' values: another drawing, or work that comes to one."""
        own = {key: value for key, value in chosen.items() if key not in self.common}
        if not self.common:
            return self.function(drawing, rng, **own)
        return self.function(meant(drawing, **{key: chosen[key] for key in self.common}), rng, **own)


_FOUND: dict[str, Operation] = {}
Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def operation(group: str) -> Decorator:
    """Makes an operation of a function of a drawing; a _ in its name is a space."""
    return _made(group, {})


def on_meant(group: str, **defaults: Any) -> Decorator:
    """Makes an operation of a function of a Meant; `defaults` are for knobs of meant() that begin with other values."""
    return _made(group, {key: replace(knob, default=defaults.get(key, knob.default)) for key, knob in of(meant).items()})


def _made(group: str, common: Mapping[str, Knob]) -> Decorator:
    def made(function: Callable[..., Any]) -> Callable[..., Any]:
        about = (function.__doc__ or function.__name__).splitlines()[0]
        add(Operation(function.__name__.replace("_", " "), group, function, about, common))
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


def find(name: str) -> Operation:
    """The operation of a name. Raises ValueError for an unknown one."""
    if name not in every():
        raise ValueError(f"no {unknown('operation', name, every())}")
    return every()[name]


def work(drawing: Drawing, name: str, values: Mapping[str, Any], seed: int) -> Work:
    """An operation at work: Steps, and the drawing that it makes. Who stops iterating has cancelled.

    Raises ValueError for what is unknown or out of range, and for what the drawing has not.
    """
    found = find(name)
    chosen = checked(found.knobs, values, f"operation {name}")
    if isinstance(seed, bool) or not isinstance(seed, numbers.Integral) or not 0 <= seed < 2**53:
        raise ValueError(f"seed is {seed!r}; it takes a whole number, 0 or more")
    begun = found.begun(replace(drawing, facts={}, notes=()), np.random.default_rng(seed), chosen)
    made: Drawing = (yield from begun) if inspect.isgenerator(begun) else begun
    count = sum(len(layer.items) for layer in made.layers)
    if count > MOST:
        raise ValueError(f"the drawing would have {count} marks, over the limit of {MOST}; draw fewer")
    return made


def applied(drawing: Drawing, name: str, values: Mapping[str, Any], seed: int = 0) -> Drawing:
    """The drawing that an operation makes."""
    return styles.run(work(drawing, name, values, seed))
