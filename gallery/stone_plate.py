"""The ammonite in black stones on white grout: rows follow its ribs and whorls, and each stone is as large as the tone asks.

Size on paper: A5, the picture 128 x 139 mm, stones of 1.5 mm at most.
Source: specimen.png is rendered by tools/specimen.py; stones after A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make(tile: float = 1.5) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=128, gamma=0.85)
    return draw("mosaic", tone, tile=tile, grout=0.12, one_ink=True, white=0.06).on("a5", margin=10)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
