"""The ammonite with three pens: dots part in two until each stands for the ink of its cell, and so the pen says how many there are.

Dots of 1.4, 0.7 and 0.35 mm on average, 0.6 to 1.6 times that by the tone: each as large as the ink of its own cell.
Size on paper: 182 x 73 mm, three panels of 56 x 61 mm.
Source: O. Deussen, M. Spicker, Q. Zheng, Weighted Linde-Buzo-Gray Stippling, SIGGRAPH Asia 2017; specimen by tools/specimen.py.
"""

from dataclasses import replace
from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=56)
    layers = []
    for left, pen in ((0, 1.4), (57, 0.7), (114, 0.35)):
        (layer,) = draw("adaptive", tone, pen=pen, size_by="tone", glyphs="brush").layers
        layers.append(replace(layer, art=layer.art.moved((left, 0)), name=f"{pen} mm"))
    return Sheet((170, tone.size[1]), tuple(layers)).on((182, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
