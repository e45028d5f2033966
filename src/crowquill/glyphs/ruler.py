"""A ruler lying on a page: its millimetre ticks found at any angle, and how many pixels a millimetre is.

Ticks are thin parallel dark marks in a row, longer each 5 and each 10 of them; one side of them ends on a line, which may
join them. Rows without that rhythm (inches, half millimetres, hatching, bar codes) are no ruler.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crowquill.glyphs.marks import Marks, Mask
from crowquill.glyphs.marks import found as candidates
from crowquill.glyphs.page import Grey, flattened
from crowquill.paths import Array, Index

WORKED = 5000  # pixels of the longer side at which a ruler is looked for: A4 at 430 dpi
TILE = 48  # pixels there, of the grid of the paper's light: few enough for a ruler's own body to be paper to its ticks
FEWEST = 21  # ticks: two centimetres, that the rhythm be seen twice
SURE = 4.0  # standard errors beyond which a drift is none of chance
GAP = 5  # ticks that may be missing in a row (glare, digits)
BODY = 15.0  # mm of ruler from its edge inwards: ticks and digits. Further rows of marks make it wider
WIDEST = 60.0  # mm
BEYOND = 15.0  # mm of ruler past its last tick seen
OUTSIDE = 1.0  # mm on the other side of its edge: the edge's line and shadow


@dataclass(frozen=True, eq=False)
class Ruler:
    """A ruler's place on a page, in pixels from the page's corner, x and y.

    pitch   pixels to the millimetre, on average along the ruler
    drift   the share by which its largest millimetre is larger than its smallest, 0 if that could be chance
    fan     the share by which a millimetre is larger or smaller a millimetre away from the ruler, by ticks that are not parallel, or 0
    ticks   how many were found
    origin  (2,) where the first tick meets the edge
    along   (2,) unit vector to the last tick
    inward  (2,) unit vector from the edge along the ticks
    length  pixels from the first to the last tick
    depth   pixels the body reaches from the edge inwards
    """

    pitch: float
    drift: float
    fan: float
    ticks: int
    origin: Array
    along: Array
    inward: Array
    length: float
    depth: float

    def shades(self, xy: Array) -> Mask:
        """Which points (n, 2), in pixels, may show a ruler's body and not paper, however wide it is."""
        return replace(self, depth=max(self.depth, WIDEST * self.pitch)).covers(xy)

    def covers(self, xy: Array, reach: Array | float = 0.0) -> Mask:
        """Which points (n, 2), in pixels, lie on the ruler or on its shadow, or so near to it."""
        u, v = (xy - self.origin) @ self.along, (xy - self.origin) @ self.inward
        past, outside = reach + BEYOND * self.pitch, reach + OUTSIDE * self.pitch
        return np.asarray((u > -past) & (u < self.length + past) & (v > -outside) & (v < self.depth + reach))


@dataclass(frozen=True, eq=False)
class _Row:
    """Ticks of a row: their whole numbers, and their places along its edge in pixels."""

    number: Index
    at: Array
    side: int  # 1 where ticks reach from the edge to larger v
    edge: tuple[float, float]  # v of the edge at u = 0, and by u
    pitch: float
    drift: float
    fan: float


