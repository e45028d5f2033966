"""The ammonite as one line that never crosses itself: of one pen, left, and bent through its sites and as wide as the tone, right.

The line passes through stippled sites by a tour that is all but the shortest.
Size on paper: 180 x 99 mm, two panels of 80 x 87 mm, a line of 0.25 mm.
Source: C. S. Kaplan, R. Bosch, TSP Art, Bridges 2005; specimen.png is rendered by tools/specimen.py.
"""

from dataclasses import replace
from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    plain = draw("tour", tone, pen=0.25).layers
    swelling = draw("tour", tone, pen=0.25, rounded=True, width_by="tone").layers

    beside = [replace(layer, art=layer.art.moved(((1, 0), (0, 1)), (88, 0))) for layer in swelling]
    return Sheet((168, tone.size[1]), (*plain, *beside)).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
