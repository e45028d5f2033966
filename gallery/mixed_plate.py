"""One drawing of three kinds: stones on the outer whorl, dots on the inner ones, ticks along the last chamber.

Size on paper: A5, the picture 128 x 139 mm, all in black.
Source: specimen.png is rendered by tools/specimen.py; after S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, 2003.
"""

from dataclasses import replace
from pathlib import Path

import shapely

from crowquill import Sheet, Tone, draw, save


def make(tile: float = 1.5) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("specimen.png"), width=128)
    across = tone.size[0]
    inner = shapely.Point(0.536 * across, 0.588 * across).buffer(0.215 * across)
    body = shapely.box(0, 0, *tone.size)
    chamber = shapely.Polygon([(0, 0), (0.47 * across, 0), (0.47 * across, 0.28 * across), (0.3 * across, 0.6 * across), (0, 0.6 * across)])
    parts = {
        "stipple": (inner, {"pen": tile / 5}),
        "objects": (chamber - inner, {"objects": "ticks", "size": tile, "turn": "field", "overlap": True}),
        "mosaic": (body - inner - chamber, {"tile": tile, "grout": 0.12, "one_ink": True, "white": 0.06}),
    }
    drawn = [draw(style, replace(tone, canvas=part), **knobs) for style, (part, knobs) in parts.items()]
    return Sheet(tone.size, tuple(layer for sheet in drawn for layer in sheet.layers)).on("a5", margin=10)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
