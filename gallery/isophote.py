"""The ammonite in dots that lie in rows along lines of equal lightness, and along its edges: rows bend as the shell does.

Size on paper: A5, the picture 128 x 139.4 mm, dots of 0.4 mm, light cut into 8 levels.
Source: specimen.png is rendered by tools/specimen.py; rows after S. Kim et al., Automated Hedcut Illustration Using Isophotes, 2010.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make(pen: float = 0.4) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=128)
    return draw("isophote", tone, pen=pen, levels=8).on("a5", margin=10)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
