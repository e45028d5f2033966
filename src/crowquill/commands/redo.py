"""Draw a drawing again from the recipe in its SVG or PDF: the same bytes.

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
from crowquill.commands import _drawing, note
from crowquill.recipe import PICTURE


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("redo", help=__doc__, no_args_is_help=True)(options.running(_redone))


def _redone(
    file: Annotated[Path, typer.Argument(help="A drawing's SVG or PDF, or its recipe as TOML.", show_default=False, metavar="FILE")],
    picture: Annotated[Path | None, typer.Option(help="The picture it was drawn from.", metavar="FILE")] = None,
    *,
    out: list[Path],
    **run: Any,
) -> int:
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        wanted, paths = making.found(file, {PICTURE: picture} if picture else {}, Path(folder))
        _drawing.check([file, *paths.values()], out, **run)
        if wanted.version != version("crowquill"):
            note(f"{file} was made by crowquill {wanted.version}, this is {version('crowquill')}; the drawing may differ")
        return _drawing.draw(wanted, paths, out, began=began, **run)
