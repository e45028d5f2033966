"""The ammonite in lines alone: on the left the cells of its sites, on the right the net that joins neighbouring sites.

Both take as much ink as the picture asks for. A net has three times the line to a site, and so a third of the sites.
Size on paper: 180 x 99 mm, two panels of 80 x 87 mm, lines of 0.13 mm.
Source: F. Aurenhammer, Voronoi Diagrams, ACM Computing Surveys 23(3), 1991; specimen.png is rendered by tools/specimen.py.
"""

from pathlib import Path

from crowquill import Ink, Layer, Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    (cells,) = draw("cells", tone, pen=0.13).layers
    (net,) = draw("cells", tone, pen=0.13, net=True).layers

    layers = (cells, Layer(Ink(pen=0.13), net.art.moved(((1, 0), (0, 1)), (88, 0)), "net"))
    return Sheet((168, tone.size[1]), layers).on((180, tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
