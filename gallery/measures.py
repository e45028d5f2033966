"""Two drawings of the specimen judged side by side: the published method in blue, crowquill's own defaults in red.

The same number of dots of the same width, against the same picture: spectrum, distances, texture, and where the tone is off.
Size on paper: A4.
Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002; specimen.png is rendered by tools/specimen.py.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save
from crowquill.figure import of as figure
from crowquill.judge import of as judged
from crowquill.seen import of_sheet


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    published = draw(
        "stipple", tone, pen=0.4,
        start="floyd-steinberg", exponent=1, step=1, iterations=100, until=0.01, white_rule="after",
    )  # fmt: skip
    ours = draw("stipple", tone, pen=0.4, dots=len(published.marks))
    named = {"the published method": published, "crowquill": ours}
    return figure([judged(of_sheet(sheet, name), tone) for name, sheet in named.items()])


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
