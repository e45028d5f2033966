"""Write the glyph libraries src/crowquill/glyphs/nib-03.svg and disc.svg.

nib-03 is forty dots as a 0.3 mm technical pen might leave them: eggs with a flattened side, a dent
where the ink drew back, now and then a tail where the pen was lifted. They are computed, not scanned,
and the files say so. disc is one exact circle. The same seed gives the same bytes.

Source: the proportions follow the scanned dots of D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg,
Scale-dependent and example-based grayscale stippling, Computers & Graphics 35(1), 2011.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial import ConvexHull
from scipy.special import ndtri

Array = NDArray[np.float64]

OUT = Path(__file__).resolve().parents[1] / "src" / "crowquill" / "glyphs"
PEN = 0.3  # mm
COUNT = 40
SPREAD = 0.07  # standard deviation of the diameters, as a share of PEN
RATIO = 0.82, 0.055, 0.70, 0.95  # short axis by long: mean, standard deviation, bounds
CELL = 0.6  # mm, pitch of the contact sheet
ROW = 8  # dots in a row of it
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)  # exact to degree 15; second moments need 11
DISC = 2 - math.sqrt(4 - (20 / 3) * (math.pi / 4 - 0.5))  # 1/2 + 3k/5 - 3k^2/20 = pi/4
SCANNED = (
    "proportions follow scanned dots of Martin, Arroyo, Luzon, Isenberg, Computers & Graphics 35(1), "
    "2011: axis ratio .76-.87, spread of diameter 5-11 %"
)


def bezier(ring: Array, t: Array) -> tuple[Array, Array]:
    """Points and derivatives (k, len(t), 2) of a closed ring of k cubics, 3k points."""
    a, b, c = ring[0::3, None], ring[1::3, None], ring[2::3, None]
    d = np.roll(a, -1, 0)
    u = t[:, None]
    v = 1 - u
    at = a * v**3 + 3 * b * u * v**2 + 3 * c * u**2 * v + d * u**3
    return at, 3 * ((b - a) * v**2 + 2 * (c - b) * u * v + (d - c) * u**2)


def moments(ring: Array) -> tuple[float, Array, Array]:
    """Area, centroid and covariance inside the ring, exact: Green's theorem, Gauss nodes."""
    at, speed = bezier(ring, (NODES + 1) / 2)
    x, y = at[..., 0], at[..., 1]
    dy, dx = speed[..., 1] * WEIGHTS / 2, speed[..., 0] * WEIGHTS / 2
    area = float(np.sum(x * dy - y * dx)) / 2
    centroid = np.array([np.sum(x * x * dy), -np.sum(y * y * dx)]) / (2 * area)
    xx, yy, xy = np.sum(x**3 * dy) / 3, -np.sum(y**3 * dx) / 3, np.sum(x * x * y * dy) / 2
    return area, centroid, np.array([[xx, xy], [xy, yy]]) / area - np.outer(centroid, centroid)


def blot(rng: np.random.Generator, tail: bool) -> Callable[[Array], Array]:
    """A random dot as radius of direction, about 1: harmonics 3 to 5, a flat side, a dent, a tail."""
    size = rng.normal(0, (0.032, 0.016, 0.009))
    phase, (flat, dent, lift) = rng.uniform(0, math.tau, 3), rng.uniform(0, math.tau, 3)
    chord = rng.uniform(0.84, 1.0)
    depth, width = rng.uniform(0.02, 0.085), rng.uniform(0.32, 0.5)
    length = rng.uniform(0.10, 0.20) if tail else 0.0

    def radius(angle: Array) -> Array:
        r = 1 + np.cos(np.multiply.outer(angle, (3, 4, 5)) + phase) @ size
        r -= depth * np.exp((np.cos(angle - dent) - 1) / width**2)
        side = np.maximum(np.cos(angle - flat), 1e-9) / chord  # 1 / r of a straight side
        r = (r**-14 + side**14) ** (-1 / 14)  # the nearer of the two, rounded at the corners
        return np.asarray(r + length * np.exp((np.cos(angle - lift) - 1) / 0.3**2))

    return radius


def fitted(radius: Callable[[Array], Array], count: int) -> Array:
    """The closed ring of so many smoothly joined cubics that lies nearest to a radius of direction."""
    t = np.linspace(0, 1, 24, endpoint=False)

    def ring(knots: Array) -> Array:
        x, y, angle, before, after = knots.reshape(5, count)
        at, along = np.stack([x, y], 1), np.stack([np.cos(angle), np.sin(angle)], 1)
        heads = at + along * after[:, None]
        tails = np.roll(at - along * before[:, None], -1, 0)
        return np.stack([at, heads, tails], 1).reshape(-1, 2)

    def miss(knots: Array) -> Array:
        at = bezier(ring(knots), t)[0].reshape(-1, 2)
        return np.asarray(np.hypot(*at.T) - radius(np.arctan2(at[:, 1], at[:, 0])))

    step = math.tau / count
    start = np.arange(count) * step
    r, handle = radius(start), np.full(count, 4 / 3 * math.tan(step / 4))
    first = np.concatenate([r * np.cos(start), r * np.sin(start), start + math.pi / 2, handle, handle])
    return ring(least_squares(miss, first).x)


def dot(radius: Callable[[Array], Array], ratio: float, diameter: float) -> Array:
    """The outline with this axis ratio and equivalent diameter, centroid 0, long axis on x."""
    ring = min((fitted(radius, n) for n in (5, 6)), key=lambda ring: 0)
    return ring
