"""Small plots as SVG inside a page: lines over decades, stacked bars, ratios. Places and round numbers are crowquill.plots' own.

Colours are Okabe's and Ito's, told apart by all eyes; lines differ in dash and marker too, so that they keep apart in grey.
Source: M. Okabe, K. Ito, Color Universal Design, 2002.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from crowquill.plots import Panel, rounds

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9", "#999999")
MARKERS = ("M -4 0 a 4 4 0 1 0 8 0 a 4 4 0 1 0 -8 0", "M -4 -4 h 8 v 8 h -8 z", "M 0 -5 L 5 4 H -5 z", "M 0 -5 L 5 0 L 0 5 L -5 0 z")
DASHES = ("", "7 3", "2 3", "9 3 2 3", "4 2", "", "7 3", "2 3")
WIDE, HIGH, LINE = 540, 300, 17  # pixels: a plot, and a line of its legend
LEFT, RIGHT, BELOW = 62, 14, 44


@dataclass(frozen=True)
class Series:
    """A named curve; x rises or not, as it was measured."""

    name: str
    x: Sequence[float]
    y: Sequence[float]


def lines(title: str, across: str, up: str, series: Sequence[Series], *, log: tuple[bool, bool] = (True, True)) -> str:
    """Curves with a marker at each point, the legend above; on logarithmic axes only what is over 0 is shown."""
    shown = []
    for each in series:
        pairs = [(x, y) for x, y in zip(each.x, each.y, strict=True) if (x > 0 or not log[0]) and (y > 0 or not log[1])]
        shown.append(Series(each.name, [x for x, _ in pairs], [y for _, y in pairs]))
    top = 30 + LINE * len(shown) + 20
    xs, ys = [x for each in shown for x in each.x], [y for each in shown for y in each.y]
    if not xs:
        return nothing(title)
    panel = Panel((LEFT, top, WIDE - LEFT - RIGHT, HIGH), reach(xs, log[0]), reach(ys, log[1]))
    parts = [*axis(panel, log, across, up)]
    for k, each in enumerate(shown):
        colour, dash = COLOURS[k % len(COLOURS)], DASHES[k % len(DASHES)]
        at = panel.place(scaled(each.x, log[0]), scaled(each.y, log[1]))
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
        parts.append(f'<polyline points="{way}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>')
        parts += [marker(k, x, y) for x, y in at]
        y = 34 + LINE * k
        stroke = f'stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"'
        parts += [f'<path d="M {LEFT} {y} h 34" {stroke}/>', marker(k, LEFT + 17, y), text(each.name, LEFT + 42, y + 4)]
    return svg(title, parts, top + HIGH + BELOW)


def stacked(title: str, across: str, bars: Sequence[tuple[str, Mapping[str, float]]], order: Sequence[str]) -> str:
    """A bar a row, its parts in order from the left, and the sum at its end."""
    if not bars:
        return nothing(title)
    head, row = 30 + LINE * (-(-len(order) // 4)) + 16, 30
    left = 112
    panel = Panel((left, head, WIDE - left - 70, row * len(bars)), (0, max(sum(parts.values()) for _, parts in bars)), (0, 1))
    out = []
    for k, name in enumerate(order):
        x, y = 8 + (k % 4) * 132, 26 + LINE * (k // 4)
        out += [box(x, y, 11, 11, k), text(name, x + 17, y + 10)]
    for r, (label, parts) in enumerate(bars):
        y, done = head + row * r + 5, 0.0
        out.append(text(label, left - 8, y + 15, anchor="end"))
        for k, name in enumerate(order):
            a, b = panel.place([done, done + parts.get(name, 0.0)], 0)[:, 0]
            done += parts.get(name, 0.0)
            out.append(box(a, y, b - a, 20, k))
        out.append(text(f"{done:.3g}", float(panel.place(done, 0)[0]) + 6, y + 15))
    bottom = head + row * len(bars) + 6
    for value in rounds(*panel.x):
        x = float(panel.place(value, 0)[0])
        out += [f'<path d="M {x:.1f} {bottom} v 4" stroke="#444"/>', text(f"{value:g}", x, bottom + 17, anchor="middle")]
    out += [f'<path d="M {left} {bottom} H {WIDE - 70}" stroke="#444"/>', text(across, WIDE - 70, bottom + 34, anchor="end")]
    return svg(title, out, bottom + 40)


def ratios(title: str, across: str, rows: Sequence[tuple[str, float]]) -> str:
    """A bar a row from 1, over decades: to the right what is ahead, to the left in another colour what is behind; with the ratio."""
    if not rows:
        return nothing(title)
    head, row, left = 30, 24, 300
    low, high = min(1.0, *(ratio for _, ratio in rows)), max(1.0, *(ratio for _, ratio in rows))
    panel = Panel((left, head, WIDE + 200 - left - 60, row * len(rows)), (np.log10(low) - 0.3, np.log10(high) + 0.1), (0, 1))
    one, out = float(panel.place(0, 0)[0]), []
    for r, (label, ratio) in enumerate(rows):
        y, x = head + row * r + 4, float(panel.place(np.log10(ratio), 0)[0])
        ahead = ratio >= 1
        words, end, anchor = (f"{ratio:.3g}", x + 6, "start") if ahead else (f"{ratio:.3g} behind", one + 6, "start")
        out += [box(min(one, x), y, abs(x - one), 16, 0 if ahead else 1), text(label, left - 8, y + 13, anchor="end")]
        out.append(text(words, end, y + 13, anchor=anchor, bold=True))
    bottom = head + row * len(rows) + 4
    out.append(f'<path d="M {one:.1f} {head} V {bottom}" stroke="#000" stroke-width="1.2"/>')
    for value in decades(panel.x):
        x = float(panel.place(np.log10(value), 0)[0])
        out += [f'<path d="M {x:.1f} {bottom} v 4" stroke="#444"/>', text(number(value), x, bottom + 17, anchor="middle")]
    out.append(text(across, WIDE + 140, bottom + 34, anchor="end"))
    return svg(title, out, bottom + 40, WIDE + 200)


def axis(panel: Panel, log: tuple[bool, bool], across: str, up: str) -> list[str]:
    """Frame, grid, numbers and what they are of."""
    left, top, width, height = panel.box
    parts = [f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#444"/>']
    for value in decades(panel.x) if log[0] else rounds(*panel.x):
        x = float(panel.place(np.log10(value) if log[0] else value, panel.y[0])[0])
        parts += [f'<path d="M {x:.1f} {top} v {height}" stroke="#ddd"/>', text(number(value), x, top + height + 16, anchor="middle")]
    for value in decades(panel.y) if log[1] else rounds(*panel.y):
        y = float(panel.place(panel.x[0], np.log10(value) if log[1] else value)[1])
        parts += [f'<path d="M {left} {y:.1f} h {width}" stroke="#ddd"/>', text(number(value), left - 6, y + 4, anchor="end")]
    return [*parts, text(across, left + width, top + height + 34, anchor="end"), text(up, left - 50, top - 7)]


def reach(values: Sequence[float], log: bool) -> tuple[float, float]:
    """A range a little wider than the values, of their logarithms where it is logarithmic; else from 0."""
    if not log:
        return 0.0, 1.05 * max(values) or 1.0
    low, high = float(np.log10(min(values))), float(np.log10(max(values)))
    room = 0.05 * (high - low) or 0.2
    return low - room, high + room


def decades(ends: tuple[float, float]) -> list[float]:
    """Round numbers between two logarithms: powers of ten, with 2 and 5 times them where these are few, or all alike apart."""
    first, last = int(np.floor(ends[0])), int(np.ceil(ends[1]))
    steps = (1, 2, 5) if ends[1] - ends[0] < 2.2 else (1,)
    every = [k * 10.0**e for e in range(first, last + 1) for k in steps]
    found = [value for value in every if ends[0] <= np.log10(value) <= ends[1]]
    return found if len(found) > 2 else rounds(10 ** ends[0], 10 ** ends[1])


def number(value: float) -> str:
    """As short as it can be read: powers of ten from ten thousand on, and below a thousandth."""
    e = int(np.floor(np.log10(value) + 1e-9)) if value > 0 else 0
    if not -4 < e < 4:
        first = round(value / 10.0**e)
        return ("" if first == 1 else f"{first}·") + "10" + str(e).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{value:.4g}"


def scaled(values: Sequence[float], log: bool) -> np.ndarray:
    return np.log10(values) if log else np.asarray(values, float)


def marker(k: int, x: float, y: float) -> str:
    """One of four shapes in a series' colour."""
    where, colour = f"translate({x:.1f} {y:.1f})", COLOURS[k % len(COLOURS)]
    return f'<path transform="{where}" d="{MARKERS[k % len(MARKERS)]}" fill="{colour}" stroke="#fff" stroke-width=".8"/>'


def box(x: float, y: float, width: float, height: float, k: int) -> str:
    """A filled rectangle, parted from its neighbours by white."""
    size = f'width="{max(0.0, width):.1f}" height="{height}"'
    return f'<rect x="{x:.1f}" y="{y:.1f}" {size} fill="{COLOURS[k % len(COLOURS)]}" stroke="#fff" stroke-width=".7"/>'


def text(words: str, x: float, y: float, *, anchor: str = "start", bold: bool = False) -> str:
    weight = ' font-weight="600"' if bold else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{weight}>{escape(words)}</text>'


def nothing(title: str) -> str:
    return svg(title, [text("not run", LEFT, 40)], 60)


def svg(title: str, parts: Sequence[str], height: float, width: float = WIDE) -> str:
    """The plot as an element of a page, its title being its name."""
    head = f'<svg role="img" aria-label="{escape(title)}" viewBox="0 0 {width} {height}" width="{width}" font-size="12.5">'
    return head + text(title, 8, 15, bold=True) + "".join(parts) + "</svg>"
