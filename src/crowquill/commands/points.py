"""Export a drawing's dots as numbers: where they are, how large, and what share of the ink is theirs, as CSV or NPY."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import numpy as np
import typer

from crowquill import formats, judge, moments, options, seen
from crowquill.cells import voronoi
from crowquill.commands import say
from crowquill.paths import Array

COLUMNS = ("x_mm", "y_mm", "diameter_mm", "weight")


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("points", help=__doc__, no_args_is_help=True)(options.lit(_exported))


def _exported(
    drawing: Annotated[Path, typer.Argument(help="An SVG of dots, or a bitmap.", show_default=False, metavar="FILE")],
    out: Annotated[Path, typer.Option("--out", "-o", help="The file to write: .csv or .npy.", metavar="FILE")],
    against: Annotated[Path | None, typer.Option(help="The picture: weights are the ink of the dots' cells.", metavar="PICTURE")] = None,
    dpi: Annotated[float | None, typer.Option(help="Pixels to the inch of a bitmap; its own when left out.", min=10, max=100_000)] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace files that are there.")] = True,
    **light: Any,
) -> int:
    if out.suffix.lower() not in (".csv", ".npy"):
        raise ValueError(f"{out}: points are written as .csv or .npy; give a name that ends so")
    formats.check([out], overwrite=overwrite, sources=[drawing, *([against] if against else [])])
    found = seen.load(drawing, dpi=dpi)
    table = np.column_stack([found.sites, found.diameters, _weights(found, against, light)])
    formats.replace_files([(out, lambda file: _write(table, file, out.suffix.lower()))])
    say(f"{len(table)} dots, columns {', '.join(COLUMNS)}: {out}")
    return 0


def _weights(found: seen.Seen, against: Path | None, light: dict[str, Any]) -> Array:
    """Each dot's share of all ink, summing to 1: by its own area, or by the ink that the picture asks for in its cell."""
    weights = found.areas
    if against is not None and len(found.sites):
        tone = judge.asked(found, against, light)
        sites = np.clip(found.sites - judge.where(found)[:2], 0, tone.size)
        weights = moments.of_tone(voronoi(sites, tone.canvas), tone).mass
    return np.asarray(weights / (weights.sum() or 1.0))


def _write(table: Array, file: BinaryIO, suffix: str) -> None:
    if suffix == ".npy":
        np.save(file, table, allow_pickle=False)
        return
    text = io.StringIO()
    np.savetxt(text, table, "%.9g", ",", header=",".join(COLUMNS), comments="")
    file.write(text.getvalue().encode("ascii"))
