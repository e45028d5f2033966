"""The ammonite in contrast-aware dots, four ways with 9000 of each: as a halftone, thinned out, with a texture, white on black.

Above left errors go row by row to the pixels around and every black pixel is a dot (G of 0); right, the pixels nearest to black
and white come first, and errors that a G of 5 makes larger leave few dots on much finer pixels. Below, waves and a scratchboard.
Size on paper: 190 x 206 mm, four panels of 84 x 92 mm.
Source: H. Li, D. Mould, Structure-preserving Stippling by Priority-based Error Diffusion, Graphics Interface 2011.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image
from scipy.ndimage import binary_fill_holes

from crowquill import Sheet, Tone, draw, save
from crowquill.sheet import shifted


def make(dots: int = 9000) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=84)
    night = tone.mapped(lambda coverage: np.where(binary_fill_holes(coverage > 0.02), coverage, 1.0))
    y, x = np.mgrid[0:64, 0:64] / 64
    with TemporaryDirectory() as folder:
        waves = Path(folder, "waves.png")
        Image.fromarray((127 * (1 + np.sin(2 * np.pi * (2 * y + 0.5 * np.sin(2 * np.pi * x))))).astype(np.uint8)).save(waves)
        ways = ({"order": "raster", "g_plus": 0.0}, {}, {"texture": waves, "texture_width": 5.0}, {"ground": "black"})
        panels = [draw("contrast", night if "ground" in way else tone, dots=dots, **way) for way in ways]
    places = [np.array([column, row]) * (90, tone.size[1] + 6) for row in (0, 1) for column in (0, 1)]
    layers = [replace(part, art=shifted(part.art, at)) for at, panel in zip(places, panels, strict=True) for part in panel.layers]
    return Sheet((174, 2 * tone.size[1] + 6), tuple(layers)).on((190, 206), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
