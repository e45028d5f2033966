"""The first 1000, 3000 and all 9000 dots of one drawing, each a drawing of its own: dots are in the order in which they were placed.

Distances grow from the dots there are, faster where it is darker and at edges, and where they reach a radius is the next dot; when
none is left the radius shrinks. The fewer dots, the larger they are, so that the ink is the same.
Size on paper: 190 x 76 mm, three panels of 58 x 64 mm.
Source: D. Mould, Stipple Placement using Distance in a Weighted Graph, Computational Aesthetics 2007.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Sheet, Tone, draw, save


def make(every: int = 9000) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=58)
    dots = draw("frontier", tone, dots=every).marks
    layers = []
    for panel, first in enumerate((every // 9, every // 3, every)):
        part = dots.take(slice(first))
        larger = replace(part, scale=part.scale * np.sqrt(len(dots) / first))
        layers.append(Layer(Ink(), larger.moved((60 * panel, 0)), f"the first {first}"))
    return Sheet((178, tone.size[1]), tuple(layers)).on((190, 76), margin=5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
