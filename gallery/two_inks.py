"""Fruit in two spot inks, orange and blue: dots of both side by side, and where it is dark white dots on solid ink.

The colours are the nearest that the two inks give together; each has a plate to itself.
Size on paper: 210 x 148 mm, the picture 180 x 135 mm.
Source: still_life.png is rendered by tools/still_life.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002, and
C. Schulz and others, Multi-Class Inverted Stippling, ACM Transactions on Graphics 40(6), 2021.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save

INKS = "Orange=#f0701c, Blue=#23347f"


def make(width: float = 180) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("still_life.png"), width=width, colour=True)
    return draw("stipple", tone, inks=INKS, reverse_from=0.7, pen=0.4).on("a5", margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
