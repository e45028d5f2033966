"""The specimen in ink dots: as it is; with its local contrast raised and rows of dots along its edges; and white on black in the darks.

Where the picture is dark a mask says so, and dots are white there, on black.
Size on paper: 190 x 78 mm, three panels of 58 mm.
Source: D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and Example-based Stippling, NPAR 2010.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from crowquill import Layer, Sheet, Tone, draw, save
from crowquill.sheet import shifted


def make(width: float = 58) -> Sheet:
    specimen = Path(__file__).with_name("specimen.png")
    plain, crisp = (Tone.load(specimen, width=width, local_contrast=contrast) for contrast in (0, 0.7))
    layers = []
    with TemporaryDirectory() as folder:
        mask = Path(folder, "mask.png")
        dark = gaussian_filter(plain.coverage, 12) > 0.5
        Image.fromarray(np.where(dark, 255, 0).astype(np.uint8)).save(mask)
        panels = (plain, {}), (crisp, {"edges": 1.2}), (crisp, {"invert_mask": str(mask)})
        for k, (tone, knobs) in enumerate(panels):
            drawing = draw("inkdots", tone, pitch=0.18, sizes=(0.18, 0.22, 0.26), **knobs)
            layers += [Layer(layer.ink, shifted(layer.art, np.array([61 * k, 0])), f"{layer.label} {k}") for layer in drawing.layers]
    return Sheet((180, plain.size[1]), tuple(layers)).on((190, 78), margin=5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
