"""A portrait as papers engrave them: lines where a draughtsman would set them, dots in rows beside them, white on black in the darks.

Dots of 0.42 mm, 0.4 to 1.4 times as wide by tone, and lines of 0.34 mm; black from a coverage of 0.7 on.
Size on paper: A5, the picture 128 x 160 mm.
Source: portrait.png is rendered by tools/portrait.py; lines and rows after D. Kim et al., Feature-Guided Image Stippling, 2008.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save


def make(pen: float = 0.42) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("portrait.png"), width=128, crop=(0.14, 0.06, 0.72, 0.72))
    return draw("hedcut", tone, pen=pen).on("a5", margin=10)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
