"""HPGL: strokes for pen plotters, 40 units to the millimetre, from the bottom left with y up."""

from __future__ import annotations

from typing import Annotated, BinaryIO

import numpy as np

from crowquill import units
from crowquill.formats._strokes import Place, by_pen, fit, upright
from crowquill.formats._text import number
from crowquill.knobs import Flag, Range, Text
from crowquill.sheet import Sheet

STROKES = True  # fills are refused
STEP = 1 / 40  # mm
PAIRS = 100  # to an instruction: some plotters hold one whole before they draw it


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    speed: Annotated[float | None, Range(0.1, 200, "cm/s", "speed of the pen on the paper; the plotter's own when left out")] = None,
    pens: Annotated[int, Range(1, 256, "", "pens that the plotter holds: layer k is drawn with pen k")] = 8,
    bed: Annotated[str | None, Text("the plotter's largest sheet: 420x297mm, or a paper's name, its long side along x")] = None,
    turned: Annotated[bool, Flag("turn the page by a quarter on the plotter, clockwise")] = False,
) -> None:
    """The sheet as HPGL: each layer a pen, each stroke a line of the file, in their order; a dot is the pen put down and up.

    Written for the oldest plotters: no instruction of HP-GL/2, no comments. Their origin lies some millimetres inside
    the paper's corner, where the pen first reaches.
    Raises ValueError for fills, more layers than pens, and sheets larger than the bed.
    """
    foresee(sheet.size, 0, bed=bed, turned=turned)
    found = by_pen(sheet, STEP, "hpgl", _quarter(sheet) if turned else upright(sheet))
    if found and found[-1].number > pens:
        raise ValueError(f"layer {found[-1].number} has no pen: the plotter holds {pens}; raise pens, or draw with fewer inks")
    text = ["IN;", f"VS{number(speed)};" if speed else "", "\n"]
    for pen in found:
        text.append(f"SP{pen.number};\n")
        text += [_stroke(points) for points in pen]
    file.write("".join([*text, "PU;SP0;\n"]).encode("ascii"))


def foresee(size: tuple[float, float], _marks: int, *, bed: str | None, turned: bool, **_: object) -> None:
    """Raises the ValueError of a sheet of this size in mm that is larger than the bed."""
    if bed is None:
        return
    most = units.paper(bed)
    if bed.strip().lower() in units.PAPERS:
        most = max(most), min(most)
    fit(size[::-1] if turned else size, most, "leave out turned" if turned else "turn the page with turned")


def _quarter(sheet: Sheet) -> Place:
    """Places of the sheet turned clockwise by a quarter, with the origin at the bottom left and y up."""
    width, height = sheet.size
    return lambda xy: np.array([height, width]) - xy[..., ::-1]


def _stroke(points: list[list[int]]) -> str:
    (x, y), *rest = points
    pairs = [f"{x},{y}" for x, y in rest]
    drawn = "".join(f"PD{','.join(pairs[at : at + PAIRS])};" for at in range(0, max(len(pairs), 1), PAIRS))
    return f"PU{x},{y};{drawn}{'' if rest else 'PU;'}\n"
