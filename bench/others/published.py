"""Published ways to place dots with NumPy, SciPy and Pillow, written here from the papers, to be timed in a process of their own.

python published.py secord|pillow FIGURES.json DARKNESS.npy DOTS PASSES OUT.npy

secord  cells are SciPy's, integrated along the scan lines of a picture enlarged to 500 pixels a cell, by tables of sums from
        the left: A. Secord, Weighted Voronoi Stippling, NPAR 2002; N. Rougier, [Re] Weighted Voronoi Stippling, ReScience 3(1),
        2017, whose numbers are used: dots by the density at first, 50 passes
pillow  Floyd and Steinberg's error diffusion on the grid whose black pixels are as many as the dots; each is one
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import zoom
from scipy.spatial import Voronoi

PIXELS = 500  # a cell
STRIP = 0.15  # of each side: what lies there is mirrored on it, so that cells end at the border


def secord(dark: np.ndarray, dots: int, passes: int) -> np.ndarray:
    """Sites (n, 2) in pixels of the picture."""
    rng = np.random.default_rng(1)
    times = max(1, int(np.ceil(np.sqrt(PIXELS * dots / dark.size))))
    fine = zoom(dark, times, order=0, grid_mode=True, mode="nearest")
    sums = np.zeros((2, fine.shape[0], fine.shape[1] + 1))
    np.cumsum(fine, axis=1, out=sums[0, :, 1:])
    np.cumsum(fine * (np.arange(fine.shape[1]) + 0.5), axis=1, out=sums[1, :, 1:])
    sites = thrown(fine, dots, rng)
    for _ in range(passes):
        sites = centroids(sites, sums)
    return sites / times


def thrown(dark: np.ndarray, dots: int, rng: np.random.Generator) -> np.ndarray:
    """Sites by rejection: a place is kept as often as it is dark."""
    kept = np.zeros((0, 2))
    while len(kept) < dots:
        xy = rng.random((2 * dots, 2)) * dark.shape[::-1]
        column, row = xy.astype(np.int64).T
        kept = np.concatenate([kept, xy[rng.random(len(xy)) < dark[row, column]]])
    return kept[:dots]


def centroids(sites: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """Where the ink of each cell has its middle; of a cell without any, its site.

    Each edge crosses the middles of some rows. What lies left of a crossing is the cell's on the left, and not the other's.
    """
    height, width = sums.shape[1], sums.shape[2] - 1
    size, copies = np.array([width, height]), [sites]
    for axis in range(2):
        for border in (0, size[axis]):
            strip = sites[abs(sites[:, axis] - border) < STRIP * size[axis]].copy()
            strip[:, axis] = 2 * border - strip[:, axis]
            copies.append(strip)
    points = np.concatenate(copies)
    cells = Voronoi(points)
    ends, pair = np.asarray(cells.ridge_vertices), cells.ridge_points
    ours = (ends >= 0).all(axis=1) & (pair < len(sites)).any(axis=1)
    ends, pair = cells.vertices[ends[ours]], pair[ours]
    ends = np.take_along_axis(ends, np.argsort(ends[:, :, 1], axis=1)[:, :, None], axis=1)
    first, last = np.clip(np.ceil(ends[:, :, 1] - 0.5), 0, height).astype(np.int64).T
    count = last - first
    edge = np.repeat(np.arange(len(ends)), count)
    row = first[edge] + np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    (x0, y0), (x1, y1) = ends[edge, 0].T, ends[edge, 1].T
    x = np.clip(np.rint(x0 + (row + 0.5 - y0) * (x1 - x0) / (y1 - y0)), 0, width).astype(np.int64)
    order = np.argsort(points[pair, 0], axis=1)
    left, right = np.take_along_axis(pair, order, axis=1)[edge].T
    mass, moment = sums[:, row, x]
    totals = [
        np.bincount(left, part, len(points))[: len(sites)] - np.bincount(right, part, len(points))[: len(sites)]
        for part in (mass, moment, mass * (row + 0.5))
    ]
    some = totals[0] > 1e-9
    middle = np.stack(totals[1:], axis=1) / np.where(some, totals[0], 1)[:, None]
    return np.where(some[:, None], middle, sites)


def pillow(dark: np.ndarray, dots: int) -> np.ndarray:
    """The middles of the black pixels, in pixels of the picture."""
    rows = round(float(np.sqrt(dots / dark.mean() * dark.shape[0] / dark.shape[1])))
    columns = round(rows * dark.shape[1] / dark.shape[0])
    light = Image.fromarray(np.uint8(np.rint(255 * (1 - dark)))).resize((columns, rows), Image.Resampling.BOX)
    y, x = np.nonzero(~np.asarray(light.convert("1")))
    return (np.stack([x, y], axis=1) + 0.5) * np.array(dark.shape[::-1]) / (columns, rows)


if __name__ == "__main__":
    way, figures, picture, dots, passes, out = sys.argv[1:]
    dark = np.load(picture)
    began, spent = time.perf_counter(), time.process_time()
    sites = secord(dark, int(dots), int(passes)) if way == "secord" else pillow(dark, int(dots))
    taken = {"seconds": time.perf_counter() - began, "cpu": time.process_time() - spent}
    Path(figures).write_text(json.dumps(taken))
    np.save(out, sites)
