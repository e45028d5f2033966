"""Relaxation weighed by the tone keeps the picture: all points on the left; on the right those on white are left out.

The specimen's paper is pure white, where no point would ever start. Here the white asks for a
fortieth of full ink, as the not quite white background of a photograph does.
Size on paper: 180 x 99 mm, two panels of 80 x 87 mm.
Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002; specimen.png is rendered by tools/specimen.py.
"""

from functools import partial
from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Paths, Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    grounded = tone.mapped(lambda coverage: np.maximum(coverage, 0.025))
    published = partial(
        draw, "stipple", grounded, dots=6000, pen=0.45, glyphs="disc",
        start="floyd-steinberg", exponent=1, step=1, iterations=100, until=0.01, white_rule="after",
    )  # fmt: skip
    every, inked = published(white=0).marks, published(white=0.03).marks

    frame = np.array([(0, 0), (80, 0), (80, tone.size[1]), (0, tone.size[1])])
    right = np.array([88, 0])
    layers = (
        Layer(Ink(pen=0.2), Paths.of([frame, frame + right]), "frames"),
        Layer(Ink(), every, "all points"),
        Layer(Ink(), inked.moved(right), "without those on white"),
    )
    return Sheet((168, tone.size[1]), layers).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
