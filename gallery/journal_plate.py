"""A plate for a journal: an ammonite in dots, and its inner whorls nearer by in cells, each with the bar of its scale.

Size on paper: 145 x 102 mm.
Source: specimen.png is rendered by tools/specimen.py; its pixels are taken as 40 um, for an ammonite of 68 mm.
"""

from pathlib import Path

from crowquill import Sheet, plate, save


def make(pen: float = 0.25) -> Sheet:
    whole = {"picture": "specimen.png", "pixel": "40 um", "scale_bar": "20 mm", "knobs": {"pen": pen}}
    part = {
        "picture": "specimen.png",
        "pixel": "40 um",
        "scale_bar": "5 mm",
        "style": "cells",
        "tone": {"crop": [0.32, 0.25, 0.37, 0.614]},
        "knobs": {"pen": 0.6 * pen},
    }
    page = {
        "journal": "amnh",
        "height": "102 mm",
        "caption": "Fig. 1. *Hoplites* sp., lateral view: **A**, whole specimen; **B**, its inner whorls.",
    }
    grid = {"columns": 2, "widths": ["87 mm", "53 mm"]}
    return plate.drawn({"page": page, "grid": grid, "panel": [whole, part]}, folder=Path(__file__).parent)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
