"""Points and lines that all start in one corner, and the same after 200 steps, in which they moved and turned.

Size on paper: 180 x 92 mm, two panels of 80 x 80 mm.
Source: S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003.
"""

from itertools import islice
from pathlib import Path

import numpy as np
import shapely

from crowquill import Ink, Layer, Marks, Paths, Sheet, save
from crowquill.glyphs import load
from crowquill.objects import Objects, Shape
from crowquill.relax import settle


def make() -> Sheet:
    rng = np.random.default_rng(0)
    line, point = Shape.of(Paths.of([[(0, 0), (8.8, 0)]], closed=False)), Shape.of(Paths.of([[(0, 0)]]))
    places, is_point = 4 + 36 * rng.random((180, 2)), np.arange(180) >= 60
    first = Objects.of(places, (line, point), angle=np.pi * rng.random(180), shape=is_point)
    last = next(islice(settle(first, shapely.box(0, 0, 80, 80), move=1.5), 200, None)).objects

    layers = []
    for objects, right in ((first, 0), (last, 88)):
        frame = Paths.of([[(right, 0), (right + 80, 0), (right + 80, 80), (right, 80)]])
        dots = Marks.of(objects.xy[is_point] + (right, 0), load("disc").glyphs, scale=1)
        lines = objects.lines()[0].moved(np.eye(2), (right, 0))
        layers += [Layer(Ink(pen=0.2), frame, "frame"), Layer(Ink(), dots, "points"), Layer(Ink(pen=0.4), lines, "lines")]
    return Sheet((168, 80), tuple(layers)).on((180, 92), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
