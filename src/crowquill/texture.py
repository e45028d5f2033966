"""Texture: what a picture of dots looks like at each distance from itself, and whether that looks made by hand.

Grey level co-occurrence matrices of pairs of pixels a displacement apart: R. M. Haralick, K. Shanmugam, I. Dinstein,
Textural Features for Image Classification, IEEE Trans. SMC 3(6), 1973. Applied to stippling, with hand-made work told from
computed work: R. Maciejewski, T. Isenberg, W. M. Andrews, D. S. Ebert, M. C. Sousa, W. Chen, Measuring Stipple Aesthetics in
Hand-Drawn and Computer-Generated Images, IEEE CG&A 28(2), 2008.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled
from crowquill.paths import Array, Index, frozen

Pixel = tuple[float, float]
STEPS = ((0, 1), (1, 1), (1, 0), (1, -1))  # rows and columns to the next pixel at 0, 45, 90 and 135 degrees from x towards y
FEATURES = ("contrast", "correlation", "energy", "homogeneity", "entropy")
COMPARED = np.arange(0.5, 3.001, 0.05)  # spacings: nearer, a dot's own shape decides; further, all is noise
NEAR, FAR = 0.12, 0.05  # c one and two spacings off: above, dots repeat as relaxed sites do, and hands do not
ROWS = 0.4  # c at any displacement: above, dots repeat as a lattice does. Relaxed sites stay below 0.3, patches of 400 dots too
LEAST = 400  # dots of a patch: twenty spacings each way
EVEN = 0.0025  # of p (1 - p): what changes of tone may add to c in a patch
CHANCE = 0.16  # over sqrt(dots): the standard deviation of c of random dots a spacing or two off, four angles together
MOST = 16  # patches
LIGHT = 0.15  # coverage below which relaxed sites, too, stay under NEAR and FAR


@dataclass(frozen=True, eq=False)
class Curves:
    """Features of the pairs of pixels at each displacement, angle by angle: 0, 45, 90 and 135 degrees.

    spacing   mm, the square root of a dot's share of the area
    lags      (4, m) mm, how far the displacements reach, rising
    features  by the names of FEATURES, (4, m) each
    """

    spacing: float
    lags: Array
    features: dict[str, Array]

    def at(self, ratios: npt.ArrayLike, name: str = "correlation") -> Array:
        """A feature at distances in spacings, (4, k): cubic splines between displacements, held beyond; 1 if there are under four."""
        from scipy.interpolate import CubicSpline

        wanted = np.atleast_1d(np.asarray(ratios, np.float64)) * self.spacing
        if self.lags.shape[1] < 4:
            return np.ones((4, len(wanted)))
        curve = zip(self.lags, self.features[name], strict=True)
        return np.array([CubicSpline(lag, value)(np.clip(wanted, lag[0], lag[-1])) for lag, value in curve])

    def mean(self, ratios: npt.ArrayLike, name: str = "correlation") -> Array:
        """The mean over the angles, (k,)."""
        return np.asarray(self.at(ratios, name).mean(axis=0))

    def anisotropy(self, ratios: npt.ArrayLike, name: str = "correlation") -> Array:
        """The greatest difference between two angles, (k,)."""
        return np.asarray(np.ptp(self.at(ratios, name), axis=0))


@dataclass(frozen=True)
class Patch:
    """A square of even tone: its first pixel, its side in pixels, its ink, dots and their spacing in mm."""

    row: int
    column: int
    side: int
    coverage: float
    dots: int
    spacing: float


@dataclass(frozen=True)
class Reading:
    """Whether dots lie as by hand: "hand", "mechanical" or, with no patch even and large enough, "unread"; reasons are sentences.

    near, far, peak  c one and two spacings off, means over the angles, and the largest of three quarters to three spacings off;
                     means over the patches by their dots
    """

    verdict: str
    reasons: tuple[str, ...]
    near: float
    far: float
    peak: float
    patches: tuple[Patch, ...]


def quantised(coverage: npt.ArrayLike, levels: int = 2) -> Index:
    """Coverage (h, w) of 0 to 1 in equal steps 0 to levels - 1; with two, ink is what is covered by half or more."""
    if not 2 <= levels <= 256:
        raise ValueError(f"levels {levels}; it takes 2 to 256")
    values = frozen(coverage, np.float64, (None, None), "coverage")
    if values.size and not -1e-9 <= values.min() <= values.max() <= 1 + 1e-9:
        raise ValueError(f"coverage runs from {values.min():g} to {values.max():g}; it takes 0 to 1")
    return np.clip((values * levels).astype(np.int64), 0, levels - 1)


def glcm(values: npt.ArrayLike, d: int, angle: float, levels: int = 2) -> Array:
    """The shares of pairs with levels i and j at distance d in pixels along an angle in degrees, (levels, levels), symmetric, sum 1.

    Values are (h, w) of 0 to levels - 1; see quantised(). Displacements are rounded to whole pixels. No pair at all gives zeros.
    """
    return matrix(values, round(d * float(np.sin(np.deg2rad(angle)))), round(d * float(np.cos(np.deg2rad(angle)))), levels)


def matrix(values: npt.ArrayLike, down: int, across: int, levels: int = 2) -> Array:
    """The matrix of glcm() for a displacement of so many rows and columns."""
    image = frozen(values, np.int64, (None, None), "values")
    if image.size and not 0 <= image.min() <= image.max() < levels:
        raise ValueError(f"values run from {image.min()} to {image.max()}; they take 0 to {levels - 1}")
    counts = np.zeros((levels, levels), np.int64)
    _counted(image, down, across, counts)
    both = counts + counts.T
    return np.asarray(both / max(1, both.sum()))


def features(shares: npt.ArrayLike) -> dict[str, Array]:
    """Features by name of matrices (..., levels, levels) whose shares sum to 1, each (...,).

    contrast     sum (i - j)^2 P
    correlation  sum (i - mean)(j - mean) P over the variance, mean and variance being the pairs' own; 1 where nothing
                 varies and where there are no pairs
    energy       sum P^2, the angular second moment, no root taken
    homogeneity  sum P / (1 + (i - j)^2)
    entropy      -sum P ln P

    Of two levels, with p the pairs' own share of ink, q = 1 - p and c the correlation: P11 = p^2 + cpq, P00 = q^2 + cpq,
    P01 = P10 = pq (1 - c), so that c and p say all.
    """
    p = np.asarray(shares, np.float64)
    level = np.arange(p.shape[-1])
    gap = (level[:, None] - level) ** 2
    share = p.sum(axis=-1)
    off = level - (share * level).sum(axis=-1, keepdims=True)
    variance = (share * off**2).sum(axis=-1)
    together = (p * off[..., :, None] * off[..., None, :]).sum(axis=(-2, -1))
    varies = variance > 1e-15
    return {
        "contrast": (p * gap).sum(axis=(-2, -1)),
        "correlation": np.where(varies, together / np.where(varies, variance, 1.0), 1.0),
        "energy": (p * p).sum(axis=(-2, -1)),
        "homogeneity": (p / (1 + gap)).sum(axis=(-2, -1)),
        "entropy": -(p * np.log(np.where(p > 0, p, 1.0))).sum(axis=(-2, -1)),
    }


def pairs(ink: npt.ArrayLike, reach: int) -> Array:
    """The matrices of a picture of ink and paper (h, w) for all displacements: (reach + 1, 2 reach + 1, 2, 2).

    Rows 0 to reach, columns -reach to reach; counted by a Fourier transform and rounded to whole numbers, hence exact.
    """
    from scipy import fft

    bits = np.asarray(ink, np.float64)
    h, w = bits.shape
    down, across = np.arange(reach + 1)[:, None], np.arange(-reach, reach + 1)[None, :]
    total = np.maximum(h - down, 0) * np.maximum(w - abs(across), 0)
    if not total.any():
        return np.zeros((reach + 1, 2 * reach + 1, 2, 2))
    shape = fft.next_fast_len(h + reach, real=True), fft.next_fast_len(w + reach, real=True)
    both = np.round(fft.irfft2(np.abs(fft.rfft2(bits, shape)) ** 2, shape))[: reach + 1][:, np.arange(-reach, reach + 1)]
    sums = _summed(bits)
    top, left, right = np.minimum(down, h), np.minimum(np.maximum(across, 0), w), np.minimum(np.maximum(-across, 0), w)
    first = sums[h - top, w - left] - sums[h - top, right]
    second = sums[h, w - right] - sums[h, left] - sums[top, w - right] + sums[top, left]
    apart = first + second - 2 * both
    counts = np.stack([2 * (total - both - apart), apart, apart, 2 * both], axis=-1).reshape(*total.shape, 2, 2)
    return np.asarray(counts / np.maximum(2 * total, 1)[..., None, None])


def curves(coverage: npt.ArrayLike, pixel: Pixel, spacing: float, *, longest: float = 4.0, levels: int = 2) -> Curves:
    """Features against distance, from one pixel to `longest` spacings, in the four angles.

    coverage  (h, w) of 0 to 1; with two levels what is covered by half or more is ink: as grey, c of dots 4 pixels wide
              comes out a sixth too large, as ink a twentieth too small
    spacing   mm, the square root of the area over the number of dots; pixel is (width, height) mm
    levels    8 to 16 for grey; more than two are counted displacement by displacement

    Compare curves at equal coverage only: contrast, energy and entropy follow it strongly. An empty picture has no displacement.
    """
    if not 0 < spacing < np.inf:
        raise ValueError(f"spacing {spacing} mm; it takes a length over 0")
    values = quantised(coverage, levels)
    lengths = [float(np.hypot(down * pixel[1], across * pixel[0])) for down, across in STEPS]
    count = max(0, min(min(values.shape) - 1, max(4, int(np.ceil(longest * spacing / min(lengths))) + 1)))
    every = pairs(values, count) if levels == 2 else None
    shares = [
        matrix(values, k * down, k * across, levels) if every is None else every[k * down, count + k * across]
        for down, across in STEPS
        for k in range(1, count + 1)
    ]
    return Curves(spacing, np.outer(lengths, np.arange(1, count + 1)), features(np.reshape(shares, (4, count, levels, levels))))


def distance(one: Curves, other: Curves) -> float:
    """How far apart two textures are: the root of the mean square difference of c, half a spacing to three off. 0 for the same."""
    return float(np.sqrt(np.mean((one.mean(COMPARED) - other.mean(COMPARED)) ** 2)))


def places(coverage: npt.ArrayLike) -> Array:
    """The middles of connected blots of ink, (n, 2) in pixels. Dots that touch are one: give their true places where known."""
    from scipy.ndimage import label

    blot, n = label(quantised(coverage))
    row, column = np.nonzero(blot)
    which = blot[row, column] - 1
    size = np.maximum(np.bincount(which, minlength=n), 1)
    return np.stack([np.bincount(which, column + 0.5, n) / size, np.bincount(which, row + 0.5, n) / size], axis=1)


def patches(
    coverage: npt.ArrayLike, pixel: Pixel, *, asked: npt.ArrayLike | None = None, dots: npt.ArrayLike | None = None
) -> tuple[Patch, ...]:
    """Squares of near-constant tone with 400 dots or more, which is 20 spacings wide; the largest first, none over another, 16 at most.

    asked  (h, w) of 0 to 1, the tone drawn: its variance in a square is at most 1/400 of p (1 - p), which is all it can add to c.
           Left out, ink itself must be: of 16 parts, four times as steep as random dots make it at most, and twice as uneven
    dots   (n, 2) mm; left out, connected blots are counted
    """
    ink = quantised(coverage).astype(np.float64)
    xy = places(coverage) if dots is None else np.asarray(dots, np.float64).reshape(-1, 2) / pixel
    if len(xy) < LEAST:
        return ()
    tone = [] if asked is None else [frozen(asked, np.float64, ink.shape, "asked")]
    sums = [_summed(part) for part in (ink, *tone, *(part * part for part in tone))]
    found: list[Patch] = []
    block = min(ink.shape) // 4
    least = np.sqrt(LEAST * ink.size / len(xy)) / 16  # of blocks: where dots are four times as near together as on the whole
    while block >= max(2, least) and len(found) < MOST:
        found += _even(sums, xy, block, found, (pixel[0] * pixel[1]) ** 0.5)
        block = int(block / np.sqrt(2))
    return tuple(found[:MOST])


def _even(sums: list[Array], xy: Array, block: int, taken: list[Patch], pitch: float) -> list[Patch]:
    """Even squares of four by four blocks that meet none taken nor each other, the evenest first."""
    parts = [np.diff(np.diff(total[::block, ::block], axis=0), axis=1) / block**2 for total in sums]
    down, across = (np.arange(side + 1) * block for side in parts[0].shape)
    n = _windows(np.histogram2d(xy[:, 1], xy[:, 0], [down, across])[0]).sum(axis=(-2, -1))
    ink, tilt = _windows(parts[0]), np.array([-3, -1, 1, 3]) / np.sqrt(5)
    p = ink.mean(axis=(-2, -1))
    if len(parts) == 3:
        uneven, chance = _windows(parts[2]).mean(axis=(-2, -1)) - _windows(parts[1]).mean(axis=(-2, -1)) ** 2, 0.0
    else:
        slope = sum((ink * way).mean(axis=(-2, -1)) ** 2 for way in (tilt, tilt[:, None]))
        uneven, chance = np.maximum(slope, ink.var(axis=(-2, -1)) / 4), 8 * p * p / np.maximum(n, 1)
    limit = EVEN * p * (1 - p) + chance
    row, column = np.nonzero((n >= LEAST) & (p < 1) & (p > 0) & (uneven <= limit))
    order = np.argsort(uneven[row, column], kind="stable")
    row, column, side = row[order], column[order], 4 * block
    for other in taken:
        row, column = _clear(row, column, block, other)
    picked: list[Patch] = []
    while len(row) and len(taken) + len(picked) < MOST:
        r, c = int(row[0]), int(column[0])
        picked.append(Patch(r * block, c * block, side, float(p[r, c]), int(n[r, c]), float(side * pitch / n[r, c] ** 0.5)))
        row, column = _clear(row, column, block, picked[-1])
    return picked


def _clear(row: Index, column: Index, block: int, other: Patch) -> tuple[Index, Index]:
    """Those squares of four by four blocks that do not meet the other patch."""
    down, across = (abs(2 * block * (at + 2) - 2 * start - other.side) for at, start in ((row, other.row), (column, other.column)))
    clear = np.maximum(down, across) >= 4 * block + other.side
    return row[clear], column[clear]


def read(coverage: npt.ArrayLike, pixel: Pixel, *, asked: npt.ArrayLike | None = None, dots: npt.ArrayLike | None = None) -> Reading:
    """Whether dots lie as by hand, from even patches: mechanical if c is over 0.05 two spacings off or 0.12 one spacing off.

    Arguments are those of patches(); dots should be 4 pixels wide. Both figures were set at a coverage of 0.2, between 5 and 20
    steps of relaxation. A third is ours: c over 0.4 at any displacement, for lattices turned away from the four angles.
    """
    found = patches(coverage, pixel, asked=asked, dots=dots)
    if not found:
        return Reading("unread", ("No patch of even tone is 20 spacings wide, so there is nothing to read.",), 0.0, 0.0, 0.0, ())
    ink = np.asarray(coverage, np.float64)
    figures = np.array([_figures(ink[p.row : p.row + p.side, p.column : p.column + p.side], pixel, p.spacing) for p in found])
    weights = np.array([patch.dots for patch in found])
    near, far, peak = (float(value) for value in weights @ figures / weights.sum())
    mechanical = near > NEAR or far > FAR or peak > ROWS
    said = [f"One spacing off, c is {near:.3f}: {'over' if near > NEAR else 'not over'} {NEAR}."]
    said += [f"Two spacings off, c is {far:.3f}: {'over' if far > FAR else 'not over'} {FAR}."]
    if peak > ROWS:
        said.append(f"At one displacement c is {peak:.3f}, over {ROWS}: dots lie on a lattice.")
    elif min(abs(near - NEAR), abs(far - FAR)) < (doubt := 2 * CHANCE / float(weights.sum()) ** 0.5):
        said.append(f"Chance alone moves these by up to {doubt:.3f} in {weights.sum()} dots: it is a near thing.")
    if not mechanical and float(weights @ [patch.coverage for patch in found] / weights.sum()) < LIGHT:
        said.append(f"Less than {LIGHT} of the patches is covered; even regular dots may pass there.")
    return Reading("mechanical" if mechanical else "hand", tuple(said), near, far, peak, found)


def _figures(values: Array, pixel: Pixel, spacing: float) -> tuple[float, float, float]:
    """c one and two spacings off, and the largest from three quarters of a spacing to three."""
    near, far = curves(values, pixel, spacing, longest=3).mean([1, 2])
    every = features(pairs(quantised(values), reach := min(int(3 * spacing / min(pixel)), min(values.shape) - 1)))["correlation"]
    away = np.hypot(np.arange(reach + 1)[:, None] * pixel[1], np.arange(-reach, reach + 1) * pixel[0])
    return float(near), float(far), float(every[(away >= 0.75 * spacing) & (away <= 3 * spacing)].max(initial=0.0))


def _summed(values: Array) -> Array:
    """Sums of all pixels above and left of each corner, (h + 1, w + 1)."""
    return np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))


def _windows(blocks: Array) -> Array:
    return np.lib.stride_tricks.sliding_window_view(blocks, (4, 4))


@compiled
def _counted(values: Index, down: int, across: int, counts: Index) -> None:
    """Adds to counts[i, j] each pixel of level i with one of level j so many rows below and columns to the right."""
    h, w = values.shape
    for r in range(max(0, -down), min(h, h - down)):
        for c in range(max(0, -across), min(w, w - across)):
            counts[values[r, c], values[r + down, c + across]] += 1
