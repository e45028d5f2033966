"""Dots and lines together: the ammonite's outline and the seam of its whorls drawn over it, and a scale bar.

The lines are an SVG laid over the picture, such as an illustrator draws; dots keep 0.12 mm of white from them.
Size on paper: 110 x 116 mm, the drawing 98 x 106.7 mm, dots of 0.3 mm, lines of 0.25 and 0.18 mm.
Source: specimen.png is rendered by tools/specimen.py, whose spiral the seam follows; D. M. Raup, J. Paleontology 40, 1966.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from crowquill import Sheet, Tone, draw, save
from crowquill.finishing import finish
from crowquill.tracing import canvas


def make(pen: float = 0.3) -> Sheet:
    picture = Path(__file__).with_name("specimen.png")
    tone = Tone.load(picture, width=98)
    tone = replace(tone, canvas=canvas("auto", picture, tone.size))
    turn = np.radians(242 - np.arange(0, 1500, 2))  # the mouth is at 242 degrees; each whorl is 1.8 times the one inside it
    reach = 0.495 * 995 / 1800 * 98 * 1.8 ** ((turn - turn[0]) / np.pi / 2)
    seam = np.stack([np.cos(turn), np.sin(turn)], axis=1) * reach[:, None] + (0.5625 * tone.size[0], 0.525 * tone.size[1])
    rim = np.array(tone.canvas.exterior.simplify(0.02).coords)
    lines = [(pen, " ".join(map(str, line.ravel().round(3).tolist()))) for pen, line in ((0.25, rim), (0.18, seam))]
    paths = "".join(f'<path stroke-width="{pen}" fill="none" stroke="black" d="M{points}"/>' for pen, points in lines)
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {tone.size[0]} {tone.size[1]}">{paths}</svg>'
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "lines.svg").write_text(svg, encoding="utf-8")
        over = finish(tone, outline=f"{folder}/lines.svg", outline_gap=0.12, scale_bar="auto", scale="1 mm = 1.25 mm")
    return over.drawn(draw("stipple", over.freed(tone, pen), pen=pen)).on((110, 116), margin=4)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
