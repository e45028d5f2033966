"""How a photograph was screened: a first line screen, a second, the dots of both together, and a halftone of round dots.

All four have the ink of the picture. Above, lines 0.9 mm apart swell with the tone; below, on the left, ink is where the mean
of the two screens is below it, and on the right each dot has the ink of its own square.
Size on paper: 180 x 194 mm, four panels of 80 x 87 mm.
Source: G. Meisenbach, patent DE 22244, 1882; specimen.png is rendered by tools/specimen.py.
"""

from pathlib import Path

from crowquill import Ink, Layer, Sheet, Tone, draw, save


def make() -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=80)
    right, down = 88, tone.size[1] + 8
    art = [
        draw("screen", tone, pitch=0.9, angles=(30,)).layers[0].art,
        draw("screen", tone, pitch=0.9, angles=(-60,)).layers[0].art.moved(((1, 0), (0, 1)), (right, 0)),
        draw("screen", tone, pitch=0.9, angles=(30, -60), combine="mean").layers[0].art.moved(((1, 0), (0, 1)), (0, down)),
        draw("dots", tone, pitch=0.9, angle=30).layers[0].art.moved((right, down)),
    ]
    names = ("first line screen", "second line screen", "both together", "round dots")
    layers = tuple(Layer(Ink(), part, name) for part, name in zip(art, names, strict=True))
    return Sheet((168, down + tone.size[1]), layers).on((180, down + tone.size[1] + 12), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
