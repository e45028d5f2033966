"""How a set of sites looks at every scale: periodogram and its rings, pair correlation.

A set is judged against the density that it should have: coverage of a tone, so scaled that it asks for as many sites as there are.
Lengths are counted in spacings, sqrt(1 / density), and frequencies in cycles a spacing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.kernel import compiled
from crowquill.paths import Array, Index, frozen
from crowquill.tone import Tone

TOP = 2.0  # cycles a spacing: the highest frequency of a periodogram
RING = 0.1  # cycles a spacing: so wide are the rings of a radial mean
FEWEST = 4  # frequencies that a ring must have
NOTHING = 1e-12  # of the power of random sites: rounding, which has no direction
STILL = -100.0  # dB: anisotropy of a ring without power, and the least there is
WIDTH = 10  # grid lines that a site is spread over: sums come out within 1e-8 of the sum of weights
BETA = 2.3 * WIDTH  # of the Kaiser-Bessel window on a grid twice as fine as the frequencies ask
PATCH = (64, 1024)  # sites that a patch is to have, at least and at most
PROBES = 16  # places across a patch where its density is asked
LEVEL = 0.25  # spread of density over its mean: a patch of more has no spacing of its own
SMOOTH = 2.0  # mean spacings: density is the mean coverage of a square of this side
REACH = 3.0  # spacings of a pair correlation, and the width of a bin
BIN = 0.05
CENTRES, PAIRS = 20_000, 1_000_000  # the most that a pair correlation takes in: counts of a bin stray by 2 % at one spacing
STEEP = 4.0  # a neighbour counts at most so many times: one on next to white paper would drown the others


@dataclass(frozen=True, eq=False)
class Density:
    """How many sites a mm^2 a tone asks for around a place, n on all of its canvas.

    sums  (2, h + 1, w + 1) coverage and share on the canvas of the pixels above and left of each corner
    """

    tone: Tone
    n: int
    sums: Array

    @classmethod
    def of(cls, tone: Tone, n: int) -> Density:
        """The density of a tone for n sites."""
        sums = np.zeros((2, tone.coverage.shape[0] + 1, tone.coverage.shape[1] + 1))
        sums[:, 1:, 1:] = np.cumsum(np.cumsum([tone.coverage * tone.inside, tone.inside], axis=1), axis=2)
        return cls(tone, n, sums)

    def around(self, places: npt.ArrayLike, side: npt.ArrayLike | None = None) -> tuple[Array, Array]:
        """The density around each place (m, 2), and the share of its square that lies on the canvas.

        The mean over a square, or the part of it on the canvas, `side` mm wide or two mean spacings: a photograph's noise,
        finer than dots, is no density. Without ink, or off the canvas, 0.
        """
        xy, total = np.asarray(places, np.float64).reshape(-1, 2), self.sums[0, -1, -1] * np.prod(self.tone.pixel)
        if not self.n or not total > 0:
            return np.zeros(len(xy)), np.zeros(len(xy))
        half = (SMOOTH * np.sqrt(shapely.area(self.tone.canvas) / self.n) if side is None else np.asarray(side, np.float64)) / 2
        half = np.broadcast_to(half, len(xy))[:, None]
        ink, inside = self._inside(xy - half, xy + half)
        some = inside > 0
        found = np.where(some, ink / np.where(some, inside, 1.0), 0.0) * (self.n / total)
        return np.maximum(found, 0.0), inside / (4 * half[:, 0] ** 2)

    def _inside(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Ink and area of the canvas in boxes from low to high (m, 2) mm, exact where the canvas cuts no pixel."""
        (h, w), pixel = self.tone.coverage.shape, np.array(self.tone.pixel)
        found = np.zeros((2, len(low)))
        for x, across in ((low[:, 0], -1.0), (high[:, 0], 1.0)):
            for y, down in ((low[:, 1], -1.0), (high[:, 1], 1.0)):
                u, v = np.clip(x / pixel[0], 0, w), np.clip(y / pixel[1], 0, h)
                i, j = np.minimum(u.astype(np.int64), w - 1), np.minimum(v.astype(np.int64), h - 1)
                s, t = u - i, v - j
                above = (1 - s) * self.sums[:, j, i] + s * self.sums[:, j, i + 1]
                below = (1 - s) * self.sums[:, j + 1, i] + s * self.sums[:, j + 1, i + 1]
                found += across * down * ((1 - t) * above + t * below)
        return found[0] * pixel.prod(), found[1] * pixel.prod()


