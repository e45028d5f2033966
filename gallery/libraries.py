"""A library of dots as a page: the brush pen's, each dot enlarged with its true diameter below, and all at true size.

Size on paper: A4.
Source: the dots are simulated by tools/ink_model.py and scanned as a page of ink would be.
"""

from pathlib import Path

from crowquill import Sheet, save
from crowquill.contact import of_library
from crowquill.glyphs import load


def make() -> Sheet:
    return of_library(load("brush"))


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
