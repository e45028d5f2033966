"""Print the recipe kept in a drawing's SVG or PDF as TOML, for redo and for --recipe."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from crowquill import making
from crowquill.commands import say


def add(app: typer.Typer) -> None:
    """Adds the command."""

    @app.command("recipe", help=__doc__, no_args_is_help=True)
    def printed(
        file: Annotated[Path, typer.Argument(help="A drawing's SVG or PDF.", show_default=False, metavar="FILE")],
    ) -> int:
        say(making.read(file)[0].toml().rstrip("\n"))
        return 0
