"""The specimen drawn with small objects in place of dots: grains along the shell's ribs, and leaves turned into the room they have.

No two objects touch; each has the ink of its own Voronoi region, so that it is larger where the shell is darker.
Size on paper: 180 x 99 mm, two panels of 80 x 87 mm, grains of 1.5 and leaves of 1.8 mm.
Source: S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003; specimen.png is
rendered by tools/specimen.py, the objects are drawn by tools/draw_objects.py.
"""

from pathlib import Path

from crowquill import Ink, Layer, Sheet, Tone, draw, save


def make(width: float = 80) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=width)
    left = draw("objects", tone, objects="grains", size=1.5).marks
    right = draw("objects", tone, objects="leaves", size=1.8, turn="region").marks
    layers = (Layer(Ink(), left, "grains"), Layer(Ink(), right.moved((width + 8, 0)), "leaves"))
    return Sheet((2 * width + 8, tone.size[1]), layers).on((180, 99.1), margin=5.9)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
