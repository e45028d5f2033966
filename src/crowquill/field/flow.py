"""The flow of a picture along its edges, and the lines that a draughtsman would draw along it.

Source: H. Kang, S. Lee, C. K. Chui, Coherent Line Drawing, NPAR 2007, for the flow and the difference of Gaussians across it, and
Flow-Based Image Abstraction, IEEE TVCG 15(1), 2009, for passes along rows and columns; C. Steger, An Unbiased Detector of
Curvilinear Structures, IEEE PAMI 20(2), 1998, for centre lines between pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from crowquill.field.directions import Field
from crowquill.field.finding import contrast
from crowquill.field.grids import between
from crowquill.halftone.averages import averaged
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index, Paths
from crowquill.tone import Tone

KERNEL = 5  # of the flow's passes, in sigmas of the picture's blur
ROUNDS = 3
WIDER = 1.6  # the outer Gaussian across the flow over the inner one
ALONG = 3  # the Gaussian along the flow, in sigmas
STEP = 0.1114  # the greatest response to a step of 1, which lies 1.24 sigmas off it
MOST = 4_000_000  # pixels that are looked at
PIXEL = 1.5  # pixels to a sigma are enough, and no more are looked at
FLAT = 1e-6  # of the greatest slope; less is rounding
FINE = 5e-3  # mm that a stroke may stray from its smoothed curve
BLUR = 0.5  # of a stroke's width: the sigma through which lines are found
SHORT = 6.0  # widths; shorter lines are specks
COARSE = 0.8  # pixels that a sigma has at least
ROWS = 16  # to a thread


def tangents(tone: Tone, sigma: float, rounds: int = ROUNDS) -> Field:
    """The directions in which edges run, on the tone's pixels: each leant on by those around that run alike on steeper ground.

    sigma   mm of the blur through which gradients are seen; the kernel reaches five of them along rows, then columns
    rounds  of smoothing

    Strength is how much those around run alike. Where nothing changes within reach there is no direction, and no strength.
    """
    from scipy.ndimage import gaussian_filter

    dx, dy = tone.pixel
    blur = (sigma / dy, sigma / dx)
    x, y = (gaussian_filter(tone.coverage, blur, order=order, mode="nearest") / side for order, side in (((0, 1), dx), ((1, 0), dy)))
    slope = np.hypot(x, y)
    top = float(slope.max()) if np.ptp(tone.coverage) > 0 else 0.0
    over = np.where(slope > FLAT * top, slope, np.inf)
    t, sure = np.stack([-y / over, x / over], axis=-1), np.zeros(slope.shape)
    weight = np.exp(2 * slope / (top or 1.0))  # a / (a + b) of these is (1 + tanh(difference)) / 2
    for _ in range(rounds if top else 0):
        for axis, wide in ((1, blur[1]), (0, blur[0])):
            t, sure = _passed(t, weight, max(1, round(KERNEL * wide)), axis)
    return Field(np.arctan2(t[..., 1], t[..., 0]), np.minimum(sure, 1), tone.size)


def _passed(t: Array, weight: Array, radius: int, axis: int) -> tuple[Array, Array]:
    """One pass of smoothing along an axis, and how much alike those around ran."""
    t, weight = (np.ascontiguousarray(part.swapaxes(0, 1)) if axis == 0 else part for part in (t, weight))
    out, sure = np.empty_like(t), np.empty_like(weight)
    shared_out(lambda lo, hi: _pass(t, weight, radius, out, sure, lo, hi), len(t), ROWS)
    return (out.swapaxes(0, 1), sure.T) if axis == 0 else (out, sure)


@compiled
def _pass(t: Array, weight: Array, radius: int, out: Array, sure: Array, low: int, high: int) -> None:
    """Fills rows low to high with unit sums of the directions around, turned alike; those in a line count, and those on steeper ground."""
    for r in range(low, high):
        for c in range(t.shape[1]):
            x, y = t[r, c, 0], t[r, c, 1]
            none = x == 0 and y == 0
            p, q, total = 0.0, 0.0, 0.0
            for k in range(max(0, c - radius), min(t.shape[1], c + radius + 1)):
                u, v = t[r, k, 0], t[r, k, 1]
                alike = x * u + y * v
                if none:  # what has no direction takes that of those around
                    alike = -1.0 if p * u + q * v < 0 else 1.0
                alike *= weight[r, k] / (weight[r, k] + weight[r, c])
                p += alike * u
                q += alike * v
                total += abs(alike)
            length = np.hypot(p, q)
            some = length > 1e-12
            out[r, c, 0], out[r, c, 1] = (p / length, q / length) if some else (x, y)
            sure[r, c] = length / total if some else 0.0


@dataclass(frozen=True, eq=False)
class Sight:
    """A picture as a pen of a width in mm can draw it, on pixels no finer than that needs; its flow; the sigma in mm it is seen through."""

    tone: Tone
    flow: Field
    sigma: float
    width: float

    @classmethod
    def of(cls, tone: Tone, width: float) -> Sight:
        """The sight of a tone, whatever the fineness of its pixels; the canvas and importance stay behind."""
        sigma = max(BLUR * width, COARSE * max(tone.pixel), PIXEL * float(np.sqrt(tone.size[0] * tone.size[1] / MOST)))
        h, w = tone.coverage.shape
        m, n = (min(count, int(np.ceil(PIXEL * side / sigma))) for count, side in ((h, tone.size[1]), (w, tone.size[0])))
        means = averaged(tone.coverage, np.linspace(0, w, n + 1), np.linspace(0, h, m + 1)) if (m, n) != (h, w) else tone.coverage
        coarser = Tone(np.clip(means, 0, 1), tone.size)
        return cls(coarser, tangents(coarser, sigma), sigma, width)

    def smoothed(self) -> Tone:
        """The picture evened out along its flow, which keeps its edges."""
        return self.tone.holding(np.clip(smoothed(self.tone.coverage, self.flow, ALONG * self.sigma), 0, 1))

    def lines(self, detail: float = 0.5, least: float | None = None) -> Paths:
        """The lines of `lines`."""
        low, high = contrast(detail)
        response = smoothed(across(self.tone.coverage, self.flow, self.sigma), self.flow, ALONG * self.sigma)
        kept = []
        for line in _ridges(response, self.flow, low):
            if between(response, self.tone.size, line).max() >= high:
                curve = _eased(line, self.sigma)
                if np.hypot(*np.diff(curve, axis=0).T).sum() >= (SHORT * self.width if least is None else least):
                    kept.append(shapely.get_coordinates(shapely.simplify(shapely.LineString(curve), FINE)))
        return Paths.of(kept, closed=False)


def lines(tone: Tone, width: float, *, detail: float = 0.5, least: float | None = None) -> Paths:
    """The dark lines of a picture and the dark sides of its edges, as smooth open lines to be drawn with a pen of this width in mm.

    detail  0 for the strongest lines alone, 1 for faint ones too. At one half ink must stand out from either side as it does
            at a step of 0.085 in the darks somewhere on a line, and of a third of that all along; in white it takes twice as much
    least   mm; shorter lines are left out, or those of less than six widths

    The pen's middle runs some 0.62 of its width inside a dark area, so that the stroke ends where the area does. Rings end where they
    begin. Pictures of one tone, and those of one row or column, have none.
    """
    return Sight.of(tone, width).lines(detail, least)


def _ridges(values: Array, flow: Field, low: float) -> list[Array]:
    """Where values (h, w) of `low` and more are greatest across a flow, as lines (k, 2) mm between the pixels' centres.

    The slope across the flow changes its sign there. Each side of a square between four centres is looked at by itself, its
    two directions turned alike, so that neighbours meet in the same point; lines go through squares that they cross twice.
    """
    h, w = values.shape
    if min(h, w) < 2:
        return []
    t, _ = _way(flow)
    n = np.stack([-t[..., 1], t[..., 0]], axis=-1)
    slope = n[..., 0] * np.gradient(values, axis=1) + n[..., 1] * np.gradient(values, axis=0)
    bend = np.empty((h, w))
    shared_out(lambda lo, hi: _bent(values, n, bend, lo, hi), h, ROWS)
    found: list[Array] = []
    number: list[Index] = []
    for axis in (1, 0):  # sides along rows, then columns
        a, b = (tuple(part if k == axis else slice(None) for k in (0, 1)) for part in (slice(None, -1), slice(1, None)))
        alike = np.where((n[a] * n[b]).sum(axis=-1) < 0, -1.0, 1.0)
        f, g = slope[a], alike * slope[b]
        part = f / np.where(f == g, 1.0, f - g)
        good = (f < 0) != (g < 0)
        for field, least in ((values, low), (-bend, 1e-12)):
            good &= field[a] + part * (field[b] - field[a]) >= least
        row, column = np.nonzero(good)
        place = np.stack([column, row], axis=1) + 0.5
        place[:, 1 - axis] += part[good]
        of = np.full((h, w), -1)
        of[row, column] = np.arange(len(row)) + sum(len(xy) for xy in found)
        found.append(place * (flow.size[0] / w, flow.size[1] / h))
        number.append(of)
    xy, (along, down) = np.concatenate(found), number
    corners = np.stack([along[:-1, :-1], along[1:, :-1], down[:-1, :-1], down[:-1, 1:]], axis=-1).reshape(-1, 4)
    twice = np.sort(corners[(corners >= 0).sum(axis=1) == 2], axis=1)[:, 2:]
    if not len(twice):
        return []
    joined = shapely.line_merge(shapely.multilinestrings(shapely.linestrings(xy[twice])))
    return [shapely.get_coordinates(line) for line in shapely.get_parts(joined)]


@compiled
def _bent(values: Array, n: Array, bend: Array, low: int, high: int) -> None:
    """Fills rows low to high with the second difference of values along n."""
    for r in range(low, high):
        for c in range(values.shape[1]):
            x, y = n[r, c, 0], n[r, c, 1]
            bend[r, c] = _at(values, c + x, r + y) + _at(values, c - x, r - y) - 2 * values[r, c]


def _eased(line: Array, sigma: float) -> Array:
    """A line (k, 2) mm smoothed along its length by a Gaussian of sigma mm: its ends stay, or, of a ring, go round."""
    from scipy.ndimage import gaussian_filter1d

    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    count = max(4, int(np.ceil(way[-1] / (sigma / 4))))
    even = np.stack([np.interp(np.linspace(0, way[-1], count + 1), way, axis) for axis in line.T], axis=1)
    wide = sigma / (way[-1] / count)
    if (line[0] == line[-1]).all():
        curve = gaussian_filter1d(even[:-1], wide, axis=0, mode="wrap")
        return np.concatenate([curve, curve[:1]])
    pad = min(count, int(4 * wide) + 1)
    whole = np.pad(even, ((pad, pad), (0, 0)), mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(whole, wide, axis=0, mode="nearest")[pad:-pad])


def smoothed(values: Array, flow: Field, sigma: float) -> Array:
    """Values (h, w) on the pixels of a flow, each the mean along it by a Gaussian of sigma mm: what lies along edges evens out."""
    t, scale = _way(flow)
    out = np.empty(values.shape)
    shared_out(lambda lo, hi: _along(values, t, sigma / scale, out, lo, hi), len(values), ROWS)
    return out


def across(values: Array, flow: Field, sigma: float) -> Array:
    """How much more values (h, w) are than those to either side across the flow, as the step that would bring that about.

    The difference of two Gaussians, of sigma mm and 1.6 times that; where all around is 0 a step counts for half, so that lines in
    the lights must be stronger: the authors take a little less than the outer Gaussian away, which asks for as much more of all lines.
    """
    t, scale = _way(flow)
    reach = np.arange(-int(3 * WIDER * sigma / scale + 1), int(3 * WIDER * sigma / scale + 1) + 1)
    inner, outer = (np.exp(-0.5 * (reach * scale / wide) ** 2) for wide in (sigma, WIDER * sigma))
    out = np.empty(values.shape)
    shared_out(lambda lo, hi: _across(values, t, inner / inner.sum(), outer / outer.sum(), out, lo, hi), len(values), ROWS)
    return out / STEP


def _way(flow: Field) -> tuple[Array, float]:
    """Steps (h, w, 2) of a flow in pixels, rows after columns, each of the length given in mm: the shorter side of a pixel."""
    h, w = flow.angle.shape
    dx, dy = flow.size[0] / w, flow.size[1] / h
    step = min(dx, dy)
    some = flow.strength > 0
    return np.stack([some * np.cos(flow.angle) * step / dx, some * np.sin(flow.angle) * step / dy], axis=-1), step


@compiled
def _at(values: Array, x: float, y: float) -> float:
    """The value between pixels' centres, of the nearest beyond the border."""
    h, w = values.shape
    x, y = min(max(x, 0.0), w - 1.0), min(max(y, 0.0), h - 1.0)
    c, r = min(int(x), max(w - 2, 0)), min(int(y), max(h - 2, 0))
    s, t = x - c, y - r
    right, below = min(c + 1, w - 1), min(r + 1, h - 1)
    upper = values[r, c] * (1 - s) + values[r, right] * s
    lower = values[below, c] * (1 - s) + values[below, right] * s
    return float(upper * (1 - t) + lower * t)