def found(light: Grey, dpi: float | None = None) -> Ruler | None:
    """The ruler of a page (h, w) of light, None where none is seen; dpi, where known, only spares time.

    Half-millimetre and inch scales are not read. Resolutions under some 150 dpi leave ticks no paper between them.
    """
    factor = max(1, int(dpi // 400) if dpi else -(-max(light.shape) // WORKED))
    h, w = (side // factor for side in light.shape)
    small = light[: h * factor, : w * factor].reshape(h, factor, w, factor).mean((1, 3)) if factor > 1 else light
    if min(h, w) < TILE:
        return None
    darkness, _ = flattened(small, tile=TILE)
    best: tuple[_Row, Marks] | None = None
    for marks in candidates(darkness):
        for side in (1, -1):
            row = _row(marks, side)
            if row and (best is None or len(row.number) > len(best[0].number)):
                best = row, marks
    return _placed(*best, factor) if best else None


def _row(marks: Marks, side: int) -> _Row | None:
    """The row of ticks among marks whose ends on one side lie on a line, if their lengths have a ruler's rhythm."""
    edge = _edge(marks, side)
    if edge is None:
        return None
    on, level, slope = edge
    lean = _lean(marks.u[on], marks.lean[on])
    base = marks.u[on] - lean * (marks.v[on] - level - slope * marks.u[on])  # where a tick's line meets the edge
    order = np.argsort(base, kind="stable")
    chosen, base = on[order], base[order] * np.hypot(1, slope)
    kept, number = _numbered(base)
    if len(kept) < FEWEST:
        return None
    chosen, base = chosen[kept], base[kept]
    sound, pitch, drift = _projected(number, base)
    chosen, number, base = chosen[sound], number[sound], base[sound]
    length, width = marks.length[chosen], float(np.median(marks.width[chosen]))
    if len(number) < FEWEST or width > 0.6 * pitch or not _rhythm(number, length, pitch):
        return None
    return _Row(number, base, side, (level, slope), pitch, drift, abs(_steepness(base, marks.lean[chosen])) * pitch)


def _edge(marks: Marks, side: int) -> tuple[Index, float, float] | None:
    """The marks that end on a common line at lower v (side 1) or higher (-1), and the line's v at u = 0 and by u."""
    if len(marks.u) < FEWEST:
        return None
    end = marks.v - side * marks.length / 2
    near = max(2.0, 0.15 * float(np.median(marks.length)))
    best = -1, 0.0, 0.0
    for slope in np.linspace(-0.1, 0.1, 81):
        height = np.sort(end - slope * marks.u)
        within = np.searchsorted(height, height + 2 * near, side="right") - np.arange(len(height))
        k = int(within.argmax())
        best = max(best, (int(within[k]), float(slope), float(height[k]) + near))
    _, slope, level = best
    for tolerance in (2 * near, near, near):
        on = np.flatnonzero(np.abs(end - slope * marks.u - level) < tolerance)
        if len(on) < FEWEST:
            return None
        slope, level = _line(marks.u[on], end[on])
    return on, level, slope


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Slope and height at 0 of the line through points, level where they are all of one x."""
    away = x - x.mean()
    slope = float(away @ y / max(away @ away, 1e-12))
    return slope, float(y.mean() - slope * x.mean())


def _lean(u: Array, lean: Array) -> Array:
    """The lean of ticks at places, on a line through them, as a camera that looks aslant fans them out; odd ones left out."""
    close = np.ones(len(u), bool)
    for _ in range(3):
        slope, level = _line(u[close], lean[close])
        off = np.abs(lean - slope * u - level)
        close = off <= 3 * np.median(off)
    return slope * u + level


def _numbered(at: Array) -> tuple[Index, Index]:
    """Which of rising places are evenly spaced, and their whole numbers: the spacing may change slowly, and a few may lack."""
    step = max(float(np.median(np.diff(at))), 1.0)
    good = np.abs(np.diff(at) / step - 1) < 0.2
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    if not len(edges):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    longest = int(np.argmax(edges[1::2] - edges[::2]))
    begin, stop = int(edges[2 * longest]), int(edges[2 * longest + 1])
    kept, number = list(range(begin, stop + 1)), list(range(stop - begin + 1))
    for places, ahead in ((range(stop + 1, len(at)), True), (range(begin - 1, -1, -1), False)):
        last = -1 if ahead else 0
        local = abs(at[kept[last]] - at[kept[-6 if ahead else 5]]) / 5 if len(kept) > 5 else step
        for place in places:
            away = abs(at[place] - at[kept[last]])
            jump = round(away / local)
            if jump > GAP:
                break
            if jump < 1 or abs(away / local - jump) > 0.25:
                continue
            local += 0.2 * (away / jump - local)
            if ahead:
                kept.append(place)
                number.append(number[-1] + jump)
            else:
                kept.insert(0, place)
                number.insert(0, number[0] - jump)
    return np.array(kept), np.array(number) - number[0]


def _projected(number: Index, at: Array) -> tuple[Mask, float, float]:
    """Which places follow the map (a + b k) / (1 + c k) of whole numbers k; the mean pitch; how much it drifts, or 0.

    That is what a camera makes of even ticks on a straight line. The fit is of a + b k - c k u = u, in turn without the furthest.
    """
    k = (number - number.mean()) / max(np.ptp(number), 1)
    size = np.ptp(at)
    u = (at - at.mean()) / size
    sound = np.ones(len(k), bool)
    for _ in range(3):
        matrix = np.stack([np.ones_like(k), k, -k * u], axis=1)
        (a, b, c), *_ = np.linalg.lstsq(matrix[sound], u[sound], rcond=None)
        off = np.abs(u - (a + b * k) / (1 + c * k))
        sound = off < max(4 * float(np.median(off)), 0.03 * b / max(np.ptp(number), 1))
    ends = np.array([k[0], k[-1]])
    pitch = float(np.diff((a + b * ends) / (1 + c * ends))[0] * size / (number[-1] - number[0]))
    speed = (b - a * c) / (1 + c * ends) ** 2
    spread = np.sqrt((off[sound] ** 2).mean() * np.linalg.inv(matrix[sound].T @ matrix[sound])[2, 2])
    drift = float(speed.max() / speed.min() - 1) if speed.min() > 0 else np.inf
    return sound, pitch, drift if abs(c) > SURE * spread else 0.0


def _steepness(x: Array, y: Array) -> float:
    """The slope of y by x, or 0 where it could be chance."""
    x, y = x - x.mean(), y - np.median(y)
    slope = float(x @ y / (x @ x))
    chance = float(1.4826 * np.median(np.abs(y - slope * x)) / np.sqrt(x @ x))
    return slope if abs(slope) > SURE * chance else 0.0


def _rhythm(number: Index, length: Array, pitch: float) -> bool:
    """Whether ticks are longer each tenth and half way between."""
    best = 0.0
    for first in range(10):
        tens, fives = length[number % 10 == first], length[number % 10 == (first + 5) % 10]
        rest = length[number % 5 != first % 5]
        if min(len(tens), len(fives)) < 2 or not len(rest):
            continue
        usual = float(np.median(rest))
        ten, five = float(np.median(tens)), float(np.median(fives))
        if ten > 1.15 * usual and five > 1.08 * usual and ten > 0.97 * five and 0.6 * pitch < usual < 12 * pitch:
            best = max(best, float((rest < (usual + five) / 2).mean()))
    return best > 0.85


def _placed(row: _Row, marks: Marks, factor: int) -> Ruler:
    """The Ruler of a row, in pixels of the whole page."""
    (level, slope), turn = row.edge, marks.turn
    true = np.array([1.0, slope]) / np.hypot(1, slope)
    frame = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])  # rows: u and v in x, y
    along, inward = true @ frame, row.side * np.array([-true[1], true[0]]) @ frame
    origin = (np.array([0.0, level]) + (row.at[0]) * true) @ frame
    depth = row.side * (marks.v - level - slope * marks.u) + marks.length / 2
    u = marks.u * np.hypot(1, slope)
    beside = (depth > BODY * row.pitch) & (depth < WIDEST * row.pitch) & (u > row.at[0]) & (u < row.at[-1])
    deep = float(np.quantile(depth[beside], 0.95)) + row.pitch if beside.sum() >= FEWEST else 0.0
    return Ruler(
        row.pitch * factor,
        row.drift,
        row.fan,
        len(row.number),
        origin * factor,
        along,
        inward,
        float(row.at[-1] - row.at[0]) * factor,
        max(BODY * row.pitch, deep) * factor,
    )
