"""Likeness: how near a drawing comes to the tone asked for, once both are seen from where dots run together.

Drawing and picture are coverage (h, w) of 0 to 1 on the same pixels of (width, height) mm, and every blur is a Gaussian of a
stated width in mm, its standard deviation, the same for both. It reaches four widths, and pictures go on past their
border as in a mirror, the pixel at the border twice. What is blurred widely is looked at only every few pixels, 1.5 or more
to a width: nothing is left between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, frozen
from crowquill.tone import Tone

VIEWED = (0.10, 0.19)  # mm: a minute of arc at 35 and at 65 cm, where drawings are held
SCORED = 8 / 1000  # of the picture's width: the blur by which stippling programs were compared
BANDS = 10  # of asked tone
FEW = 0.005  # of all pixels: a band with fewer is not called the worst
C1, C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2  # 6.5025 and 58.5225, as published
FINE = 1.5  # pixels to a blur's width at least; what varies faster than they show is below 2e-5
STEPS = 12  # of Gauss and Newton at each blur
Pixel = tuple[float, float]


@dataclass(frozen=True)
class Band:
    """Where the blurred picture asks for `low` to `high`: what share of the pixels that is, and how the drawing errs there."""

    low: float
    high: float
    share: float
    bias: float
    rmse: float


@dataclass(frozen=True, eq=False)
class ToneError:
    """The drawing's coverage less the picture's, both after a blur of `width` mm.

    bias, rmse  the mean, which no blur changes, and the root of the mean square
    bands       ten of asked tone
    error       the difference after the blur, for a map; of every few pixels, as steps() has it
    """

    width: float
    bias: float
    rmse: float
    bands: tuple[Band, ...]
    error: Array

    @property
    def worst(self) -> Band | None:
        """The band furthest off on the whole, of those with a two-hundredth of the pixels; None of an empty picture."""
        return max((band for band in self.bands if band.share >= FEW), key=lambda band: abs(band.bias), default=None)


@dataclass(frozen=True)
class Shift:
    """How far the drawing lies off the picture: x and y in mm, and the standard error of each.

    The error is what dots alone would do were they thrown at random; of dots evenly spread it is less. A picture that
    does not vary along a direction says nothing of it: 0, with an error that is infinite.
    """

    x: float
    y: float
    x_error: float
    y_error: float


def asked(tone: Tone, grid: tuple[int, int]) -> Array:
    """The tone's coverage inside its canvas, none outside, as means over the pixels of a grid (h, w): exact, whatever both sizes."""
    values = np.asarray(tone.coverage * tone.inside)
    for axis, n in enumerate(grid):
        total = np.insert(values.cumsum(axis=axis), 0, 0.0, axis=axis)
        at = np.linspace(0, values.shape[axis], n + 1)
        below = np.minimum(at.astype(np.int64), values.shape[axis] - 1)
        share = (at - below).reshape((-1, 1) if axis == 0 else (1, -1))
        ends = total.take(below, axis=axis) * (1 - share) + total.take(below + 1, axis=axis) * share
        values = np.diff(ends, axis=axis) * (n / values.shape[axis])
    return np.clip(values, 0, 1)


def steps(width: float, pixel: Pixel) -> tuple[int, int]:
    """Every how many rows and columns a picture is looked at after a blur of `width` mm."""
    return max(1, int(width / pixel[1] / FINE)), max(1, int(width / pixel[0] / FINE))


