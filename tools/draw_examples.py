"""Draw the examples of stippling by example: src/crowquill/examples/<name>.png, and what is learned of them. Same program, same bytes.

No hand drew them. Each is a page of flat tones as a scanner would see it: "hand" with dots of several sizes that crowd in small
groups, as a pen that is not lifted far leaves them; "even" with dots of one nib, as evenly spaced as relaxation makes them.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image, PngImagePlugin
from scipy import ndimage

from crowquill import Marks, Tone, draw, exemplar, glyphs, measure, raster
from crowquill.exemplar import stylefile
from crowquill.paths import Array

FOLDER = Path(__file__).resolve().parents[1] / "src" / "crowquill" / "examples"
SEED = 313
DPI = 600.0
PATCH, GAP, MARGIN = 18.0, 3.0, 5.0  # mm
EDGE = 0.3  # mm of black around white marks
BLACK = (0.04, 0.08, 0.14, 0.22, 0.32, 0.43, 0.55)
WHITE = (0.26, 0.15, 0.07)  # of paper left, in the darks
PAPER, INK, OPTICS = 0.90, 0.03, 0.6  # light of paper and ink; the blur of a scanner, in pixels
CLUMP, NEAR, PATIENCE = 2.4, 1.3, 0.08  # dots to a group, diameters between them, and how often one is let overlap another
EVENLY = (0.7548776662466927, 0.5698402909980532)  # multiples of these fill a square evenly, however many
ASTRAY = 0.7  # of the spacing of groups, by which each is off its even place

Maker = Callable[[float, bool, np.random.Generator], Marks]


def hand(coverage: float, white: bool, rng: np.random.Generator) -> Marks:
    """dots of several sizes that crowd in small groups"""
    shapes = tuple(glyph for name in ("nib-03", "nib-035", "nib-05") for glyph in glyphs.load(name).glyphs)
    mean = 0.26 if white else 0.36  # mm
    count = int(-2.2 * np.log1p(-coverage) * (PATCH + 4) ** 2 / (np.pi / 4 * mean**2))
    parents = (np.arange(1, count // 2)[:, None] * EVENLY + rng.random(2)) % 1 * (PATCH + 4) - 2
    parents += rng.normal(0, ASTRAY * (PATCH + 4) * np.sqrt(CLUMP / count), parents.shape)
    places = np.repeat(parents, rng.poisson(CLUMP - 1, len(parents)) + 1, axis=0)[:count]
    places += rng.normal(0, NEAR * mean, places.shape)
    kept: list[int] = []
    squares: dict[tuple[int, int], list[int]] = {}
    for i, (x, y) in enumerate(places.tolist()):
        near = [j for a in (-1, 0, 1) for b in (-1, 0, 1) for j in squares.get((int(x // mean) + a, int(y // mean) + b), ())]
        if all(np.hypot(*(places[j] - places[i])) > 0.95 * mean for j in near) or rng.random() < PATIENCE + coverage:
            kept.append(i)
            squares.setdefault((int(x // mean), int(y // mean)), []).append(i)
    places = places[kept]
    scale = mean * np.sqrt(np.pi) / 2 * np.exp(rng.normal(0, 0.16, len(places)))
    kind = rng.integers(len(shapes), size=len(places))
    marks = Marks.of(places, shapes, scale=scale, angle=rng.uniform(0, 2 * np.pi, len(places)), glyph=kind)
    low, high = 0, len(marks)
    while high - low > 1:  # as many as cover what is asked for
        middle = (low + high) // 2
        covers = measure.rendered(marks.take(slice(middle)), (PATCH, PATCH), (90, 90)).mean()
        low, high = (middle, high) if covers < coverage else (low, middle)
    return marks.take(slice(high))


def even(coverage: float, white: bool, rng: np.random.Generator) -> Marks:
    """dots of one nib, as evenly spaced as relaxation makes them"""
    side = PATCH + 4
    tone = Tone(np.full((8, 8), coverage), (side, side))
    found = draw("stipple", tone, pen=0.25 if white else 0.35, glyphs="nib-025" if white else "nib-035", seed=int(rng.integers(1 << 30)))
    return found.marks.moved((-2, -2))


def page(maker: Maker, rng: np.random.Generator) -> Array:
    """The coverage of a page of ten tones in two rows, pixel by pixel. No mark is cut: where a patch ends they end."""
    pixel = 25.4 / DPI
    w, h = (int((2 * MARGIN + count * (PATCH + GAP) - GAP) / pixel) for count in (5, 2))
    ink = np.zeros((h, w))
    for k, coverage in enumerate([*BLACK, *WHITE]):
        white = k >= len(BLACK)
        marks = maker(coverage, white, rng)
        inset = EDGE if white else 0
        marks = marks.take(((marks.xy > inset) & (marks.xy < PATCH - inset)).all(axis=1))
        corner = MARGIN + np.array([k % 5, k // 5]) * (PATCH + GAP)
        cover = raster.covered(marks.moved(corner), (h, w), pixel=(pixel, pixel))
        left, top, right, bottom = (round(end / pixel) for end in (*corner, *(corner + PATCH)))
        if white:
            ink[top:bottom, left:right] = 1 - cover[top:bottom, left:right]
        else:
            ink = np.maximum(ink, cover)
    return ink


def scanned(ink: Array, about: str) -> bytes:
    """A page of ink as the PNG of a scan, of 16 greys."""
    light = ndimage.gaussian_filter(PAPER + (INK - PAPER) * ink, OPTICS)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    notes = PngImagePlugin.PngInfo()
    notes.add_text("Description", f"Simulated, drawn by tools/draw_examples.py of crowquill: {about}. CC0-1.0.")
    file = io.BytesIO()
    grey = Image.fromarray((np.round(code * 15) * 17).astype(np.uint8))
    grey.save(file, "PNG", optimize=True, dpi=(DPI, DPI), pnginfo=notes)
    return file.getvalue()


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for k, maker in enumerate((hand, even)):
        path = FOLDER / f"{maker.__name__}.png"
        path.write_bytes(scanned(page(maker, np.random.default_rng([SEED, k])), maker.__doc__ or ""))
        stylefile.save(exemplar.learned(path), path.with_suffix(".style"))
