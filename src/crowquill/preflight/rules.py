"""What a rule is, what it finds, and the limits it goes by. Each rule is a function, registered by its decorator."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from crowquill.preflight.values import told

ERROR, WARNING, INFORMATION = "error", "warning", "information"
KINDS = ("x1a", "x3", "x4", "a")  # what a PDF can be held to
X = ("x1a", "x3", "x4")


@dataclass(frozen=True)
class Hit:
    """One thing that a rule met: where, what, the value measured, and a severity other than the rule's own."""

    where: str
    message: str
    value: Any = None
    severity: str | None = None


@dataclass(frozen=True)
class Finding:
    """A hit with its rule's name and its severity."""

    rule: str
    severity: str
    where: str
    message: str
    value: Any = None


@dataclass(frozen=True)
class Limits:
    """What a press bears; lengths in mm.

    min_dot, min_gap and min_line warn below themselves, and are errors below their half. safe: None is 5 mm on a paper's size or
    with a bleed, and else 0. spots: None allows any ink. size: the trim that is expected, None for any.
    """

    min_dot: float = 0.1
    min_gap: float = 0.1
    min_line: float = 0.1
    min_text: float = 1.76  # of the font's size: 5 pt
    max_ink: float = 280.0  # percent
    safe: float | None = None
    min_ppi: float = 300.0
    min_ppi_line: float = 600.0
    max_elements: int = 1_000_000
    spots: tuple[str, ...] | None = None
    size: tuple[float, float] | None = None


Check = Callable[[Any, Limits], Iterator[Hit]]


@dataclass(frozen=True)
class Rule:
    """A named check of a PDF, an SVG, or of what either draws (`on` is pdf, svg or drawing), and the kinds it is for; () is all."""

    name: str
    severity: str
    on: str
    kinds: tuple[str, ...]
    about: str
    check: Check = field(repr=False)

    def findings(self, subject: Any, limits: Limits) -> Iterator[Finding]:
        """What it finds in the subject; where it fails, what it found until then, and that as an error."""
        try:
            for hit in self.check(subject, limits):
                yield Finding(self.name, hit.severity or self.severity, hit.where, hit.message, hit.value)
        except Exception as error:  # a file of anybody's may break a rule in any way
            cause = f"{type(error).__name__}: {told(error)[:100]}"
            yield Finding(self.name, ERROR, getattr(subject, "where", "file"), f"this rule could not look: {cause}")


RULES: dict[str, Rule] = {}


def rule(name: str, severity: str, on: str, *kinds: str) -> Callable[[Check], Check]:
    """Registers a check under its name; the first line of its docstring says what it asks for."""

    def registered(check: Check) -> Check:
        assert name not in RULES and set(kinds) <= set(KINDS)
        RULES[name] = Rule(name, severity, on, kinds, (check.__doc__ or "").splitlines()[0], check)
        return check

    return registered


def run(on: str, subject: Any, limits: Limits, kinds: frozenset[str] = frozenset()) -> list[Finding]:
    """All that the rules of one sort of subject find, in the order in which they were registered."""
    return [
        finding
        for one in RULES.values()
        if one.on == on and (not one.kinds or kinds & set(one.kinds))
        for finding in one.findings(subject, limits)
    ]