@dataclass(frozen=True, eq=False)
class Radial:
    """Power by frequency: 1 is that of random sites.

    frequency   (k,) cycles a spacing, the middles of rings a tenth wide; rings of fewer than four frequencies are left out
    power       (k,) mean of the ring
    anisotropy  (k,) dB, the variance within the ring over the square of its mean: a mean of m random sets has
                -10 log10(m), a lattice more than 0; -100 where there is no power
    patches     how many sets or patches were averaged
    share       of the sites that lie in a patch
    """

    frequency: Array
    power: Array
    anisotropy: Array
    patches: int = 1
    share: float = 1.0


def periodogram(sites: npt.ArrayLike, size: tuple[float, float]) -> tuple[Array, Array]:
    """The power |sum exp(-2 pi i f s)|^2 / n of sites (n, 2) on a torus of size (width, height) mm, each frequency's.

    Gives f (m, 2) in cycles a spacing, those with a whole number of periods both ways, of one of each two opposite,
    without 0 and up to 2, and the power (m,). No site has none. For a drawing, which is no torus, see of_patches.
    """
    sites = frozen(sites, np.float64, (None, 2), "sites")
    n, sides = len(sites), np.array(size, np.float64)
    step = np.sqrt(sides.prod() / max(n, 1)) / sides
    top = (int(TOP / step[0]), int(TOP / step[1])) if n else (0, 0)
    down, across = np.mgrid[-top[1] : top[1] + 1, : top[0] + 1]
    f = np.stack([across, down], axis=-1) * step
    kept = ((across > 0) | (down > 0)) & (np.hypot(f[..., 0], f[..., 1]) <= TOP)
    power = np.abs(transform(sites / sides, np.ones(n), top)) ** 2 / max(n, 1)
    return f[kept], power[kept]


def transform(sites: Array, weights: Array, top: tuple[int, int]) -> npt.NDArray[np.complex128]:
    """Sums of weight exp(-2 pi i (k x + l y)) over sites (n, 2) of the unit square, for k of 0 to top[0], l of -top[1] to top[1].

    Rows are l. Within 1e-8 of the sum of weights: sites are spread on a grid by a window whose own transform is then divided out.
    Source: A. Dutt, V. Rokhlin, Fast Fourier Transforms for Nonequispaced Data, 1993; J. Jackson et al., 1991, for the window.
    """
    from scipy.fft import next_fast_len, rfft2

    w, h = (max(next_fast_len(2 * (2 * k + 1), real=True), 2 * WIDTH) for k in top)
    grid = np.zeros((h, w))
    place = (sites % 1.0) * (w, h)
    _spread(place, _window(place), np.asarray(weights, np.float64), grid)
    rows, columns = np.arange(-top[1], top[1] + 1), np.arange(top[0] + 1)
    return np.asarray(rfft2(grid)[rows][:, columns] / (_window_of(rows / h)[:, None] * _window_of(columns / w)))


