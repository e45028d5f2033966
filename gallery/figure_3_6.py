"""Relaxation without weights loses the picture: the points of a halftone, and the same after 20 steps of Lloyd's.

Size on paper: 180 x 99 mm, two panels of 80 x 87 mm.
Source: S. Lloyd, Least Squares Quantization in PCM, 1982; specimen.png is rendered by tools/specimen.py.
"""

from itertools import islice
from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Marks, Paths, Sheet, Tone, lloyd, save, scatter
from crowquill.glyphs import load


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    first = scatter(tone, 6000, np.random.default_rng(1), "floyd-steinberg")
    *_, last = islice(lloyd(first, tone, step=1, exponent=0), 21)  # the first state is before any step

    frame = np.array([(0, 0), (80, 0), (80, tone.size[1]), (0, tone.size[1])])
    right = np.array([88, 0])
    dots = Marks.of(np.concatenate([first, last.sites + right]), load("disc").glyphs, scale=0.45 * np.sqrt(np.pi / 4))
    layers = (
        Layer(Ink(pen=0.2), Paths.of([frame, frame + right]), "frames"),
        Layer(Ink(), dots, "points"),
    )
    return Sheet((168, tone.size[1]), layers).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
