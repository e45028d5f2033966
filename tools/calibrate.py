"""Prints the NOMINAL and RENDERED columns of stippling.py: what relaxed dots cover when their areas sum to more.

Flat tones are stippled without any correction for overlap, with the style's own start and steps,
and the union of the dots is measured away from the border. Mean of three seeds.
"""

import numpy as np

from crowquill import glyphs, measure, relax
from crowquill.stippling import NOMINAL, dotted
from crowquill.tone import Tone

SIDE, PEN = 30.0, 0.3  # mm


def covered(nominal: float, seed: int) -> float:
    """The share covered in the middle of a square of dots of the 0.3 mm library whose areas sum to `nominal` of it."""
    rng = np.random.default_rng(seed)
    tone = Tone(np.full((50, 50), 0.5), (SIDE, SIDE))
    library = glyphs.load("nib-03").glyphs
    sites = relax.scatter(tone, round(nominal * SIDE**2 / (np.pi * PEN**2 / 4)), rng)
    sites = next(state.sites for state in relax.lloyd(sites, tone) if state.done == 30)
    marks = dotted(sites, library, PEN, rng)
    cover = measure.rendered(marks, (SIDE, SIDE), (30, 30), pitch=PEN / 40)
    # what the middle really holds: borders have a ring of dots of their own
    middle = ((sites > 2) & (sites < SIDE - 2)).all(axis=1)
    held = (marks.scale[middle] ** 2).sum() / (SIDE - 4) ** 2
    return float(cover[2:-2, 2:-2].mean()) * nominal / held


if __name__ == "__main__":
    rendered = [0.0] + [float(np.mean([covered(nominal, seed) for seed in range(3)])) for nominal in NOMINAL[1:]]
    print("NOMINAL  =", NOMINAL.tolist())
    print("RENDERED =", [round(value, 4) for value in rendered])
