"""A wall print in small: a drawing relaxed in four tiles, cut to four sheets that share 8 mm, as they are before they are pasted.

Their names, ticks and targets stand in the margins; grey lines are the edges of the paper.
Size on paper: A4, the drawing 140 x 152 mm once it is pasted together.
Source: specimen.png is rendered by tools/specimen.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Paths, Sheet, Tone, draw, pasting, save
from crowquill.sheet import shifted

GREY = Ink("paper's edge", (0.0, 0.0, 0.0, 0.3), pen=0.15)


def make(width: float = 140) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    drawing = draw("stipple", tone, pen=0.45, tiles="2x2")
    across, down = (side / 2 + 4 + 2 * pasting.MARGIN for side in drawing.size)
    cut = pasting.cut(drawing.size, sheets=f"{across + 0.01:.3f}x{down + 0.01:.3f}mm", sheet_overlap=8.0)
    layers = []
    for column, row in cut.places:
        at = np.array([column * (cut.paper[0] + 4), row * (cut.paper[1] + 4)])
        x, y = cut.paper
        layers.append(Layer(GREY, Paths.of([at + np.array([(0, 0), (x, 0), (x, y), (0, y)])])))
        layers += [replace(layer, art=shifted(layer.art, at)) for layer in cut.sheet(drawing, (column, row)).layers]
    return Sheet((2 * cut.paper[0] + 4, 2 * cut.paper[1] + 4), tuple(layers)).on("a4", margin=0)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
