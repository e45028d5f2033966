"""Show what a plotter will do with a drawing: every stroke as wide as its pen, and in red the way with the pen up."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from crowquill import formats
from crowquill.commands import note, say
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet

UP = Ink("pen up", (0.0, 0.85, 0.9, 0.0), 0.1)
HOME = (0.05, 0.05)  # mm: the corner, where the pen begins, so far in that half of the red line is not cut off


def add(app: typer.Typer) -> None:
    """Adds the command."""

    @app.command("preview", help=__doc__, no_args_is_help=True)
    def shown(
        file: Annotated[Path, typer.Argument(help="A drawing's SVG, drawn with --for plotter.", show_default=False, metavar="FILE")],
        out: Annotated[list[Path], typer.Argument(help="Files to write: .png, .svg, .pdf.", show_default=False, metavar="OUT")],
        dpi: Annotated[float, typer.Option(help="Pixels to the inch of a PNG or TIFF.", min=20, max=4800)] = 150,
        overwrite: Annotated[bool, typer.Option(help="Replace files that are there.")] = True,
    ) -> int:
        pixels = any("dpi" in formats.knobs(path.suffix[1:].lower()) for path in out)
        more: dict[str, Any] = {"dpi": dpi} if pixels else {}
        formats.check(out, overwrite=overwrite, sources=[file])
        sheet = formats.load(file)
        filled = [layer.label for layer in sheet.layers if layer.ink.pen is None and len(layer.art)]
        if filled:
            raise ValueError(f"{file}: layer {filled[0]!r} is filled, which no pen draws; draw it with --for plotter")
        page, lifts, up = preview(sheet)
        formats.save(page, *out, overwrite=overwrite, **more)
        for warning in sheet.report.get("warnings", ()):
            note(warning)
        say(f"{lifts} strokes, {up / 1000:.1f} m with the pen up: {', '.join(map(str, out))}")
        return 0


def preview(sheet: Sheet) -> tuple[Sheet, int, float]:
    """The sheet with its pen-up moves in a layer of their own, how many strokes it has, and the length of those moves in mm."""
    at: Array = np.array(HOME)
    moves, strokes = [], 0
    for layer in sheet.layers:
        if not isinstance(layer.art, Paths) or not len(layer.art):
            continue
        for path in layer.art:
            moves.append([at, path[0]])
            at = path[0] if layer.art.closed else path[-1]
            strokes += 1
    ways = Paths.of(moves, closed=False)
    length = float(np.hypot(*(ways.xy[1::2] - ways.xy[::2]).T).sum())
    return Sheet(sheet.size, (*sheet.layers, Layer(UP, ways, "pen up")), sheet.recipe), strokes, length
