"""Write the glyph libraries src/crowquill/glyphs/nib-*.svg, brush.svg and disc.svg; those named, or all.

The dots of nibs and brush are SIMULATED: an ink model draws them, a scan sheet is rendered with paper's fibres and grain and a
scanner's blur, noise and uneven light, and crowquill.glyphs.scanning makes the library of it, as of any scan. The sheets
are not kept. disc is one circle, its area exact, and was not scanned. The same seed gives the same bytes.

A dot is a disc, longer than wide, with a blunter end, flat or drawn back where ink dried first, now and then with a tail where
the pen was lifted. Its rim has teeth along fibres, finer than a pixel: they, the soft edge and the noise are what makes the
masks of scanned dots as ragged as the source found them; outlines run through their middle. At 1200 dpi those of 0.5 mm take
seven cubics and more; such are scanned at 800, as many pixels as one of 0.33.

Source: the proportions follow the scanned dots of D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and
example-based grayscale stippling, Computers & Graphics 35(1), 2011; its solidity is of masks of pixels at 1200 dpi.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree
from scipy.special import ndtri

from crowquill.glyphs.scanning import Scan, library, scan
from crowquill.paths import Paths
from crowquill.picture import encoded
from crowquill.units import INCH

Array = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

OUT = Path(__file__).resolve().parents[1] / "src" / "crowquill" / "glyphs"
SOURCE = (
    "proportions after scanned dots of Martin, Arroyo, Luzon, Isenberg, Computers & Graphics "
    "35(1), 2011: axis ratio .76-.87, spread of diameter 5-11 %, solidity .89-.93"
)
MADE = "SIMULATED: sheet rendered by tools/ink_model.py, scanned by crowquill.glyphs.scanning at {dpi:g} dpi"

SEED = 1
DOTS = {"": 2, "f": 4, "ff": 3, "b": 12, "fb": 13, "t": 3, "ft": 3}  # of a nib; each letter a flat (f), drawn back (b) or tail (t)
SPREAD, WIDEST = 0.065, 0.13  # of a nib's diameters: standard deviation and most, as shares of the pen
RATIO = 0.81, 0.055, 0.67, 0.94  # short axis by long: mean, standard deviation, bounds
POINTS = 1440  # round a dot: a twentieth of a pixel apart
INK = 0.62, 0.02  # light taken by full ink: mean, standard deviation between dots
FEATHER = 0.2  # of a pen, from paper to full ink, a third more or less by the side of the dot
TEETH = 0.045  # of a pen (rms): more ink creeps further
FIBRE = 0.006  # mm, of the Gaussian that leaves teeth of 10 to 25 um

FINE = 4  # places to a pixel, each way
ROW = 8  # dots in a row of a sheet
BLUR, NOISE = 0.8, 0.02  # of the scanner: pixels, code values
GRAIN = 0.03, 0.6  # of the paper: share of its light (rms), pixels
LAMP = 0.12  # of the light is lost on the right of the sheet, half as much at the bottom


@dataclass(frozen=True)
class Pen:
    """A technical pen, or a brush pen's mean dot: its width in mm, its scan's resolution, its rim's roughness beside a nib's."""

    mm: float
    dpi: float = 1200
    rough: float = 1.0


PENS = {"nib-02": Pen(0.2, rough=1.15), "nib-025": Pen(0.25), "nib-03": Pen(0.3), "nib-035": Pen(0.35), "nib-05": Pen(0.5, 800, 0.97)}
BRUSH = Pen(0.5, 800, 0.3)


def pen_dot(rng: np.random.Generator, kinds: str, mm: float) -> Complex:
    """Points x + iy round a disc of radius about 1, blunter on one side; flat (f), drawn back (b) or drawn out (t) for each letter."""
    angle = np.arange(POINTS) * math.tau / POINTS
    inverse = np.ones(POINTS)
    factor = 1 + sum(rng.normal(0, 0.02 / n) * np.cos(n * (angle - rng.uniform(0, math.tau))) for n in (2, 3, 4))
    first = rng.uniform(0, math.tau)
    for k, kind in enumerate(kinds):
        off = angle - first - math.tau * (k + rng.uniform(-0.22, 0.22)) / len(kinds)
        if kind == "f":  # a line; its ends are as round in mm on any dot, the rounder the lower the power
            power = rng.uniform(1.8, 3.8) / mm
            inverse = (inverse**power + (np.maximum(np.cos(off), 0) / rng.uniform(0.7, 0.88)) ** power) ** (1 / power)
            continue
        wide = rng.uniform(0.55, 0.8) if kind == "b" else rng.uniform(0.2, 0.3)
        high = -rng.uniform(0.52, 0.74) * mm**0.35 if kind == "b" else rng.uniform(0.2, 0.42)
        factor = factor * (1 + high * np.exp(-((np.angle(np.exp(1j * off)) / wide) ** 2)))
    ring = factor / inverse * np.exp(1j * angle)
    return np.asarray(ring.real + 1j * ring.imag * (1 + rng.uniform(0.05, 0.22) * ring.real))


def brush_dot(rng: np.random.Generator, kind: str) -> Complex:
    """A drop (d) with a point, a comma (c) whose point is bent, or a dab (f) of flats."""
    if kind == "f":
        return pen_dot(rng, str(rng.choice(["f", "ff", "fff"])), BRUSH.mm)
    angle = np.arange(POINTS) * math.tau / POINTS
    across = np.sin(angle) * np.sin(angle / 2) ** rng.uniform(1.2, 2.2)
    bend = rng.choice((-1, 1)) * (rng.uniform(0.5, 0.9) if kind == "c" else rng.uniform(0, 0.1))
    return np.asarray(np.cos(angle) + 1j * (across + bend * ((1 + np.cos(angle)) / 2) ** 3))


def laid(dot: Complex, rng: np.random.Generator, *, ratio: float, diameter: float) -> Array:
    """Points (n, 2) round a dot of this axis ratio and equivalent diameter, about its centroid, turned at random."""
    points = np.stack([dot.real, dot.imag], 1)
    if not shapely.Polygon(points).is_valid:
        raise ValueError("a dot crosses itself; take another seed")
    m = Paths.of([points]).green()[0]
    x, y = m[1:3] / m[0]
    xy = m[4] / m[0] - x * y
    spread, axes = np.linalg.eigh([[m[3] / m[0] - x * x, xy], [xy, m[5] / m[0] - y * y]])
    axes[:, 0] *= np.linalg.det(axes)  # else a reflection
    even = (points - points[0] - (x, y)) @ axes * np.sqrt([ratio / spread[0], 1 / (ratio * spread[1])])
    angle = rng.uniform(0, math.tau)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    return np.asarray(even @ turn * diameter / 2 * math.sqrt(math.pi / Paths.of([even]).areas[0]))


def sheet(dots: Sequence[Array], pen: Pen, rng: np.random.Generator) -> Array:
    """Code values of a page of dots in rows, as a scanner gives them, in 8 bits."""
    pixel = INCH / pen.dpi
    pitch = 2 * max(float(np.abs(dot).max()) for dot in dots) + 0.3
    taken = np.zeros([round((n + 1) * pitch / pixel) for n in (math.ceil(len(dots) / ROW), ROW)])
    for k, dot in enumerate(dots):
        ring = (dot + pitch * (np.array([k % ROW, k // ROW]) + 1)) / pixel + rng.uniform(-0.5, 0.5, 2)
        (left, top), (right, bottom) = np.floor(ring.min(0)).astype(int) - 4, np.ceil(ring.max(0)).astype(int) + 4
        ink = taken_by((ring - (left, top)) * FINE, ((bottom - top) * FINE, (right - left) * FINE), pen, rng)
        taken[top:bottom, left:right] += ink.reshape(bottom - top, FINE, right - left, FINE).mean((1, 3))
    light = 0.9 * (1 - taken) * (1 + GRAIN[0] * grain(taken.shape, GRAIN[1], rng))
    down, along = (np.linspace(0, 1, side) for side in taken.shape)
    light = ndimage.gaussian_filter(light, BLUR) * (1 - LAMP * along) * (1 - LAMP / 2 * down[:, None])
    code = encoded(np.clip(light, 0, 1)) + rng.normal(0, NOISE, taken.shape)
    return np.asarray(np.round(np.clip(code, 0, 1) * 255) / 255)


def grain(shape: tuple[int, ...], wide: float, rng: np.random.Generator) -> Array:
    """A random field of unit variance, smoothed by a Gaussian of this standard deviation."""
    field = ndimage.gaussian_filter(rng.normal(size=shape), wide)
    return np.asarray(field / field.std())


def taken_by(ring: Array, shape: tuple[int, int], pen: Pen, rng: np.random.Generator) -> Array:
    """The light that a dot's ink takes at fine places: half of its most on its outline, but for its teeth; softer on one side."""
    fine = INCH / pen.dpi / FINE
    places = np.stack(np.meshgrid(*(np.arange(side) + 0.5 for side in shape[::-1])), -1).reshape(-1, 2)
    outline = shapely.Polygon(ring)
    shapely.prepare(outline)
    away = cKDTree(ring).query(places)[0] * np.where(shapely.contains_xy(outline, places), 1, -1)
    away += pen.rough * TEETH * pen.mm / fine * grain(shape, FIBRE / fine, rng).ravel()
    x, y = (places - ring.mean(0)).T
    width = pen.rough * FEATHER * pen.mm / fine * (1 + np.cos(np.arctan2(y, x) - rng.uniform(0, math.tau)) / 3)
    step = np.clip(away / width + 0.5, 0, 1)
    return np.asarray(rng.normal(*INK) * step * step * (3 - 2 * step))