def blurred(values: npt.ArrayLike, width: float, pixel: Pixel, step: tuple[int, int] = (1, 1)) -> Array:
    """Values (h, w) after a Gaussian of this width in mm, every so many rows and columns from the middle of the first so many.

    None for a width of 0.
    """
    if not 0 <= width < np.inf:
        raise ValueError(f"width {width} mm; it takes a length, or 0 for no blur")
    array = np.ascontiguousarray(values, np.float64)
    if array.size == 0:
        return _looked_at(array, step)
    taps = []
    for side in (pixel[1], pixel[0]):
        at = np.arange(-int(4 * width / side + 0.5), int(4 * width / side + 0.5) + 1)
        weight = np.exp(-0.5 * (at * side / (width or 1.0)) ** 2)
        taps.append(weight / weight.sum())
    rows, columns = (-(-(n - (k - 1) // 2) // k) for n, k in zip(array.shape, step, strict=True))
    out = np.zeros((max(rows, 1), max(columns, 1)))
    shared_out(lambda lo, hi: _blurred(array, taps[0], taps[1], *step, lo, out[lo:hi]), len(out), 64)
    return out


def tone_error(
    drawn: npt.ArrayLike, wanted: npt.ArrayLike, pixel: Pixel, width: float, *, within: npt.ArrayLike | None = None
) -> ToneError:
    """What is left of the difference between a drawing and its picture after a blur of `width` mm.

    within  (h, w) weights of the pixels counted, a canvas's share of each; left out, all alike

    Of empty pictures, or where nothing is counted, all figures are 0.
    """
    ours, theirs = _both(drawn, wanted)
    weight = np.ones(ours.shape) if within is None else frozen(within, np.float64, ours.shape, "within")
    step = steps(width, pixel)
    error = blurred(ours - theirs, width, pixel, step)
    band = np.clip((blurred(theirs, width, pixel, step) * BANDS + 1e-9).astype(np.int64), 0, BANDS - 1).ravel()
    bias = float((weight * (ours - theirs)).sum() / (weight.sum() or 1.0))
    weight = _looked_at(weight, step)
    sums = [np.bincount(band, (weight * part).ravel(), BANDS) for part in (np.ones(1), error, error * error)]
    total, n = float(sums[0].sum()) or 1.0, np.where(sums[0] > 0, sums[0], 1.0)
    figures = np.stack([sums[0] / total, sums[1] / n, np.sqrt(sums[2] / n)], axis=1)
    bands = tuple(Band(k / BANDS, (k + 1) / BANDS, *map(float, figures[k])) for k in range(BANDS))
    error.setflags(write=False)
    return ToneError(width, bias, float(np.sqrt(sums[2].sum() / total)), bands, error)


def widths(spacing: float) -> tuple[float, ...]:
    """The blurs at which tone is judged, mm: one and two mean spacings of dots, and the eye's own."""
    return (spacing, 2 * spacing, *VIEWED)


def scored(drawn: npt.ArrayLike, wanted: npt.ArrayLike) -> float:
    """The root mean square error after a Gaussian of 8 pixels on a picture of 1000 across, as stippling programs were compared."""
    ours, theirs = _both(drawn, wanted)
    return tone_error(ours, theirs, (1.0, 1.0), SCORED * ours.shape[1]).rmse


def ssim(one: npt.ArrayLike, other: npt.ArrayLike) -> float:
    """The mean structural similarity of two pictures (h, w) of 0 to 255: 1 for the same, near 0 for strangers.

    Windows are Gaussian, 11 by 11 pixels, of standard deviation 1.5; variances are the windows' own (no n - 1). The
    mean is taken over the pixels whose window lies in the picture, which is without 5 at each border, or, of
    pictures less than 11 wide or high, over all, mirrored. Empty pictures are the same.
    Source: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, Image Quality Assessment: From Error Visibility
    to Structural Similarity, IEEE Trans. Image Processing 13(4), 2004.
    """
    from scipy.ndimage import gaussian_filter

    x, y = _both(one, other)
    if x.size == 0:
        return 1.0
    mx, my, xx, yy, xy = (gaussian_filter(part, 1.5, truncate=3.5, mode="reflect") for part in (x, y, x * x, y * y, x * y))
    vx, vy, both = xx - mx * mx, yy - my * my, xy - mx * my
    every = (2 * mx * my + C1) * (2 * both + C2) / ((mx * mx + my * my + C1) * (vx + vy + C2))
    return float((every[5:-5, 5:-5] if min(x.shape) > 10 else every).mean())


def psnr(one: npt.ArrayLike, other: npt.ArrayLike) -> float:
    """The peak signal to noise ratio of two pictures (h, w) of 0 to 255 in dB; infinite for the same and for empty ones."""
    x, y = _both(one, other)
    mean = float(np.mean((x - y) ** 2)) if x.size else 0.0
    return float(10 * np.log10(255**2 / mean)) if mean > 0 else float("inf")


def similarity(drawn: npt.ArrayLike, wanted: npt.ArrayLike, pixel: Pixel, width: float) -> tuple[float, float]:
    """ssim() and psnr() of a drawing and its picture as light, 255 for bare paper, after a blur of `width` mm; never without one.

    Both are taken at the pixels of steps(), so that windows grow with the blur and figures keep when a drawing is rendered finer.
    """
    if not width > 0:
        raise ValueError(f"width {width} mm; dots are likened to tone after a blur only, of a length over 0")
    one, other = (255 * (1 - blurred(part, width, pixel, steps(width, pixel))) for part in _both(drawn, wanted))
    return ssim(one, other), psnr(one, other)


def edges_kept(drawn: npt.ArrayLike, wanted: npt.ArrayLike, pixel: Pixel, width: float, *, within: npt.ArrayLike | None = None) -> float:
    """How much of the picture's edges the drawing keeps: 1 all, 0 none, below 0 where light and dark have changed places.

    Both are blurred by `width` mm, a mean spacing of dots. With G the picture's gradient and H the drawing's: sum G.H over
    sum G.G, which is the gradient of the drawing projected on the picture's. What is uncorrelated with the picture, as the
    dots' own noise, adds nothing on the whole; too much contrast gives more than 1. The definition is our own: others compare the
    magnitudes of gradients pixel by pixel (W. Xue, L. Zhang, X. Mou, A. C. Bovik, Gradient Magnitude Similarity
    Deviation, IEEE Trans. Image Processing 23(2), 2014), which dots, having edges everywhere, would not pass.
    A picture without edges has none to lose: 1.
    """
    ours, theirs = _both(drawn, wanted)
    weight = np.ones(ours.shape) if within is None else frozen(within, np.float64, ours.shape, "within")
    step = steps(width, pixel)
    weight, kept, energy = _looked_at(weight, step), 0.0, 0.0
    one, other = (blurred(part, width, pixel, step) for part in (ours, theirs))
    for axis, side in enumerate((pixel[1] * step[0], pixel[0] * step[1])):
        if other.shape[axis] > 1 and other.size:
            h, g = (np.asarray(np.gradient(part, side, axis=axis)) for part in (one, other))
            energy += float((weight * g * g).sum())
            kept += float((weight * g * h).sum())
    return kept / energy if energy > 1e-20 * max(other.size, 1) / min(pixel) ** 2 else 1.0


def shift(drawn: npt.ArrayLike, wanted: npt.ArrayLike, pixel: Pixel, width: float) -> Shift:
    """How far a drawing lies off its picture, from blurs of eight times `width` mm down to one; see Shift.

    The picture is moved, made lighter or darker and of more or less contrast until it comes nearest to the drawing in squares,
    so that a fault of tone is not taken for one of place. Shifts to about six widths are found, less in small pictures. A strip at
    the border is left out, an eighth of the shorter side at most. Pictures under 8 pixels wide or high, or without
    change, say nothing: 0, with infinite errors. Dots stand off a hard edge: one alone moves a drawing by 3 % of a spacing.
    Source: B. D. Lucas, T. Kanade, An Iterative Image Registration Technique, IJCAI 1981.
    """
    ours, theirs = _both(drawn, wanted)
    if not 0 < width < np.inf:
        raise ValueError(f"width {width} mm; it takes a length over 0")
    most = (np.array(ours.shape) * (pixel[1], pixel[0])).min(initial=np.inf) / 16
    first = steps(width, pixel)
    sides = pixel[0] * first[1], pixel[1] * first[0]
    seen = [blurred(part, width, pixel, first) for part in (ours, theirs)]
    at, error = np.zeros(2), np.full(2, np.inf)
    for blur in [times * width for times in (8, 4, 2) if times * width <= most] + [width]:
        more = float(np.sqrt(blur**2 - width**2))
        down, across = steps(more, sides)
        one, other = (blurred(part, more, sides, (down, across)) for part in seen)
        if min(one.shape) >= 8:
            at, error = _registered(one, other, np.array([sides[1] * down, sides[0] * across]), at, blur)
    return Shift(float(at[1]), float(at[0]), float(error[1]), float(error[0]))


def _registered(drawn: Array, wanted: Array, step: Array, at: Array, width: float) -> tuple[Array, Array]:
    """The shift (y, x) mm that best moves `wanted` onto `drawn`, sought from `at`, and its standard errors."""
    from scipy.ndimage import shift as moved

    error = np.full(2, np.inf)
    for _ in range(STEPS):
        edge = np.minimum(np.array(wanted.shape) // 8, np.ceil((2 * width + abs(at)) / step).astype(np.int64) + 1)
        inner = tuple(slice(int(e), -int(e)) for e in edge)
        image = moved(wanted, at / step, order=3, mode="nearest")
        down, across = (np.asarray(np.gradient(image, side, axis=axis))[inner].ravel() for axis, side in enumerate(step))
        value = image[inner].ravel()
        rows = np.stack([-down, -across, value - value.mean(), np.ones(value.size)], axis=1)
        # a direction without gradient is left alone, not blown up
        normal, away = rows.T @ rows, rows.T @ (drawn[inner].ravel() - value)
        scale = np.sqrt(np.maximum(np.diag(normal), 1e-30))
        level = 1e-6 * np.sqrt(value.size) / width  # of gradient: below is rounding
        known = scale > np.array([level, level, 1e-9, 0.0])
        inverse = np.linalg.pinv(np.where(known[:, None] & known, normal / np.outer(scale, scale), 0.0), rcond=1e-8, hermitian=True)
        change = inverse @ (away / scale) / scale
        left = drawn[inner].ravel() - value - rows @ change
        alike = 4 * np.pi * width**2 / step.prod()  # pixels that a blur of white noise makes one
        spread = np.sqrt(np.diag(inverse)[:2] * (left**2).mean() * alike) / scale[:2]
        error = np.where(known[:2], spread, np.inf)
        change = np.clip(change[:2], -width, width)
        at = at + change
        if abs(change).max() < 1e-4 * width:
            break
    return at, error


def _looked_at(weight: Array, step: tuple[int, int]) -> Array:
    """Of weights (h, w) those of the pixels that blurred() gives."""
    return weight[tuple(slice(min((k - 1) // 2, n - 1) if n else 0, None, k) for n, k in zip(weight.shape, step, strict=True))]


def _both(one: npt.ArrayLike, other: npt.ArrayLike) -> tuple[Array, Array]:
    """Two pictures of the same pixels, or ValueError; not copied, for they are large."""
    ours, theirs = np.asarray(one, np.float64), np.asarray(other, np.float64)
    if ours.shape != theirs.shape or ours.ndim != 2:
        raise ValueError(f"pictures have {ours.shape} and {theirs.shape} pixels; both take the same rows and columns")
    if not (np.isfinite(ours.sum()) and np.isfinite(theirs.sum())):
        raise ValueError("a picture has a value that is not finite; it takes numbers only")
    return ours, theirs


@compiled
def _blurred(values: Array, down: Array, across: Array, by: int, along: int, first: int, out: Array) -> None:
    """Fills rows of a blur from row `first` on, each `by` rows of the values below the last, with every column `along` from the last."""
    h, w = values.shape
    above, left = len(down) // 2, len(across) // 2
    line = np.empty(w + 2 * left)
    for r in range(len(out)):
        line[:] = 0
        for t in range(len(down)):
            row = (min((by - 1) // 2, h - 1) + (first + r) * by + t - above) % (2 * h)
            line[left : left + w] += down[t] * values[min(row, 2 * h - 1 - row)]
        for k in range(left):
            before, after = (-1 - k) % (2 * w), (w + k) % (2 * w)
            line[left - 1 - k] = line[left + min(before, 2 * w - 1 - before)]
            line[left + w + k] = line[left + min(after, 2 * w - 1 - after)]
        begin = min((along - 1) // 2, w - 1)
        for t in range(len(across)):
            for c in range(out.shape[1]):
                out[r, c] += across[t] * line[begin + c * along + t]
