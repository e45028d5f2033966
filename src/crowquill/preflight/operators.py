"""The plain operators of page content, run as compiled code: paths, paint, matrices, greys and process colours.

All else (fonts, forms, colour spaces, states) comes back to the caller, who is `walker`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled
from crowquill.paths import Array, Index
from crowquill.preflight.lexing import number, parts, skipped

# The graphics state is a row of numbers, so that q and Q copy it; what is no number is the index of something of the walker's.
WIDTH, CAP = 6, 7  # behind the matrix, which is 0 to 5
FILL, STROKE = 8, 13  # each a kind of colour and four shares
FILL_ALPHA, STROKE_ALPHA, FILL_OVER, STROKE_OVER = 18, 19, 20, 21
CLIP = 22  # left, top, right, bottom
FONT, SIZE, SPACED, WORDS, STRETCH, LEADING, RISE, MODE = 26, 27, 28, 29, 30, 31, 32, 33
STATE = 34  # numbers to the state
GREY, RGB, CMYK, OTHER = 0, 1, 2, 3  # kinds of colour; from OTHER on they are the walker's own
SHARES = np.array([1, 3, 4])  # numbers to each kind

# What a painting operator leaves: how it paints, its colours, the pen in mm and its cap, overprints, alphas, the clip.
FILLS, EVENODD, STROKES = 1, 2, 4
THING_FILL, THING_STROKE, THING_PEN, THING_CAP, THING_OVER, THING_ALPHA, THING_CLIP = 1, 6, 11, 12, 13, 15, 17
THING = 21

# Counts that go in and out: how much of each buffer is used, the first outline of the path under way, and what was met.
DEEP, POINTS, RINGS, THINGS, FIRST, OPERATORS, CLIPPING, FAULTS = range(8)
COUNTS = 8
DEEPEST = 1024  # states kept; PDF asks for 28
END, ODD, FULL = 0, 1, 2  # why it came back
FLAT = 0.002  # mm that a chord may stray from its curve
MOST = 64  # chords to a curve
OPERANDS = 64


def _word(text: str) -> int:
    return int(sum(ord(letter) << (8 * k) for k, letter in enumerate(text)))


M, L, C, V, Y, H, RE = (_word(text) for text in ("m", "l", "c", "v", "y", "h", "re"))
F, FCAP, FSTAR, B, BSTAR, BCLOSED, BCLOSEDSTAR = (_word(text) for text in ("f", "F", "f*", "B", "B*", "b", "b*"))
S, SCLOSED, N, W, WSTAR = (_word(text) for text in ("S", "s", "n", "W", "W*"))
Q, QEND, CM, PEN, CAPS, JOIN, MITRE, FLATNESS = (_word(text) for text in ("q", "Q", "cm", "w", "J", "j", "M", "i"))
G, GCAP, RG, RGCAP, K, KCAP = (_word(text) for text in ("g", "G", "rg", "RG", "k", "K"))


@compiled
def _curve(points: Array, counts: Index, area: Array, ring: int, x: Array, y: Array) -> None:
    """Adds a cubic in even steps to the outline, and its part of the area exactly."""
    ox, oy = area[ring, 1], area[ring, 2]
    a, b, c, d = x[0] - ox, x[1] - ox, x[2] - ox, x[3] - ox
    p, q, r, s = y[0] - oy, y[1] - oy, y[2] - oy, y[3] - oy
    area[ring, 0] += 0.3 * ((a * q - b * p) + (b * r - c * q) / 2 + (c * s - d * r))
    area[ring, 0] += 0.15 * ((a * r - c * p) + (b * s - d * q)) + 0.05 * (a * s - d * p)
    bend = max(np.hypot(a - 2 * b + c, p - 2 * q + r), np.hypot(b - 2 * c + d, q - 2 * r + s))
    steps = MOST if not bend < FLAT * MOST * MOST else max(1, int(np.ceil(np.sqrt(0.75 * bend / FLAT))))
    for k in range(1, steps + 1):
        t = k / steps
        u = 1 - t
        at = counts[POINTS]
        points[at, 0] = u * u * u * x[0] + 3 * u * u * t * x[1] + 3 * u * t * t * x[2] + t * t * t * x[3]
        points[at, 1] = u * u * u * y[0] + 3 * u * u * t * y[1] + 3 * u * t * t * y[2] + t * t * t * y[3]
        counts[POINTS] += 1


@compiled
def _begin(points: Array, rings: Index, area: Array, counts: Index, x: float, y: float) -> None:
    """Starts an outline at a point."""
    ring, at = counts[RINGS], counts[POINTS]
    rings[ring, 0], rings[ring, 1], rings[ring, 2] = at, 0, 0
    area[ring, 0], area[ring, 1], area[ring, 2] = 0.0, x, y
    points[at, 0], points[at, 1] = x, y
    counts[RINGS] += 1
    counts[POINTS] += 1


@compiled
def _line(points: Array, area: Array, counts: Index, x: float, y: float) -> None:
    ring, at = counts[RINGS] - 1, counts[POINTS]
    u, v = points[at - 1, 0] - area[ring, 1], points[at - 1, 1] - area[ring, 2]
    area[ring, 0] += (u * (y - area[ring, 2]) - (x - area[ring, 1]) * v) / 2
    points[at, 0], points[at, 1] = x, y
    counts[POINTS] += 1


@compiled
def _close(rings: Index, counts: Index) -> None:
    """Closes the outline under way; what follows without a move begins where it began."""
    ring = counts[RINGS] - 1
    if not rings[ring, 1]:
        rings[ring, 1] = 1


@compiled
def _clip(now: Array, points: Array, counts: Index, first: int) -> None:
    """Narrows the clip to the box around the path under way."""
    if counts[POINTS] == first:
        return
    low, high = now[CLIP : CLIP + 2], now[CLIP + 2 : CLIP + 4]
    for axis in range(2):
        part = points[first : counts[POINTS], axis]
        low[axis], high[axis] = max(low[axis], part.min()), min(high[axis], part.max())


@compiled
def _paint(now: Array, things: Array, rings: Index, counts: Index, how: int) -> None:
    """Makes a thing of the path under way."""
    thing = counts[THINGS]
    row = things[thing]
    row[0] = how
    row[THING_FILL : THING_FILL + 10] = now[FILL : FILL + 10]
    a, b, c, d = now[0], now[1], now[2], now[3]
    half, det = (a * a + b * b + c * c + d * d) / 2, a * d - b * c
    row[THING_PEN] = abs(now[WIDTH]) * np.sqrt(max(0.0, half - np.sqrt(max(0.0, half * half - det * det))))  # the narrower way
    row[THING_CAP] = now[CAP]
    row[THING_OVER : THING_OVER + 2] = now[FILL_OVER : FILL_OVER + 2]
    row[THING_ALPHA : THING_ALPHA + 2] = now[FILL_ALPHA : FILL_ALPHA + 2]
    row[THING_CLIP : THING_CLIP + 4] = now[CLIP : CLIP + 4]
    for ring in range(counts[FIRST], counts[RINGS]):
        rings[ring, 2] = thing
    counts[THINGS] += 1
    counts[FIRST] = counts[RINGS]


@compiled
def run(
    code: npt.NDArray[np.uint8],
    at: int,
    now: Array,
    stack: Array,
    counts: Index,
    points: Array,
    rings: Index,
    area: Array,
    things: Array,
) -> tuple[int, int, int, int]:
    """Runs content from `at` on until its end, an operator that is none of ours, or a full buffer.

    now (STATE,), stack (DEEPEST, STATE), counts (COUNTS,): the state, those kept, what is used; points (p, 2) mm; rings (r, 3):
    an outline's first point, whether closed, its thing; area (r, 3): its area in mm^2, and its first point; things (t, THING).
    Returns why it stopped, where the operands begin, and where the operator begins and ends.
    """
    numbers, x, y = np.zeros(OPERANDS), np.zeros(4), np.zeros(4)
    n, plain, begin = 0, True, at
    while at < len(code):
        letter = code[at]
        if letter <= 32 or letter == 37:
            at = skipped(code, at)
            continue
        if 48 <= letter <= 57 or letter in (43, 45, 46):
            value, at = number(code, at)
            if n == OPERANDS:
                plain = False
            else:
                numbers[n] = value
                n += 1
            continue
        if parts(letter):
            plain = False
            at = skipped(code, at)
            continue
        end = at
        while end < len(code) and not parts(code[end]):
            end += 1
        word = 0
        for k in range(min(end - at, 7)):
            word |= int(code[at + k]) << (8 * k)
        if min(len(points) - counts[POINTS] - MOST, len(rings) - counts[RINGS], len(things) - counts[THINGS]) < 5:
            return FULL, begin, at, end
        known = plain and _state(word, numbers[:n], now, stack, counts)
        if not known and plain:
            known = _path(word, numbers[:n], now, counts, points, rings, area, things, x, y)
        if not known:
            return ODD, begin, at, end
        counts[OPERATORS] += 1
        n, plain, at = 0, True, end
        begin = at
    return END, begin, at, at


@compiled
def _state(word: int, numbers: Array, now: Array, stack: Array, counts: Index) -> bool:
    """Runs an operator that changes the state alone; False for others and for those that want operands."""
    n = len(numbers)
    if word == Q:
        if counts[DEEP] < len(stack):
            stack[counts[DEEP]] = now
        else:
            counts[FAULTS] += 1
        counts[DEEP] += 1
    elif word == QEND:
        if counts[DEEP] > 0:
            counts[DEEP] -= 1
            if counts[DEEP] < len(stack):
                now[:] = stack[counts[DEEP]]
        else:
            counts[FAULTS] += 1
    elif word == CM and n == 6:
        a, b, c, d, e, f = now[0], now[1], now[2], now[3], now[4], now[5]
        for k in range(0, 6, 2):
            p, q = numbers[k], numbers[k + 1]
            now[k], now[k + 1] = p * a + q * c, p * b + q * d
        now[4] += e
        now[5] += f
    elif word == PEN and n == 1:
        now[WIDTH] = numbers[0]
    elif word == CAPS and n == 1:
        now[CAP] = numbers[0]
    elif word in (JOIN, MITRE, FLATNESS) and n == 1:
        pass
    elif word in (G, GCAP) and n == 1:
        _coloured(now, FILL if word == G else STROKE, GREY, numbers)
    elif word in (RG, RGCAP) and n == 3:
        _coloured(now, FILL if word == RG else STROKE, RGB, numbers)
    elif word in (K, KCAP) and n == 4:
        _coloured(now, FILL if word == K else STROKE, CMYK, numbers)
    else:
        return False
    return True


@compiled
def _coloured(now: Array, where: int, kind: int, numbers: Array) -> None:
    now[where : where + 5] = 0
    now[where] = kind
    now[where + 1 : where + 1 + len(numbers)] = numbers


@compiled
def _path(
    word: int, numbers: Array, now: Array, counts: Index, points: Array, rings: Index, area: Array, things: Array, x: Array, y: Array
) -> bool:
    """Runs an operator of paths; False for others and for those that want operands or a path to go on with."""
    n = len(numbers)
    under_way = counts[RINGS] > counts[FIRST]
    for k in range(n // 2 if word != RE else 0):
        if k < 3:
            x[k + 1] = now[0] * numbers[2 * k] + now[2] * numbers[2 * k + 1] + now[4]
            y[k + 1] = now[1] * numbers[2 * k] + now[3] * numbers[2 * k + 1] + now[5]
    if word == M and n == 2:
        _begin(points, rings, area, counts, x[1], y[1])
    elif word in (L, C, V, Y) and under_way:
        if n != (2 if word == L else 6 if word == C else 4):
            return False
        if rings[counts[RINGS] - 1, 1]:
            _begin(points, rings, area, counts, area[counts[RINGS] - 1, 1], area[counts[RINGS] - 1, 2])
        if word == L:
            _line(points, area, counts, x[1], y[1])
            return True
        x[0], y[0] = points[counts[POINTS] - 1]
        if word == V:
            x[3], y[3], x[2], y[2], x[1], y[1] = x[2], y[2], x[1], y[1], x[0], y[0]
        elif word == Y:
            x[3], y[3] = x[2], y[2]
        _curve(points, counts, area, counts[RINGS] - 1, x, y)
    elif word == H and n == 0:
        if under_way:
            _close(rings, counts)
    elif word == RE and n == 4:
        left, top, width, height = numbers
        for k in range(4):
            u, v = left + (width if k in (1, 2) else 0), top + (height if k > 1 else 0)
            p, q = now[0] * u + now[2] * v + now[4], now[1] * u + now[3] * v + now[5]
            if k == 0:
                _begin(points, rings, area, counts, p, q)
            else:
                _line(points, area, counts, p, q)
        _close(rings, counts)
    elif word in (W, WSTAR) and n == 0:
        counts[CLIPPING] = 1
    elif n == 0:
        return _painted(word, now, counts, points, rings, things)
    else:
        return False
    return True


@compiled
def _painted(word: int, now: Array, counts: Index, points: Array, rings: Index, things: Array) -> bool:
    """Runs an operator that ends a path; False for others."""
    how = 0
    if word in (F, FCAP, B, BCLOSED):
        how = FILLS
    elif word in (FSTAR, BSTAR, BCLOSEDSTAR):
        how = FILLS | EVENODD
    elif word not in (S, SCLOSED, N):
        return False
    if word in (B, BSTAR, BCLOSED, BCLOSEDSTAR, S, SCLOSED):
        how |= STROKES
    under_way = counts[RINGS] > counts[FIRST]
    first = rings[counts[FIRST], 0] if under_way else counts[POINTS]
    if word in (BCLOSED, BCLOSEDSTAR, SCLOSED) and under_way:
        _close(rings, counts)
    if how and under_way:
        _paint(now, things, rings, counts, how)
    if counts[CLIPPING]:
        _clip(now, points, counts, first)
        counts[CLIPPING] = 0
    if not how and under_way:
        counts[POINTS], counts[RINGS] = first, counts[FIRST]
    return True
