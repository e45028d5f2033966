"""Contours found in the picture and drawn over its dots, which keep 0.1 mm of white from them.

What `--outline edges` does for any style: here dots of two nibs, and lines of 0.3 mm.
Size on paper: 100 x 122 mm, the picture 92 x 115 mm.
Source: portrait.png is rendered by tools/portrait.py; lines after H. Kang, S. Lee, C. K. Chui, Coherent Line Drawing, NPAR 2007.
"""

from pathlib import Path

from crowquill import Sheet, Tone, draw, save
from crowquill.finishing import finish


def make(fine: float = 0.2, broad: float = 0.35, iterations: int = 30) -> Sheet:
    tone = Tone.load(Path(__file__).with_name("portrait.png"), width=92, gamma=1.3)
    over = finish(tone, outline="edges", outline_width=0.3, outline_gap=0.1, outline_detail=0.5)
    dots = draw("stipple", over.freed(tone, broad), sizes=(fine, broad), iterations=iterations)
    return over.drawn(dots).on((100, 122), margin=3.5)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
