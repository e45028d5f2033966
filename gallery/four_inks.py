"""Fruit in dots of cyan, magenta, yellow and black, and below it the four separations that it is printed from.

Dots of different inks keep clear of each other, so that their colours are side by side; black comes in where there is no more room.
Size on paper: A5, the picture 124 x 93 mm.
Source: still_life.png is rendered by tools/still_life.py; separation and dots after H. E. J. Neugebauer, 1937, A. Secord, NPAR 2002,
and C. Schulz and others, Multi-Class Inverted Stippling, ACM Transactions on Graphics 40(6), 2021.
"""

from pathlib import Path

import numpy as np

from crowquill import Sheet, Tone, draw, save
from crowquill.plate.parts import scaled
from crowquill.sheet import Layer, shifted

SMALL = 60 / 124  # the separations, over the picture


def make(width: float = 124) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("still_life.png"), width=width, colour=True)
    whole = draw("stipple", tone, inks="C,M,Y,K", pen=0.3)
    wide, high = np.array(whole.size)
    corners = [(x, high + 6 + y) for y in (0, SMALL * high + 4) for x in (0, (1 - SMALL) * wide)]
    inks = {name: [layer for layer in whole.layers if layer.ink.name == name] for name in ("cyan", "magenta", "yellow", "black")}
    parts = [
        Layer(small.ink, shifted(small.art, np.array(corner)), f"{name} alone")
        for (name, layers), corner in zip(inks.items(), corners, strict=True)
        for small in (scaled(layer, SMALL) for layer in layers)
    ]
    return Sheet((wide, high + 10 + 2 * SMALL * high), (*whole.layers, *parts), whole.recipe).on("a5", margin=8)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
