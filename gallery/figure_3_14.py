"""A picture, its dots as they were scanned, grey, at 600 pixels to the inch, and the same dots at 1200 in black and white.

Twenty millimetres of a drawing made for A5, three times as large; pixels in sixteen greys.
Size on paper: 200 x 72 mm, panels of 60 x 60 mm.
Source: D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and Example-based Stippling, NPAR 2010.
"""

from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from crowquill import Ink, Layer, Sheet, Tone, draw, save, to_bytes
from crowquill.sheet import Bitmap
from crowquill.units import INCH


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=118)
    drawing = draw("inkdots", tone)
    shown = [(INCH / tone.pixel[0], tone.coverage)]
    for dpi, bilevel in ((600, False), (1200, True)):
        page = Image.open(BytesIO(to_bytes(drawing, "png", dpi=dpi, bilevel=bilevel)))
        shown.append((dpi, 1 - np.asarray(page.convert("L")) / 255))
    layers = []
    for panel, (dpi, dark) in enumerate(shown):
        x, y, side = (round(mm / INCH * dpi) for mm in (38, 62, 20))
        level = np.round(15 * dark[y : y + side, x : x + side])
        at = (64 * panel, 0)
        layers += [Layer(Ink(f"{k:g}", (0, 0, 0, k / 15)), Bitmap.of(level == k, dpi / 3, at)) for k in np.unique(level) if k]
    return Sheet((188, 60), tuple(layers)).on((200, 72), margin=5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