def scanned(draw: Callable[[float], Sequence[Array]], pen: Pen) -> tuple[Array, Scan]:
    """A sheet and its scan, of the dots that draw(scale) gives, of a scale that makes the mean diameter found the pen's.

    A first sheet tells by how much. ValueError where not every dot is found.
    """
    scale = 1.0
    for _ in range(2):
        dots = draw(scale)
        page = sheet(dots, pen, np.random.default_rng(SEED))
        found = scan(page, dpi=pen.dpi)
        scale = round(scale * pen.mm / float(found.diameters.mean()), 3)  # else a scan better by a hair has all other noise
    if len(found.outlines) != len(dots):
        raise ValueError(f"{len(found.outlines)} of {len(dots)} dots were found, and {found.counts}; take another seed")
    return page, found


def nib(pen: Pen) -> tuple[Array, Scan]:
    """The sheet of a technical pen's dots, and its scan; diameters and axis ratios are quantiles of normal laws, shuffled."""
    kinds = [kind for kind, many in DOTS.items() for _ in range(many)]
    normal = ndtri((np.arange(len(kinds)) + 0.5) / len(kinds))
    normal /= normal.std()

    def draw(scale: float) -> list[Array]:
        rng = np.random.default_rng([SEED, round(1000 * pen.mm)])
        diameters = pen.mm * scale * (1 + rng.permutation(np.clip(SPREAD * normal, -WIDEST, WIDEST)))
        ratios = rng.permutation(np.clip(RATIO[0] + RATIO[1] * normal, *RATIO[2:]))
        shuffled = zip(rng.permutation(kinds).tolist(), ratios.tolist(), diameters.tolist(), strict=True)
        return [laid(pen_dot(rng, kind, pen.mm), rng, ratio=ratio, diameter=diameter) for kind, ratio, diameter in shuffled]

    return scanned(draw, pen)


