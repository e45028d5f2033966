"""A scanned page: its code values and resolution, and how dark each place is beside the paper around it.

Threshold: N. Otsu, A threshold selection method from gray-level histograms, IEEE Trans. SMC 9(1), 1979.
"""

from __future__ import annotations

import itertools
import os
import warnings
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.interpolate import make_interp_spline

from crowquill.paths import Array, frozen
from crowquill.picture import FORMATS, decoded

Grey = npt.NDArray[np.float32]
Source = str | os.PathLike[str] | BinaryIO | npt.NDArray[Any]

COARSEST = 300.0  # dpi: a 0.3 mm dot is 3.5 pixels across


def called(source: Source) -> str:
    """What errors call a scan: its path or file name, else "scan"."""
    return str(source) if isinstance(source, (str, os.PathLike)) else str(getattr(source, "name", "scan"))


def code_values(source: Source) -> Array:
    """Grey code values 0 to 1 of a picture or an array; an open file is left at its beginning."""
    if not isinstance(source, np.ndarray):
        code = decoded(source)
        if not isinstance(source, (str, os.PathLike)):
            source.seek(0)
        return code
    scale = np.iinfo(source.dtype).max if source.dtype.kind == "u" else 1
    code = frozen(source / scale, np.float64, (None, None), "scan")
    if code.size and not 0 <= code.min() <= code.max() <= 1:
        raise ValueError(f"scan has values from {code.min():g} to {code.max():g}; it takes grey code values 0 to 1")
    return code


def resolution(source: Source, dpi: float | None = None) -> float:
    """Pixels to the inch: `dpi` where given, else the tag of a sound picture file. ValueError for none, two, or one under 300."""
    from PIL import Image

    if dpi is None and not isinstance(source, np.ndarray):
        with warnings.catch_warnings():  # Pillow's limit on pixels: the picture's size was found good by decoded()
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            try:
                with Image.open(source, formats=FORMATS) as image:
                    x, y = (float(side) for side in image.info.get("dpi", (0, 0)))
            except Image.DecompressionBombError:  # over twice Pillow's limit, yet under ours
                x = y = 0.0
        if abs(x - y) > 0.01 * max(x, y):
            raise ValueError(f"{called(source)}: has {x:g} by {y:g} dpi; scan with square pixels, or give dpi")
        dpi = round((x + y) / 2, 1) or None  # PNG counts pixels to the metre: 1200 dpi comes back as 1199.9976
    if dpi is None:
        raise ValueError(f"{called(source)}: its dpi is not known; give it, such as dpi=1200")
    if not COARSEST <= dpi < np.inf:
        raise ValueError(
            f"{called(source)}: {dpi:g} dpi is too coarse for ink dots; scan at 1200, or give the true dpi, {COARSEST:g} or more"
        )
    return float(dpi)


def flattened(light: Grey, *, tile: int) -> tuple[Grey, float]:
    """The share of the paper's light that is taken, (h, w), about 0 on paper; and the dimmest paper's light by the brightest's.

    The paper's light is the ninth decile of tiles of so many pixels, splines between their centres and straight lines beyond.
    A tile with less than 0.4 of the light of the page's bright tiles is ink, and takes the mean of the paper around it.
    """
    edges = [np.linspace(0, side, max(1, round(side / tile)) + 1).astype(int) for side in light.shape]
    rows, columns = (list(itertools.pairwise(edge)) for edge in edges)
    paper = np.array([[np.quantile(light[a:b, c:d], 0.9) for c, d in columns] for a, b in rows], np.float64)
    sound = (paper > 0.4 * np.quantile(paper, 0.9)).astype(np.float64)
    blurred = [ndimage.gaussian_filter(values, 2.0, mode="nearest", truncate=16) for values in (paper * sound, sound)]
    paper = np.where(sound > 0, paper, blurred[0] / np.maximum(blurred[1], 1e-12))
    along = []
    for edge, side in zip(edges, light.shape, strict=True):
        centre, place = (edge[:-1] + edge[1:]) / 2, np.arange(side) + 0.5
        at = np.clip(place, centre[0], centre[-1])
        line = make_interp_spline(centre, np.eye(len(centre)), k=min(3, len(centre) - 1))
        along.append(line(at) + (line(at, 1) * (place - at)[:, None] if len(centre) > 1 else 0))
    darkness = light.copy()
    for top in range(0, len(light), 256):  # in bands, for the sake of memory
        band = slice(top, top + 256)
        darkness[band] = 1 - light[band] / np.maximum(along[0][band] @ paper @ along[1].T, 1e-3)
    return darkness, float(paper.min() / max(paper.max(), 1e-9))


def otsu(darkness: Grey) -> tuple[float, float, float]:
    """Mean darkness of ink and of paper, and the threshold that leaves each the least variance."""
    counts = np.histogram(darkness, 256, (0, 1))[0].astype(np.float64)
    level = (np.arange(256) + 0.5) / 256
    below, sums = np.cumsum(counts)[:-1], np.cumsum(counts * level)[:-1]
    above, rest = counts.sum() - below, (counts @ level) - sums
    paper, ink = sums / np.maximum(below, 1), rest / np.maximum(above, 1)
    best = int(np.argmax(below * above * (ink - paper) ** 2))
    return float(ink[best]), float(paper[best]), (best + 1) / 256
