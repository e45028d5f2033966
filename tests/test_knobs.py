"""A knob is what its annotation says: values of other kinds are refused by name, and names unknown by the nearest."""

from __future__ import annotations

from typing import Annotated

import pytest

from crowquill import knobs
from crowquill.knobs import Choice, Flag, Numbers, Range, Text


def shape(
    thing: object,
    *,
    size: Annotated[float, Range(0.1, 5, "mm", "across")] = 0.5,
    count: Annotated[int | None, Range(1, 9, "", "how many")] = None,
    kind: Annotated[str, Choice(("round", "square"), "what kind")] = "round",
    bold: Annotated[bool, Flag("stronger")] = False,
    sides: Annotated[tuple[float, ...] | None, Numbers(0, 10, "mm", "some")] = None,
    box: Annotated[tuple[float, ...] | None, Numbers(0, 1, "", "four", 4)] = None,
    source: Annotated[str | None, Text("a file", file=True)] = None,
) -> None:
    """A function with a knob of every kind."""


TAKES = knobs.of(shape)


def test_knobs_are_the_keywords_of_a_function_in_its_order():
    assert list(TAKES) == ["size", "count", "kind", "bold", "sides", "box", "source"]
    assert TAKES["count"].whole and not TAKES["size"].whole and TAKES["size"].default == 0.5


@pytest.mark.parametrize(
    ("name", "value", "gives"),
    [
        ("size", 1, 1.0),
        ("size", "0.3mm", 0.3),
        ("size", "1cm", None),
        ("size", True, None),
        ("size", "wide", None),
        ("size", float("nan"), None),
        ("count", 3.0, 3),
        ("count", 2.5, None),
        ("count", "3", None),
        ("kind", "square", "square"),
        ("kind", "oval", None),
        ("kind", 1, None),
        ("kind", ["round"], None),
        ("bold", True, True),
        ("bold", 1, None),
        ("sides", [1, "2mm"], (1.0, 2.0)),
        ("sides", (0.5,), (0.5,)),
        ("sides", [], None),
        ("sides", 3, None),
        ("sides", [11], None),
        ("box", [0, 0, 1, 1], (0, 0, 1, 1)),
        ("box", [0, 0, 1], None),
        ("source", "a.svg", "a.svg"),
        ("source", 7, None),
    ],
)
def test_a_value_is_taken_in_the_knobs_own_type_or_refused_by_name(name, value, gives):
    if gives is not None:
        assert TAKES[name].checked(value) == gives and type(TAKES[name].checked(value)) is type(gives)
        return
    with pytest.raises(ValueError, match=name):
        TAKES[name].checked(value)


def test_defaults_stand_in_and_an_unknown_name_is_answered_with_the_nearest():
    assert knobs.checked(TAKES, {"size": 2}, "shape")["size"] == 2.0 and knobs.checked(TAKES, {}, "shape")["kind"] == "round"
    with pytest.raises(ValueError, match=r"shape has no knob 'siez'; did you mean size\?"):
        knobs.checked(TAKES, {"siez": 2}, "shape")
    with pytest.raises(ValueError, match="there are size, count"):
        knobs.checked(TAKES, {"zzz": 2}, "shape")
