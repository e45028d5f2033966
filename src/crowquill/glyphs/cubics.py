"""Few cubics that follow a closed contour: the fewest that stay within a bound of it."""

from __future__ import annotations

import numpy as np

from crowquill.glyphs.outline import arc, moments
from crowquill.kernel import compiled
from crowquill.paths import Array

EVEN = 160  # points of a contour that are fitted
SAMPLES = 16  # on a cubic, to measure from: their chords lie 0.005 pixels off a dot of 14
PHASES = (0.0, 0.5, 0.25, 0.75)  # of the way between knots: where the first one falls
MORE = (*PHASES, 0.125, 0.625, 0.375, 0.875)  # before it is given up
TURNS = np.fft.fftfreq(EVEN, 1 / EVEN)
LOW = np.exp(-((TURNS / 12) ** 2))


def fitted(contour: Array, bound: float) -> tuple[Array, float]:
    """A closed ring of 5 to 8 smoothly joined cubics (3k points) near a closed contour, of its area; and how far off it is.

    The fewest cubics that stay within so many pixels, or else the nearest eight or fewer.
    """
    points, dense = _evenly(contour)
    area = moments(contour)[0]
    best, nearest = np.empty((0, 2)), np.inf
    for count in range(5, 9):
        for phase in PHASES if count < 8 else MORE:
            knots = np.interp((np.arange(count) + phase) / count, dense, np.arange(EVEN + 1) / EVEN)
            ring, off = _least_squares(points, knots)
            if off > bound and off > nearest:  # off, of the fitted points alone, is cheap and below the stray
                continue
            _to_area(ring, area)
            stray = _stray(_samples(ring), contour)
            if stray <= bound:
                return ring, stray
            if stray < nearest:
                best, nearest = ring, stray
    return best, nearest


def _evenly(contour: Array) -> tuple[Array, Array]:
    """EVEN points evenly round a contour, and the share of knots due up to each of them: more where it bends."""
    length = arc(contour)
    even = np.arange(EVEN) / EVEN * length[-1]
    points = np.stack([np.interp(even, length, np.append(side, side[0])) for side in contour.T], axis=1)
    wave = np.fft.fft(points @ (1, 1j)) * LOW  # the pixels' steps are no bends
    first, second = np.fft.ifft(1j * TURNS * wave), np.fft.ifft(-(TURNS**2) * wave)
    bend = np.abs((first.conj() * second).imag) / np.maximum(np.abs(first), 1e-9) ** 2
    dense = np.concatenate([[0.0], np.cumsum(np.sqrt(bend + bend.mean()))])
    return points, dense / dense[-1]


@compiled
def _least_squares(points: Array, knots: Array) -> tuple[Array, float]:
    """The closed ring of cubics near evenly spaced points, its pieces parted at these shares of the way round; the furthest point.

    Points and velocities at the knots are the unknowns; each point's share is moved towards its nearest on the curve, in turn.
    """
    n, count = len(points), len(knots)
    width = np.empty(count)
    for k in range(count):
        width[k] = (knots[(k + 1) % count] - knots[k]) % 1
    at = np.empty(n)
    for i in range(n):
        share, piece = (i / n - knots[0]) % 1, 0
        while piece < count - 1 and share >= width[piece]:
            share -= width[piece]
            piece += 1
        at[i] = piece + min(share / width[piece], 0.999999)
    matrix, found = np.empty((2 * count, 2 * count)), np.empty((2 * count, 2))
    ring = np.empty((3 * count, 2))
    furthest = 0.0
    for _ in range(6):
        matrix[:] = 0
        found[:] = 0
        for i in range(n):
            piece = int(at[i]) % count
            after, t = (piece + 1) % count, at[i] - int(at[i])
            s, w = 1 - t, width[piece]
            where = (piece, after, count + piece, count + after)
            share = ((1 + 2 * t) * s * s, t * t * (3 - 2 * t), t * s * s * w, -t * t * s * w)
            for a in range(4):
                for b in range(4):
                    matrix[where[a], where[b]] += share[a] * share[b]
                for side in range(2):
                    found[where[a], side] += share[a] * points[i, side]
        _solve(matrix, found)
        for k in range(count):
            after = (k + 1) % count
            for side in range(2):
                ring[3 * k, side] = found[k, side]
                ring[3 * k + 1, side] = found[k, side] + found[count + k, side] * width[k] / 3
                ring[3 * k + 2, side] = found[after, side] - found[count + after, side] * width[k] / 3
        furthest = 0.0
        for i in range(n):
            at[i], away = _nearer(ring, points[i, 0], points[i, 1], at[i])
            furthest = max(furthest, away)
    return ring, np.sqrt(furthest)


