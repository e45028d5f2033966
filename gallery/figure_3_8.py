"""The specimen as a stipple drawing, twice with the same number of dots: the published method, and crowquill's own way.

Left: dots start on a halftone's grid, cells weigh coverage, and the dots on white go at the end.
Right: dots start where the ink is, cells weigh coverage squared, and no dot ever lies on white.
Size on paper: 180 x 99 mm, two panels of 80 x 87 mm, dots of 0.4 mm.
Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002; specimen.png is rendered by tools/specimen.py.
"""

from pathlib import Path

from crowquill import Ink, Layer, Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    left = draw(
        "stipple", tone, pen=0.4,
        start="floyd-steinberg", exponent=1, step=1, iterations=100, until=0.01, white_rule="after",
    ).marks  # fmt: skip
    right = draw("stipple", tone, pen=0.4, dots=len(left)).marks

    layers = (
        Layer(Ink(), left, "published method"),
        Layer(Ink(), right.moved((88, 0)), "crowquill's defaults"),
    )
    return Sheet((168, tone.size[1]), layers).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
