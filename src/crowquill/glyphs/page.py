"""A scanned page: its code values and its file's dpi, how dark each place is beside the paper around it, and how noisy.

Threshold: N. Otsu, A threshold selection method from gray-level histograms, IEEE Trans. SMC 9(1), 1979.
"""

from __future__ import annotations

import itertools
import os
import warnings
from collections.abc import Callable
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.interpolate import make_interp_spline

from crowquill.paths import Array, frozen
from crowquill.picture import FORMATS, decoded

Grey = npt.NDArray[np.float32]
Covers = Callable[[Array], npt.NDArray[np.bool_]]  # which points x, y, in pixels, are of no paper
Source = str | os.PathLike[str] | BinaryIO | npt.NDArray[Any]

SMOOTHER = (0.0, 0.5, 0.7, 0.85, 1.0, 1.2)  # pixels: more smoothing gains nothing, as edges flatten as fast as noise goes down
APART = 8  # pixels between places whose noise has nothing in common
COUNTED = 1e6  # pixels enough for a histogram
SAMPLED = 20000  # pixels of edges that tell how steep they are
SEEN = 1000  # pixels a side of the part that noise is measured on


def nowhere(xy: Array) -> npt.NDArray[np.bool_]:
    """No point is of no paper."""
    return np.zeros(len(xy), bool)


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


def tagged(source: Source) -> float | None:
    """Pixels to the inch by a sound picture file's own tag, None where it has none. ValueError where it has two."""
    from PIL import Image

    if isinstance(source, np.ndarray):
        return None
    with warnings.catch_warnings():  # Pillow's limit on pixels: the picture's size was found good by decoded()
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        try:
            with Image.open(source, formats=FORMATS) as image:
                x, y = (float(side) for side in image.info.get("dpi", (0, 0)))
        except Image.DecompressionBombError:  # over twice Pillow's limit, yet under ours
            x = y = 0.0
    if not (np.isfinite(x + y) and min(x, y) > 0):
        return None
    if abs(x - y) > 0.01 * max(x, y):
        raise ValueError(f"{called(source)}: has {x:.6g} by {y:.6g} dpi; scan with square pixels, or give dpi")
    return round((x + y) / 2, 1)  # PNG counts pixels to the metre: 1200 dpi comes back as 1199.9976


def flattened(light: Grey, *, tile: int, hidden: Covers = nowhere) -> tuple[Grey, float]:
    """The share of the paper's light that is taken, (h, w), about 0 on paper; and the dimmest paper's light by the brightest's.

    The paper's light is the ninth decile of tiles of so many pixels, splines between their centres and straight lines beyond.
    A tile with less than 0.4 of the light of the page's bright tiles is ink, and takes the mean of the paper around it.
    Tiles whose middles are hidden do not count as dim or bright.
    """
    edges = [np.linspace(0, side, max(1, round(side / tile)) + 1).astype(int) for side in light.shape]
    rows, columns = (list(itertools.pairwise(edge)) for edge in edges)
    paper = np.array([[np.quantile(light[a:b, c:d], 0.9) for c, d in columns] for a, b in rows], np.float64)
    sound = (paper > 0.4 * np.quantile(paper, 0.9)).astype(np.float64)
    blurred = [ndimage.gaussian_filter(values, 2.0, mode="nearest", truncate=16) for values in (paper * sound, sound)]
    paper = np.where(sound > 0, paper, blurred[0] / np.maximum(blurred[1], 1e-12))
    middle = [(edge[:-1] + edge[1:]) / 2 for edge in edges]
    places = np.stack(np.meshgrid(middle[1], middle[0]), axis=-1).reshape(-1, 2)
    seen = paper.ravel()[~hidden(places)]
    evenness = float(seen.min(initial=np.inf) / max(seen.max(initial=0), 1e-9)) if len(seen) else 1.0
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
    return darkness, evenness


