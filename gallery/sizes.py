"""The ammonite with three nibs in one drawing: dots of 0.2 mm in the lights, of 0.3 and 0.5 mm where it is darker.

How much ink there is does not depend on the nibs: large dots are fewer. A layer a nib, the finest first.
Size on paper: A5, the picture 124 x 135 mm.
Source: specimen.png is rendered by tools/specimen.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make(width: float = 124) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    return draw("stipple", tone, sizes=(0.2, 0.3, 0.5)).on("a5", margin=12)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
