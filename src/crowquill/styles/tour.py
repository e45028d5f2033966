"""Tour: a drawing of one unbroken line through stippled sites, which nowhere crosses itself, closer where it is darker.

Sites are as dense as a line of the pen's width through them needs to be, relaxed as in stippling, and joined by a short tour.
Source: C. S. Kaplan, R. Bosch, TSP Art, Bridges 2005; A. Secord, Weighted Voronoi Stippling, NPAR 2002, for where the sites lie.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from crowquill import raster, relax, route
from crowquill.knobs import Choice, Flag, Range
from crowquill.paths import Array, Paths
from crowquill.route.crossings import crossings
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, allowed, cut_white, expected_seconds, settled, snapped, widest
from crowquill.styles import Work
from crowquill.tone import Tone

INKS = False  # one line
PEN = 0.2  # mm
CAP = 0.9  # coverage; from there on strands of the line run into each other
ROUNDS = 3  # of drawing, at most
CLOSE = 0.005  # of the ink; nearer, no other round is made
SPAN = (0.5, 1.5)  # narrowest and widest line over a pen that follows the tone
WIDTHS = 8  # between them; a step of a seventh of the pen does not show
FLAT = 1e-3  # mm: pieces of curves that are looked through for crossings stray no more from them
HANDLE = 0.4  # of a link; longer ones bulge

# Coverage of a line through relaxed sites whose width is this share of their spacing, the root of the area to each: its length
# is 1.025 spacings to a site. Measured on 20 000 sites at two seeds, which differ by 0.001 at most.
SHARE = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
COVER = np.array([0.0, 0.1020, 0.2031, 0.3032, 0.4025, 0.5009, 0.5983, 0.6950, 0.7907, 0.8845, 0.9606])


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "line width (0.2mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of sites on the line; the tone gives")] = None,
    closed: Annotated[bool, Flag("lead the line back to where it begins")] = False,
    rounded: Annotated[bool, Flag("bend the line through its sites in place of corners")] = False,
    width_by: Annotated[str, Choice(("pen", "tone"), "a line as wide as the pen, or wider where it is darker")] = "pen",
    iterations: Annotated[int, Range(0, 100_000, "", "most relaxation steps")] = 15,
    start: Annotated[str, Choice(relax.STARTS, "where sites begin")] = "levels",
    white: Annotated[float, Range(0, 1, "", "no sites where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size with one black line, or with a layer for each of its widths, the finest first.

    sites    in the canvas and off the white; the line between them goes straight on across white and beyond the canvas, where
             the picture has islands or bays, because it must not break: `outside_mm` is how much of it does
    rounded  bends are eased until curves cross nowhere either; only where sites crowd they stay corners
    width_by "tone": 0.5 to 1.5 times the pen by the tone along the line, in eight widths; a stroke ends where the width
             changes and the next begins there
    ink      what is asked up to a coverage of 0.9, and the report has `coverage_missing`. Where the first drawing is off by more
             than half a percent, others follow with more or fewer sites, three at most; with `dots` there is one
    no ink   or less than two sites take, an empty sheet and a warning. Raises ValueError for more than max_dots and for a
             pen wider than the canvas
    """
    clock = Clock()
    asked, blank = cut_white(tone, white)
    line = widest(tone, pen, PEN)
    demand, near, wanted = _planned(asked, line, width_by)
    reached = asked.mapped(lambda c: np.minimum(c, CAP)).ink
    count = wanted if dots is None else dots if wanted else 0
    if count > max_dots:
        raise ValueError(
            f"the picture takes {count} sites, over the limit of {max_dots}; draw it smaller, use a wider pen, or raise max-dots"
        )
    yield Step("plan", 0, 1, {"dots": count, "pen_mm": line, "seconds": 2 * expected_seconds(count, iterations)})
    tried: list[tuple[int, float]] = []
    for chance in rng.spawn(ROUNDS):
        state = yield from settled(demand, count, chance, clock, start=start, iterations=iterations, banned=blank)
        sites, kept = snapped(state.sites, tone, blank)
        sites = sites[kept]
        path = sites[route.tour(sites, closed)]
        yield Step("tour", 1, 1)
        clock.lap("tour")
        strokes = _strokes(path, closed, rounded, np.array([line]) if width_by == "pen" else _widths(line), near)
        ink = inked(strokes)
        clock.lap("measure")
        tried.append((count, ink))
        if dots is not None or not ink or abs(ink / reached - 1) <= CLOSE:
            break
        count = min(_corrected(tried, reached), max_dots)
    report: dict[str, Any] = {
        "marks": sum(len(paths) for _, paths in strokes),
        "sites": len(sites),
        "pen_mm": line,
        "length_mm": float(sum(_length(paths.flat(line / 100)) for _, paths in strokes)),
        "outside_mm": _outside(path, closed, tone, blank),
        "ink_asked_mm2": asked.ink,
        "ink_placed_mm2": ink,
        "coverage_missing": max(0.0, 1 - ink / asked.ink) if asked.ink else 0.0,
        "iterations": state.done,
        "energy": state.energy,
        "movement": state.movement,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(report, tone)
    none = Layer(Ink(pen=line), Paths.of([], closed=False), "tour")
    layers = [Layer(Ink(pen=pen), paths, f"{pen:.4g} mm" if len(strokes) > 1 else "tour") for pen, paths in strokes]
    return Sheet(tone.size, tuple(layers) or (none,), report=report)


def _planned(asked: Tone, pen: float, width: str) -> tuple[Tone, Tone, int]:
    """Where sites go, as a tone over its densest, the tone around that decides, and how many sites the ink takes: two at least.

    As in stippling the tone around decides how wide the line is and how much of it runs over itself, and the pixel its share.
    """
    from scipy.ndimage import gaussian_filter

    sigma = [3 * pen / side for side in reversed(asked.pixel)]  # about the spacing in a medium tone
    near = np.clip(gaussian_filter(np.minimum(asked.coverage, CAP), sigma, mode="nearest", truncate=3.0), 1e-4, CAP)
    wide = pen * (_swell(near) if width == "tone" else 1.0)
    crowd = (np.interp(near, COVER, SHARE) / wide) ** 2 / near * np.minimum(asked.coverage, CAP)
    most = max(float(crowd.max()), float(np.finfo(float).tiny))
    demand = Tone(crowd / most, asked.size, asked.canvas)
    return demand, Tone(near, asked.size, asked.canvas), max(2, round(demand.ink * most)) if asked.ink > pen**2 else 0


def _swell(coverage: Array) -> Array:
    """The width over the pen's that goes with a coverage."""
    return np.asarray(SPAN[0] + (SPAN[1] - SPAN[0]) * coverage / CAP)


def _widths(pen: float) -> Array:
    """The widths of a line that follows the tone, mm."""
    return np.maximum(1e-3, np.round(pen * np.linspace(*SPAN, WIDTHS), 3))


def _corrected(tried: list[tuple[int, float]], reached: float) -> int:
    """How many sites should give the ink to be reached, after the numbers tried and the ink that each gave.

    Ink rises about as the root of the number of sites, and otherwise as tried twice where it has been; no step is over 2.
    """
    (count, ink), power = tried[-1], 2.0
    if len(tried) > 1 and tried[-2][1] != ink:
        power = float(np.clip(np.log(count / tried[-2][0]) / np.log(ink / tried[-2][1]), 0.8, 3))
    return max(2, round(count * float(np.clip((reached / ink) ** power, 0.5, 2))))


def _strokes(path: Array, closed: bool, rounded: bool, widths: Array, near: Tone) -> list[tuple[float, Paths]]:
    """The line through places (n, 2) in their order as strokes of each width, the finest first; none through one place or no place.

    A stroke is as wide as the tone along each of its links asks for, and as long as that does not change.
    """
    if len(path) < 2:
        return []
    closed = closed and len(path) > 2
    ends = np.concatenate([path, path[:1]]) if closed else path
    n = len(ends) - 1
    along = np.linspace(0.1, 0.9, 5)[:, None, None]
    tone = near.coverage[near.under((ends[:-1] + along * (ends[1:] - ends[:-1])).reshape(-1, 2))].reshape(5, n).mean(axis=0)
    kind = np.abs(_swell(tone)[:, None] - widths / widths.mean()).argmin(axis=1)
    first = np.flatnonzero(kind != np.roll(kind, 1)) if closed else np.flatnonzero(np.append(True, kind[1:] != kind[:-1]))
    handles = _bends(ends, closed) if rounded else np.empty((n, 0, 2))
    chain = np.concatenate([ends[:-1, None], handles], axis=1)  # what each link has but its end
    if not len(first):
        return [(float(widths[kind[0]]), Paths.of([chain.reshape(-1, 2)], cubic=rounded))]
    last = np.append(first[1:], first[0] + n if closed else n)
    found = []
    for k in np.unique(kind):
        runs = [np.arange(a, b) % n for a, b in zip(first.tolist(), last.tolist(), strict=True) if kind[a] == k]
        lines = [np.concatenate([chain[run].reshape(-1, 2), ends[run[-1] + 1 : run[-1] + 2]]) for run in runs]
        found.append((float(widths[k]), Paths.of(lines, closed=False, cubic=rounded)))
    return found


def _bends(ends: Array, closed: bool) -> Array:
    """Two handles for each link between ends (n + 1, 2), (n, 2, 2), by which it bends through its ends and crosses no other.

    At a site the line goes on along the middle of both links' directions. Where curves cross, handles are halved, at last to
    nothing: and straight links do not cross.
    """
    link = ends[1:] - ends[:-1]
    length = np.maximum(np.hypot(*link.T), 1e-12)[:, None]
    way = link / length
    lead = np.zeros_like(ends)
    lead[1:-1] = way[:-1] + way[1:]
    if closed:
        lead[[0, -1]] = way[0] + way[-1]
    lead /= np.maximum(np.hypot(*lead.T), 1.0)[:, None]  # shorter where the line turns back
    bend = np.full((len(ends), 1), HANDLE)
    start = 4 * np.arange(len(link) + 1)
    while True:
        a, d = ends[:-1], ends[1:]
        b, c = np.round(a + (bend * lead)[:-1] * length, 3), np.round(d - (bend * lead)[1:] * length, 3)
        flat = Paths(np.stack([a, b, c, d], axis=1).reshape(-1, 2), start, closed=False, cubic=True).flat(FLAT)
        piece = np.flatnonzero(flat.path[1:] == flat.path[:-1])
        crossed = np.unique(flat.path[piece[crossings(flat.xy[piece], flat.xy[piece + 1])]])
        eased = np.unique(np.concatenate([crossed, crossed + 1]))
        eased = np.union1d(eased, [0, len(ends) - 1]) if closed and np.isin([0, len(ends) - 1], eased).any() else eased
        if not (bend[eased] > 0).any():
            return np.stack([b, c], axis=1)
        bend[eased] = np.where(bend[eased] > HANDLE / 8, bend[eased] / 2, 0)


def inked(strokes: list[tuple[float, Paths]]) -> float:
    """The area that strokes of pens cover together, mm^2, within about 1e-4 of many, 1e-3 of one."""
    if not strokes:
        return 0.0
    finest = strokes[0][0]
    rings = [raster.stroked(paths.flat(finest / 200), pen, finest / 200) for pen, paths in strokes]
    xy, counts = np.concatenate([ring.xy for ring in rings]), np.concatenate([np.diff(ring.start) for ring in rings])
    low, high = xy.min(axis=0), xy.max(axis=0)
    pixel = max(finest, float(np.sqrt(np.prod(high - low) / 4e7)))
    columns, rows = np.ceil((high - low) / pixel).astype(int)
    area = Paths(xy - low, np.concatenate([[0], np.cumsum(counts)]))
    return float(raster.covered(area, (rows, columns), pixel=(pixel, pixel), lines=max(16, round(32 * pixel / finest))).sum()) * pixel**2


def _length(lines: Paths) -> float:
    """The length of straight lines or rings, mm."""
    total = 0.0
    for line in lines:
        ring = np.concatenate([line, line[:1]]) if lines.closed else line
        total += float(np.hypot(*np.diff(ring, axis=0).T).sum())
    return total


def _outside(path: Array, closed: bool, tone: Tone, blank: npt.NDArray[np.bool_]) -> float:
    """How much of the straight line through places lies on white or outside the canvas, mm, looked at every half pixel."""
    after = np.roll(path, -1, axis=0) if closed else path[1:]
    before = path[: len(after)]
    length = np.hypot(*(after - before).T)
    count = np.maximum(1, np.ceil(length / (min(tone.pixel) / 2))).astype(np.int64)
    link = np.repeat(np.arange(len(before)), count)
    part = (np.arange(len(link)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[link]
    place = before[link] + part[:, None] * (after - before)[link]
    return float((length / count)[link][~allowed(place, tone, blank)].sum())


def _warnings(report: dict[str, Any], tone: Tone) -> list[str]:
    """What is to be said of the ink, and of importance."""
    missing, said = report["coverage_missing"], []
    if not report["ink_asked_mm2"]:
        said.append("no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on")
    elif not report["marks"]:
        said.append(f"no line: all the ink is less than two sites of a {report['pen_mm']:.4g} mm line take; a finer pen would draw it")
    elif missing > 0.02:
        said.append(f"{missing:.1%} of the ink asked for is not reached; a wider pen, more dots or lighter tones would help")
    if tone.importance is not None:
        said.append("importance is not heeded: one line leaves nothing to choose; stippling heeds it")
    return said
