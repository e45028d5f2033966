"""Plotters' SVG files are read by vpype, the program most plots go through: every dot, the layers, and nothing of no length."""

from __future__ import annotations

import functools
import importlib.util
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rendering import LIMIT, require

from crowquill import formats, styles
from crowquill.paths import Paths
from crowquill.plotting import FORMS, plotted
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.tone import Tone

LEAST = 0.015  # mm; the shortest ticks are 0.02 before their ends are rounded to whole micrometres
PX = 25.4 / 96  # mm to vpype's pixel


@dataclass(frozen=True)
class Read:
    """A layer as vpype reads it: its number, name, strokes, mm drawn, pen in mm and colour."""

    number: int
    name: str
    strokes: int
    length: float
    pen: float
    colour: str


def vpype(svg: bytes, *commands: str) -> list[Read]:
    """The layers that vpype finds in a file after some commands."""
    program = [sys.executable, "-m", "vpype_cli"] if importlib.util.find_spec("vpype_cli") else [require("vpype")]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "plot.svg").write_bytes(svg)
        done = subprocess.run(
            [*program, "read", "--no-crop", "plot.svg", *commands, "stat"], cwd=folder, capture_output=True, timeout=LIMIT, text=True
        )
    assert done.returncode == 0, done.stderr[-500:]
    return _told(done.stdout)


def _told(text: str) -> list[Read]:
    """What vpype's `stat` prints, by layer."""

    def after(pattern: str, part: str) -> str:
        found = re.search(pattern, part)
        return found[1] if found else "0"

    parts = re.split(r"^Layer (\d+)$", text.split("\nTotals\n")[0], flags=re.MULTILINE)[1:]
    return [
        Read(
            int(number),
            after(r"vp_name: '(.*)'", part),
            int(after(r"Path count: (\d+)", part)),
            float(after(r"Length: ([\d.]+)", part)) * PX,
            float(after(r"vp_pen_width: ([\d.]+)", part)) * PX,
            after(r"svg_stroke: '(#\w+)'", part),
        )
        for number, part in zip(parts[::2], parts[1::2], strict=True)
    ]


@functools.cache
def drawing(style: str, **knobs: Any) -> Sheet:
    """A ramp of 30 by 24 mm in a style."""
    y, x = np.mgrid[0:48, 0:60]
    return styles.run(styles.steps(style, Tone(x / 60 * (y > 3), (30.0, 24.0)), seed=1, **knobs))


def check_read(plot: Sheet, found: list[Read]) -> None:
    """Raises AssertionError unless vpype has every stroke of every layer, in its pen, none of them short."""
    assert [(layer.number, layer.name) for layer in found] == list(enumerate((layer.name for layer in plot.layers), 1))
    for layer, mine, told in zip(found, plot.layers, plot.report["plot"]["layers"], strict=True):
        assert layer.strokes == told["strokes"], f"vpype finds {layer.strokes} strokes in {layer.name!r} of {told['strokes']}"
        assert layer.length == pytest.approx(told["pen_down_mm"], rel=1e-5)
        assert layer.pen == pytest.approx(mine.ink.pen)
        assert layer.colour == "#{:02x}{:02x}{:02x}".format(*mine.ink.rgb)


STYLES: list[tuple[str, dict[str, Any]]] = [
    ("stipple", {"pen": 0.4}),
    ("stipple", {"sizes": (0.3, 0.5)}),
    ("stipple", {"size_by": "tone", "pen": 0.8}),
]


@pytest.mark.parametrize("dot", FORMS)
@pytest.mark.parametrize("style", range(len(STYLES)), ids=["pen", "sizes", "tone"])
def test_vpype_reads_every_dot_of_a_stippled_plot(style: int, dot: str) -> None:
    name, knobs = STYLES[style]
    sheet = drawing(name, iterations=3, **knobs)
    plot = plotted(sheet, dot=dot)
    assert plot.report["plot"]["dots"] == sum(len(layer.art) for layer in sheet.layers)
    check_read(plot, vpype(formats.to_bytes(plot, "svg"), "filter", "--min-length", f"{LEAST}mm"))


@pytest.mark.parametrize("style", [name for name in styles.names() if name != "stipple"])
def test_vpype_reads_every_stroke_of_every_other_style(style: str) -> None:
    plot = plotted(drawing(style))
    check_read(plot, vpype(formats.to_bytes(plot, "svg"), "filter", "--min-length", f"{LEAST}mm"))


def test_vpype_numbers_layers_as_we_do_with_splits_inks_and_codes() -> None:
    ink = Ink("red 2", (0, 1, 1, 0), 0.5)  # a digit in an ink's name is not the layer's number
    line = Layer(ink, Paths.of([[(1, 1), (20, 9)]], closed=False))
    sheet = drawing("stipple", iterations=3, pen=0.4)
    plot = plotted(Sheet(sheet.size, (*sheet.layers, line)), codes="axidraw", split_dots=300)
    assert len(plot.layers) > 3 and plot.layers[-1].name.endswith("red 2 0.5")
    check_read(plot, vpype(formats.to_bytes(plot, "svg")))


def test_the_check_sees_strokes_that_vpype_drops() -> None:
    strokes = Paths.of([[(1, 1), (2, 2)], [(3, 3), (3, 3)]], closed=False)
    told = {"strokes": 2, "pen_down_mm": float(np.sqrt(2))}
    bad = Sheet((9, 9), (Layer(Ink(pen=0.3), strokes, "1 black 0.3"),), report={"plot": {"layers": [told]}})
    with pytest.raises(AssertionError, match="finds 1 strokes"):
        check_read(bad, vpype(formats.to_bytes(bad, "svg")))


def test_a_missing_program_is_said_aloud(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match="NOT RUN: vpype"):
        vpype(b"")
    monkeypatch.setenv("CI", "1")
    with pytest.raises(pytest.fail.Exception, match="NOT RUN: vpype"):
        vpype(b"")
