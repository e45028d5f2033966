"""The ammonite in two inks: dots of ochre, and over them dots of black, which overprint, as duotones are printed.

Ochre is a spot ink and carries the lights, by a curve that lifts them; black draws the darks alone. Each has a seed of its own.
Size on paper: A5, the picture 124 x 135 mm.
Source: specimen.png is rendered by tools/specimen.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

import numpy as np

from crowquill import Ink, Layer, Sheet, Tone, draw, save

OCHRE = Ink("Ochre", (0.0, 0.28, 0.6, 0.25), spot=True)


def make(width: float = 124) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    light = tone.mapped(lambda coverage: 0.75 * np.sqrt(coverage))
    dark = tone.mapped(lambda coverage: np.clip((coverage - 0.3) / 0.7, 0, 1) ** 1.3)
    ochre = draw("stipple", light, pen=0.35, seed=1)
    black = draw("stipple", dark, pen=0.3, seed=2)
    layers = (Layer(OCHRE, ochre.marks), Layer(Ink(overprint=True), black.marks))
    return Sheet(tone.size, layers, {"style": "stipple"}).on("a5", margin=12)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
