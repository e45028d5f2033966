"""The inner whorls twice, in the same number of dots: on the left stippled, on the right with equal shares of ink for all dots.

Relaxed dots fall into rows, which turn from one patch to the next; dots of equal shares need not, and keep tone as well.
Size on paper: 180 x 98 mm, two panels of 82 x 86 mm, dots of 0.7 mm.
Source: F. de Goes and others, Blue Noise through Optimal Transport, SIGGRAPH Asia 2012; specimen by tools/specimen.py.
"""

from dataclasses import replace
from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=82, crop=(0.32, 0.25, 0.37, 0.357))
    (rows,) = draw("stipple", tone, pen=0.7, glyphs="disc", iterations=100).layers
    (even,) = draw("bluenoise", tone, pen=0.7, glyphs="disc").layers

    layers = (rows, replace(even, art=even.art.moved((86, 0))))
    return Sheet((168, tone.size[1]), layers).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
