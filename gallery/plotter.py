"""What a plotter does with the specimen: every dot a touch of a 0.5 mm pen, or a spiral, and in red the way between them.

The dots lie as wide as the pen, or wider, where it spirals; they are drawn in an order that takes the pen little way.
Size on paper: A5, the picture 110 x 120 mm.
Source: specimen.png is rendered by tools/specimen.py; dots after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save
from crowquill.commands.preview import preview
from crowquill.plotting import plotted


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=110)
    sheet = draw("stipple", tone, sizes=(0.5, 1.5), size_by="tone").on("a5", margin=15)
    return preview(plotted(sheet, nib=0.5, dot="spiral"))[0]


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