def otsu(darkness: Grey) -> tuple[float, float, float]:
    """Mean darkness of ink and of paper, and the threshold that leaves each the least variance."""
    counts = np.histogram(darkness, 256, (0, 1))[0].astype(np.float64)
    level = (np.arange(256) + 0.5) / 256
    below, sums = np.cumsum(counts)[:-1], np.cumsum(counts * level)[:-1]
    above, rest = counts.sum() - below, (counts @ level) - sums
    paper, ink = sums / np.maximum(below, 1), rest / np.maximum(above, 1)
    best = int(np.argmax(below * above * (ink - paper) ** 2))
    return float(ink[best]), float(paper[best]), (best + 1) / 256


def beside(darkness: Grey, hidden: Covers) -> Grey:
    """The pixels of a page that are not hidden, or evenly chosen ones where the page has many millions: (n,)."""
    step = int(np.sqrt(darkness.size / COUNTED)) + 1
    few = darkness[::step, ::step]
    y, x = step * np.indices(few.shape, np.float64).reshape(2, -1) + 0.5
    return few.ravel()[~hidden(np.stack([x, y], axis=1))]


def smoothed(darkness: Grey, ink: float, threshold: float, *, limit: float, hidden: Covers = nowhere) -> tuple[Grey, float, float]:
    """The darkness, smoothed by as little as leaves noise moving an edge by `limit` pixels (rms); that Gaussian's pixels; what is left.

    It is a sixth of the dots' radius at most, even if noise is left. The noise is that of paper three pixels and more from
    ink, and not hidden. A darkness that climbs by c a pixel is moved by noise / c, c being that of the page's edges, less
    what smoothing blurs.
    """
    level = ink / 2
    edges = np.flatnonzero(np.abs(darkness[1:-1, 1:-1] - level) < 0.1 * ink)
    rows, columns = (side + 1 for side in np.unravel_index(edges[:: len(edges) // SAMPLED + 1], np.array(darkness.shape) - 2))
    kept = ~hidden(np.stack([columns + 0.5, rows + 0.5], axis=1))
    if not kept.any():
        return darkness, 0.0, 0.0
    top, left = (max(0, int(np.median(side[kept])) - SEEN // 2) for side in (rows, columns))
    part = darkness[top : top + SEEN, left : left + SEEN]
    y, x = np.indices(part.shape, np.float64).reshape(2, -1)
    shown = ~hidden(np.stack([x + left + 0.5, y + top + 0.5], axis=1)).reshape(part.shape)
    blur, radius = _edges(part, shown, ink)
    bare = shown & ~ndimage.binary_dilation(part > threshold, np.ones((3, 3), bool), 3)
    pairs = bare[:, APART:] & bare[:, :-APART]  # differences: shading is no noise
    if not pairs.any():
        return darkness, 0.0, 0.0
    chosen = moved = 0.0
    for pixels in SMOOTHER:
        if pixels > radius / 6:
            break
        chosen = pixels
        paper = ndimage.gaussian_filter(part, pixels) if pixels else part
        noise = 1.4826 / np.sqrt(2) * float(np.median(np.abs((paper[:, APART:] - paper[:, :-APART])[pairs])))
        moved = noise * float(np.sqrt(2 * np.pi * (blur * blur + pixels**2))) / ink
        if moved <= (limit if pixels else 0.75 * limit):  # noise that is not smoothed has shorter waves, which cubics cannot follow
            break
    return (ndimage.gaussian_filter(darkness, chosen) if chosen else darkness), chosen, moved


def _edges(part: Grey, shown: npt.NDArray[np.bool_], ink: float) -> tuple[float, float]:
    """The blur of the edges on a part of a page (a Gaussian's pixels), and the radius of what they go round: 2 areas by perimeter.

    Both are taken from the part smoothed by a pixel, lest noise pass for edges.
    """
    calm = ndimage.gaussian_filter(part, 1.0)
    rims = shown & (np.abs(calm - ink / 2) < 0.1 * ink)
    if not rims.any():
        return 0.0, 0.0
    climb = max(float(np.median(np.hypot(*np.gradient(calm))[rims])), 1e-9)
    around = np.count_nonzero(rims) * climb / (0.2 * ink)  # as wide as the darkness takes to climb so far
    blur = np.sqrt(max(ink * ink / (2 * np.pi * climb**2) - 1 / 3 - 1, 0))  # 1/3: of differences over two pixels
    return float(blur), float(2 * np.count_nonzero(shown & (calm > ink / 2)) / max(around, 1e-9))
