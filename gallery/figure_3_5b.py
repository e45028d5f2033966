"""How 120 random points move in 20 steps of Lloyd's relaxation: from ring to dot, between the cells they end in.

Size on paper: 90 x 90 mm, the frame 80 mm square.
Source: S. Lloyd, Least Squares Quantization in PCM, IEEE Transactions on Information Theory 28(2), 1982.
"""

from itertools import islice
from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Marks, Paths, Sheet, Tone, lloyd, save, scatter
from crowquill.glyphs import load


def make() -> Sheet:
    paper = Tone(np.ones((1, 1)), (80, 80))
    sites = scatter(paper, 120, np.random.default_rng(5), "random")
    states = list(islice(lloyd(sites, paper, step=1, exponent=0), 21))
    tracks = np.stack([state.sites for state in states], axis=1)  # (120, 21, 2)

    frame = Paths.of([[(0, 0), (80, 0), (80, 80), (0, 80)]])
    disc, area = load("disc").glyphs, np.pi / 4  # of a disc 1 mm wide
    layers = (
        Layer(Ink(pen=0.12), states[-1].cells.rings, "cells"),
        Layer(Ink(pen=0.4), frame, "frame"),
        Layer(Ink(pen=0.3), Paths.of(tracks, closed=False), "tracks"),
        Layer(Ink(), Marks.of(tracks[:, -1], disc, scale=1.1 * area**0.5), "end"),
    )
    return Sheet((80, 80), layers).on((90, 90), margin=5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
