"""The ammonite in two inks: dots of ochre, and between and over them dots of black, which overprint, as duotones are printed.

Ochre is a spot ink and carries the lights, black draws the darks; both together have the lightness of the picture.
Size on paper: A5, the picture 124 x 135 mm.
Source: specimen.png is rendered by tools/specimen.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make(width: float = 124) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    return draw("stipple", tone, inks="Ochre=0,0.28,0.6,0.25, black", ink_match="lightness", pen=0.3).on("a5", margin=12)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
