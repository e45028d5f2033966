"""Four thresholds on two pictures: one for all, by chance, Bayer's tile, and one by void-and-cluster; below, their errors of tone.

Each is the root mean square of what blocks of 8 x 8 cells are off. A cell is a pixel of 110 dpi.
Size on paper: 187 x 113 mm, panels of 180 cells.
Source: R. Ulichney, Digital Halftoning, 1987; The Void-and-Cluster Method, SPIE 1913, 1993; camera by L. Varshney, CC0.
"""

from pathlib import Path

import numpy as np
from skimage.data import camera

from crowquill import Ink, Layer, Sheet, Tone, draw, save
from crowquill.lettering import Words
from crowquill.units import INCH

METHODS = ("threshold", "random", "bayer", "void-and-cluster")


def make() -> Sheet:
    pixel = INCH / 110  # all lies on whole pixels of 110 dpi, so that a screen shows cells as they are
    specimen = Tone.load(Path(__file__).with_name("specimen.png"), width=180 * pixel, height=196 * pixel, fit="cover")
    layers, said = [], []
    for top, tone in ((26, specimen), (262, Tone.load(1 - camera() / 255, width=180 * pixel))):
        for k, method in enumerate(METHODS):
            sheet = draw("halftone", tone, method=method, cells_per_inch=110)
            at = pixel * np.array([26 + 193 * k, top])
            layers.append(Layer(Ink(), sheet.layers[0].art.moved(np.eye(2), at), method))
            said.append((f"{method}: {sheet.report['tone_error']:.3f}", at[0], at[1] + tone.size[1] + 4))
    return Sheet((811 * pixel, 490 * pixel), (*layers, Layer(Ink(), Words.of(said, size=2.6), "errors of tone")))


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
