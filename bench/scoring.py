"""How near dots come to a picture, whoever placed them: the tone error and the evenness by which programs are put side by side."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from PIL import Image

from crowquill import cells, glyphs, likeness, raster
from crowquill.marks import Marks

LINES = 8  # scan lines to a row of pixels
ALIKE = 0.005  # of evenness: seeds differ by half of it


class Score(NamedTuple):
    """Tone error, and evenness: the mean distance to the nearest other dot over a hexagon's for the dot's own cell."""

    tone: float
    rho: float

    def reaches(self, other: Score, *, even: bool) -> bool:
        """Whether it is as good as another in tone, and in evenness too where that counts."""
        return self.tone <= other.tone and (self.rho >= other.rho - ALIKE or not even)


def camera(side: int = 1000) -> np.ndarray:
    """scikit-image's camera (L. Varshney, CC0), side x side code values."""
    from skimage.data import camera as picture

    return np.asarray(Image.fromarray(picture()).resize((side, side), Image.Resampling.BICUBIC))


def darkness(levels: np.ndarray) -> np.ndarray:
    """How much ink code values ask for: 1 - v/255."""
    return 1 - levels / 255


def tone_error(sites: np.ndarray, dark: np.ndarray, areas: np.ndarray | None = None) -> float:
    """The root mean square of the difference after a Gaussian of 8 pixels of 1000, dots being discs whose areas sum to the ink.

    sites  (n, 2) in pixels of `dark`, x and y from the top left corner; areas (n,) in any unit, of dots that differ
    """
    areas = np.ones(len(sites)) if areas is None else areas
    scale = np.sqrt(areas * (dark.sum() / areas.sum()))
    marks = Marks.of(sites, glyphs.load("disc").glyphs, scale=scale)
    return likeness.scored(raster.covered(marks, dark.shape, pixel=(1.0, 1.0), lines=LINES), dark)


def evenness(sites: np.ndarray, shape: tuple[int, int]) -> float:
    """Mean of nearest distance over sqrt(2 area / sqrt 3), of dots with a cell; dots on one another have none between them."""
    from scipy.spatial import cKDTree

    near = cKDTree(sites).query(sites, k=2)[0][:, 1]
    area = cells.voronoi(sites, shapely.box(0, 0, shape[1], shape[0])).areas
    good = area > 0
    return float((near[good] / np.sqrt(2 * area[good] / np.sqrt(3))).mean())


def scored(sites: np.ndarray, dark: np.ndarray, areas: np.ndarray | None = None) -> Score:
    """Both figures. Dots that their program drew in several sizes are tried as equal ones too, and the better tone counts."""
    errors = [tone_error(sites, dark), *([] if areas is None else [tone_error(sites, dark, areas)])]
    return Score(min(errors), evenness(sites, dark.shape))
