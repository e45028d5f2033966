"""The specimen by an example whose dots crowd in groups, left, and by relaxed dots of the same size, right.

Below each, how its dots repeat in a flat tone of three tenths: the correlation of ink with itself one half, one and two
spacings off. By the example it falls and stays low, as a hand's does; relaxed dots swing.
Size on paper: 190 x 118 mm, two panels of 84 mm.
Source: S. Kim, R. Maciejewski, T. Isenberg, W. M. Andrews, W. Chen, M. C. Sousa, D. S. Ebert, Stippling by Example, NPAR 2009;
A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Sheet, Tone, draw, exemplar, measure, save
from crowquill.lettering import Words
from crowquill.sheet import shifted
from crowquill.texture import curves


def make(width: float = 84) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    flat, grid = Tone(np.full((9, 9), 0.3), (30, 30)), (900, 900)
    pen = float(2 * np.sqrt(exemplar.load("hand").black.area / np.pi))
    layers = []
    for right, name, style, knobs in ((0, "by example", "byexample", {}), (90, "weighted Voronoi", "stipple", {"pen": pen})):
        dots = draw(style, flat, **knobs).marks
        texture = curves(measure.rendered(dots, flat.size, grid), (1 / 30, 1 / 30), 30 / len(dots) ** 0.5)
        figures = ", ".join(f"{value:.2f}" for value in texture.mean([0.5, 1, 2]))
        said = Words.of([(f"{name}: {figures}", right + 42, tone.size[1] + 6)], size=3, anchor="middle")
        layers += [Layer(layer.ink, shifted(layer.art, np.array([right, 0])), name) for layer in draw(style, tone, **knobs).layers]
        layers.append(Layer(Ink(), said, "figures"))
    return Sheet((174, tone.size[1] + 8), tuple(layers)).on((190, 118), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
