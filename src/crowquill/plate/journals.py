"""Journals: how wide their columns are and what lettering they ask for, as far as they state it."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crowquill import units


@dataclass(frozen=True)
class Journal:
    """Widths of figures in mm, for one column and more; the height of its page, style of letters and sizes of text in mm, where stated.

    least   the smallest lettering it takes, by the font's size
    source  where it says so
    """

    widths: tuple[float, ...]
    source: str
    height: float | None = None
    letters: str | None = None
    text: float | None = None
    least: float | None = None


def _read() -> dict[str, Journal]:
    found: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    return {name: Journal(tuple(map(float, said.pop("widths"))), **_plain(said)) for name, said in found.items()}


def _plain(said: dict[str, Any]) -> dict[str, Any]:
    """Points as millimetres."""
    return {key: units.length(value) if key in ("text", "least") and isinstance(value, str) else value for key, value in said.items()}


JOURNALS = _read()
