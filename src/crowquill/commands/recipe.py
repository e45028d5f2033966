"""Print the recipe kept in a drawing as TOML, for redo and for --recipe."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Annotated

import typer

from crowquill import making, plate
from crowquill.commands import say


def add(app: typer.Typer) -> None:
    """Adds the command."""

    @app.command("recipe", help=__doc__, no_args_is_help=True)
    def printed(
        file: Annotated[Path, typer.Argument(help="A drawing: SVG, PDF, PNG or TIFF.", show_default=False, metavar="FILE")],
    ) -> int:
        kept = plate.kept(file)
        text = plate.toml(kept[0]) if kept else making.read(file)[0].toml()
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(encoding="utf-8")  # TOML is UTF-8 whatever the terminal speaks
        say(text.rstrip("\n"))
        return 0
