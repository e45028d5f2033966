"""Pixels to pixels: a picture of tones becomes a picture of black and white, whole or band by band."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np
import numpy.typing as npt

from crowquill.halftone.diffusion import KERNELS, LEVELS, Bits, Diffusion, Kernel
from crowquill.halftone.thresholds import bayer, void_and_cluster
from crowquill.knobs import unknown
from crowquill.paths import Array

TILES = {"bayer": bayer, "void-and-cluster": void_and_cluster}
METHODS = ("threshold", "random", *KERNELS, *TILES)
KEEPING = tuple(name for name in METHODS if name != "threshold" and (name not in KERNELS or KERNELS[name].keeps_tone))  # tone
DEFAULT = "ostromoukhov"
BAND = 1 << 20  # pixels worked on at a time
RUN_IN = 64  # rows: from nothing, the first dots of a light tone come after some 2 / sqrt(tone) rows


def halftoned(coverage: npt.ArrayLike, method: str = DEFAULT, *, rng: np.random.Generator | None = None, serpentine: bool = True) -> Bits:
    """Black pixels (h, w) whose local share follows coverage (h, w), numbers of 0 to 1 or bytes of 0 to 255.

    threshold         black from a half on: no tone is kept
    random            black over a threshold by chance, pixel by pixel
    diffuse-1d        each error goes to the next pixel of the row
    floyd-steinberg   to four neighbours; jarvis and stucki to twelve, burkes to seven
    atkinson          three quarters of it to six: lights and darks lose their tone
    ostromoukhov      to three, in shares by the pixel's own coverage; zhou-fang likewise, with a threshold by chance
    bayer             over a tile of 8 x 8 thresholds; void-and-cluster 64 x 64 without a grain

    KEEPING names those whose share is the coverage.

    rng         chance, which random and zhou-fang need. Diffusions with it first run through mirrored rows above the
                picture over thresholds by chance, so that their first rows are like all others, and tiles begin anywhere;
                without it they start from nothing, in the corner
    serpentine  rows of diffusions run to and fro, else all from the left; errors fall off the picture's sides

    White stays white and black black. Raises ValueError for an unknown method and for what is no coverage.
    Source: R. W. Floyd, L. Steinberg, An Adaptive Algorithm for Spatial Grey Scale, SID 17(2), 1976; R. Ulichney, Digital
    Halftoning, MIT Press 1987; V. Ostromoukhov, A Simple and Efficient Error-Diffusion Algorithm, SIGGRAPH 2001;
    B. Zhou, X. Fang, Improving Mid-tone Quality of Variable-Coefficient Error Diffusion, SIGGRAPH 2003.

    >>> halftoned([[0.5, 0.5], [0.5, 0.5]], "floyd-steinberg").astype(int).tolist()
    [[1, 0], [0, 1]]
    """
    whole = np.asarray(coverage)
    if whole.ndim != 2:
        raise ValueError(f"coverage has shape {whole.shape}; it takes rows by columns")
    black = np.zeros(whole.shape, np.bool_)
    rows = max(RUN_IN, BAND // max(1, whole.shape[1]))
    at = 0
    for band in bands((whole[top : top + rows] for top in range(0, len(whole), rows)), method, rng=rng, serpentine=serpentine):
        black[at : at + len(band)] = band
        at += len(band)
    return black


def bands(
    rows: Iterable[npt.NDArray[np.generic]], method: str = DEFAULT, *, rng: np.random.Generator | None = None, serpentine: bool = True
) -> Iterator[Bits]:
    """The same for a picture that comes as bands (k, w) of its rows from the top, and goes as such: no more than one is held.

    What bands there are does not show, if the first has RUN_IN rows or is all.
    """
    if method not in METHODS:
        raise ValueError(f"no {unknown('method', method, METHODS)}")
    kernel = KERNELS.get(method)
    if rng is None and (method == "random" or (kernel and kernel.noise)):
        raise ValueError(f"method {method} goes by chance and rng is None; give a generator")
    ready = (_checked(band) for band in rows)
    return _by_threshold(ready, method, rng) if kernel is None else _by_diffusion(ready, kernel, rng, serpentine)


def floyd_steinberg(coverage: npt.ArrayLike) -> Bits:
    """Black pixels (h, w) of coverage (h, w), 0 to 1, by error diffusion as it was published: all rows from the left.

    >>> floyd_steinberg([[0.5, 0.5], [0.5, 0.5]]).astype(int).tolist()
    [[1, 0], [0, 1]]
    """
    return halftoned(coverage, "floyd-steinberg", serpentine=False)


def _checked(band: npt.NDArray[np.generic]) -> Array:
    """Coverage of a band, 0 to 1."""
    share: Array = np.ascontiguousarray(band, np.float64)
    share = share / 255 if band.dtype == np.uint8 else share
    if share.size and not 0 <= share.min() <= share.max() <= 1:
        raise ValueError(f"coverage runs from {share.min():g} to {share.max():g}; it takes 0 to 1, or bytes")
    return share


def _by_threshold(rows: Iterator[Array], method: str, rng: np.random.Generator | None) -> Iterator[Bits]:
    """Black where coverage reaches a threshold of its pixel; no threshold is 0, so that white stays white."""
    tile = TILES[method]() if method in TILES else np.full((1, 1), 0.5)
    down, across = rng.integers(len(tile), size=2) if rng else (0, 0)
    for band in rows:
        k, w = band.shape
        if method == "random":
            assert rng is not None
            yield band > rng.random(band.shape)
            continue
        yield band >= tile[(np.arange(k) + down)[:, None] % len(tile), (np.arange(w) + across) % len(tile)]
        down += k


def _by_diffusion(rows: Iterator[Array], kernel: Kernel, rng: np.random.Generator | None, serpentine: bool) -> Iterator[Bits]:
    """Black pixels, band by band, after rows that run in."""
    first = next(rows, None)
    if first is None:
        return
    lead = first[:RUN_IN][::-1] if rng else first[:0]
    work = Diffusion(kernel, first.shape[1], serpentine=serpentine, row=-len(lead))
    if rng:
        work.band(np.ascontiguousarray(lead), 0.25 + 0.5 * rng.random(lead.shape))
    for band in chain([first], rows):
        yield work.band(band, _threshold(band, kernel, rng))


def _threshold(band: Array, kernel: Kernel, rng: np.random.Generator | None) -> Array:
    """A half, or by chance as far below it as the noise goes at each pixel's level."""
    if not kernel.noise:
        return np.full(band.shape, 0.5)
    assert rng is not None
    level = (band * (LEVELS - 1) + 0.5).astype(np.uint8)
    return np.asarray(0.5 - 0.5 * np.array(kernel.noise)[level] * rng.random(band.shape))
