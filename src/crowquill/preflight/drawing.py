"""What a page draws, in millimetres, whatever file it came from: outlines and strokes with their inks, words, bitmaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array, Index, Paths

EVERY = "Separation All"  # the colour of crop marks: on every plate, and no ink in the picture
TRIM = 0.1  # mm that a page may differ from the paper asked for
Box = tuple[float, float, float, float]  # left, top, right, bottom in mm
DARK = 0.15  # of the light: RGB below it in all three is black to the eye
BLACK = 0.85  # of a black ink: as dark


@dataclass(frozen=True)
class Colour:
    """A colour as the file gives it: its space, its inks and their shares of 0 to 1, or the light it stands for.

    Light has no inks until somebody converts it; None is ink. `known` is False for patterns and the like, of which nothing is known.
    """

    space: str
    shares: tuple[tuple[str, float], ...] = ()
    light: tuple[float, float, float] | None = None
    known: bool = True

    @property
    def white(self) -> bool:
        """Whether it leaves the paper as it is."""
        return self.known and (not self.shares if self.light is None else min(self.light) >= 1)

    @property
    def black(self) -> bool:
        """Whether it is black to the eye."""
        if self.light is not None:
            return max(self.light) <= DARK
        inks = dict(self.shares)
        return inks.get("Black", 0) >= BLACK or all(inks.get(name, 0) >= BLACK for name in ("Cyan", "Magenta", "Yellow"))

    @property
    def plates(self) -> int:
        """How many inks it needs."""
        return 4 if self.light is not None and not self.white else len(self.shares)


@dataclass(frozen=True, eq=False)
class Art:
    """Outlines in straight pieces and the things they make: what one painting operator, or one shape, draws.

    outlines: n paths, whatever they are, in mm; area (n,): mm^2 of each, of its curves and not of the pieces, and signed;
    closed (n,); thing (n,): which thing each belongs to. For each thing fill and stroke: its colour, an index or -1;
    pen: mm, 0 for the thinnest that a device has; evenodd; round: a stroke's caps; over: whether its fill, its stroke overprint.
    """

    outlines: Paths
    area: Array
    closed: npt.NDArray[np.bool_]
    thing: Index
    fill: Index
    stroke: Index
    pen: Array
    evenodd: npt.NDArray[np.bool_]
    round: npt.NDArray[np.bool_]
    over: npt.NDArray[np.bool_]
    colours: tuple[Colour, ...]

    def __len__(self) -> int:
        return len(self.outlines)

    @property
    def boxes(self) -> Array:
        """Left, top, right, bottom of each outline, (n, 4) mm, without its pen."""
        if not len(self):
            return np.zeros((0, 4))
        low, high = (of.reduceat(self.outlines.xy, self.outlines.start[:-1], axis=0) for of in (np.minimum, np.maximum))
        return np.hstack([low, high])

    @property
    def lengths(self) -> Array:
        """The length of each outline, (n,) mm, the way back to its first point included where it is closed."""
        if not len(self):
            return np.zeros(0)
        xy, start = self.outlines.xy, self.outlines.start
        step = np.hypot(*np.diff(xy, axis=0, append=xy[-1:]).T)
        last = start[1:] - 1
        step[last] = np.where(self.closed, np.hypot(*(xy[last] - xy[start[:-1]]).T), 0)
        return np.asarray(np.add.reduceat(step, start[:-1]))


@dataclass(frozen=True)
class Words:
    """Letters of one font and size: mm, what they are in, how many."""

    font: str
    size: float
    colour: Colour
    count: int


@dataclass(frozen=True)
class Bitmap:
    """A bitmap as it is placed: what it is called, where, its pixels, bits to a channel, pixels to the inch the coarser way."""

    name: str
    box: Box
    pixels: tuple[int, int]
    bits: int
    ppi: float


@dataclass(frozen=True, eq=False)
class Drawing:
    """A page: its boxes in mm, all that is drawn on it, and what was not read.

    trim, bleed   what is left when it is cut, and how far art goes beyond
    extents       boxes of what has no outline here
    unread        what is not measured, in words, and how many of each
    elements      how many operators or elements, and `parts`, which
    ink           the most ink in a bitmap, 1 for each plate
    page          where art must end, None where the file's own boxes see to that
    screen        colours are those of a screen, as they must be in SVG
    """

    where: str
    trim: Box
    bleed: Box
    art: Art
    words: Sequence[Words] = ()
    bitmaps: Sequence[Bitmap] = ()
    extents: Sequence[Box] = ()
    unread: Mapping[str, int] = field(default_factory=dict)
    elements: int = 0
    parts: str = "operators"
    ink: float = 0.0
    page: Box | None = None
    screen: bool = False

    @cached_property
    def printed(self) -> Art:
        """The art that is not cut off: without outlines wholly outside the bleed, and those of crop marks outside the trim."""
        art = self.art
        crop = np.array([one.space == EVERY for one in art.colours] + [False])
        marks = (crop[art.fill] | (art.fill < 0)) & (crop[art.stroke] | (art.stroke < 0))
        pen = np.where(art.stroke < 0, 0, art.pen / 2)[art.thing]
        trim, bleed = np.array([self.trim]).T, np.array([self.bleed]).T
        bleed = np.concatenate([np.minimum(trim, bleed)[:2], np.maximum(trim, bleed)[2:]])  # a broken one may be inside the trim
        left, top, right, bottom = np.where(marks[art.thing], trim, bleed)
        a, b, c, d = art.boxes.T
        kept = np.flatnonzero((a - pen < right) & (c + pen > left) & (b - pen < bottom) & (d + pen > top))
        if len(kept) == len(art):
            return art
        return replace(art, outlines=art.outlines.take(kept), area=art.area[kept], closed=art.closed[kept], thing=art.thing[kept])


def same_paper(size: Sequence[float], paper: tuple[float, float]) -> bool:
    """Whether a page of this size in mm is the paper within TRIM, upright or turned."""
    return any(max(abs(size[0] - width), abs(size[1] - height)) <= TRIM for width, height in (paper, paper[::-1]))
