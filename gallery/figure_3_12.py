"""The ammonite as a mosaic, laid in four ways: Hausner's squares, rows, Lloyd's squares, and cells; stones are finer on the spiral.

Size on paper: 196 x 212 mm, four panels of 88 x 96 mm, stones of 1.9 mm and on the spiral half of that, grout of 0.2 mm.
Source: after figure 3.12 of S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, 2003; colours are put on specimen.png's tones here.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import ndimage

from crowquill import Layer, Sheet, Tone, draw, save

STONE = np.array([(40, 20, 25), (140, 60, 35), (222, 150, 80), (250, 236, 205)])  # dark to light


def make(tile: float = 1.9) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=88, tone="grey")
    y, x = np.indices(tone.coverage.shape) / tone.coverage.shape[1]
    areas, _ = ndimage.label(tone.coverage < 0.015)
    shell = np.stack([np.interp(1 - tone.coverage, (0, 0.35, 0.7, 1), band) for band in STONE.T], axis=-1)
    sea = y[..., None] * ((-46, -74, -51),) + (70, 150, 165)
    rgb = np.where((areas == areas[0, 0])[..., None], sea, shell).round().astype(np.uint8)
    spiral = np.clip(1.6 - np.hypot(x - 0.561, y - 0.62) / 0.167, 0, 1)
    tone = replace(tone, values=1 - rgb @ (0.3, 0.59, 0.11) / 255, rgb=rgb, importance=0.5 + 0.5 * spiral)

    layers, (width, height) = [], tone.size
    for k, mode in enumerate(("hausner", "rows", "lloyd", "cells")):
        (stones,) = draw("mosaic", tone, mode=mode, tile=tile, grout=0.2).layers
        art = stones.art.moved(np.eye(2), ((width + 4) * (k % 2), (height + 4) * (k // 2)))
        layers.append(Layer(stones.ink, art, mode, stones.fill))
    return Sheet((2 * width + 4, 2 * height + 4), tuple(layers)).on((2 * width + 20, 2 * height + 20), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
