"""The judge's figure: what was measured of one drawing, or of two side by side, as one page of curves and maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from crowquill.judge import Judged
from crowquill.lettering import text
from crowquill.likeness import ToneError
from crowquill.paths import Array
from crowquill.plots import BLACK, BLUE, GREY, MEDIUM, RED, SMALL, Panel, joined
from crowquill.sheet import Ink, Layer, Sheet

PAGE = (210.0, 297.0)  # mm, A4
LEFT, RIGHT, WIDE, HIGH = 22.0, 118.0, 78.0, 44.0
ROWS = (72.0, 134.0, 196.0)  # tops of the panels
INKS = (BLUE, RED)
LINES = 10  # of words
CELLS = 60  # squares of a heat map's longer side
REACH = 4.0  # spacings of texture


def of(drawings: Sequence[Judged]) -> Sheet:
    """A page of A4: figures in words, spectrum, pair correlation, texture, diameters, tone, and a map of its error each.

    Raises ValueError for more than two drawings, or none.
    """
    if not 1 <= len(drawings) <= 2:
        raise ValueError(f"{len(drawings)} drawings; a figure takes one, or two side by side")
    named = [Path(drawing.seen.name).name for drawing in drawings]
    layers = [Layer(BLACK, text("Measured by crowquill", LEFT - 6, 20, size=6), "title")]
    for k, drawing in enumerate(drawings):
        lines = [line for said in _words(drawing) for line in wrap(said, 62 if len(drawings) > 1 else 120)]
        x = LEFT - 6 if k == 0 else RIGHT - 12
        words = [text(line, x, 31 + 3.6 * row, size=SMALL) for row, line in enumerate(lines[:LINES])]
        layers.append(Layer(INKS[k] if len(drawings) > 1 else BLACK, text(named[k], x, 26.5, size=MEDIUM), "name"))
        layers.append(Layer(BLACK, joined(words), "figures"))
    layers += _spectrum(drawings, named)
    layers += _pairs(drawings)
    layers += _texture(drawings)
    layers += _diameters(drawings)
    layers += _tone(drawings)
    layers += _maps(drawings)
    return Sheet(PAGE, tuple(layer for layer in layers if len(layer.art)))


def _words(drawing: Judged) -> list[str]:
    """The figures that are read first, as sentences."""
    facts = drawing.facts
    ink, near, look = facts["ink"], facts["spacing"], facts["texture"]
    said = [
        f"{facts['dots']} dots of {facts['diameters']['mean_mm']:.3f} mm (spread {facts['diameters']['cv'] or 0:.1%}); "
        f"coverage {ink['coverage']:.3f}" + ("" if ink["overlap"] is None else f", overlap {ink['overlap']:.1%}"),
        f"nearest neighbour {_number(near['nearest'])} mm, least {_number(near['nearest_least'])}; evenness {_number(near['evenness'])}, "
        f"capacity error {_number(near['capacity_cv'])}, hexagons {_number(near['hexagons'])}",
        f"{'texture' if look['verdict'] == 'unread' else 'reads as ' + look['verdict']}: {' '.join(look['reasons'])}",
    ]
    if "tone" in facts:
        tone, first = facts["tone"], facts["tone"]["blurs"][0]
        said.append(
            f"tone after a blur of {first['width_mm']:.2f} mm: bias {first['bias']:+.4f}, rmse {first['rmse']:.4f}; "
            f"ssim {_number(tone['ssim'])}, edges kept {_number(tone['edges_kept'])}, "
            f"shift {tone['shift_mm'][0] * 1000:.0f}, {tone['shift_mm'][1] * 1000:.0f} um"
        )
    return [*said, *(f"Note: {note}" for note in facts["notes"])]


def _number(value: Any) -> str:
    return "-" if value is None else f"{value:.3f}"


def _panel(column: int, row: int, x: tuple[float, float], y: tuple[float, float]) -> Panel:
    return Panel(((LEFT, RIGHT)[column], ROWS[row], WIDE, HIGH), x, y)


def _spectrum(drawings: Sequence[Judged], named: list[str]) -> list[Layer]:
    """Radial power; random dots have 1 everywhere."""
    most = max([2.0, *(float(drawing.radial[1].max()) for drawing in drawings if drawing.radial)])
    panel = _panel(0, 0, (0, 2), (0, 1.05 * most))
    layers = [*panel.axes("Radial power", "cycles a spacing"), panel.level(1)]
    for k, drawing in enumerate(drawings):
        if drawing.radial:
            layers += panel.curve(*drawing.radial, INKS[k], named[k][:40], k)
    return layers


def _pairs(drawings: Sequence[Judged]) -> list[Layer]:
    """Pair correlation; random dots have 1 everywhere."""
    most = max([2.0, *(float(drawing.pairs[1].max()) for drawing in drawings if drawing.pairs)])
    panel = _panel(1, 0, (0, 3), (0, 1.05 * min(most, 6.0)))
    layers = [*panel.axes("Pair correlation", "distance in spacings"), panel.level(1)]
    for k, drawing in enumerate(drawings):
        if drawing.pairs:
            layers += panel.curve(*drawing.pairs, INKS[k])
    return layers


def _texture(drawings: Sequence[Judged]) -> list[Layer]:
    """Correlation of pixels against distance: hands fall to nothing at once, relaxed dots swing on."""
    panel = _panel(0, 1, (0, REACH), (-0.5, 1))
    even = all(drawing.facts["texture"]["patches"] for drawing in drawings)
    title = f"Texture: correlation of pixels{'' if even else ', tones mixed'}"
    layers = [*panel.axes(title, "distance in spacings"), panel.level(0)]
    at = np.linspace(0.05, REACH, 160)
    for k, drawing in enumerate(drawings):
        layers += panel.curve(at, drawing.curves.mean(at), INKS[k])
    return layers


def _diameters(drawings: Sequence[Judged]) -> list[Layer]:
    """How many dots are how wide; of two drawings as lines."""
    parts = [drawing.facts["diameters"] for drawing in drawings]
    low, high = min(part["edges_mm"][0] for part in parts), max(part["edges_mm"][-1] for part in parts)
    most = max(max(part["counts"]) for part in parts)
    panel = _panel(1, 1, (low, high), (0, 1.05 * most))
    layers = panel.axes("Diameters of dots", "mm", "dots")
    for k, part in enumerate(parts):
        if len(parts) == 1:
            layers.append(panel.bars(part["edges_mm"], part["counts"], GREY))
        else:
            layers += panel.curve(np.repeat(part["edges_mm"], 2)[1:-1], np.repeat(part["counts"], 2), INKS[k])
    return layers


def _tone(drawings: Sequence[Judged]) -> list[Layer]:
    """What was drawn against what was asked, band by band."""
    panel = _panel(0, 2, (0, 1), (0, 1))
    layers = [*panel.axes("Tone, after a blur of one spacing", "asked", "drawn"), *panel.curve([0, 1], [0, 1], Ink("grey", GREY.cmyk))]
    for k, drawing in enumerate(drawings):
        if drawing.errors:
            bands = [band for band in drawing.errors[0].bands if band.share > 0]
            middle = np.array([(band.low + band.high) / 2 for band in bands])
            layers += panel.curve(middle, middle + [band.bias for band in bands], INKS[k])
        else:
            layers.append(Layer(GREY, text("no picture to compare with", LEFT + 4, ROWS[2] + 8, size=SMALL)))
    return layers


def _maps(drawings: Sequence[Judged]) -> list[Layer]:
    """Where the drawing is too dark (red) or too light (blue) after a blur of two spacings."""
    shown = [(drawing, drawing.errors[1]) for drawing in drawings if drawing.errors]
    if not shown:
        return []
    most = max(0.02, *(float(np.quantile(np.abs(error.error), 0.995)) for _, error in shown))
    words = f"Too dark (red), too light (blue); full colour at {most:.3f}"
    layers = [Layer(BLACK, text(words, RIGHT, ROWS[2] - 1.6, size=SMALL))]
    room = (WIDE - 4 * (len(shown) - 1)) / len(shown), 70.0
    for k, (drawing, error) in enumerate(shown):
        scale = min(room[0] / drawing.box[2], room[1] / drawing.box[3])
        width, height = drawing.box[2] * scale, drawing.box[3] * scale
        panel = Panel((RIGHT + k * (room[0] + 4), ROWS[2], width, height), (0, 1), (0, 1))
        layers += [*panel.heat(_coarse(error), most), *panel.axes("", numbers=False)[:1]]
    return layers


def _coarse(error: ToneError) -> Array:
    """The map in few squares: means of blocks."""
    k = max(1, -(-max(error.error.shape) // CELLS))
    h, w = (side // k for side in error.error.shape)
    return np.asarray(error.error[: h * k, : w * k].reshape(h, k, w, k).mean(axis=(1, 3)))
