"""How photographs were screened: a first line screen, a second, the dots of both together, and a halftone of round dots.

Beneath stand the errors of tone: the root mean square of what squares of 1.6 mm are off. All rulings are 0.8 mm.
Size on paper: 202 x 122 mm, panels 44 mm wide.
Source: G. Meisenbach, patent DE 22244, 1882; specimen.png is rendered by tools/specimen.py; camera by L. Varshney, CC0.
"""

from pathlib import Path

import numpy as np
from skimage.data import camera

from crowquill import Ink, Layer, Sheet, Tone, draw, save
from crowquill.halftone.averages import averaged
from crowquill.lettering import Words
from crowquill.seen import of_sheet
from crowquill.sheet import shifted


def make() -> Sheet:
    specimen = Tone.load(Path(__file__).with_name("specimen.png"), width=44)
    both = {"angles": (30, -60), "combine": "mean"}
    ways = [("screen", {"angles": (30,)}), ("screen", {"angles": (-60,)}), ("screen", both), ("dots", {})]
    layers, said = [], []
    for top, tone in ((8, specimen), (66, Tone.load(1 - camera() / 255, width=44))):
        h, w = tone.coverage.shape
        for k, (style, knobs) in enumerate(ways):
            sheet = draw(style, tone, pitch=0.8, **knobs)
            cover, _ = of_sheet(sheet).coverage(1.6)
            asked = averaged(tone.coverage, np.linspace(0, w, cover.shape[1] + 1), np.linspace(0, h, len(cover) + 1))
            layers.append(Layer(Ink(), shifted(sheet.layers[0].art, np.array([8 + 47.5 * k, top])), style))
            said.append((f"{np.sqrt(np.mean((cover - asked) ** 2)):.3f}", 8 + 47.5 * k, top + tone.size[1] + 4))
    return Sheet((202, 122), (*layers, Layer(Ink(), Words.of(said, size=2.6), "errors of tone")))


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
