"""How a picture of marks repeats itself at each distance, all directions together; and what pairs of marks add to that.

Of ink and paper all features of grey level co-occurrence follow from coverage and this curve; see crowquill.texture.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array

ANGLES = 48  # directions over which a pair's share is averaged
FINE = 24  # distances of pairs to a mark's diameter


def radial(ink: npt.ArrayLike, lags: Array, pixel: float, mask: npt.ArrayLike | None = None) -> Array:
    """The correlation of ink (h, w) with itself at distances `lags` mm in even steps from 0, (m,); of the mask's pixels, or of a torus.

    Each is the mean over displacements of half a step more or less. Without ink, or without paper, all are 0; so are
    distances that no two pixels of the mask have.
    """
    from scipy import fft

    bits = np.asarray(ink, np.float64)
    inside = np.ones(bits.shape) if mask is None else np.asarray(mask, np.float64)
    p = float((bits * inside).sum() / max(inside.sum(), 1.0))
    if not 0 < p < 1:
        return np.zeros(len(lags))
    step = float(lags[1])
    reach = int((lags[-1] + step / 2) / pixel) + 1
    shape = bits.shape if mask is None else tuple(fft.next_fast_len(side + reach, real=True) for side in bits.shape)
    both = fft.irfft2(np.abs(fft.rfft2((bits - p) * inside, shape)) ** 2, shape)
    pairs = np.full(shape, float(bits.size)) if mask is None else fft.irfft2(np.abs(fft.rfft2(inside, shape)) ** 2, shape)
    down, across = (np.minimum(np.arange(side), side - np.arange(side)) * pixel for side in shape)
    near_down, near_across = (np.flatnonzero(side <= reach * pixel) for side in (down, across))
    window = np.ix_(near_down, near_across)
    ring = np.round(np.hypot(down[near_down][:, None], across[near_across]) / step).astype(np.int64).ravel()
    sums = [np.bincount(ring, values[window].ravel(), len(lags))[: len(lags)] for values in (both, pairs)]
    return np.asarray(np.where(sums[1] > 0.5, sums[0] / np.maximum(sums[1], 0.5), 0.0) / (p * (1 - p)))


def lens(distance: npt.ArrayLike, diameter: float) -> Array:
    """The area that two discs share whose centres are so far apart, mm^2."""
    t = np.clip(np.asarray(distance, np.float64) / diameter, 0, 1)
    return np.asarray(diameter**2 / 2 * (np.arccos(t) - t * np.sqrt(1 - t * t)))


def shares(lags: Array, diameter: float) -> Array:
    """What a pair of discs shares when one is moved by each of the lags in any direction: (k, m) mm^2, a row for each distance of the pair.

    Rows are FINE to a diameter, up to a diameter beyond the last lag.
    """
    apart = np.arange(int(np.ceil((lags[-1] / diameter + 1) * FINE)) + 2) * diameter / FINE
    turn = np.cos((np.arange(ANGLES) + 0.5) * np.pi / ANGLES)
    found = np.empty((len(apart), len(lags)))
    for k, r in enumerate(apart):
        found[k] = lens(np.sqrt(np.maximum(r * r + lags[:, None] ** 2 - 2 * r * lags[:, None] * turn, 0)), diameter).mean(axis=1)
    return found
