"""Separations: a picture's colours as one tone an ink, so that dots of all inks together look like it.

What inks look like together depends on how their dots lie. Let ink i cover a share a of the paper and take d of the light where it
is. If dots lie where chance has them, inks cover each other as often as their shares say, and of the light is left the product of
all 1 - a d (Demichel's shares, Neugebauer's colours, of inks that are filters). Dots that keep clear of each other lie side by side
while there is room, and what they take adds up. In between, any two inks meet on k a b of the paper, any three on k^2 a b c, and so
on, and what is left is 1 - (1 - product of all (1 - k a d)) / k: the sum for k = 0, and the product for k = 1. What paper such
dots really leave free, by how much all inks cover together, was measured, and gives k.

Source: H. E. J. Neugebauer, Die theoretischen Grundlagen des Mehrfarbendrucks, 1937; the rest is our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import map_coordinates

from crowquill.inks import LUMINANCE, looks
from crowquill.paths import Array
from crowquill.picture import encoded, linear
from crowquill.sheet import Ink
from crowquill.tone import Tone

# How much of the paper dots of several inks cover together that keep clear of each other, by the sum of what each ink covers.
# Written by tools/calibrate.py.
SUMS = np.array([0.0, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.6, 2.0])
COVERED = np.array([0.0, 0.3987, 0.5921, 0.6786, 0.7589, 0.8226, 0.8738, 0.9169, 0.9501, 0.9672, 0.979, 0.9911, 0.9997])
LEAST = 1e-3  # of k: the sum, but for rounding
GRID = 17  # colours to a side of the cube that are separated; between them coverage runs straight, and the light errs by .004
STEPS = 400  # of descent; the grey axis stands still after 300
COST = 2e-3  # of ink beside the square of an error of light: errors of .001 are worth it
MEETING = 0.3  # of that, for ink on ink; with .6 skin had black dots, with .15 black began in tones of .3
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

    Of mixtures that look alike it takes the one whose dots stand out least and lie least on each other: black comes in only where
    lighter inks would have to meet. A tone without colours is grey by its coverage.

    limit  of what all inks cover at one place, in sheets of paper
    apart  whether dots will keep clear of each other, or lie where chance has them
    greys  let the darkest ink, of mixtures that look alike, take all that it can: greys are then that ink alone
    """
    taken = 1 - looks(inks)
    contrast = taken @ LUMINANCE
    cost = np.where(np.arange(len(inks)) == contrast.argmax(), 0.0, 1.0) if greys else contrast**2
    nodes = np.linspace(0, 1, GRID)
    cube = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    table = solved(linear(cube), taken, cost, limit=limit, apart=apart)
    grey = encoded(1 - tone.coverage)[..., None]
    codes: Array = np.repeat(grey, 3, axis=2) if tone.rgb is None else tone.rgb / 255.0
    shares = _looked_up(table, codes)
    least = float(mixed(np.ones((1, len(inks))), taken, apart=False)[0] @ LUMINANCE)
    return _judged(tone, shares, taken, linear(_some(tone, codes)), least, apart)


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
    free = 1 - np.interp(shares.sum(axis=1), SUMS, COVERED)
    low, high = np.full(len(shares), LEAST), np.ones(len(shares))
    for _ in range(20):
        middle = (low + high) / 2
        more = 1 - (1 - np.prod(1 - middle[:, None] * shares, axis=1)) / middle < free
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return high


def solved(wanted: Array, taken: Array, cost: Array, *, limit: float, apart: bool) -> Array:
    """Shares of inks (m, n), each of 0 to 1 and together within the limit, that leave the light wanted (m, c) most nearly.

    taken  (n, c) of the light by each ink; cost (n,) of each beside errors of light. By projected gradients, accelerated.
    Source: A. Beck, M. Teboulle, A Fast Iterative Shrinkage-Thresholding Algorithm, SIAM J. Imaging Sciences 2(1), 2009.
    """
    middles, sides = (SUMS[:-1] + SUMS[1:]) / 2, np.diff(COVERED) / np.diff(SUMS)
    step = 1 / (2 * (taken**2).sum())
    shares = ahead = np.zeros((len(wanted), len(taken)))
    k, pace = np.ones(len(wanted)), 1.0
    for turn in range(STEPS):
        if turn % 10 == 0 and apart:
            k = meeting(ahead)
        left = 1 - (k[:, None] * ahead)[:, :, None] * taken
        every = np.prod(left, axis=1)
        error = 1 - (1 - every) / k[:, None] - wanted
        slope = -taken * every[:, None, :] / np.maximum(left, 1e-9)
        more = np.interp(ahead.sum(axis=1), middles, sides, left=1, right=0)
        price = COST * (cost + MEETING * (1 - more[:, None] if apart else 0.0))
        found = _held(ahead - step * (2 * (error[:, None, :] * slope).sum(axis=2) + price), limit)
        faster = (1 + np.sqrt(1 + 4 * pace**2)) / 2
        ahead = np.clip(found + (pace - 1) / faster * (found - shares), 0, 1)
        shares, pace = found, faster
    return shares


def _held(shares: Array, limit: float) -> Array:
    """The nearest shares of 0 to 1 whose sum is within the limit."""
    held = np.clip(shares, 0, 1)
    over = np.flatnonzero(held.sum(axis=1) > limit)
    low, high = np.zeros(len(over)), np.ones(len(over))
    for _ in range(30 if len(over) else 0):
        middle = (low + high) / 2
        more = np.clip(shares[over] - middle[:, None], 0, 1).sum(axis=1) > limit
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    held[over] = np.clip(shares[over] - high[:, None], 0, 1)
    return held


def _looked_up(table: Array, codes: Array) -> Array:
    """Shares (h, w, n) of colours (h, w, 3), sRGB of 0 to 1, straight between those of the cube's nodes."""
    at = codes.reshape(-1, 3).T * (GRID - 1)
    found = [map_coordinates(column.reshape(GRID, GRID, GRID), at, order=1, mode="nearest") for column in table.T]
    shares: Array = np.clip(np.stack(found, axis=1), 0, 1).reshape(*codes.shape[:2], -1)
    return shares


def _judged(tone: Tone, shares: Array, taken: Array, wanted: Array, least: float, apart: bool) -> Separation:
    """The tones of shares (h, w, n), and how far their mixture is from the light wanted at some pixels."""
    error = np.abs(mixed(_some(tone, shares), taken, apart=apart) - wanted)
    tones = tuple(replace(tone, coverage=part, rgb=None) for part in np.moveaxis(shares, 2, 0))
    return Separation(tones, float(error.mean()), float((error.max(axis=1) > FAR).mean()), least)


def _some(tone: Tone, values: Array) -> Array:
    """Values (h, w, c) at pixels in the canvas, SEEN of them or fewer, evenly strewn: (m, c), m over 0."""
    inside = np.flatnonzero(tone.inside.ravel() >= min(0.5, tone.inside.max()))
    kept: Array = values.reshape(-1, values.shape[2])[inside[:: 1 + len(inside) // SEEN]]
    return kept
