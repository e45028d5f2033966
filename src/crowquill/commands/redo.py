"""Draw a drawing again from the recipe that its file keeps: the same bytes.

The picture is looked for beside the drawing, unless it was drawn with --embed, or is given.
"""

from __future__ import annotations

import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import making, options
from crowquill.commands import _drawing
from crowquill.recipe import PICTURE


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("redo", help=__doc__, no_args_is_help=True)(options.running(_redone))


def _redone(
    file: Annotated[Path, typer.Argument(help="A drawing, SVG, PDF, PNG, TIFF, or a TOML recipe.", show_default=False, metavar="FILE")],
    picture: Annotated[Path | None, typer.Option(help="The picture it was drawn from, where it is not beside it.", metavar="FILE")] = None,
    canvas: Annotated[Path | None, typer.Option(help="Its canvas, likewise.", metavar="FILE")] = None,
    importance: Annotated[Path | None, typer.Option(help="Its map of importance, likewise.", metavar="FILE")] = None,
    glyphs: Annotated[Path | None, typer.Option(help="Its library of dots, likewise.", metavar="FILE")] = None,
    *,
    out: list[Path],
    **run: Any,
) -> int:
    began = time.perf_counter()
    given = {PICTURE: picture, "canvas": canvas, "importance": importance, "glyphs": glyphs}
    with tempfile.TemporaryDirectory() as folder:
        wanted, paths = making.found(file, {key: path for key, path in given.items() if path is not None}, Path(folder))
        _drawing.check([file, *paths.values()], out, **run)
        now, said = version("crowquill"), []
        if wanted.version != now:
            said = [f"{file} was made by crowquill {wanted.version}, this is {now}; the drawing may differ"]
        return _drawing.draw(wanted, paths, out, began=began, said=said, **run)
