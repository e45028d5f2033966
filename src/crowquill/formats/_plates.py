"""The plates of a sheet as files: one an ink, PDF or pixels of one bit, with registration marks around.

They are plain PDF whatever the drawing's own is: PDF/X is for pages whose inks are together.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from crowquill import forme
from crowquill.formats import pdf, tiff
from crowquill.forme import Forme
from crowquill.knobs import checked, of
from crowquill.sheet import Sheet

KINDS = ("pdf", "tiff")
DPI = 2400  # of pixels, where no other is asked for: what platesetters have

Plan = list[tuple[Path, Callable[[BinaryIO], object]]]


def plan(sheet: Sheet, folder: Path, name: str, *, kind: str = "pdf", values: Mapping[str, Any]) -> Plan:
    """A path in the folder for the plate of each ink, NAME-INK.pdf or .tiff, and what fills an open file with it.

    values  knobs of formats, of which bleed, colour_bar, compact and the dpi of pixels count

    Raises ValueError for a sheet without ink, for pixels of shares of ink, which nothing here screens, and what
    forme.inks raises.
    """
    own = _knobs(values)
    plates = forme.separated(sheet, bleed=own["bleed"], colour_bar=own["colour_bar"])
    if not plates:
        raise ValueError("the drawing has no ink, and so no plates; leave out plates")
    paths = [folder / f"{name}-{part}.{kind}" for part in named(plates)]
    if kind == "pdf":
        fills: list[Callable[[BinaryIO], object]] = [partial(pdf.compose, plate, compact=own["compact"]) for plate in plates.values()]
    else:
        for ink, plate in plates.items():
            _check_solid(ink, plate)
        fills = [partial(_pixels, plate, _dpi(values)) for plate in plates.values()]
    return list(zip(paths, fills, strict=True))


def targets(kind: str) -> list[Path]:
    """Names of the formats whose knobs count for plates of a kind. Raises ValueError for an unknown one."""
    if kind not in KINDS:
        raise ValueError(f"no plates-as {kind!r}; there are {', '.join(KINDS)}")
    return [Path("plates.pdf"), Path(f"plates.{kind}")]


def foresee(size: tuple[float, float], *, kind: str, values: Mapping[str, Any]) -> None:
    """Raises the ValueError that plates of a sheet of this size, in mm, would raise, where that is known before."""
    own = _knobs(values)
    if kind == "tiff":
        tiff.foresee(forme.locked(Sheet(size), bleed=own["bleed"], marks=True).size, 0, dpi=_dpi(values), bilevel=True)


def named(inks: Iterable[str]) -> list[str]:
    """Inks' names as parts of file names: letters, digits, point, plus and minus, and no two alike, whatever their case."""
    found: list[str] = []
    for ink in inks:
        plain = re.sub(r"[^A-Za-z0-9.+-]+", "_", ink).strip("_.")
        taken = {name.lower() for name in found}
        number = next(k for k in range(1, len(found) + 2) if (plain if k == 1 else f"{plain}_{k}").lower() not in taken)
        found.append(plain if number == 1 else f"{plain}_{number}")
    return found


def _knobs(values: Mapping[str, Any]) -> dict[str, Any]:
    takes = of(pdf.write)
    return checked(takes, {key: value for key, value in values.items() if key in takes}, "format")


def _dpi(values: Mapping[str, Any]) -> float:
    return float(values.get("dpi") or DPI)


def _check_solid(ink: str, plate: Forme) -> None:
    """Raises ValueError for shares of an ink, which one bit does not hold."""
    for layer in plate.layers:
        found = np.array([layer.ink.cmyk[3]]) if layer.fill is None else layer.fill[:, 3]
        tints = found[found < 1] if layer.fill is not None else found[(found > 0) & (found < 1)]
        if len(tints):
            wish = "leave out colour-bar" if layer in plate.around else "draw in full ink"
            share = f"{100 * tints[0]:.4g} %"
            raise ValueError(f"plate {ink!r} has {share} of its ink, and pixels are full or empty; {wish}, or write plates as pdf")


def _pixels(plate: Forme, dpi: float, file: BinaryIO) -> None:
    tiff.write(plate.flat(), file, dpi=dpi, bilevel=True)
