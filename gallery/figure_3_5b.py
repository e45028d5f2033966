"""How the points of figure 3.5a move in 20 steps of Lloyd's relaxation: from dot to arrow head, each into its last cell.

Size on paper: 90 x 90 mm, the frame 80 mm square.
Source: S. Lloyd, Least Squares Quantization in PCM, IEEE Transactions on Information Theory 28(2), 1982.
"""

from itertools import islice
from pathlib import Path

import numpy as np

from crowquill import Glyph, Ink, Layer, Marks, Paths, Sheet, Tone, lloyd, save, scatter
from crowquill.glyphs import load


def make() -> Sheet:
    paper = Tone(np.ones((1, 1)), (80, 80))
    first = scatter(paper, 100, np.random.default_rng(1780), "random")
    states = list(islice(lloyd(first, paper, step=1, exponent=0), 21))  # the first is before any step
    tracks = np.stack([state.sites for state in states], axis=1)  # (100, 21, 2)

    x, y = (tracks[:, -1] - tracks[:, -6]).T  # the way each was going
    arrow = Glyph.of(Paths.of([[(-0.7, -0.6), (1.4, 0), (-0.7, 0.6)]]))
    layers = (
        Layer(Ink(pen=0.1), states[-1].cells.rings, "cells"),
        Layer(Ink(pen=0.4), Paths.of([[(0, 0), (80, 0), (80, 80), (0, 80)]]), "frame"),
        Layer(Ink(pen=0.25), Paths.of(tracks, closed=False), "tracks"),
        Layer(Ink(), Marks.of(tracks[:, 0], load("disc").glyphs, scale=0.7), "starts"),
        Layer(Ink(), Marks.of(tracks[:, -1], (arrow,), scale=1.1, angle=np.arctan2(y, x)), "arrow heads"),
    )
    return Sheet((80, 80), layers).on((90, 90), margin=5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
