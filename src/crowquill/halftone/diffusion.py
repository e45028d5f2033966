"""Error diffusion: where each error goes, as data, and the one loop that takes it there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled
from crowquill.paths import Array

Bits = npt.NDArray[np.bool_]
Place = tuple[int, int]
REACH = 2  # columns to either side, and rows below, that an error may go to
LEVELS = 256  # of coverage, by which weights are chosen where they differ


@dataclass(frozen=True)
class Kernel:
    """Where a pixel's error goes: to each place (columns ahead, rows below) a share, for all levels of coverage or for each.

    shares  one tuple of fractions, or one for each of LEVELS levels, in the order of `places`
    noise   how far chance lowers the threshold from a half, of a half, at each level; none where empty
    """

    places: tuple[Place, ...]
    shares: tuple[tuple[Fraction, ...], ...]
    noise: tuple[float, ...] = ()

    @classmethod
    def of(cls, divisor: int, parts: Mapping[Place, int]) -> Kernel:
        """The kernel that sends parts of a divisor to places."""
        return cls(tuple(parts), (tuple(Fraction(part, divisor) for part in parts.values()),))

    @property
    def keeps_tone(self) -> bool:
        """Whether all of every error is sent on."""
        return all(sum(shares) == 1 for shares in self.shares)


ROW = {(1, 0): 1}
NEAR = {(1, 0): 7, (-1, 1): 3, (0, 1): 5, (1, 1): 1}
BURKES = {(1, 0): 8, (2, 0): 4, (-2, 1): 2, (-1, 1): 4, (0, 1): 8, (1, 1): 4, (2, 1): 2}
STUCKI = {**BURKES, (-2, 2): 1, (-1, 2): 2, (0, 2): 4, (1, 2): 2, (2, 2): 1}
JARVIS = {
    (1, 0): 7, (2, 0): 5, (-2, 1): 3, (-1, 1): 5, (0, 1): 7, (1, 1): 5, (2, 1): 3,
    (-2, 2): 1, (-1, 2): 3, (0, 2): 5, (1, 2): 3, (2, 2): 1,
}  # fmt: skip
ATKINSON = dict.fromkeys([(1, 0), (2, 0), (-1, 1), (0, 1), (1, 1), (0, 2)], 1)
THREE = ((1, 0), (-1, 1), (0, 1))  # ahead, behind in the next row, below

# Of levels 0 to 127, for THREE, each to be shared by its own sum; those above mirror them. From the paper's appendix.
OSTROMOUKHOV = """
13,0,5 13,0,5 21,0,10 7,0,4 8,0,5 47,3,28 23,3,13 15,3,8 22,6,11 43,15,20 7,3,3 501,224,211 249,116,103 165,80,67 123,62,49
489,256,191 81,44,31 483,272,181 60,35,22 53,32,19 237,148,83 471,304,161 3,2,1 459,304,161 38,25,14 453,296,175 225,146,91
149,96,63 111,71,49 63,40,29 73,46,35 435,272,217 108,67,56 13,8,7 213,130,119 423,256,245 5,3,3 281,173,162 141,89,78
283,183,150 71,47,36 285,193,138 13,9,6 41,29,18 36,26,15 289,213,114 145,109,54 291,223,102 73,57,24 293,233,90 21,17,6
295,243,78 37,31,9 27,23,6 149,129,30 299,263,54 75,67,12 43,39,6 151,139,18 303,283,30 38,36,3 305,293,18 153,149,6 307,303,6
1,1,0 101,105,2 49,53,2 95,107,6 23,27,2 89,109,10 43,55,6 83,111,14 5,7,1 172,181,37 97,76,22 72,41,17 119,47,29
4,1,1 4,1,1 4,1,1 4,1,1 4,1,1 4,1,1 4,1,1 4,1,1 4,1,1 65,18,17 95,29,26 185,62,53 30,11,9 35,14,11 85,37,28 55,26,19 80,41,29
155,86,59 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 5,3,2 305,176,119 155,86,59 105,56,39 80,41,29
65,32,23 55,26,19 335,152,113 85,37,28 115,48,37 35,14,11 355,136,109 30,11,9 365,128,107 185,62,53 25,8,7 95,29,26 385,112,103
65,18,17 395,104,101 4,1,1
"""

# Of key levels the same, and of others how strong the noise is; straight lines lie between.
ZHOU_FANG = """
0:13,0,5 1:1300249,0,499250 2:213113,287,99357 3:351854,0,199965 4:801100,0,490999 10:704075,297466,303694
22:46613,31917,21469 32:47482,30617,21900 44:43024,42131,14826 64:36411,43219,20369 72:38477,53843,7678 77:40503,51547,7948
85:35865,34108,30026 95:34117,36899,28983 102:35464,35049,29485 107:16477,18810,14712 112:33360,37954,28685 127:35269,36066,28664
"""
NOISE = {0: 0.0, 44: 0.34, 64: 0.5, 85: 1.0, 95: 0.17, 102: 0.5, 107: 0.7, 112: 0.79, 127: 1.0}


def _own_sum(text: str) -> tuple[Fraction, ...]:
    """Numbers parted by commas as shares of their sum."""
    parts = [int(part) for part in text.split(",")]
    return tuple(Fraction(part, sum(parts)) for part in parts)


def _mirrored(half: list[tuple[Fraction, ...]]) -> tuple[tuple[Fraction, ...], ...]:
    """Shares of all levels from those of the lower half."""
    return (*half, *reversed(half))


def _between(keys: dict[int, tuple[Fraction, ...]]) -> list[tuple[Fraction, ...]]:
    """Shares of levels 0 to 127 on straight lines between those of key levels."""
    found, known = [], sorted(keys)
    for level in range(LEVELS // 2):
        low = max(key for key in known if key <= level)
        high = min(key for key in known if key >= level)
        way = Fraction(level - low, max(1, high - low))
        found.append(tuple(a + (b - a) * way for a, b in zip(keys[low], keys[high], strict=True)))
    return found


def _zhou_fang() -> Kernel:
    keys = {int(key): _own_sum(shares) for key, shares in (part.split(":") for part in ZHOU_FANG.split())}
    noise = np.interp(np.arange(LEVELS // 2), list(NOISE), list(NOISE.values())).tolist()
    return Kernel(THREE, _mirrored(_between(keys)), (*noise, *reversed(noise)))


KERNELS = {
    "diffuse-1d": Kernel.of(1, ROW),
    "floyd-steinberg": Kernel.of(16, NEAR),
    "jarvis": Kernel.of(48, JARVIS),
    "stucki": Kernel.of(42, STUCKI),
    "burkes": Kernel.of(32, BURKES),
    "atkinson": Kernel.of(8, ATKINSON),
    "ostromoukhov": Kernel(THREE, _mirrored([_own_sum(shares) for shares in OSTROMOUKHOV.split()])),
    "zhou-fang": _zhou_fang(),
}


class Diffusion:
    """A picture under way, band by band from the top: the errors that its next rows are to have.

    serpentine  odd rows run from right to left, the kernel mirrored
    row         the number of the first row, which may be below 0: rows run in
    """

    def __init__(self, kernel: Kernel, width: int, *, serpentine: bool, row: int = 0) -> None:
        self.row = row
        self._serpentine = serpentine
        self._places = np.array(kernel.places, np.int64)
        self._shares = np.array([[float(share) for share in shares] for shares in kernel.shares])
        self._owed = np.zeros((REACH + 1, width + 2 * REACH))

    def band(self, coverage: Array, threshold: Array) -> Bits:
        """Black pixels (k, w) of the next rows of coverage (k, w): black from the threshold (k, w) on."""
        black = np.empty(coverage.shape, np.bool_)
        _diffused(coverage, threshold, self._places, self._shares, self.row, self._serpentine, self._owed, black)
        self.row += len(coverage)
        return black


@compiled
def _diffused(
    coverage: Array, threshold: Array, places: npt.NDArray[np.int64], shares: Array, first: int, serpentine: bool, owed: Array, black: Bits
) -> None:
    """Fills `black`. Along a row errors go on one by one; down, they are sent once a row is done, which runs four times as fast.

    owed  (3, w + 4) the errors sent to this row and the two below, by the row's number; what falls off the sides lies in two columns each
    """
    h, w = coverage.shape
    level, error = np.zeros(w, np.int64), np.empty(w)
    ahead = np.zeros((2, len(shares)))
    for k in range(len(places)):
        if places[k, 1] == 0:
            ahead[places[k, 0] - 1] = shares[:, k]
    for r in range(h):
        row = first + r
        now = owed[row % 3]
        back = serpentine and row % 2 == 1
        if len(shares) > 1:
            for c in range(w):
                level[c] = int(coverage[r, c] * (LEVELS - 1) + 0.5)
        to_next, to_second, second = 0.0, 0.0, 0.0
        for i in range(w):
            c = w - 1 - i if back else i
            value = coverage[r, c] + now[c + REACH] + second + to_next
            dark = value >= threshold[r, c]
            black[r, c] = dark
            off = value - (1.0 if dark else 0.0)
            error[c] = off
            second = to_second
            to_next, to_second = off * ahead[0, level[c]], off * ahead[1, level[c]]
        now[:] = 0
        for k in range(len(places)):
            if places[k, 1] == 0:
                continue
            below = owed[(row + places[k, 1]) % 3]
            shift = REACH + (-places[k, 0] if back else places[k, 0])
            if len(shares) == 1:
                for c in range(w):
                    below[c + shift] += shares[0, k] * error[c]
            else:
                for c in range(w):
                    below[c + shift] += shares[level[c], k] * error[c]
