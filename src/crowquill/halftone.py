"""Pixels to pixels: a picture of tones becomes a picture of black and white."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled
from crowquill.paths import Array


def floyd_steinberg(coverage: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Black pixels (h, w) whose local share follows coverage (h, w), 0 to 1, by error diffusion.

    The threshold is one half; rows run left to right, and the error of the last column and row falls off the picture.
    Source: R. W. Floyd, L. Steinberg, An Adaptive Algorithm for Spatial Grey Scale, SID 17(2), 1976.

    >>> floyd_steinberg([[0.5, 0.5], [0.5, 0.5]]).astype(int).tolist()
    [[1, 0], [0, 1]]
    """
    rest = np.array(coverage, np.float64)
    if rest.ndim != 2:
        raise ValueError(f"coverage has shape {rest.shape}; it takes rows by columns")
    black = np.zeros(rest.shape, np.bool_)
    _diffused(rest, black)
    return black


@compiled
def _diffused(rest: Array, black: npt.NDArray[np.bool_]) -> None:
    """Fills `black`; `rest` is coverage on entry and each pixel's coverage with errors received on return."""
    h, w = rest.shape
    for r in range(h):
        for c in range(w):
            black[r, c] = rest[r, c] >= 0.5
            error = rest[r, c] - (1.0 if black[r, c] else 0.0)
            if c + 1 < w:
                rest[r, c + 1] += error * 7 / 16
            if r + 1 < h:
                if c > 0:
                    rest[r + 1, c - 1] += error * 3 / 16
                rest[r + 1, c] += error * 5 / 16
                if c + 1 < w:
                    rest[r + 1, c + 1] += error * 1 / 16
