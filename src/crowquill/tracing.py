"""Canvases from pictures: the outline of what is opaque, of what is light in a mask, or of a specimen on a plain backdrop.

Threshold: N. Otsu, A threshold selection method from gray-level histograms, IEEE Trans. SMC 9(1), 1979.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import vector
from crowquill.paths import Array
from crowquill.picture import MAX_PIXELS, Bytes, File, colours, linear, read, shape, window

WISHES = ("alpha", "auto")
FINEST = 16_000_000  # pixels traced: of a larger picture the means of whole blocks
SMALLEST = 4.0  # pixels: islands and holes below are dropped
FINE = 0.05  # of a pixel: how far the outline may run from the contour
MOST, CORNERS = 20_000, 1_000_000  # islands and holes of a canvas, and points of their contours
BAND = 0.02  # of the shorter side: the border that shows the backdrop, and what lies in it alone is a frame or dust
SPECK = 1e-4  # of the picture: smaller islands on a backdrop are dust
ROUGH = 4.0  # of Lab: the standard deviation about a smooth surface that a plain backdrop keeps below
FAINT = 4.0  # of Lab: what differs less is backdrop, whatever the histogram
STRONG = 20.0  # of Lab: all that differs more counts alike, or a dark specimen's light parts would be lost
SAMPLE = 6_000  # pixels to which a backdrop is fitted
XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])  # of sRGB

Mask = npt.NDArray[np.bool_]
Field = npt.NDArray[np.float32]


def canvas(
    wish: str | os.PathLike[str],
    picture: File,
    size: tuple[float, float] = (1.0, 1.0),
    *,
    crop: tuple[float, float, float, float] | None = None,
    max_pixels: int = MAX_PIXELS,
) -> shapely.Geometry:
    """The (Multi)Polygon that is wished for on a picture, what is left of it by the crop being a rectangle of this size in mm.

    wish  "alpha": what the picture holds opaque, half or more; "auto": what stands off the plain backdrop that its border
          shows; an SVG file: what its outlines enclose; any other file: a mask, of which half light or lighter is canvas
          and transparent is not. Files are laid over the whole picture, whatever their own size, and the crop cuts them too.
    size  (1, 1) for shares of the picture

    With "auto" all that the specimen encloses is canvas, its holes too: from the picture they cannot be told from
    parts in the backdrop's colour; draw them in a mask. So is a shadow that is as dark as the specimen's light parts. Islands of
    less than a ten-thousandth of the picture are dust, and a frame of 2 % of its shorter side is dropped.
    Islands and holes under 4 pixels are dropped; outlines keep within 0.05 of a pixel. Of pictures of over 16 million pixels
    means of blocks are traced. Raises ValueError where nothing is canvas or no backdrop is plain.
    """
    name = str(wish if str(wish) not in WISHES else getattr(picture, "name", "picture") if hasattr(picture, "read") else picture)
    whole: tuple[int, ...] = (1, 1)
    if str(wish) in WISHES:
        rgba, clear = colours(picture, max_pixels)
        whole = rgba.shape
        found = _opaque(rgba, clear, name) if str(wish) == "alpha" else _specimen(rgba, name)
    elif Path(wish).suffix.lower() == ".svg":
        found = vector.canvas(vector.contents(Path(wish)), name, (1.0, 1.0))
    else:
        found = traced(read(wish, max_pixels, under=0.0)[0], name=name)
        if found.is_empty:
            raise ValueError(f"{name}: has no light place to draw in; make the canvas white in it")
    if crop is not None and str(wish) not in WISHES:
        whole = shape(picture, max_pixels)
    rows, columns = window(whole, crop)
    corner = np.array([columns.start, rows.start]) / whole[1::-1]
    span = np.array([columns.stop, rows.stop]) / whole[1::-1] - corner
    placed = shapely.transform(found, lambda xy: np.multiply((xy - corner) / span, size))
    cut = _polygons(shapely.intersection(placed, shapely.box(0, 0, *size)))
    if cut.is_empty:
        raise ValueError(f"{name}: its canvas has no area on the picture{' that the crop leaves' if crop else ''}; move one")
    return cut


def traced(values: npt.NDArray[Any], level: float = 0.5, *, name: str = "canvas") -> shapely.Geometry:
    """The area where (h, w) values at the centres of pixels are of this level or over, on a unit square; empty where none are.

    The contour runs straight between the centres. Of more than 16 million values the means of whole blocks are traced.
    Raises ValueError for more than 20 000 islands and holes, or a million corners.
    """
    k = _block(values.shape)
    return _outlined(_shrunk(values, k), values.shape, k, level, name)


def _outlined(values: Field, shape: tuple[int, ...], k: int, level: float, name: str) -> shapely.Geometry:
    """The area of `traced` for values that are means of blocks of k by k pixels of a picture of this shape."""
    from contourpy import FillType, contour_generator

    h, w = shape[:2]
    edge = 1e-9  # of a pixel: beyond the border the values fall to nothing within it
    y, x = (np.concatenate([[-edge, 0], _centres(side, k), [side, side + edge]]) for side in (h, w))
    around = np.pad(np.pad(values, 1, mode="edge"), 1, constant_values=level - 1)
    generator: Any = contour_generator(x, y, around, fill_type=FillType.ChunkCombinedOffsetOffset)
    (points,), (starts,), (firsts,) = generator.filled(level, np.inf)
    if points is None:
        return shapely.MultiPolygon()
    xy, starts, firsts = np.clip(points, 0, (w, h)), starts.astype(np.int64), firsts.astype(np.int64)
    twice = np.append(xy[:-1, 0] * xy[1:, 1] - xy[1:, 0] * xy[:-1, 1], 0.0)
    twice[starts[1:] - 1] = 0.0  # from one ring's last point to the next one's first
    kept = np.abs(np.add.reduceat(twice, starts[:-1])) >= 2 * SMALLEST * k * k
    kept &= np.repeat(kept[firsts[:-1]], np.diff(firsts))  # holes go with their island
    corners = int(np.diff(starts)[kept].sum())
    if kept.sum() > MOST or corners > CORNERS:
        raise ValueError(f"{name}: would be a canvas of {kept.sum()} islands and holes of {corners} corners; smooth it")
    if not kept.any():
        return shapely.MultiPolygon()
    counts, island = np.diff(starts), np.repeat(np.arange(len(firsts) - 1), np.diff(firsts))
    rings = shapely.linearrings(xy[np.repeat(kept, counts)], indices=np.repeat(np.arange(kept.sum()), counts[kept]))
    island = np.unique(island[kept], return_inverse=True)[1]
    # ring by ring: polygons GEOS would mend each, which takes minutes; where rings then cross, every point stays
    tries = [shapely.multipolygons(shapely.polygons(lines, indices=island)) for lines in (shapely.simplify(rings, FINE * k), rings)]
    found = next((shape for shape in tries if shapely.is_valid(shape)), None) or shapely.make_valid(tries[1])
    return shapely.transform(found, lambda xy: xy / (w, h))


def _block(shape: tuple[int, ...]) -> int:
    """The side of the blocks of pixels of which no more than FINEST cover a picture."""
    return int(np.ceil(np.sqrt(shape[0] * shape[1] / FINEST)))


def _shrunk(values: npt.NDArray[Any], k: int) -> Field:
    """Means of blocks of k by k pixels; those at the far edges may be smaller."""
    if k == 1:
        return values.astype(np.float32)
    for _ in range(2):  # along the rows, and turned, along the columns
        starts = np.arange(0, len(values), k)
        counts = np.diff([*starts, len(values)]).astype(np.float32)
        sums = np.add.reduceat(values, starts, 0, np.float32)
        values = (sums.T / counts).T.swapaxes(0, 1)
    return values


def _centres(side: int, k: int) -> Array:
    """Where along a side of so many pixels the blocks have their centres."""
    starts = np.arange(0, side, k)
    return (starts + np.minimum(starts + k, side)) / 2


def _opaque(rgba: Bytes, clear: bool, name: str) -> shapely.Geometry:
    if not clear:
        raise ValueError(f"{name}: has no transparency to take a canvas from; ask for auto, or give a mask")
    found = traced(rgba[..., 3], 127.5, name=name)
    if found.is_empty:
        raise ValueError(f"{name}: is transparent all over; ask for auto, or give a mask")
    return found


def _specimen(rgba: Bytes, name: str) -> shapely.Geometry:
    """The area of what stands off the backdrop, on a unit square; ValueError where nothing does or the backdrop is not plain."""
    from scipy import ndimage

    k = _block(rgba.shape)
    lab = _lab(rgba, k)
    h, w = lab.shape[0], lab.shape[1]
    wide = max(2, round(BAND * min(h, w)))
    for outer in (0, wide):  # the border, and where a frame covers it the same within
        band, inner = np.zeros((h, w), bool), (slice(outer + wide, -outer - wide),) * 2
        band[outer : h - outer, outer : w - outer] = True
        band[inner] = False
        noise = _levelled(lab, band, 2) if 0 < 2 * band.sum() < band.size else np.inf  # a picture of a dozen pixels is all border
        if noise <= ROUGH:
            break
    else:
        raise ValueError(f"{name}: its border shows no plain backdrop; give a mask")
    noise = _levelled(lab, np.linalg.norm(lab, axis=2) < max(FAINT, 4 * noise), 4)
    off = np.linalg.norm(lab, axis=2)
    level = float(np.clip(_otsu(np.minimum(off, STRONG)), max(FAINT, 4 * noise), STRONG))
    body = ~_reached(off < level, band)
    islands, n = ndimage.label(body, np.ones((3, 3)))
    sizes = np.bincount(islands.ravel(), minlength=n + 1)
    good = (sizes >= SPECK * body.size) & (np.bincount(islands[inner].ravel(), minlength=n + 1) > 0)
    good[0] = False
    body = good[islands]
    if not 0 < body.mean() < 0.99:
        raise ValueError(f"{name}: {'all' if body.any() else 'nothing'} of it stands off its backdrop; give a mask")
    return _outlined(_shares(lab, body), rgba.shape, k, 0.5, name)


def _lab(rgba: Bytes, k: int) -> Field:
    """CIE Lab of the means of blocks of k by k pixels over white, smoothed by 0.7 of a block."""
    from scipy.ndimage import gaussian_filter

    light_of = linear(np.arange(256) / 255)
    bands = []
    for top in range(0, len(rgba), 256 * k):
        part = rgba[top : top + 256 * k]
        alpha = part[..., 3:] / 255
        ratio = _shrunk(light_of[part[..., :3]] * alpha + (1 - alpha), k) @ (XYZ / XYZ.sum(axis=1, keepdims=True)).T
        root = np.where(ratio > 216 / 24389, np.cbrt(ratio), ratio * (24389 / 27 / 116) + 16 / 116)
        x, y, z = np.moveaxis(root, -1, 0)
        bands.append(np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1).astype(np.float32))
    return np.asarray(gaussian_filter(np.concatenate(bands), (0.7, 0.7, 0)))


def _levelled(lab: Field, sample: Mask, degree: int) -> float:
    """Takes from all pixels, in place, the polynomial surface through the sample; the sample's standard deviation about it.

    Fitted by least squares, each pixel weighed anew by Cauchy's rule: up to some 4 in 10 of the sample may be other things.
    """
    h, w = sample.shape
    at = np.flatnonzero(sample)
    row, column = np.divmod(at[:: -(-len(at) // SAMPLE)], w)
    basis, values = _powers(2 * column / w - 1, 2 * row / h - 1, degree), lab[row, column].astype(np.float64)
    weight = np.ones(len(basis))
    for _ in range(15):
        weighed = basis.T * weight
        surface = np.linalg.lstsq(weighed @ basis, weighed @ values, rcond=None)[0]
        rest = values - basis @ surface
        far = np.linalg.norm(rest, axis=1)
        weight = 1 / (1 + (far / max(float(np.median(far)), 0.1)) ** 2)
    for r in range(h):
        lab[r] -= _powers(2 * np.arange(w) / w - 1, np.full(w, 2 * r / h - 1), degree) @ surface
    return float(np.linalg.norm(1.4826 * np.median(np.abs(rest), axis=0)))


def _powers(x: Array, y: Array, degree: int) -> Array:
    return np.stack([x**i * y**j for i in range(degree + 1) for j in range(degree + 1 - i)], axis=-1)


def _otsu(values: Field) -> float:
    """The threshold that leaves the values on either side the least variance."""
    counts, edges = np.histogram(values, 256)
    middle = (edges[:-1] + edges[1:]) / 2
    below, sums = np.cumsum(counts)[:-1], np.cumsum(counts * middle)[:-1]
    above, rest = counts.sum() - below, counts @ middle - sums
    return float(edges[1 + np.argmax(below * above * (rest / np.maximum(above, 1) - sums / np.maximum(below, 1)) ** 2)])


def _reached(backdrop: Mask, band: Mask) -> Mask:
    """What of the backdrop's colour hangs together with the picture's edge, or with a tenth of its border inside a frame."""
    from scipy import ndimage

    areas, n = ndimage.label(backdrop)
    outer = np.bincount(areas[band], minlength=n + 1) > 0.1 * band.sum()
    for edge in (areas[0], areas[-1], areas[:, 0], areas[:, -1]):
        outer[edge] = True
    outer[0] = False
    return np.asarray(outer[areas])


def _shares(rest: Field, body: Mask) -> Field:
    """The share of each pixel that is body: 1 well inside, 0 well outside, and between how far its colour has gone from the backdrop's
    to that of the body inside.

    Half way is the edge, wherever the threshold lay, and blurred colours shift it to neither side.
    """
    from scipy import ndimage

    inner = ndimage.binary_erosion(body, iterations=2, border_value=1)
    rim = ndimage.binary_dilation(body) & ~inner

    def about(values: Field) -> Field:
        """Means around the rim of what is well inside, or where the body is thin, of all that is body."""
        means = [ndimage.gaussian_filter(np.where(part, values, np.float32(0)), 2.5)[rim] for part in (inner, body)]
        return np.asarray(np.where(near[0] > 0.02, means[0] / np.maximum(near[0], 0.02), means[1] / np.maximum(near[1], 1e-3)))

    near = [ndimage.gaussian_filter(part.astype(np.float32), 2.5)[rim] for part in (inner, body)]
    off = np.linalg.norm(rest, axis=2)
    length = about(off)
    colour = np.stack([about(rest[..., k]) for k in range(3)], axis=1)
    square = (colour**2).sum(axis=1)
    along = (rest[rim] * colour).sum(axis=1) / np.maximum(square, 1e-6)
    share = inner.astype(np.float32)
    one = square > (0.7 * length) ** 2  # else the body is of many colours there, and only their distance counts
    share[rim] = np.clip(np.where(one, along, off[rim] / np.maximum(length, 1e-3)), 0, 1)
    return np.asarray(ndimage.gaussian_filter(share, 0.5), np.float32)


def _polygons(shape: shapely.Geometry) -> shapely.Geometry:
    """The parts of a shape that have an area, as one Polygon or MultiPolygon."""
    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and part.area > 0]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)
