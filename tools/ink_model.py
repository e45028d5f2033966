"""Write the glyph libraries src/crowquill/glyphs/nib-03.svg and disc.svg.

nib-03 is forty dots as a 0.3 mm technical pen might leave them: eggs, flattened where the ink drew
back, now and then with a tail where the pen was lifted. They are computed, not scanned, and the
files say so. disc is one circle, its area exact. The same seed gives the same bytes.

Source: the proportions follow the scanned dots of D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg,
Scale-dependent and example-based grayscale stippling, Computers & Graphics 35(1), 2011.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial import ConvexHull
from scipy.special import ndtri

Array = NDArray[np.floating[Any]]
Radius = Callable[[Array], Array]  # of direction, from x towards y

OUT = Path(__file__).resolve().parents[1] / "src" / "crowquill" / "glyphs"
PEN = 0.3  # mm
COUNT = 40
SPREAD = 0.07  # standard deviation of the diameters, as a share of PEN
RATIO = 0.82, 0.055, 0.70, 0.95  # short axis by long: mean, standard deviation, bounds
CELL = 0.6  # mm, pitch of the contact sheet
ROW = 8  # dots in a row of it
TAILS = 6  # dots with a tail
SEED = 3
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)  # exact to degree 15; second moments need 11
DISC = 2 - math.sqrt(4 - (20 / 3) * (math.pi / 4 - 0.5))  # 1/2 + 3k/5 - 3k^2/20 = pi/4
SCANNED = (
    "proportions after scanned dots of Martin, Arroyo, Luzon, Isenberg, Computers & Graphics "
    "35(1), 2011: axis ratio .76-.87, spread of diameter 5-11 %"
)
ABOUT = {
    "nib-03": (
        "Forty SIMULATED dots of a 0.3 mm technical pen: computed from an ink model, not scanned.",
        "computed by tools/ink_model.py: two discs flowing together, harmonics 3 to 5 of the "
        "radius, a side drawn back, some tails; five or six cubics each, long axis on x",
        SCANNED,
    ),
    "disc": (
        "One SIMULATED dot, a circle of 0.3 mm: computed, not scanned.",
        "computed by tools/ink_model.py: four cubics with the area of the circle",
        "none: a circle",
    ),
}


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


def blot(rng: np.random.Generator, tail: bool) -> Radius:
    """A random dot: where the nib stood, where it slid, and how the ink crept.

    Two discs flow together into an egg; harmonics 3 to 5 unsettle its edge; one side is drawn back,
    another has crept out along a fibre. A tail is a longer creep, where the pen was lifted.
    """
    size = rng.normal(0, (0.015, 0.014, 0.013))
    phase = rng.uniform(0, math.tau, 3)
    slid, slide, stood = rng.uniform(0, math.tau), rng.uniform(0.15, 0.40), rng.uniform(0.72, 0.95)
    back, depth, wide = rng.uniform(0, math.tau), rng.uniform(0.03, 0.09), rng.uniform(0.24, 0.38)
    crept = slid + rng.uniform(0.8, math.tau - 0.8)
    length = rng.uniform(0.18, 0.30) if tail else rng.uniform(0.0, 0.07)

    def radius(angle: Array) -> Array:
        e, f = slide * np.cos(angle - slid), slide * np.sin(angle - slid)
        r = (1 + (e + np.sqrt(stood**2 - f**2)) ** 12) ** (1 / 12)  # the farther edge, flowing
        r += np.cos(np.multiply.outer(angle, (3, 4, 5)) + phase) @ size
        r -= depth * np.exp((np.cos(angle - back) - 1) / wide**2)
        return np.asarray(r + length * np.exp((np.cos(angle - crept) - 1) / 0.22**2))

    return radius


def fitted(radius: Radius, count: int) -> Array:
    """The closed ring of so many smoothly joined cubics that lies nearest to a radius."""
    t = np.linspace(0, 1, 24, endpoint=False)

    def ring(knots: Array) -> Array:
        x, y, angle, before, after = knots.reshape(5, count)
        at, along = np.stack([x, y], 1), np.stack([np.cos(angle), np.sin(angle)], 1)
        heads = at + along * np.exp(after)[:, None]  # by logarithm: handles stay positive
        tails = np.roll(at - along * np.exp(before)[:, None], -1, 0)
        return np.stack([at, heads, tails], 1).reshape(-1, 2)

    def miss(knots: Array) -> Array:
        at = bezier(ring(knots), t)[0].reshape(-1, 2)
        off = np.hypot(*at.T) - radius(np.arctan2(at[:, 1], at[:, 0]))
        return np.concatenate([off, 0.02 * (knots - first)])  # knots stay spread, handles full

    step = math.tau / count
    start = np.arange(count) * step
    r, handle = radius(start), np.full(count, math.log(4 / 3 * math.tan(step / 4)))
    x, y = r * np.cos(start), r * np.sin(start)
    first = np.concatenate([x, y, start + math.pi / 2, handle, handle])
    return ring(np.asarray(least_squares(miss, first).x))


def dot(radius: Radius, ratio: float, diameter: float) -> Array:
    """The outline with this axis ratio and equivalent diameter, centroid 0, long axis on x.

    Five cubics where they meet the model's area within 0.1 %, else six; else a ValueError.
    """
    turn = np.linspace(0, math.tau, 4096, endpoint=False)
    wanted = math.pi * float(np.mean(radius(turn) ** 2))
    for count in (5, 6):
        ring = fitted(radius, count)
        area, centroid, covariance = moments(ring)
        at, speed = bezier(ring, np.linspace(0, 1, 64))
        off = np.abs(np.hypot(*at.T) - radius(np.arctan2(at[..., 1], at[..., 0])).T).max()
        onward = at[..., 0] * speed[..., 1] - at[..., 1] * speed[..., 0]  # seen from 0: no crossing
        if abs(area / wanted - 1) < 1e-3 and off < 0.008 and onward.min() > 0:
            break
    else:
        raise ValueError(f"no fit by six cubics: area {area:.4f} for {wanted:.4f}, {off:.4f} off")
    spread, axes = np.linalg.eigh(covariance)
    long = axes[:, 1] * math.copysign(1, axes[0, 1])
    turned = (ring - centroid) @ np.array([long, (-long[1], long[0])]).T
    turned *= np.sqrt([1 / (spread[1] * ratio), ratio / spread[0]])  # variances in ratio ** 2
    return np.asarray(turned * diameter / 2 * math.sqrt(math.pi / moments(turned)[0]))


def path(ring: Array, centre: Array) -> str:
    """The ring as absolute M, C, Z, in mm with five decimals."""
    pairs = [f"{x:.5f},{y:.5f}" for x, y in (ring + centre).tolist()]
    pairs.append(pairs[0])
    cubics = (" ".join(pairs[i : i + 3]) for i in range(1, len(pairs), 3))
    return f"M {pairs[0]} " + " ".join(f"C {three}" for three in cubics) + " Z"


def sheet(name: str, about: str, made: str, source: str, rings: list[Array]) -> str:
    """The library as an SVG file: a contact sheet of its glyphs, with what is known of them."""
    columns = min(ROW, len(rings))
    wide, high = CELL * columns, CELL * -(-len(rings) // columns)
    facts = {"name": name, "simulated": True, "pen_mm": PEN, "count": len(rings)}
    facts |= {"made": made, "source": source, "licence": "MIT"}
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="{wide:g}mm" height="{high:g}mm" viewBox="0 0 {wide:g} {high:g}">',
        f"<title>{escape(name)}</title>",
        f"<desc>{escape(about)}</desc>",
        f'<metadata><library xmlns="urn:crowquill:library" schema="1">{escape(json.dumps(facts, indent=2))}</library></metadata>',
        '<g fill="#000">',
    ]
    for i, ring in enumerate(rings):
        centre = CELL * (np.array([i % columns, i // columns]) + 0.5)
        lines.append(f'<path id="{name}-{i:02d}" d="{path(ring, centre)}"/>')
    return "\n".join([*lines, "</g>", "</svg>", ""])


def nib(rng: np.random.Generator) -> list[Array]:
    """The forty dots; diameters and axis ratios are quantiles of their laws, shuffled."""
    share = (np.arange(COUNT) + 0.5) / COUNT
    normal = ndtri(share)
    diameters = rng.permutation(PEN * (1 + SPREAD * normal / normal.std()))
    mean, sigma, low, high = RATIO
    ratios = rng.permutation(np.clip(mean + sigma * normal, low, high))
    tails = rng.permutation(COUNT) < TAILS
    return [dot(blot(rng, bool(t)), r, d) for t, r, d in zip(tails, ratios, diameters, strict=True)]


def report(rings: list[Array]) -> str:
    """Mean diameter, its spread, and the least, mean and greatest axis ratio and solidity."""
    table = []
    for ring in rings:
        area, _, covariance = moments(ring)
        narrow, wide = np.linalg.eigvalsh(covariance)
        hull = ConvexHull(bezier(ring, np.linspace(0, 1, 200))[0].reshape(-1, 2)).volume
        table.append((2 * math.sqrt(area / math.pi), math.sqrt(narrow / wide), area / hull))
    low, mean, high = np.min(table, 0), np.mean(table, 0), np.max(table, 0)
    spread = np.std(table, 0)[0] / mean[0]
    shape = (f"{low[i]:.3f} {mean[i]:.3f} {high[i]:.3f}" for i in (1, 2))
    return f"diameter {mean[0]:.5f} mm, spread {spread:.4f}; axis ratio {'; solidity '.join(shape)}"


def main() -> None:
    """Write both libraries, and say what their dots measure."""
    quarter = np.array([(1, 0), (1, DISC), (DISC, 1)]) * PEN / 2
    turns = [np.array([[c, s], [-s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    disc = np.concatenate([quarter @ turn for turn in turns])
    libraries = {"nib-03": nib(np.random.default_rng(SEED)), "disc": [disc]}
    for name, rings in libraries.items():
        text = sheet(name, *ABOUT[name], rings)
        (OUT / f"{name}.svg").write_text(text, encoding="utf-8", newline="\n")
        print(name, report(rings), sep=": ")


if __name__ == "__main__":
    main()
