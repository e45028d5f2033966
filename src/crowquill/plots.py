"""Small plots in millimetres as layers of a sheet: axes with round numbers, curves, bars, heat maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill.lettering import text
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer

BLACK, GREY = Ink("black"), Ink("grey", (0.0, 0.0, 0.0, 0.5))
BLUE, RED = Ink("blue", (0.9, 0.5, 0.0, 0.1)), Ink("red", (0.0, 0.85, 0.9, 0.05))
THIN, THICK = 0.1, 0.3  # mm
SMALL, MEDIUM = 2.2, 2.8  # mm, of lettering
TICK = 0.8  # mm
STEPS = 12  # of colour each way in a heat map


@dataclass(frozen=True)
class Panel:
    """A rectangle of paper, left, top, width and height in mm, with a range of x to the right and of y upwards."""

    box: tuple[float, float, float, float]
    x: tuple[float, float]
    y: tuple[float, float]

    def place(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """Where on the paper values lie, (n, 2) mm; what is outside the ranges is put on the border."""
        left, top, width, height = self.box
        across = (np.clip(np.asarray(x, np.float64), *self.x) - self.x[0]) / (self.x[1] - self.x[0])
        up = (np.clip(np.asarray(y, np.float64), *self.y) - self.y[0]) / (self.y[1] - self.y[0])
        return np.stack(np.broadcast_arrays(left + width * across, top + height * (1 - up)), axis=-1)

    def axes(self, title: str, across: str = "", up: str = "", *, numbers: bool = True) -> list[Layer]:
        """Frame, ticks at round numbers, and words: a title above, what x is below, what y is at the top left."""
        left, top, width, height = self.box
        frame = [[(left, top), (left + width, top), (left + width, top + height), (left, top + height)]]
        words = [text(title, left, top - 1.6, size=MEDIUM), text(across, left + width, top + height + 6.4, size=SMALL, anchor="end")]
        words.append(text(up, left + width, top - 1.6, size=SMALL, anchor="end"))
        ticks = []
        for value in rounds(*self.x) if numbers else []:
            x = float(self.place(value, self.y[0])[0])
            ticks.append([(x, top + height), (x, top + height + TICK)])
            words.append(text(f"{value:g}", x, top + height + TICK + 2.4, size=SMALL, anchor="middle"))
        for value in rounds(*self.y) if numbers else []:
            y = float(self.place(self.x[0], value)[1])
            ticks.append([(left - TICK, y), (left, y)])
            words.append(text(f"{value:g}", left - TICK - 0.6, y + 0.8, size=SMALL, anchor="end"))
        lines = Ink("black", pen=THIN)
        return [Layer(lines, Paths.of(frame)), Layer(lines, Paths.of(ticks, closed=False)), Layer(BLACK, joined(words))]

    def curve(self, x: npt.ArrayLike, y: npt.ArrayLike, ink: Ink = BLUE, name: str = "", row: int = 0) -> list[Layer]:
        """A line through points in their order, those not finite left out; its name stands in the panel's top right, in rows."""
        xs, ys = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        good = np.isfinite(xs) & np.isfinite(ys)
        line = Paths.of([self.place(xs[good], ys[good])] if good.sum() > 1 else [], closed=False)
        layers = [Layer(Ink(ink.name, ink.cmyk, THICK), line)]
        if name:
            left, top, width, _ = self.box
            layers.append(Layer(ink, text(name, left + width - 1, top + 3 * (row + 1), size=SMALL, anchor="end")))
        return layers

    def level(self, y: float) -> Layer:
        """A thin grey line across at a value."""
        return Layer(Ink(GREY.name, GREY.cmyk, THIN), Paths.of([self.place(self.x, [y, y])], closed=False))

    def bars(self, edges: npt.ArrayLike, heights: npt.ArrayLike, ink: Ink = BLUE) -> Layer:
        """A bar between each two edges, from the bottom up."""
        at, tall = np.asarray(edges, np.float64), np.asarray(heights, np.float64)
        low = np.full(len(tall), self.y[0])
        corners = [self.place(at[:-1], tall), self.place(at[1:], tall), self.place(at[1:], low), self.place(at[:-1], low)]
        return Layer(ink, Paths.of(np.stack(corners, axis=1)))

    def heat(self, values: Array, most: float) -> list[Layer]:
        """Values (h, w) as squares, blue below 0 and red above, full at `most` either way; nearly none stay white."""
        left, top, width, height = self.box
        h, w = values.shape
        dx, dy = width / w, height / h
        shade = np.clip(np.round(values / most * STEPS), -STEPS, STEPS).astype(np.int64)
        layers = []
        for level in np.unique(shade[shade != 0]).tolist():
            row, column = np.nonzero(shade == level)
            x, y = left + column * dx, top + row * dy
            squares = np.stack([np.stack([x + a * dx, y + b * dy], axis=1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)
            hue = RED if level > 0 else BLUE
            share = abs(level) / STEPS
            cyan, magenta, yellow, black = (round(part * share, 4) for part in hue.cmyk)
            layers.append(Layer(Ink(hue.name, (cyan, magenta, yellow, black)), Paths.of(squares)))
        return layers


def rounds(low: float, high: float) -> list[float]:
    """Four to nine round numbers from low to high: multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / 5
    size = 10 ** np.floor(np.log10(rough))
    step = float(size * min((1, 2, 5, 10), key=lambda k: abs(np.log(k * size / rough))))
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return [round(k * step, 12) + 0.0 for k in np.arange(first, last + 1).tolist()]


def joined(parts: list[Paths]) -> Paths:
    """Several closed cubic paths as one."""
    return Paths.of([ring for part in parts for ring in part], cubic=True)
