"""The sheet that tells what a printer does: rulers, dots, lines and gaps, nibs, and steps of tone to measure.

What is read off it goes into --ink-gain and --tone-curve. `crowquill calibrate sheet.pdf` writes it for A4.
Size on paper: A5.
Source: none; dots of the steps after A. Secord, Weighted Voronoi Stippling, NPAR 2002.
"""

from pathlib import Path

from crowquill import Sheet, save
from crowquill.calibration import sheet


def make() -> Sheet:
    return sheet("a5")


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