def brush() -> tuple[Array, Scan]:
    """The sheet of forty-eight dots of a brush pen, and its scan: half of about one size, half smaller, down to 0.6 of it.

    The largest are round: a scan would take long ones for two.
    """
    share = (np.arange(24) + 0.5) / 24
    shares = np.concatenate([0.64 + 0.3 * share**1.5, 1.02 + 0.26 * share])
    large = shares > 1.14

    def draw(scale: float) -> list[Array]:
        rng = np.random.default_rng(SEED)
        kinds = np.where(large, "f", rng.permutation(list("dcdcf" * 10))[: len(shares)])
        ratios = np.where(large, rng.uniform(0.8, 0.92, len(shares)), rng.uniform(0.61, 0.72, len(shares)))
        dots = zip(kinds.tolist(), ratios.tolist(), (BRUSH.mm * scale * shares).tolist(), strict=True)
        drawn = [laid(brush_dot(rng, kind), rng, ratio=ratio, diameter=diameter) for kind, ratio, diameter in dots]
        return [drawn[k] for k in rng.permutation(len(drawn))]

    return scanned(draw, BRUSH)


def disc() -> bytes:
    """The library of one circle of 0.3 mm: four cubics with its area."""
    k = 2 - math.sqrt(4 - (20 / 3) * (math.pi / 4 - 0.5))  # 1/2 + 3k/5 - 3k^2/20 = pi/4
    quarter = np.array([1, 1 + 1j * k, k + 1j])
    ring = 0.15 * np.concatenate([quarter * turn for turn in (1, 1j, -1, -1j)]) + 0.3 + 0.3j
    pairs = [f"{z.real:.5f},{z.imag:.5f}" for z in [*ring, ring[0]]]
    facts = {"name": "disc", "simulated": True, "pen_mm": 0.3, "count": 1}
    facts |= {
        "made": "computed by tools/ink_model.py: four cubics with the area of the circle",
        "source": "none: a circle",
        "licence": "MIT",
    }
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="0.6mm" height="0.6mm" viewBox="0 0 0.6 0.6">',
        "<title>disc</title>",
        "<desc>One SIMULATED dot, a circle of 0.3 mm: computed, not scanned.</desc>",
        f'<metadata><library xmlns="urn:crowquill:library" schema="1">{json.dumps(facts, indent=2)}</library></metadata>',
        '<g fill="#000">',
        f'<path id="disc-00" d="M {pairs[0]} ' + " ".join("C " + " ".join(pairs[i : i + 3]) for i in range(1, 13, 3)) + ' Z"/>',
        "</g>",
        "</svg>",
    ]
    return "\n".join([*lines, ""]).encode()


def rendered(name: str) -> tuple[Array, Scan]:
    """The scan sheet of a nib or of "brush", code values, and its scan."""
    return nib(PENS[name]) if name in PENS else brush()


def made(name: str) -> bytes:
    """The bytes of a library: of a nib, "brush" or "disc". Prints what its scan says of it."""
    if name == "disc":
        return disc()
    _, found = rendered(name)
    wide = found.diameters
    cubics = np.diff(found.outlines.start) / 3
    said = "".join(f"; {warning}" for warning in found.warnings)
    print(f"{name}: {len(wide)} dots of {wide.mean():.4f} mm, spread {wide.std() / wide.mean():.3f}, {cubics.mean():.2f} cubics each{said}")
    about = {"simulated": True, "made": MADE.format(dpi=found.dpi), "source": SOURCE, "licence": "MIT"}
    return library(found, name=name, pen_mm=PENS.get(name, BRUSH).mm, about=about)


if __name__ == "__main__":
    for name in sys.argv[1:] or [*PENS, "brush", "disc"]:
        (OUT / f"{name}.svg").write_bytes(made(name))
