"""Write a sheet to print and measure: rulers, dots, lines, gaps and steps of tone, for --ink-gain and --tone-curve."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from crowquill import calibration, formats, options
from crowquill.commands import plain, say


def add(app: typer.Typer) -> None:
    """Adds the command."""

    @app.command("calibrate", help=__doc__, no_args_is_help=True)
    def calibrate(
        out: Annotated[list[Path], typer.Argument(help="Files to write: .pdf, .svg, .png, .tiff.", show_default=False, metavar="OUT")],
        paper: Annotated[str, typer.Option(help="Paper: a4, a5, letter, or a size such as 297x210mm.")] = "a4",
        pen: Annotated[float, typer.Option(help="Width of the dots of tones.", parser=options.lengths, metavar="LENGTH")] = 0.3,
        overwrite: Annotated[bool, typer.Option(help="Replace files that are there.")] = True,
    ) -> int:
        for path in out:
            formats.module(path.suffix[1:].lower(), str(path))
        formats.check(out, overwrite=overwrite)
        page = calibration.sheet(paper, pen)
        formats.save(page, *out, overwrite=overwrite)
        say(f"{page.size[0]:g} x {page.size[1]:g} mm, to print at 100 %: {plain(', '.join(map(str, out)))}")
        return 0
