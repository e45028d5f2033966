"""Reversed dots: where a tone is dark, ink covers all, and white dots are cut out of it.

Black dots on white and white dots on black are one and the same to a style: on the dark part of the canvas it draws what is
white. Holes are real, so that paper shows through them on every plate.
Source: C. Schulz, K. C. Kwan, M. Becher, D. Baumgartner, G. Reina, O. Deussen, D. Weiskopf, Multi-Class Inverted
Stippling, ACM Transactions on Graphics 40(6), 2021.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter

from crowquill import measure
from crowquill.exemplar import darks
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.tone import Tone

SEEN = 0.5  # of a dot: the blur through which dark parts are looked for
LEAST = 20.0  # dots, as squares: smaller parts, and smaller gaps in one, go


@dataclass(frozen=True, eq=False)
class Parted:
    """A tone in two: the light part, drawn as any, and the dark part, whose tone is what shall stay white; None for one that is not.

    area  of the dark part, as a (Multi)Polygon in mm
    """

    light: Tone | None
    dark: Tone | None
    area: shapely.Geometry


def parted(tone: Tone, dark_from: float, dot: float) -> Parted:
    """The tone parted where its coverage, seen through a blur of half a dot, which is so many mm wide, passes `dark_from`."""
    sigma = [SEEN * dot / side for side in reversed(tone.pixel)]
    seen = replace(tone, values=np.clip(gaussian_filter(tone.coverage, sigma, mode="nearest"), 0, 1))
    found = darks.ground(seen, (dark_from, dark_from), dot, np.random.default_rng(0)).whole  # no chance between two that are one
    area = _without_specks(found, LEAST * dot**2)
    return Parted(_on(tone, shapely.difference(tone.canvas, area)), _on(tone.mapped(lambda c: 1 - c), area), area)


def cut(parts: Parted, white: Marks, dot: float) -> shapely.Geometry:
    """The dark area without its white dots, as large as their tone asks: what prints as a hairline between two goes with them."""
    return darks.cut(parts.area, white.take(slice(0)), white, np.pi / 4 * dot**2)


def rings(area: shapely.Geometry) -> Paths:
    """The area as rings, its holes turning the other way."""
    return darks.rings(area)


def ink(area: shapely.Geometry, black: Marks) -> float:
    """What area and dots cover together, mm^2."""
    return float(shapely.area(area)) + measure.ink(black) - darks.overlap(area, black)


def _on(tone: Tone, canvas: shapely.Geometry) -> Tone | None:
    parts = [part for part in shapely.get_parts(canvas) if part.geom_type == "Polygon" and part.area > 0]
    return replace(tone, canvas=shapely.multipolygons(parts)) if parts else None


def _without_specks(area: shapely.Geometry, least: float) -> shapely.Geometry:
    parts = [part for part in shapely.get_parts(area) if part.area >= least]
    return shapely.MultiPolygon([darks.filled(part, least) for part in parts])