def _window(place: Array) -> Array:
    """The window's values (n, 2, WIDTH) at the grid lines around each place, the first being the least."""
    x = np.floor(place)[..., None] - place[..., None] + np.arange(1 - WIDTH // 2, 1 + WIDTH // 2)
    values: Array = np.i0(BETA * np.sqrt(np.maximum(0.0, 1 - (2 * x / WIDTH) ** 2)))
    return values


def _window_of(f: Array) -> Array:
    """The window's transform, f in cycles a grid line: what a grid of sites is too strong by."""
    root = np.sqrt(BETA**2 - (np.pi * WIDTH * f) ** 2)
    return WIDTH * np.sinh(root) / root


@compiled
def _spread(place: Array, window: Array, weights: Array, grid: Array) -> None:
    """Adds each site's window to the grid, which goes round."""
    for k in range(len(place)):
        i, j = int(np.floor(place[k, 0])) + 1 - WIDTH // 2, int(np.floor(place[k, 1])) + 1 - WIDTH // 2
        for b in range(WIDTH):
            row, value = (j + b) % grid.shape[0], weights[k] * window[k, 1, b]
            for a in range(WIDTH):
                grid[row, (i + a) % grid.shape[1]] += value * window[k, 0, a]


def radial(f: Array, power: Array, *, patches: int = 1, share: float = 1.0) -> Radial:
    """The rings of frequencies (m, 2) and the power (m,) at each, of one set or the mean of several."""
    ring = (np.hypot(*f.T) / RING).astype(np.int64)
    count = np.bincount(ring)
    kept = np.flatnonzero(count >= FEWEST)
    count = np.maximum(count, 1)
    mean = np.bincount(ring, power).astype(np.float64) / count
    spread = (np.bincount(ring, (power - mean[ring]) ** 2) / count)[kept]
    mean = mean[kept]
    some = (mean > NOTHING) & (spread > 1e-10 * mean**2)
    ratio = np.where(some, spread, 1.0) / np.where(some, mean, 1.0) ** 2
    return Radial(
        ((kept + 0.5) * RING).astype(np.float64), mean, np.where(some, 10 * np.log10(ratio), STILL).astype(np.float64), patches, share
    )


def of_patches(sites: npt.ArrayLike, tone: Tone) -> Radial | None:
    """The radial power of a drawing, each part of it in its own spacing; None where no part is level enough.

    Squares, which may overlap, are laid where they hold the same number of sites: a quarter of all, 1024 at most, and half as many
    while less than half the sites lie in one, down to 64. A square counts where it lies on the canvas whole and density
    spreads over it by less than a quarter of its mean. Its sites weigh a Hann window over their density, so that
    sites placed at random have a power of 1 whatever the tone; frequencies below two periods of a square, which
    the window itself has, are left out. Means are over squares, and anisotropy is of that mean.
    The smaller the squares the more a narrow peak is levelled: only sets of much the same number can be compared.
    Source: P. Welch, The Use of Fast Fourier Transform, 1967; R. Ulichney, Dithering with Blue Noise, 1988.
    """
    sites, best = _sorted(sites), None
    asked, wanted = Density.of(tone, len(sites)), min(len(sites) // 4, PATCH[1])
    around = asked.around(sites)[0]
    while wanted >= PATCH[0] and (best is None or best.share < 0.5):
        found = _welch(sites, asked, around, wanted)
        best = found if best is None or (found is not None and found.share > best.share) else best
        wanted //= 2
    return best


def _welch(sites: Array, asked: Density, around: Array, wanted: int) -> Radial | None:
    """The mean over squares that are to hold so many sites, whose densities are `around`."""
    top = int(TOP * np.sqrt(wanted))
    total, seen, count = np.zeros((2 * top + 1, top + 1)), np.zeros(len(sites), bool), 0
    probes = (np.indices((PROBES, PROBES)).reshape(2, -1).T + 0.5) / PROBES
    for low, side, within in _squares(sites, asked, wanted):
        here, level = around[within], asked.around(low + side * probes)[0]
        if len(within) < wanted // 4 or here.min() <= 0 or level.std() > LEVEL * level.mean():
            continue
        unit = (sites[within] - low) / side
        weights = np.prod(np.sin(np.pi * unit) ** 2, axis=1) / here
        total += np.abs(transform(unit, weights, (top, top))) ** 2 / (weights**2).sum()
        seen[within], count = True, count + 1
    if not count:
        return None
    down, across = np.mgrid[-top : top + 1, : top + 1]
    f = np.stack([across, down], axis=-1) / np.sqrt(wanted)
    kept = ((across > 0) | (down > 0)) & (np.maximum(across, np.abs(down)) > 1) & (np.hypot(across, down) <= TOP * np.sqrt(wanted))
    return radial(f[kept], total[kept] / count, patches=count, share=float(seen.mean()))


def _sorted(sites: npt.ArrayLike) -> Array:
    """The sites in an order of their own, so that the one they came in makes no difference."""
    checked = frozen(sites, np.float64, (None, 2), "sites")
    return np.asarray(checked[np.lexsort(checked.T)])


def _squares(sites: Array, asked: Density, wanted: int) -> list[tuple[Array, float, Index]]:
    """Corner, side and sites of squares on the canvas that are to hold so many sites, about middles of half as many."""
    from scipy.spatial import cKDTree

    tone = asked.tone
    if not tone.ink > 0:
        return []
    middle = np.array([sites[group].mean(axis=0) for group in _groups(sites, wanted // 2)])
    side, fits = np.full(len(middle), np.sqrt(shapely.area(tone.canvas) * wanted / len(sites))), np.zeros(len(middle), bool)
    for _ in range(12):  # side and density settle within a per cent where the tone is level
        side = np.minimum(side, min(tone.size))
        middle = np.clip(middle, side[:, None] / 2, np.array(tone.size) - side[:, None] / 2)
        found, inside = asked.around(middle, side)
        fits = np.abs(found * side**2 / wanted - 1) < 0.02
        if fits.all():
            break
        side = np.where(fits | (found <= 0), side, np.sqrt(wanted / np.where(found > 0, found, 1.0)))
    tree, kept = cKDTree(sites), np.zeros(len(middle), bool)
    for k in np.flatnonzero(fits & (inside > 1 - 1e-9)):  # rounding of sums over the pixels
        away = np.abs(middle[kept] - middle[k]).max(axis=1)
        kept[k] = not (away < side[k] / 4).any()  # a clump, which many groups share, is not seen many times
    within = [np.array(tree.query_ball_point(middle[k], side[k] / 2, p=np.inf), np.int64) for k in np.flatnonzero(kept)]
    return list(zip(middle[kept] - side[kept, None] / 2, side[kept].tolist(), within, strict=True))


def _groups(sites: Array, most: int) -> list[Index]:
    """Sites in groups of at most so many, halved across the longer side until they are."""
    waiting, found = [np.arange(len(sites))], []
    while waiting:
        group = waiting.pop()
        if len(group) <= most:
            found.append(group)
            continue
        axis = int(np.argmax(np.ptp(sites[group], axis=0)))
        order = np.argpartition(sites[group, axis], len(group) // 2)
        waiting += [group[order[: len(group) // 2]], group[order[len(group) // 2 :]]]
    return found


def pair_correlation(sites: npt.ArrayLike, tone: Tone) -> tuple[Array, Array]:
    """Distances (k,) in spacings, and how much more often two sites are so far apart than random ones: 1 is no more (k,).

    Distances count in the spacing at one of the two; the other weighs the density there over its own, at most four times, so that
    sites placed at random come out at 1 whatever the tone. Only sites count that lie three spacings or more inside the
    canvas and on ink. Both arrays are empty where there are none; coincident sites are in the first bin. Of many sites 20 000 are
    asked, of crowded ones fewer.
    Source: A. Baddeley, J. Moller, R. Waagepetersen, Non- and semi-parametric estimation of interaction, 2000.
    """
    from scipy.spatial import cKDTree

    sites = _sorted(sites)
    asked = Density.of(tone, len(sites)).around(sites)[0]
    reach = REACH / np.sqrt(np.where(asked > 0, asked, 1.0))
    inner = np.flatnonzero((asked > 0) & tone.holds(sites))
    outline = shapely.boundary(tone.canvas)
    shapely.prepare(outline)
    inner = inner[~shapely.dwithin(outline, shapely.points(sites[inner]), reach[inner])][:: 1 + len(inner) // CENTRES]
    if not len(inner):
        return np.zeros(0), np.zeros(0)
    # a heap of coincident sites is one place of the tree, many times over
    first = np.flatnonzero(np.concatenate([[True], (sites[1:] != sites[:-1]).any(axis=1)]))
    heap, times = np.searchsorted(first, inner, side="right") - 1, np.diff(np.append(first, len(sites)))
    tree = cKDTree(sites[first])
    crowd = int(tree.query_ball_point(sites[inner], reach[inner], return_length=True).sum())
    inner, heap = inner[:: 1 + crowd // PAIRS], heap[:: 1 + crowd // PAIRS]
    found = tree.query_ball_point(sites[inner], reach[inner])
    counts = [len(others) for others in found]
    one, own = np.repeat(inner, counts), np.repeat(heap, counts)
    place = np.concatenate([np.asarray(others, np.int64) for others in found])
    other, often = first[place], times[place] - (place == own)
    apart = np.hypot(*(sites[one] - sites[other]).T) / reach[one] * REACH
    weight = np.minimum(asked[one] / np.maximum(asked[other], asked[one] / STEEP), STEEP)
    edges = np.linspace(0, REACH, round(REACH / BIN) + 1)
    total = np.histogram(apart, edges, weights=weight * often)[0]
    return (edges[1:] + edges[:-1]) / 2, total / (len(inner) * np.pi * np.diff(edges**2))
