"""Knobs: what a function takes by keyword, read from its signature, the one place where each is declared.

Options of the command line, checks of recipes and of calls, and editors' controls all come from here.
"""

from __future__ import annotations

import difflib
import inspect
import math
import numbers
import os
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from crowquill import units


@dataclass(frozen=True)
class Range:
    """A number from low to high; unit "mm" makes it a length, which may be a text such as "0.3mm"."""

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
    """A name or a path; `file` where a path is read as a file, which a recipe keeps by its name and contents."""

    help: str
    file: bool = False


@dataclass(frozen=True)
class Flag:
    """Yes or no."""

    help: str


@dataclass(frozen=True)
class Numbers:
    """Some numbers from low to high, `count` of them where that is given; on the command line parted by commas."""

    low: float
    high: float
    unit: str
    help: str
    count: int | None = None


Takes = Range | Choice | Text | Flag | Numbers


@dataclass(frozen=True)
class Knob:
    """One keyword of a function: what it takes, its default, and whether its numbers are whole. None is left to the function."""

    name: str
    takes: Takes
    default: Any
    whole: bool

    def checked(self, value: Any) -> Any:
        """The value in the knob's own type, or a ValueError that says what would be right."""
        takes = self.takes
        if value is None and self.default is None:
            return None
        if isinstance(takes, Choice):
            if value not in takes.names:
                raise ValueError(f"no {self.name} {value!r}; there are {', '.join(takes.names)}")
            return str(value)
        if isinstance(takes, Flag):
            if not isinstance(value, bool):
                raise ValueError(f"{self.name} is {value!r}; it takes true or false")
            return value
        if isinstance(takes, Range):
            return self._number(value)
        if isinstance(takes, Numbers):
            several = list(value) if hasattr(value, "__iter__") and not isinstance(value, (str, bytes, Mapping)) else []
            if not several or takes.count not in (None, len(several)):
                raise ValueError(f"{self.name} is {value!r}; it takes {takes.count or 'some'} numbers")
            return tuple(self._number(part) for part in several)
        if not isinstance(value, (str, os.PathLike)):
            raise ValueError(f"{self.name} is {value!r}; it takes a name or a path")
        return os.fspath(value)

    def _number(self, value: Any) -> float | int:
        assert isinstance(self.takes, (Range, Numbers))
        low, high, unit = self.takes.low, self.takes.high, self.takes.unit
        if isinstance(value, str) and unit == "mm":
            try:
                value = units.length(value)
            except ValueError as error:
                raise ValueError(f"{self.name}: {error}") from None
        number = isinstance(value, numbers.Real) and not isinstance(value, bool) and math.isfinite(value)
        if not number or not low <= value <= high or (self.whole and value != int(value)):
            kind = "whole number" if self.whole else "number"
            raise ValueError(f"{self.name} is {value!r}; it takes a {kind} from {low:g} to {high:g}{f' {unit}' if unit else ''}")
        return int(value) if self.whole else float(value)


def of(function: Callable[..., Any]) -> dict[str, Knob]:
    """The knobs of a function, in its order: its keyword-only parameters."""
    hints = typing.get_type_hints(function, include_extras=True)
    found = {}
    for key, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is not parameter.KEYWORD_ONLY:
            continue
        base, takes = typing.get_args(hints[key])[:2]
        kinds = typing.get_args(base) or (base,)
        found[key] = Knob(key, takes, parameter.default, int in kinds and float not in kinds)
    return found


def checked(takes: Mapping[str, Knob], values: Mapping[str, Any], owner: str) -> dict[str, Any]:
    """Every knob's value, its default where none is given. A ValueError names what is unknown, with the nearest that is known."""
    for key in values:
        if key not in takes:
            raise ValueError(f"{owner} has no {unknown('knob', str(key), takes)}")
    return {key: knob.checked(values.get(key, knob.default)) for key, knob in takes.items()}


def unknown(kind: str, name: str, known: typing.Iterable[str]) -> str:
    """What is said of a name that is not among those known: the nearest, or all there are."""
    near = difflib.get_close_matches(name, list(known), 1)
    return f"{kind} {name!r}; {f'did you mean {near[0]}?' if near else 'there are ' + ', '.join(known)}"
