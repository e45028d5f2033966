"""Ten ways to place dots, on the specimen and on a face, and what comes of each.

Below: dots and seconds; error of tone and structural similarity after a blur of a spacing, edge energy kept, peak of the spectrum.
Size on paper: 300 x 272 mm.
Source: those of the styles; specimen.png and portrait.png are rendered by tools/specimen.py and tools/portrait.py.
"""

from pathlib import Path
from time import perf_counter

import numpy as np

from crowquill import Ink, Layer, Sheet, Tone, draw, judge, save, seen
from crowquill.lettering import Words
from crowquill.sheet import shifted

STYLES = ("stipple", "adaptive", "bluenoise", "halftone", "inkdots", "byexample", "contrast", "frontier", "hedcut", "isophote")


def make(dots: int = 5000, styles: tuple[str, ...] = STYLES) -> Sheet:
    layers, said = [], []
    for k, (picture, style) in enumerate((picture, style) for picture in ("specimen", "portrait") for style in styles):
        tone = Tone.load(Path(__file__).with_name(f"{picture}.png"), width=52, height=56, fit="cover")
        cell = (tone.ink / dots) ** 0.5  # the area of a dot is its square
        own = {"halftone": {"cell": cell, "form": "dots"}, "inkdots": {"pitch": 0.8 * cell, "sizes": (1.1 * cell,)}}
        own |= {"byexample": {}, "adaptive": {"pen": 1.13 * cell}}
        began, sheet = perf_counter(), draw(style, tone, **own.get(style, {"dots": dots}))
        took, facts = perf_counter() - began, judge.of(seen.of_sheet(sheet, style), tone).facts
        at, near, peak = np.array([6 + 58 * (k % 5), 6 + 66 * (k // 5)]), facts["tone"], facts["spacing"]["power"] or 0
        figures = f"tone {near['blurs'][0]['rmse']:.3f}, ssim {near['ssim']:.3f}, edges {near['edges_kept']:.2f}, peak {peak:.1f}"
        layers += [Layer(layer.ink, shifted(layer.art, at), style) for layer in sheet.layers]
        said += [(f"{style}: {facts['dots']} dots, {took:.1f} s", at[0], at[1] + 59.2), (figures, at[0], at[1] + 61.8)]
    return Sheet((300, 272), (*layers, Layer(Ink(), Words.of(said, size=2), "figures")))


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
