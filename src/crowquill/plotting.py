"""Sheets for pen plotters: strokes only, in an order of little travel, a layer a pen, and how long the machine takes.

Layers are named by number, ink and nib, so that plotting programs take them in their order: "2 red 0.5".
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from crowquill import hatching, knobs, plotforms, route
from crowquill.kernel import compiled
from crowquill.knobs import Choice, Range
from crowquill.marks import Marks
from crowquill.paths import Array, Index, Paths
from crowquill.plotforms import FORMS, Strokes
from crowquill.sheet import Ink, Layer, Sheet, outlined

NIB = 0.3  # mm, the commonest technical pen
STEP = 0.01  # mm: desktop plotters move in steps of 0.006 to 0.025, and finer nibs are not made
FASTEST = 220.9  # mm/s, of which an AxiDraw's speeds are percents: 8.6979 inches
LAYERS = 1000  # AxiDraw's numbers go no further
TOUR = 0.7124 * 1.1  # travel over sqrt(dots x area): the constant of the shortest tour through even chance, and what routes miss it by
NAMED = re.compile(r"(\d*\.?\d+) mm")  # how `stipple` names a layer for a nib; a check bar is named otherwise


@dataclass(frozen=True)
class Machine:
    """How fast a plotter is: mm/s with the pen down and up, seconds for a lift (up and down again) and more for each dot."""

    speed_down: float = 30.0
    speed_up: float = 100.0
    lift: float = 0.25
    dwell: float = 0.0

    def seconds(self, down: float, up: float, lifts: float, dots: float) -> float:
        """The time for so many mm with the pen down and up, lifts and dots."""
        return down / self.speed_down + up / self.speed_up + lifts * self.lift + dots * self.dwell


MIDDLING = Machine()  # a desktop plotter on the short ways of a drawing of dots, which leave no room for its top speed


def plotted(
    sheet: Sheet,
    *,
    nib: Annotated[float | None, Range(STEP, 20, "mm", "pen that draws all (each layer's own, or 0.3mm)")] = None,
    dot: Annotated[str, Choice(FORMS, "how the pen draws a dot")] = "circle",
    codes: Annotated[str, Choice(("plain", "axidraw"), "names of layers; axidraw's pause for pens and set the speed")] = "plain",
    split_distance: Annotated[float | None, Range(1, 1e9, "mm", "another layer, to refill the pen, after so much drawn")] = None,
    split_dots: Annotated[int | None, Range(1, 100_000_000, "", "another layer after so many dots")] = None,
    split_time: Annotated[float | None, Range(1, 1e9, "s", "another layer after so long")] = None,
    speed_down: Annotated[float, Range(0.1, 5000, "mm/s", "speed of the lowered pen")] = MIDDLING.speed_down,
    speed_up: Annotated[float, Range(0.1, 5000, "mm/s", "speed of the raised pen")] = MIDDLING.speed_up,
    lift: Annotated[float, Range(0, 60, "s", "time for the pen to rise and fall")] = MIDDLING.lift,
    dwell: Annotated[float, Range(0, 60, "s", "more time for each dot")] = MIDDLING.dwell,
) -> Sheet:
    """The same drawing for a plotter: each layer is a pen's strokes, open and straight, in the order in which they are drawn.

    marks    dots in their form, see `plotforms.dots`; other fills are hatched, strokes stay
    nib      left out, a layer of strokes keeps its own, one of marks named "0.2 mm" has that, and other fills
             have the finest of their ink, or 0.3 mm
    layers   of one ink and nib become one; those whose name begins with % (not plotted, for AxiDraw) stay apart
    short    strokes under 0.02 mm that meet no other become ticks of it: plotting programs drop them
    splits   fall between strokes; one longer than split_distance is cut
    codes    axidraw: "!2+S14 red 0.5" waits for the pen before the layer, and draws at 14 percent of full speed

    The report's "plot" has strokes, dots, lifts, pen_down_mm, pen_up_mm and seconds, of all and of each of `layers`;
    each layer starts and ends at the top left corner. Recipe and attached files stay. Raises ValueError for knobs out of
    range, a nib wider than the page or finer than 0.01 mm, and more than 1000 layers.
    """
    given = {
        "nib": nib, "dot": dot, "codes": codes, "split_distance": split_distance, "split_dots": split_dots, "split_time": split_time,
        "speed_down": speed_down, "speed_up": speed_up, "lift": lift, "dwell": dwell,
    }  # fmt: skip
    took = knobs.checked(knobs.of(plotted), given, "plotter")
    machine = Machine(took["speed_down"], took["speed_up"], took["lift"], took["dwell"])
    limits = {"mm": took["split_distance"], "dots": took["split_dots"], "seconds": took["split_time"]}
    nibs = _nibs(sheet, took["nib"])
    pens: dict[Ink, list[Strokes]] = {}
    layers: list[Layer] = []
    for layer, width in zip(sheet.layers, nibs, strict=True):
        ink, strokes = replace(layer.ink, pen=width), _strokes(layer, width, took["dot"])
        if layer.name.startswith("%"):
            layers.append(Layer(ink, strokes.paths, layer.name))
        elif len(strokes.paths):
            pens.setdefault(ink, []).append(strokes)
    told: list[dict[str, Any]] = []
    for ink, several in pens.items():
        parts = _parts(_drawn(Strokes.together(several), limits["mm"]), machine, limits)
        for number, part in enumerate(parts, 1):
            name = _name(len(told) + 1, ink, number, took["codes"], machine)
            layers.append(Layer(ink, part.paths, name))
            told.append({"name": name, "nib_mm": ink.pen, **_figures(part, machine)})
    if len(told) > LAYERS:
        raise ValueError(f"the splits make {len(told)} layers, over the limit of {LAYERS}; split less often")
    total = {key: sum(part[key] for part in told) for key in _figures(Strokes.of([]), machine)}
    warnings = [*sheet.report.get("warnings", []), *_warnings(sheet, nibs, took["dot"])]
    warnings += ["areas with colours of their own are drawn in one ink"] if any(layer.fill is not None for layer in sheet.layers) else []
    report = {**sheet.report, "plot": {**total, "layers": told}, "warnings": warnings}
    return replace(sheet, layers=tuple(layers), report=report)


def expected(dots: int, area_mm2: float, *, nib: float = NIB, dot: str = "circle", machine: Machine = MIDDLING) -> float:
    """Seconds to draw so many dots, each a touch of the nib, spread over so many mm^2."""
    each, way = _costs(area_mm2, nib, dot, machine)
    return dots * each + math.sqrt(dots) * way


def dots_for(seconds: float, area_mm2: float, *, nib: float = NIB, dot: str = "circle", machine: Machine = MIDDLING) -> int:
    """The most dots that are expected to be drawn in this time.

    >>> dots_for(expected(5000, 1e4), 1e4)
    5000
    """
    if not 0 <= seconds < math.inf:
        raise ValueError(f"time for plotting is {seconds} s; it takes a time of 0 or more")
    each, way = _costs(area_mm2, nib, dot, machine)
    root = 2 * seconds / (way + math.sqrt(way**2 + 4 * each * seconds)) if seconds else 0.0  # of each r^2 + way r = seconds
    return int(root**2 * (1 + 1e-12))


def _costs(area_mm2: float, nib: float, dot: str, machine: Machine) -> tuple[float, float]:
    """Seconds for each dot, and for each root of their number on the ways between them."""
    if not (0 < area_mm2 < math.inf and 0 < nib < math.inf):
        raise ValueError(f"area {area_mm2} mm^2 for a nib of {nib} mm; both must be over 0")
    down = plotforms.TICK[0] if dot in ("tick", "hatch") else 2 * math.pi * plotforms.TOUCH * nib
    return machine.seconds(down, 0, 1, 1), machine.seconds(0, TOUR * math.sqrt(area_mm2), 0, 0)


def _nibs(sheet: Sheet, nib: float | None) -> list[float]:
    """The nib that draws each layer, in mm."""
    own: list[float | None] = [nib] * len(sheet.layers)
    if nib is None:
        for k, layer in enumerate(sheet.layers):
            named = NAMED.fullmatch(layer.name) if isinstance(layer.art, Marks) else None
            own[k] = layer.ink.pen if layer.ink.pen is not None else float(named[1]) if named else None
    found = []
    for layer, width in zip(sheet.layers, own, strict=True):
        same = [w for other, w in zip(sheet.layers, own, strict=True) if w and replace(other.ink, pen=None) == replace(layer.ink, pen=None)]
        found.append(width or min(same, default=NIB))
        if found[-1] < STEP:
            raise ValueError(
                f"nib {found[-1]:g} mm of layer {layer.label!r} is finer than a plotter's step; give one of {STEP:g} mm or more"
            )
        if found[-1] > min(sheet.size):
            raise ValueError(f"nib {found[-1]:g} mm is wider than the page of {sheet.size[0]:g} x {sheet.size[1]:g} mm; give a finer one")
    return found


def _strokes(layer: Layer, nib: float, dot: str) -> Strokes:
    """All that the pen draws of a layer."""
    art = layer.art
    if layer.ink.pen is not None:
        return plotforms.lines(outlined(art))
    return plotforms.dots(art, nib, dot) if isinstance(art, Marks) else Strokes.of(hatching.areas(outlined(art), nib))


def _drawn(strokes: Strokes, longest: float | None) -> Strokes:
    """The strokes in whole micrometres, joined where they meet, none over the longest, in an order and direction of little travel."""
    strokes = replace(strokes, paths=replace(strokes.paths, xy=np.round(strokes.paths.xy, 3)))
    lines = np.flatnonzero(~strokes.dot)
    chained = [_long_enough(stroke) for stroke in _chained(strokes.paths.take(lines))]
    if longest is not None:
        chained = [piece for stroke in chained for piece in _cut(stroke, longest)]
    dots = np.flatnonzero(strokes.dot)
    every = Strokes.together([Strokes(strokes.paths.take(dots), strokes.dot[dots]), Strokes.of(chained)])
    index, turned = route.order(_ends(every.paths), closed=True)
    return Strokes.of([every.paths[i][::-1] if back else every.paths[i] for i, back in zip(index, turned, strict=True)], every.dot[index])


def _ends(paths: Paths) -> Array:
    """The first and last point of each path, (n, 2, 2) mm."""
    return np.stack([paths.xy[paths.start[:-1]], paths.xy[paths.start[1:] - 1]], axis=1)


def _chained(lines: Paths) -> list[Array]:
    """Lines joined into as few strokes as go from end to end without a lift; the pen goes along each line once."""
    if not len(lines):
        return []
    places = np.round(_ends(lines) * 1000).astype(np.int64).reshape(-1, 2)
    node = np.unique(places, axis=0, return_inverse=True)[1].reshape(-1, 2).astype(np.int64)
    order, back, first = np.empty(len(node), np.int64), np.empty(len(node), np.bool_), np.zeros(len(node), np.bool_)
    half = np.argsort(node.reshape(-1), kind="stable")  # ends by node; an end is twice its line, and one more where it is the last
    _trails(node, half, np.searchsorted(node.reshape(-1)[half], np.arange(node.max() + 2)), order, back, first)
    found: list[list[Array]] = []
    for i, turned, begins in zip(order.tolist(), back.tolist(), first.tolist(), strict=True):
        points = lines[i][::-1] if turned else lines[i]
        if begins:
            found.append([points])
        else:
            found[-1].append(points[1:])
    return [np.concatenate(parts) for parts in found]


@compiled
def _trails(node: Index, half: Index, start: Index, order: Index, back: Any, first: Any) -> None:
    """Fills lines in the order of trails, whether each is gone along backwards, and where trails begin: at odd nodes first."""
    used = np.zeros(len(node), np.bool_)
    at = start[:-1].copy()
    done = 0
    for round_ in range(2):
        for begin in range(len(at)):
            if round_ == 0 and (start[begin + 1] - start[begin]) % 2 == 0:
                continue
            here, begins = begin, True
            while at[here] < start[here + 1]:
                end = half[at[here]]
                at[here] += 1
                line, turned = end // 2, end % 2 == 1
                if used[line]:
                    continue
                used[line] = True
                order[done], back[done], first[done] = line, turned, begins
                done, begins = done + 1, False
                here = node[line, 0] if turned else node[line, 1]


def _long_enough(stroke: Array) -> Array:
    """The stroke without points that repeat; a tick in its place where it is so short that plotting programs may drop it."""
    steps = np.diff(stroke, axis=0)
    if np.hypot(*steps.T).sum() < hatching.SHORTEST:
        x, y = stroke[-1] - stroke[0]
        return np.round(hatching.tick((stroke[0] + stroke[-1]) / 2, float(np.arctan2(y, x)), hatching.SHORTEST), 3)
    return np.asarray(stroke[np.append(True, (steps != 0).any(axis=1))])


def _cut(stroke: Array, longest: float) -> list[Array]:
    """A stroke in equal pieces, none over the longest."""
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(stroke, axis=0).T))])
    pieces = int(np.ceil(along[-1] / longest * (1 - 1e-9)))
    if pieces < 2:
        return [stroke]
    found = []
    for k in range(pieces):
        low, high = along[-1] * k / pieces, along[-1] * (k + 1) / pieces
        ends = [[np.interp(at, along, side) for side in stroke.T] for at in (low, high)]
        found.append(np.round(np.concatenate([ends[:1], stroke[(along > low) & (along < high)], ends[1:]]), 3))
    return found


def _lengths(paths: Paths) -> Array:
    """The length of each open path, (n,) mm."""
    step = np.hypot(*np.diff(paths.xy, axis=0).T) * (paths.path[1:] == paths.path[:-1])
    return np.bincount(paths.path[1:], step, len(paths)).astype(np.float64)


def _ways(paths: Paths) -> Array:
    """The way of the raised pen to each stroke, the first from the corner, and at last back there, (n + 1,) mm."""
    ends = _ends(paths)
    return np.asarray(np.hypot(*(np.concatenate([ends[:, 0], [(0, 0)]]) - np.concatenate([[(0, 0)], ends[:, 1]])).T))


def _parts(strokes: Strokes, machine: Machine, limits: Mapping[str, float | None]) -> list[Strokes]:
    """The strokes in runs that keep to the limits of mm drawn, dots and seconds, where one stroke alone does."""
    down, up = _lengths(strokes.paths), _ways(strokes.paths)[:-1]
    seconds = down / machine.speed_down + up / machine.speed_up + machine.lift + strokes.dot * machine.dwell
    kept = [(cost.tolist(), limit) for cost, limit in zip((down, strokes.dot * 1.0, seconds), limits.values(), strict=True) if limit]
    cuts, sums = [0], [0.0] * len(kept)
    for i in range(len(down)):
        sums = [total + cost[i] for total, (cost, _) in zip(sums, kept, strict=True)]
        if i > cuts[-1] and any(total > limit * (1 + 1e-6) for total, (_, limit) in zip(sums, kept, strict=True)):
            cuts.append(i)
            sums = [cost[i] for cost, _ in kept]
    runs = np.split(np.arange(len(down)), cuts[1:])
    return [Strokes(strokes.paths.take(run), strokes.dot[run]) for run in runs]


def _name(number: int, ink: Ink, part: int, codes: str, machine: Machine) -> str:
    """A layer's name. AxiDraw's codes come right behind the number, or are not seen."""
    name = f"{ink.name} {ink.pen:.4g}{f' part {part}' if part > 1 else ''}"
    if codes == "plain":
        return f"{number} {name}"
    percent = min(100, max(1, round(100 * machine.speed_down / FASTEST)))
    return f"{'!' if number > 1 else ''}{number}+S{percent} {name}"


def _figures(strokes: Strokes, machine: Machine) -> dict[str, float]:
    """What a layer takes; the pen goes up and down once a stroke."""
    lifts, dots = len(strokes.paths), int(strokes.dot.sum())
    down, up = float(_lengths(strokes.paths).sum()), float(_ways(strokes.paths).sum())
    seconds = machine.seconds(down, up, lifts, dots)
    return {"strokes": lifts, "dots": dots, "lifts": lifts, "pen_down_mm": down, "pen_up_mm": up, "seconds": seconds}


def _warnings(sheet: Sheet, nibs: list[float], dot: str) -> list[str]:
    """What is to be said of dots that the pen cannot draw as wide as they are."""
    said = []
    for layer, nib in zip(sheet.layers, nibs, strict=True):
        if not isinstance(layer.art, Marks) or layer.ink.pen is not None:
            continue
        wide = plotforms.widths(layer.art)
        fine, broad = int(((wide > 0) & (wide < 0.8 * nib)).sum()), int((wide > 1.05 * plotforms.CLOSED * nib).sum())
        if fine:
            said.append(
                f"{fine} dots of {layer.label!r} are finer than the nib of {nib:g} mm and come out wider; plot them with a finer one"
            )
        if broad and dot in ("circle", "tick"):
            said.append(
                f"{broad} dots of {layer.label!r} are more than twice as wide as the nib of {nib:g} mm and come out as one touch of it; "
                "dot spiral or hatch fills them"
            )
    return said
