"""Separations: a picture's colours as one tone an ink, so that dots of all inks together look like it.

What inks look like together depends on how their dots lie. Let ink i cover a share a of the paper and take d of the light where it
is. If dots lie where chance has them, inks cover each other as often as their shares say, and of the light is left the product of
all 1 - a d (Demichel's shares, Neugebauer's colours, of inks that are filters). Dots that keep clear of each other lie side by side
while there is room, and what they take adds up. In between, any two inks meet on k a b of the paper, any three on k^2 a b c, and so
on, and what is left is 1 - (1 - product of all (1 - k a d)) / k: the sum for k = 0, and the product for k = 1. What paper such
dots really leave free, by how much all inks cover together, was measured, and gives k.

Source: H. E. J. Neugebauer, Die theoretischen Grundlagen des Mehrfarbenbuchdrucks, Zeitschrift für wissenschaftliche
Photographie 36(4), 1937; k is our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from crowquill.inks import LUMINANCE, looks
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array
from crowquill.picture import encoded, linear
from crowquill.sheet import Ink
from crowquill.tone import Tone

# How much of the paper dots of several inks cover together that keep clear of each other, by the sum of what each ink covers.
# Written by tools/calibrate.py.
SUMS = np.array([0.0, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.6, 2.0])
COVERED = np.array([0.0, 0.4, 0.5978, 0.6895, 0.7719, 0.8381, 0.8891, 0.9258, 0.9581, 0.9734, 0.9832, 0.9929, 0.9998])
LEAST = 1e-3  # of k: the sum, but for rounding
GRID = 17  # colours to a side of the cube that are separated; between them coverage runs straight, and the light errs by .003
STEPS = 800  # of descent at most; three thousand change a share by .0001 on the mean
STILL = 1e-7  # of a share: a descent that moves no more is at its end
COST = 2e-3  # of ink beside the square of an error of light: errors of .001 are worth it
BLACK = (0.25, 0.65)  # of the darkest ink at most: where it comes in, and where it takes all; lighter inks side by side reach .3
ROOM = 0.6  # of the paper that dots of one ink fill before they touch: where the next ink begins when lightness alone is matched
SEEN = 200_000  # pixels on which a separation is judged
FAR = 0.1  # of the light: an error that is seen side by side
DARK = 0.1  # of the light; inks that together leave more have no dark one among them


@dataclass(frozen=True, eq=False)
class Separation:
    """What a picture asks of each ink, and how near inks can come to it.

    tones  one an ink, in their order
    error  the mean over pixels and channels of how far the light of the mixture is from that asked for, in linear light
    lost   the share of the canvas where a channel errs by more than FAR
    least  the light, in luminance, that all inks together leave
    """

    tones: tuple[Tone, ...]
    error: float
    lost: float
    least: float


def of_colour(tone: Tone, inks: Sequence[Ink], *, limit: float = 3.0, apart: bool = True, greys: bool = False) -> Separation:
    """The separation nearest to a picture's colours, in linear light: by non-negative least squares, colour by colour.

    Many mixtures look alike, from one with the least of the darkest ink to one with the most. Light ones are taken with the least,
    whose dots stand out less, dark ones with the most, whose dots lie less on each other; between them it comes in by degrees.
    A tone without colours is grey by its coverage.

    limit  of what all inks cover at one place, in sheets of paper
    apart  whether dots will keep clear of each other, or lie where chance has them
    greys  take all colours with the most of the darkest ink: greys are then that ink alone
    """
    taken = 1 - looks(inks)
    grey = encoded(1 - tone.coverage)[..., None]
    codes: Array = np.repeat(grey, 3, axis=2) if tone.rgb is None else tone.rgb / 255.0
    shares = _looked_up(_table(tuple(inks), limit, apart, greys), codes)
    least = float(mixed(np.ones((1, len(inks))), taken, apart=False)[0] @ LUMINANCE)
    return _judged(tone, shares, taken, linear(_some(tone, codes)), least, apart)


@lru_cache(maxsize=8)
def _table(inks: tuple[Ink, ...], limit: float, apart: bool, greys: bool) -> Array:
    """Shares (GRID cubed, n) of the inks for the colours of a cube of sRGB, the darkest ink by degrees."""
    nodes = np.linspace(0, 1, GRID)
    wanted = linear(np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3))
    taken = 1 - looks(inks)
    contrast = taken @ LUMINANCE
    darkest = np.arange(len(inks)) == contrast.argmax()
    most = solved(wanted, taken, np.where(darkest, 0.0, 1.0), limit=limit, apart=apart)
    if greys:
        return most
    least = solved(wanted, taken, np.where(darkest, 1.0, contrast**2), limit=limit, apart=apart)
    high, low = most[:, darkest], least[:, darkest]
    by = np.clip((high - BLACK[0]) / (BLACK[1] - BLACK[0]), 0, 1)
    held = np.minimum(low, high) + np.maximum(high - low, 0) * by**2 * (3 - 2 * by)
    return solved(wanted, taken, contrast**2, limit=limit, apart=apart, held=np.where(darkest, held, np.nan))


def of_lightness(tone: Tone, inks: Sequence[Ink], *, apart: bool = True) -> Separation:
    """The separation that gives a tone's coverage in lightness, whatever its colours: each ink, the lightest first, fills the
    room there is for dots side by side, and stays; the next goes on.

    The last, the darkest, covers all in the end, and, where that is not dark enough, the others too.
    """
    n, taken = len(inks), 1 - looks(inks) @ LUMINANCE[:, None]
    stops = np.tril(np.full((n + 2, n), ROOM), -1)
    stops[n:, -1] = stops[n + 1] = 1.0
    way = np.linspace(0, n + 1, 100 * (n + 1) + 1)
    path = np.stack([np.interp(way, np.arange(n + 2), column) for column in stops.T], axis=1)
    dark = np.maximum.accumulate(1 - mixed(path, taken, apart=apart)[:, 0])
    shares = np.stack([np.interp(tone.coverage, dark, column) for column in path.T], axis=-1)
    return _judged(tone, shares, taken, 1 - _some(tone, tone.coverage[..., None]), 1 - float(dark[-1]), apart)


def mixed(shares: Array, taken: Array, *, apart: bool = True) -> Array:
    """The light (m, c) that inks leave together which cover these shares (m, n) and each take (n, c) of the light."""
    k = meeting(shares) if apart else np.ones(len(shares))
    return np.asarray(1 - (1 - np.prod(1 - (k[:, None] * shares)[:, :, None] * taken, axis=1)) / k[:, None])


def meeting(shares: Array) -> Array:
    """How often dots meet that keep clear of each other, over chance, (m,) for shares (m, n): as leaves the paper free that they leave."""
    found = np.ones(len(shares))
    shared_out(lambda lo, hi: _meetings(shares, found, lo, hi), len(shares))
    return found


def solved(wanted: Array, taken: Array, cost: Array, *, limit: float, apart: bool, held: Array | None = None) -> Array:
    """Shares of inks (m, n), each of 0 to 1 and together within the limit, that leave the light wanted (m, c) most nearly.

    taken  (n, c) of the light by each ink; cost (n,) of each beside errors of light, which decides between mixtures that look alike
    held   (m, n) shares that are given, NaN where they are not

    By projected gradients, accelerated. Source: A. Beck, M. Teboulle, A Fast Iterative Shrinkage-Thresholding Algorithm, SIAM
    J. Imaging Sciences 2(1), 2009.
    """
    given = np.full((len(wanted), len(taken)), np.nan) if held is None else held
    low, high = np.where(np.isnan(given), 0.0, given), np.where(np.isnan(given), 1.0, given)
    shares = low.copy()
    shared_out(lambda lo, hi: _descend(wanted, taken, cost * COST, low, high, limit, apart, shares, lo, hi), len(wanted), 64)
    return shares


@compiled
def _descend(
    wanted: Array, taken: Array, cost: Array, low: Array, high: Array, limit: float, apart: bool, shares: Array, lo: int, hi: int
) -> None:
    """Shares of colours lo to hi, from those of `low` on; k stays for ten steps."""
    n, channels = taken.shape
    step = 1 / (2 * (taken**2).sum())
    now, ahead, found = np.empty(n), np.empty(n), np.empty(n)
    for m in range(lo, hi):
        now[:], ahead[:], k, pace = shares[m], shares[m], 1.0, 1.0
        for turn in range(STEPS):
            if apart and turn % 10 == 0:
                k = _meeting(ahead)
            found[:] = ahead
            for c in range(channels):
                left = 1.0
                for i in range(n):
                    left *= 1 - k * ahead[i] * taken[i, c]
                error = 1 - (1 - left) / k - wanted[m, c]
                for i in range(n):
                    found[i] += 2 * step * error * taken[i, c] * left / max(1 - k * ahead[i] * taken[i, c], 1e-9)
            _hold(found, step * cost, low[m], high[m], limit)
            faster = (1 + np.sqrt(1 + 4 * pace**2)) / 2
            moved = 0.0
            for i in range(n):
                way = found[i] - now[i]
                ahead[i] = min(max(found[i] + (pace - 1) / faster * way, low[m, i]), high[m, i])
                now[i], moved = found[i], max(moved, abs(way))
            pace = faster
            if turn % 10 == 9 and moved < STILL:
                break
        shares[m] = now


@compiled
def _hold(shares: Array, less: Array, low: Array, high: Array, limit: float) -> None:
    """Takes `less` off the shares (n,) and puts them from low to high, all less by as much as brings their sum within the limit."""
    off, most = 0.0, 1.0 + np.abs(shares).max()
    for turn in range(32):
        total = 0.0
        for i in range(len(shares)):
            total += min(max(shares[i] - less[i] - off, low[i]), high[i])
        if turn == 0 and total <= limit:
            break
        if turn == 0:
            least, off = 0.0, most / 2
        else:
            least, most = (off, most) if total > limit else (least, off)
            off = (least + most) / 2
    for i in range(len(shares)):
        shares[i] = min(max(shares[i] - less[i] - off, low[i]), high[i])


@compiled
def _meetings(shares: Array, found: Array, lo: int, hi: int) -> None:
    for m in range(lo, hi):
        found[m] = _meeting(shares[m])


@compiled
def _meeting(shares: Array) -> float:
    """k of one mixture, by halving: the more often dots meet, the more paper they leave free."""
    covered = np.interp(shares.sum(), SUMS, COVERED)
    low, high = LEAST, 1.0
    for _ in range(20):
        k, free = (low + high) / 2, 1.0
        for share in shares:
            free *= 1 - k * share
        low, high = (k, high) if (1 - free) / k > covered else (low, k)
    return high


def _looked_up(table: Array, codes: Array) -> Array:
    """Shares (h, w, n) of colours (h, w, 3), sRGB of 0 to 1, straight between those of the cube's nodes.

    Between the four nodes of a tetrahedron, whose edge is the cube's way from black to white: greys are made of greys alone.
    """
    flat, cube = codes.reshape(-1, 3), table.reshape(GRID, GRID, GRID, -1)
    shares = np.empty((len(flat), table.shape[1]))
    shared_out(lambda lo, hi: _straight(cube, flat * (GRID - 1), shares, lo, hi), len(flat))
    return np.asarray(np.clip(shares, 0, 1).reshape(*codes.shape[:2], -1))


@compiled
def _straight(cube: Array, places: Array, shares: Array, lo: int, hi: int) -> None:
    """Shares at places lo to hi, in steps of the cube: a step along each axis in turn, the longest first."""
    node, part = np.empty(3, np.int64), np.empty(3)
    for m in range(lo, hi):
        for c in range(3):
            node[c] = min(int(places[m, c]), GRID - 2)
            part[c] = places[m, c] - node[c]
        before = cube[node[0], node[1], node[2]]
        shares[m] = before
        for c in np.argsort(-part):
            node[c] += 1
            after = cube[node[0], node[1], node[2]]
            shares[m] += part[c] * (after - before)
            before = after


def _judged(tone: Tone, shares: Array, taken: Array, wanted: Array, least: float, apart: bool) -> Separation:
    """The tones of shares (h, w, n), and how far their mixture is from the light wanted at some pixels."""
    error = np.abs(mixed(_some(tone, shares), taken, apart=apart) - wanted)
    tones = tuple(replace(tone, values=part, rgb=None) for part in np.moveaxis(shares, 2, 0))
    return Separation(tones, float(error.mean()), float((error.max(axis=1) > FAR).mean()), least)


def _some(tone: Tone, values: Array) -> Array:
    """Values (h, w, c) at pixels in the canvas, SEEN of them or fewer, evenly strewn: (m, c), m over 0."""
    inside = np.flatnonzero(tone.inside.ravel() >= min(0.5, tone.inside.max()))
    kept: Array = values.reshape(-1, values.shape[2])[inside[:: 1 + len(inside) // SEEN]]
    return kept
