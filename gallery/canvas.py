"""Where to draw, and where it matters: the specimen traced off its paper, and dots of three nibs, the finest about its heart.

Left: the canvas that "auto" finds, its outline drawn, in dots of one pen. Right: nibs of 0.25, 0.35 and 0.5 mm in the
same canvas; an importance map, white in the middle, asks for the finer ones there, and the tone stays as it is.
Size on paper: 180 x 99 mm, two panels of 80 x 87 mm.
Source: specimen.png is rendered by tools/specimen.py; N. Otsu, IEEE Trans. SMC 9(1), 1979, for the threshold.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Paths, Sheet, Tone, draw, save
from crowquill.tracing import canvas


def make() -> Sheet:
    picture = Path(__file__).with_name("specimen.png")
    tone = Tone.load(picture, width=80)
    traced = replace(tone, canvas=canvas("auto", picture, tone.size))
    outline = Paths.of_polygons([traced.canvas])[0]

    h, w = tone.coverage.shape
    y, x = np.mgrid[:h, :w] / h - [[[0.5]], [[0.5 * w / h]]]
    heart = replace(traced, importance=np.clip(1.25 - 4 * np.hypot(x, y), 0, 1))
    one = draw("stipple", traced, pen=0.35)
    three = draw("stipple", heart, sizes=(0.25, 0.35, 0.5)).on((168, tone.size[1]), margin=0)

    move = 84 + 4 - (168 - 80) / 2  # mm, from the middle of the sheet to the right panel
    right = [replace(layer, art=layer.art.moved((move, 0))) for layer in three.layers]
    layers = (Layer(Ink(pen=0.15), outline, "canvas"), *one.layers, *right)
    return Sheet((168, tone.size[1]), layers).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
