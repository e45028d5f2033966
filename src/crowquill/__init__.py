"""crowquill draws pictures with points and cells, at exact size.

A picture becomes a Tone in millimetres, a style turns it into a Sheet, a format writes the sheet:

    from crowquill import Tone, draw, save

    tone = Tone.load("shell.png", width=120)
    sheet = draw("stipple", tone, pen=0.3, seed=1)
    save(sheet.on("a4", margin=15), "shell.pdf", "shell.svg")

Reading order: units, paths, tone, sheet, cells, moments, relax, styles/stipple, formats/svg.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from crowquill.cells import Cells, voronoi
    from crowquill.formats import load, save, to_bytes
    from crowquill.making import redo
    from crowquill.marks import Glyph, Marks
    from crowquill.moments import Moments
    from crowquill.objects import Objects, Shape
    from crowquill.paths import Paths
    from crowquill.relax import lloyd, scatter, settle
    from crowquill.sheet import Ink, Layer, Sheet, Step
    from crowquill.styles import steps
    from crowquill.tone import Tone

_PUBLIC = {
    "cells": ("Cells", "voronoi"),
    "formats": ("load", "save", "to_bytes"),
    "making": ("redo",),
    "moments": ("Moments",),
    "objects": ("Objects", "Shape"),
    "paths": ("Paths",),
    "relax": ("lloyd", "scatter", "settle"),
    "marks": ("Glyph", "Marks"),
    "sheet": ("Ink", "Layer", "Sheet", "Step"),
    "styles": ("steps",),
    "tone": ("Tone",),
}
_HOME = {name: module for module, names in _PUBLIC.items() for name in names}
__all__ = [
    "Cells", "Glyph", "Ink", "Layer", "Marks", "Moments", "Objects", "Paths", "Shape", "Sheet", "Step", "Tone",
    "draw", "lloyd", "load", "redo", "save", "scatter", "settle", "steps", "to_bytes", "voronoi",
]  # fmt: skip


def draw(style: str, tone: Tone, *, seed: int = 0, watch: Callable[[Step], None] | None = None, **knobs: Any) -> Sheet:
    """The Sheet that a style makes of a tone; `watch`, where given, sees each Step.

    knobs  those of the style, and those of inking.steps: inks="C,M,Y,K" draws in several

    Raises ValueError for an unknown style or knob and for values out of range.
    """
    from crowquill import inking
    from crowquill.knobs import of
    from crowquill.styles import run

    own = {key: knobs.pop(key) for key in of(inking.steps) if key in knobs}
    return run(inking.steps(style, tone, seed, knobs, **own), watch)


def __getattr__(name: str) -> Any:
    """Public names are imported when first asked for, so that the command line can answer at once."""
    if name in _HOME:
        return getattr(import_module(f"crowquill.{_HOME[name]}"), name)
    raise AttributeError(f"module 'crowquill' has no attribute {name!r}")
