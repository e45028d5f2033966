"""The plate: an ammonite in dots of a 0.3 mm pen, as many as its tones need.

Size on paper: A4, the picture 180 x 196 mm.
Source: specimen.png is rendered by tools/specimen.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make(width: float = 180) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    return draw("stipple", tone, pen=0.3).on("a4", margin=15)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
