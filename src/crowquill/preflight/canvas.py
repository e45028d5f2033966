"""What content draws, gathered as it is run: outlines, characters, the boxes of all else; and made into Art at the end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array, Index, Paths
from crowquill.preflight import operators as op
from crowquill.preflight.colours import Space, colour
from crowquill.preflight.document import Met
from crowquill.preflight.drawing import Art, Box, Colour, Words
from crowquill.preflight.fonts import Font

BUFFER = 1 << 16  # outlines and things held before they are put aside, and 16 points to each
POINTS = 60_000_000  # of a page: 1 GB
FURTHEST = 1e5  # mm
PLAIN = (Space("DeviceGray", 1), Space("DeviceRGB", 3), Space("DeviceCMYK", 4))
INVISIBLE = (3, 7)  # ways of showing text that leave no ink
Matrix = tuple[float, ...]


class Stop(Exception):
    """The page is more than can be looked at."""


def times(a: Matrix, b: Matrix) -> Matrix:
    """The matrix that does a, and then b."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
        a[4] * b[0] + a[5] * b[2] + b[4],
        a[4] * b[1] + a[5] * b[3] + b[5],
    )


class Canvas:
    """The state of the graphics and what they leave. `now` is the state's row; see `operators`."""

    def __init__(self, met: Met, matrix: Matrix, clip: Box) -> None:
        self.met = met
        self.now = np.zeros(op.STATE)
        self.now[:6] = matrix
        self.now[op.WIDTH] = 1
        self.now[[op.FILL_ALPHA, op.STROKE_ALPHA, op.STRETCH]] = 1
        self.now[op.CLIP : op.CLIP + 4] = clip
        self.now[op.FONT] = -1
        self.stack = np.empty((op.DEEPEST, op.STATE))
        self.counts = np.zeros(op.COUNTS, np.int64)
        self._room(BUFFER)
        self._kept: list[tuple[Array, Index, Array, Array]] = []
        self._seen = 0  # points put aside
        self.own: list[tuple[Space | None, tuple[float, ...]]] = []  # colours beyond grey, RGB and CMYK
        self._own: dict[Any, int] = {}
        self.fonts: list[Font] = []
        self.extents: list[Box] = []
        self._words: dict[tuple[str, float, tuple[float, ...]], int] = {}
        self._placed: dict[tuple[int, int, tuple[float, ...]], list[Matrix]] = {}
        self.text = False
        self.at: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
        self.line: Matrix = self.at

    def _room(self, size: int) -> None:
        self._points, self._rings = np.empty((16 * size, 2)), np.empty((size, 3), np.int64)
        self._area, self._things = np.empty((size, 3)), np.empty((size, op.THING))

    def run(self, letters: npt.NDArray[np.uint8], at: int) -> int:
        """Runs plain content from `at` on; returns where the operands of an operator that is not plain begin, or the end."""
        while True:
            why, begin, _, _ = op.run(letters, at, self.now, self.stack, self.counts, self._points, self._rings, self._area, self._things)
            if why == op.ODD:
                return begin
            if why == op.END:
                if letters[begin:].tobytes().split(b"%")[0].strip(b"\0\t\n\f\r "):
                    self.met.note("content", "an end without an operator")
                return len(letters)
            self._flush()
            at = begin

    def _flush(self) -> None:
        """Puts aside what is painted; the path under way stays."""
        points, rings, things, begun = (int(self.counts[k]) for k in (op.POINTS, op.RINGS, op.THINGS, op.FIRST))
        first = int(self._rings[begun, 0]) if rings > begun else points
        if begun:
            parts = self._points[:first], self._rings[:begun], self._area[:begun, 0], self._things[:things]
            self._kept.append((parts[0].copy(), parts[1].copy(), parts[2].copy(), parts[3].copy()))
        self._seen += first
        if self._seen > POINTS:
            raise Stop(f"over {POINTS / 1e6:.0f} million points of outlines; only those were looked at")
        tail = self._points[first:points].copy(), self._rings[begun:rings].copy(), self._area[begun:rings].copy()
        if len(tail[0]) > len(self._points) // 2 or len(tail[1]) > len(self._rings) // 2:
            self._room(2 * len(self._rings))
        self._points[: len(tail[0])], self._area[: len(tail[1])] = tail[0], tail[2]
        self._rings[: len(tail[1])] = tail[1] - (first, 0, 0)
        self.counts[[op.POINTS, op.RINGS, op.THINGS, op.FIRST]] = len(tail[0]), len(tail[1]), 0, 0

    def number_of(self, of: Space | None, numbers: tuple[float, ...]) -> int:
        """The kind by which the state knows a colour of its own."""
        key = (of, numbers)
        if key not in self._own:
            self._own[key] = len(self.own) + op.OTHER
            self.own.append(key)
        return self._own[key]

    def colour(self, key: tuple[float, ...]) -> Colour:
        """The colour of a kind and four shares, as the state has them."""
        kind = int(key[0])
        if kind >= op.OTHER:
            return colour(*self.own[kind - op.OTHER])
        return colour(PLAIN[kind], tuple(key[1 : 1 + PLAIN[kind].n]))

    def filling(self) -> tuple[float, ...]:
        """The key of the colour that fills now."""
        return tuple(self.now[op.FILL : op.FILL + 5].tolist())

    def show(self, text: bytes) -> None:
        """Sets a string: dots as outlines, letters as words with a box; invisible text only moves on."""
        if self.now[op.FONT] < 0:
            self.met.note("content", "text without a font")
            return
        which = int(self.now[op.FONT])
        font = self.fonts[which]
        size, stretch, rise = (float(self.now[k]) for k in (op.SIZE, op.STRETCH, op.RISE))
        spaced, words = float(self.now[op.SPACED]), float(self.now[op.WORDS])
        key, letters, gone = self.filling(), 0, 0.0
        over = times((size * stretch, 0.0, 0.0, size, 0.0, rise), times(self.at, tuple(self.now[:6].tolist())))
        codes = font.codes(text)
        if self.now[op.MODE] in INVISIBLE:
            key = ()
        for code in codes:
            step = font.advance(code) * size + spaced + (words if code == 32 and not font.wide else 0)
            if key:
                if font.dot(code) is not None:
                    ahead = gone / size if size else 0.0
                    place = (*over[:4], over[0] * ahead + over[4], over[1] * ahead + over[5])
                    self._placed.setdefault((which, code, key), []).append(place)
                elif code != 32 or font.wide:
                    letters += 1
            gone += step
        if codes and key:
            self.met.shown.add(font.name)
        if letters:
            self._say(font, over, gone / size if size else 0.0, letters, key)
        self.forward(gone * stretch)

    def forward(self, by: float) -> None:
        """Moves on along the line."""
        a, b, c, d, e, f = self.at
        self.at = (a, b, c, d, e + a * by, f + b * by)

    def _say(self, font: Font, over: Matrix, width: float, letters: int, key: tuple[float, ...]) -> None:
        """Notes letters and the box that they take: their line from a fifth below to three quarters above."""
        size = round(float(np.hypot(over[2], over[3])), 3)
        entry = (font.name, size, key)
        self._words[entry] = self._words.get(entry, 0) + letters
        corners = np.array([(x, y) for x in (0.0, width) for y in (-0.2, 0.75)]) @ np.array([over[:2], over[2:4]]) + over[4:]
        self.extend(corners)

    def extend(self, corners: Array) -> None:
        """Notes the box of something that has no outline here, as far as the clip shows it."""
        clip = self.now[op.CLIP : op.CLIP + 4]
        box = np.concatenate([np.maximum(corners.min(axis=0), clip[:2]), np.minimum(corners.max(axis=0), clip[2:])])
        if np.isfinite(box).all() and (box[:2] <= box[2:]).all():
            self.extents.append((float(box[0]), float(box[1]), float(box[2]), float(box[3])))

    def words(self) -> Iterator[Words]:
        """Letters by font, size and colour."""
        for (name, size, key), count in self._words.items():
            yield Words(name, size, self.colour(key), count)

    def art(self) -> Art:
        """All outlines within the clip; those that lie beyond reason are left out and noted."""
        self._flush()
        lots: list[tuple[npt.NDArray[Any], ...]] = []
        for xy, rings, area, things in self._kept:
            lots.append((xy, np.diff(rings[:, 0], append=len(xy)), area, rings[:, 2], rings[:, 1] == 1, things))
        for (which, code, key), places in self._placed.items():
            lots.append(self._set(self.fonts[which].dot(code), np.array(places), key))
        first = np.cumsum([0, *(len(lot[5]) for lot in lots)])
        xy = np.concatenate([np.zeros((0, 2)), *(lot[0] for lot in lots)])
        counts, area, closed = (np.concatenate([np.zeros(0), *(lot[k] for lot in lots)]) for k in (1, 2, 4))
        thing = np.concatenate([np.zeros(0), *(lot[3] + begin for lot, begin in zip(lots, first, strict=False))])
        things = np.concatenate([np.zeros((0, op.THING)), *(lot[5] for lot in lots)])
        start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        return self._seen_through(xy, start, area, thing.astype(np.int64), closed == 1, things)

    def _set(self, paths: Paths | None, places: Array, key: tuple[float, ...]) -> tuple[npt.NDArray[Any], ...]:
        """A character set in all its places: points, points to an outline, areas, things, whether closed, and their rows."""
        assert paths is not None
        turns = places[:, 0] * places[:, 3] - places[:, 1] * places[:, 2]
        flat = paths.flat(op.FLAT / max(1e-6, float(np.sqrt(np.abs(turns).max()))))
        a, b, c, d, e, f = places.T[:, :, None]
        x, y = flat.xy.T
        self._seen += len(places) * len(x)
        if self._seen > POINTS:
            raise Stop(f"over {POINTS / 1e6:.0f} million points of outlines; only those were looked at")
        xy = np.stack([a * x + c * y + e, b * x + d * y + f], axis=2).reshape(-1, 2)
        n = len(places)
        rows = np.zeros((n, op.THING))
        rows[:, 0], rows[:, op.THING_FILL : op.THING_FILL + 5] = op.FILLS, key
        rows[:, op.THING_CLIP : op.THING_CLIP + 4] = (-FURTHEST, -FURTHEST, FURTHEST, FURTHEST)
        thing = np.repeat(np.arange(n), len(paths))
        return xy, np.tile(np.diff(flat.start), n), np.outer(turns, paths.areas).ravel(), thing, np.ones(len(thing)), rows

    def _seen_through(self, xy: Array, start: Index, area: Array, thing: Index, closed: npt.NDArray[np.bool_], things: Array) -> Art:
        """The Art of outlines and the rows of their things, without what the clip hides."""
        sound = np.asarray(np.all(np.abs(xy) < FURTHEST, axis=1))
        if len(area):
            whole: npt.NDArray[np.bool_] = np.logical_and.reduceat(sound, start[:-1])
            if not whole.all():
                self.met.note("content", "outlines that lie over 100 m off", int((~whole).sum()))
                xy = np.where(sound[:, None], xy, 0)
            low, high = (of.reduceat(xy, start[:-1], axis=0) for of in (np.minimum, np.maximum))
            pen = np.where(things[:, 0].astype(int) & op.STROKES, things[:, op.THING_PEN] / 2, 0)[thing, None]
            clip = things[thing, op.THING_CLIP :]
            seen = whole & np.all(low - pen <= clip[:, 2:], axis=1) & np.all(high + pen >= clip[:, :2], axis=1)
            if not seen.all():
                paths = Paths(xy, start).take(np.flatnonzero(seen))
                xy, start, area, thing, closed = paths.xy, paths.start, area[seen], thing[seen], closed[seen]
        how = things[:, 0].astype(np.int64)
        keys = np.concatenate([things[:, at : at + 5] for at in (op.THING_FILL, op.THING_STROKE)])
        different, index = np.unique(keys, axis=0, return_inverse=True)
        fill, stroke = np.split(index.reshape(-1).astype(np.int64), 2)
        return Art(
            Paths(xy, start),
            np.nan_to_num(area),
            closed,
            thing,
            np.where(how & op.FILLS, fill, -1),
            np.where(how & op.STROKES, stroke, -1),
            things[:, op.THING_PEN],
            (how & op.EVENODD) > 0,
            things[:, op.THING_CAP] == 1,
            things[:, op.THING_OVER : op.THING_OVER + 2] > 0,
            tuple(self.colour(tuple(row)) for row in different.tolist()),
        )