@compiled
def _solve(matrix: Array, found: Array) -> None:
    """Solves a symmetric, positive system in place (Cholesky)."""
    n = len(matrix)
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            if i == j:
                matrix[i, i] = np.sqrt(max(total, 1e-12))  # a piece that has lost its points stays where it was
            else:
                matrix[i, j] = total / matrix[j, j]
    for side in range(found.shape[1]):
        for i in range(n):
            for k in range(i):
                found[i, side] -= matrix[i, k] * found[k, side]
            found[i, side] /= matrix[i, i]
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                found[i, side] -= matrix[k, i] * found[k, side]
            found[i, side] /= matrix[i, i]


@compiled
def _nearer(ring: Array, x: float, y: float, at: float) -> tuple[float, float]:
    """A place on a closed cubic ring nearer to a point than this one (one step of Newton's); the square of this one's distance."""
    count = len(ring) // 3
    piece, t = int(at) % count, at - int(at)
    s, k = 1 - t, 3 * piece
    d = (k + 3) % len(ring)
    away = slope = bend = square = climb = turn = 0.0
    for side in range(2):
        p0, p1, p2, p3 = ring[k, side], ring[k + 1, side], ring[k + 2, side], ring[d, side]
        away = s * s * s * p0 + 3 * s * s * t * p1 + 3 * s * t * t * p2 + t * t * t * p3 - (y if side else x)
        slope = 3 * (s * s * (p1 - p0) + 2 * s * t * (p2 - p1) + t * t * (p3 - p2))
        bend = 6 * (s * (p2 - 2 * p1 + p0) + t * (p3 - 2 * p2 + p1))
        square += away * away
        climb += away * slope
        turn += slope * slope + away * bend
    step = climb / turn if turn > 0 else 0.0
    return (at - min(max(step, -0.25), 0.25)) % count, square


@compiled
def _samples(ring: Array) -> Array:
    """SAMPLES points on each cubic of a closed ring."""
    count = len(ring) // 3
    found = np.empty((count * SAMPLES, 2))
    for k in range(count):
        for i in range(SAMPLES):
            t = i / SAMPLES
            s = 1 - t
            for side in range(2):
                a, b, c, d = ring[3 * k, side], ring[3 * k + 1, side], ring[3 * k + 2, side], ring[(3 * k + 3) % len(ring), side]
                found[k * SAMPLES + i, side] = s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d
    return found


@compiled
def _to_area(ring: Array, area: float) -> None:
    """Scales a closed cubic ring about its middle to an area."""
    x = y = have = 0.0
    for k in range(len(ring)):
        x += ring[k, 0] / len(ring)
        y += ring[k, 1] / len(ring)
    for k in range(0, len(ring), 3):
        for i, j, weight in ((0, 1, 6), (0, 2, 3), (0, 3, 1), (1, 2, 3), (1, 3, 3), (2, 3, 6)):
            a, b = k + i, (k + j) % len(ring)
            have += weight / 20 * ((ring[a, 0] - x) * (ring[b, 1] - y) - (ring[b, 0] - x) * (ring[a, 1] - y))
    scale = np.sqrt(area / have) if have > 0 else 1.0
    for k in range(len(ring)):
        ring[k, 0] = x + (ring[k, 0] - x) * scale
        ring[k, 1] = y + (ring[k, 1] - y) * scale


@compiled
def _stray(curve: Array, contour: Array) -> float:
    """The greatest distance of the points of either of two closed rings from the other's straight sides."""
    return max(_furthest(curve, contour), _furthest(contour, curve))


@compiled
def _furthest(points: Array, ring: Array) -> float:
    """The greatest distance of points from a ring of straight sides."""
    worst = 0.0
    for i in range(len(points)):
        x, y = points[i]
        best = np.inf
        for k in range(len(ring)):
            u, v = ring[k, 0] - ring[k - 1, 0], ring[k, 1] - ring[k - 1, 1]
            a, b = x - ring[k - 1, 0], y - ring[k - 1, 1]
            share = min(max((a * u + b * v) / max(u * u + v * v, 1e-18), 0.0), 1.0)
            a, b = a - share * u, b - share * v
            best = min(best, a * a + b * b)
            if best <= worst:
                break
        worst = max(worst, best)
    return float(np.sqrt(worst))
