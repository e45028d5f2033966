"""Prints the NOMINAL and RENDERED columns of stippling.py, and RENDERED of styles/frontier.py: what dots cover whose areas sum to more.

Flat tones are drawn without any correction for overlap, relaxed with the style's own start and steps or placed at the frontier,
and the union of the dots is measured away from the border. Mean of three seeds.

Then the SUMS and COVERED columns of separation.py: what dots of several inks that keep clear of each other cover together, by the sum
of what each covers. Mean of two and three inks of equal tones.
"""

from collections.abc import Callable

import numpy as np

from crowquill import glyphs, measure, mingling, relax, styles
from crowquill.marks import together
from crowquill.paths import Array
from crowquill.separation import SUMS
from crowquill.stippling import NOMINAL, dotted
from crowquill.tone import Tone

SIDE, PEN = 30.0, 0.3  # mm
FLAT = Tone(np.full((50, 50), 0.5), (SIDE, SIDE))


def relaxed(dots: int, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    sites = relax.scatter(FLAT, dots, rng)
    return next(state.sites for state in relax.lloyd(sites, FLAT) if state.done == 30)


def at_frontier(dots: int, seed: int) -> Array:
    return styles.run(styles.steps("frontier", FLAT, dots=dots, pen=PEN, seed=seed)).marks.xy


def covered(nominal: float, seed: int, placed: Callable[[int, int], Array]) -> float:
    """The share covered in the middle of a square of dots of the 0.3 mm library whose areas sum to `nominal` of it."""
    library = glyphs.load("nib-03").glyphs
    sites = placed(round(nominal * SIDE**2 / (np.pi * PEN**2 / 4)), seed)
    rng = np.random.default_rng(seed)
    marks = dotted(sites, library, PEN, rng)
    cover = measure.rendered(marks, (SIDE, SIDE), (30, 30), pitch=PEN / 40)
    # what the middle really holds: borders have a ring of dots of their own
    middle = ((sites > 2) & (sites < SIDE - 2)).all(axis=1)
    held = (marks.scale[middle] ** 2).sum() / (SIDE - 4) ** 2
    return float(cover[2:-2, 2:-2].mean()) * nominal / held


def shared(inks: int, total: float) -> tuple[float, float]:
    """What so many inks cover in the middle of a square, each by itself, summed, and all together; `total` is asked for."""
    tone = Tone(np.full((50, 50), total / inks), (SIDE, SIDE))
    parts = [styles.run(styles.steps("stipple", tone, seed=seed, pen=PEN)).marks for seed in range(inks)]
    parts = styles.run(mingling.mingled(parts, [tone] * inks, tone.canvas))
    each = [measure.rendered(marks, (SIDE, SIDE), (30, 30), pitch=PEN / 40)[2:-2, 2:-2].mean() for marks in [*parts, together(parts)]]
    return float(sum(each[:-1])), float(each[-1])


if __name__ == "__main__":
    print("NOMINAL  =", NOMINAL.tolist())
    for placed in (relaxed, at_frontier):
        rendered = [0.0] + [float(np.mean([covered(nominal, seed, placed) for seed in range(3)])) for nominal in NOMINAL[1:]]
        print("RENDERED =", [round(value, 4) for value in rendered], placed.__name__)
    found = [[(0.0, 0.0), *(shared(inks, total) for total in SUMS[1:] if total / inks < 0.96), (inks, 1.0)] for inks in (2, 3)]
    every = np.mean([np.interp(SUMS, *zip(*points, strict=True)) for points in found], axis=0)
    print("SUMS     =", SUMS.tolist())
    print("COVERED  =", [round(value, 4) for value in every.tolist()])
