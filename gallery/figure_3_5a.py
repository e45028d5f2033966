"""The Voronoi diagram of 100 random points in a frame: every place belongs to the point nearest to it.

Size on paper: 90 x 90 mm, the frame 80 mm square.
Source: F. Aurenhammer, Voronoi Diagrams, ACM Computing Surveys 23(3), 1991.
"""

from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Marks, Paths, Sheet, Tone, save, scatter, voronoi
from crowquill.glyphs import load


def make() -> Sheet:
    paper = Tone(np.ones((1, 1)), (80, 80))  # one tone all over
    # a seed whose dots touch neither the frame nor one another
    sites = scatter(paper, 100, np.random.default_rng(1780), "random")
    cells = voronoi(sites, paper.canvas)

    frame = Paths.of([[(0, 0), (80, 0), (80, 80), (0, 80)]])
    dots = Marks.of(sites, load("disc").glyphs, scale=1.1 * np.sqrt(np.pi / 4))  # 1.1 mm wide
    layers = (
        Layer(Ink(pen=0.18), cells.rings, "cells"),
        Layer(Ink(pen=0.4), frame, "frame"),
        Layer(Ink(), dots, "sites"),
    )
    return Sheet((80, 80), layers).on((90, 90), margin=5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
