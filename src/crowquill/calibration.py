"""The calibration sheet: what a printer makes of dots, lines, gaps and tones, at true size and in black alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from crowquill import glyphs, styles, units
from crowquill.lettering import Words, width
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, shifted
from crowquill.tone import Tone

MARGIN = 12.0  # mm; printers leave up to 6 white
BESIDE = 12.0  # mm, for the upright ruler
LEAST = 108.0  # mm of width beside it, for the rows below
RULER = 100  # mm
TICK = 0.1  # mm
TICKS = {1: 2.0, 5: 3.0, 10: 4.0}  # mm, how long by what they divide
DOTS = (0.05, 0.08, 0.1, 0.13, 0.15, 0.18, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8)  # mm
LINES = (0.03, 0.05, 0.07, 0.1, 0.13, 0.15, 0.18, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5)  # mm
STEPS = (0, 5, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100)  # percent
APART = 1.6  # mm between patches of tone, and between dots and lines of one size
SMALL, NORMAL, LARGE = 1.8, 2.5, 5.0  # mm of letters
HEADING = 1.6 * NORMAL
SAYS = (
    "Print at 100 %, not fitted to the page. Both rulers must then measure 100 mm.",
    "Dots, gaps and lines: see with a loupe which is the finest that prints whole. Finer ones are not worth drawing; white narrower "
    "than the finest that stays open is no use as min-gap or outline-gap.",
    "Ink gain: measure a line or a dot of 0.2 to 0.5 mm, with a loupe or in a scan of 2400 dpi. Half of what it is too wide is the "
    "gain: 0.34 mm in place of 0.3 mm is --ink-gain 0.02mm.",
    "Tones: measure how dark each step is, with a densitometer or as the mean of a scan, bare paper being 0 and the solid square 100. "
    "Write a line for each step into a CSV file, asked and measured: 50,61. Draw with --tone-curve FILE.csv. Where that is used, "
    "leave out --ink-gain: either makes up for the gain.",
)


@dataclass(frozen=True, eq=False)
class Block:
    """Layers from the origin down, and how high they are in mm."""

    layers: tuple[Layer, ...]
    height: float


def sheet(paper: str = "a4", pen: float = 0.3) -> Sheet:
    """A page to print and measure: rulers, dots, holes, lines, steps of tone in dots of this pen in mm, and the nibs that come along.

    All is black of one ink. The same paper and pen give the same page. Raises ValueError for a paper on which it has no room.
    """
    size = units.paper(paper)
    room = size[0] - 2 * MARGIN - BESIDE
    if room < LEAST:
        raise ValueError(f"paper {paper!r} is {size[0]:g} mm wide, and the sheet takes {LEAST + 2 * MARGIN + BESIDE:g}; give a wider one")
    blocks = [
        _said(room),
        _level(),
        _headed("dots, and holes in black, mm", _dots()),
        _headed("lines, and white ones in black, mm", _lines()),
        _headed("nibs", _nibs(room)),
        _headed(f"tones asked, %, in dots of {pen:g} mm, and solid black", _tones(room)),
    ]
    tops = MARGIN + np.cumsum([0.0, *(block.height + NORMAL for block in blocks)])
    if (high := max(tops[-1] - NORMAL, MARGIN + RULER) + MARGIN) > size[1]:
        raise ValueError(f"paper {paper!r} is {size[1]:g} mm high, and the sheet takes {high:.0f}; give a higher one")
    layers = [_moved(layer, MARGIN, MARGIN) for layer in _upright().layers]
    for block, top in zip(blocks, tops.tolist(), strict=False):
        layers += [_moved(layer, MARGIN + BESIDE, top) for layer in block.layers]
    layers += [_moved(layer, MARGIN + BESIDE, float(tops[-2]) + HEADING) for layer in _stippled(room, pen)]
    return Sheet(size, tuple(layers))


def ticks() -> Paths:
    """A ruler of 100 mm along x from 0, on the line y = 0: a bar for each millimetre, in the middle of which it is, going down."""
    every = np.arange(RULER + 1)
    high = np.select([every % 10 == 0, every % 5 == 0], [TICKS[10], TICKS[5]], TICKS[1])
    return _boxes([(x - TICK / 2, 0.0, TICK, h) for x, h in zip(every.tolist(), high.tolist(), strict=True)])


def _level() -> Block:
    numbers = [(f"{x}", float(x), TICKS[10] + SMALL) for x in range(0, RULER + 1, 10)]
    words = Words.of([*numbers[:-1], (f"{RULER} mm", float(RULER), TICKS[10] + SMALL)], size=SMALL, anchor="middle")
    return Block((_black(ticks(), "ruler"), _black(words, "ruler's numbers")), TICKS[10] + SMALL)


def _upright() -> Block:
    """The ruler along y, its numbers to the right."""
    numbers = [(f"{y}", TICKS[10] + 0.5, y + 0.36 * SMALL) for y in range(0, RULER + 1, 10)]
    turned = ticks().moved([[0, 1], [1, 0]])
    return Block((_black(turned, "upright ruler"), _black(Words.of(numbers, size=SMALL), "upright ruler's numbers")), float(RULER))


def _said(room: float) -> Block:
    """The heading, and what to do with the sheet, in lines no wider than the room."""
    lines: list[tuple[str, float, float]] = []
    y = LARGE + 2.0
    for number, text in enumerate(SAYS, 1):
        line = f"{number}"
        y += 0.8
        for word in text.split():
            if width(f"{line} {word}", NORMAL) > room:
                lines.append((line, 0.0, (y := y + 1.35 * NORMAL)))
                line = "  "
            line = f"{line} {word}"
        lines.append((line, 0.0, (y := y + 1.35 * NORMAL)))
    title = Words.of([("crowquill: calibration sheet", 0.0, LARGE)], size=LARGE, font="bold")
    return Block((_black(title, "title"), _black(Words.of(lines, size=NORMAL), "what to do")), y + 1.0)


def _headed(heading: str, block: Block) -> Block:
    words = _black(Words.of([(heading, 0.0, NORMAL)], size=NORMAL, font="bold"), f"{heading}: heading")
    return Block((words, *(_moved(layer, 0.0, HEADING) for layer in block.layers)), block.height + HEADING)


def _dots() -> Block:
    """Six discs of each diameter, their sizes, and six holes as large in a black bar."""
    pitch, (disc,) = LEAST / len(DOTS), glyphs.load("disc").glyphs
    left = pitch * np.arange(len(DOTS))
    grid = np.array([(x, y) for y in (0.5, 1.5) for x in (0.5, 1.5, 2.5)]) * APART
    xy = (np.stack([left, 0 * left], axis=1)[:, None] + grid + (pitch / 2 - 1.5 * APART, 0)).reshape(-1, 2)
    marks = Marks.of(xy, (disc,), scale=np.repeat(DOTS, len(grid)) * np.sqrt(np.pi) / 2)
    high, down = 2 * APART, 2 * APART + 1.6 * SMALL
    bar = _boxes([(0.0, down, LEAST, high)])
    holes = [np.roll(ring[::-1], 1, axis=0) for ring in marks.moved((0, down)).outlines()]  # the other way round
    black = Paths.of([*bar.curved(), *holes], cubic=True)
    return Block((_black(marks, "dots"), _labels(DOTS, pitch, high + 1.2 * SMALL), _black(black, "holes")), down + high)


def _lines() -> Block:
    """Two upright and two level lines of each width, their widths, and the same left white in a black bar."""
    pitch, long = LEAST / len(LINES), 3.0
    boxes = []
    for k, wide in enumerate(LINES):
        x = k * pitch + 0.5
        boxes += [(x + i * 1.2, 0.5, wide, long) for i in range(2)]
        boxes += [(x + 3.0, 0.5 + i * 1.2, long + 1, wide) for i in range(2)]
    high, down = long + 1, long + 1 + 1.6 * SMALL
    lines = _boxes(boxes)
    bar = _boxes([(0.0, down, LEAST, high)])
    black = Paths.of([*bar, *(ring[::-1] for ring in lines.moved(np.eye(2), (0, down)))])
    return Block((_black(lines, "lines"), _labels(LINES, pitch, high + 1.1 * SMALL), _black(black, "white lines")), down + high)


def _tones(room: float) -> Block:
    """The number of each step of tone below its square, and a square of solid black; dots come last."""
    pitch, side = _squares(room)
    solid = _boxes([(len(STEPS) * pitch, 0.0, side, side)])
    below = [(name, k * pitch + side / 2, side + 1.2 * SMALL) for k, name in enumerate([*map(str, STEPS), "solid"])]
    words = Words.of(below, size=SMALL, anchor="middle")
    return Block((_black(solid, "solid"), _black(words, "tones asked")), side + 1.4 * SMALL)


def _stippled(room: float, pen: float) -> list[Layer]:
    """The squares of all steps as a drawing stipples them, in one drawing."""
    pitch, side = _squares(room)
    squares = shapely.multipolygons([shapely.box(k * pitch, 0, k * pitch + side, side) for k in range(len(STEPS))])
    tone = Tone(np.array([STEPS]) / 100, (pitch * len(STEPS), side), squares)
    drawn = styles.run(styles.steps("stipple", tone, pen=pen, white=0.0))
    return [replace(layer, name="tones") for layer in drawn.layers]


def _squares(room: float) -> tuple[float, float]:
    """How far squares of tone are apart from left to left, and how wide they are."""
    pitch = room / (len(STEPS) + 1)
    return pitch, round(pitch - APART, 1)


def _nibs(room: float) -> Block:
    """A row of the dots of each library that is of more than one, at their own sizes."""
    found, names, y = [], [], 0.0
    for name in glyphs.names():
        library = glyphs.load(name)
        if len(library.glyphs) < 2:
            continue
        y += APART
        n = min(len(library.glyphs), int((room - BESIDE) / APART))
        scale = np.array([glyph.size for glyph in library.glyphs[:n]]) * np.sqrt(np.pi) / 2
        xy = np.stack([BESIDE + (np.arange(n) + 0.5) * APART, np.full(n, y)], axis=1)
        found.append(_black(Marks.of(xy, library.glyphs[:n], scale=scale, glyph=np.arange(n)), name))
        names.append((name, 0.0, y + 0.36 * SMALL))
        y += APART / 2
    return Block((*found, _black(Words.of(names, size=SMALL), "nibs' names")), y)


def _labels(sizes: Sequence[float], pitch: float, y: float) -> Layer:
    lines = [(f"{size:g}", (k + 0.5) * pitch, y) for k, size in enumerate(sizes)]
    return _black(Words.of(lines, size=SMALL, anchor="middle"), "sizes")


def _boxes(boxes: Sequence[tuple[float, float, float, float]]) -> Paths:
    """Rectangles of left, top, width and height in mm."""
    left, top, wide, high = np.array(boxes, np.float64).reshape(-1, 4).T
    corners: Array = np.stack([left, top, left + wide, top, left + wide, top + high, left, top + high], axis=1)
    return Paths.of(corners.reshape(-1, 4, 2))


def _black(art: Marks | Paths | Words, name: str) -> Layer:
    return Layer(Ink(), art, name)


def _moved(layer: Layer, x: float, y: float) -> Layer:
    return replace(layer, art=shifted(layer.art, np.array([x, y])))