@compiled
def _across(values: Array, t: Array, inner: Array, outer: Array, out: Array, low: int, high: int) -> None:
    """Fills rows low to high with the difference of two weighed sums of values on a line across the flow, over 2 less the second."""
    half = len(inner) // 2
    for r in range(low, high):
        for c in range(values.shape[1]):
            near, wide = 0.0, 0.0
            for k in range(len(inner)):
                value = _at(values, c - (k - half) * t[r, c, 1], r + (k - half) * t[r, c, 0])
                near += inner[k] * value
                wide += outer[k] * value
            out[r, c] = (near - wide) / (2 - wide)


@compiled
def _along(values: Array, t: Array, sigma: float, out: Array, low: int, high: int) -> None:
    """Fills rows low to high with means along the flow, stepped through both ways, a pixel at a time; sigma in steps."""
    h, w = values.shape
    for r in range(low, high):
        for c in range(w):
            total, weight = values[r, c], 1.0
            for side in (-1.0, 1.0):
                x, y, u, v = float(c), float(r), side * t[r, c, 0], side * t[r, c, 1]
                for k in range(1, int(3 * sigma) + 1):
                    x, y = x + u, y + v
                    if (u == 0 and v == 0) or not (0 <= x <= w - 1 and 0 <= y <= h - 1):
                        break
                    part = np.exp(-0.5 * (k / sigma) ** 2)
                    total += part * _at(values, x, y)
                    weight += part
                    p, q = t[int(y + 0.5), int(x + 0.5), 0], t[int(y + 0.5), int(x + 0.5), 1]
                    sign = -1.0 if u * p + v * q < 0 else 1.0
                    u, v = sign * p, sign * q
            out[r, c] = total / weight
