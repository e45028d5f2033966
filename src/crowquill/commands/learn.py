"""Learn how a hand stipples from the scan of a drawing, into one file for byexample --style-file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from crowquill import exemplar, formats
from crowquill.commands import note, plain, say
from crowquill.commands._running import silence, watched
from crowquill.exemplar import learning, stylefile


def add(app: typer.Typer) -> None:
    """Adds the command."""

    @app.command("learn", help=__doc__, no_args_is_help=True)
    def learn(
        scan: Annotated[Path, typer.Argument(help="The scan: PNG, JPEG, TIFF.", show_default=False, metavar="SCAN")],
        out: Annotated[Path, typer.Argument(help="The file to write, such as hand.style.", show_default=False, metavar="OUT")],
        example_dpi: Annotated[
            float | None, typer.Option(help="Dpi of the scan; its tag's, or by a ruler on it, when left out.", min=300, max=25_400)
        ] = None,
        overwrite: Annotated[bool, typer.Option(help="Replace a file that is there.")] = True,
    ) -> int:
        formats.check([out], overwrite=overwrite, sources=[scan])
        with silence():
            style = learning.learn(scan, example_dpi)
        style = watched(exemplar.learning_steps(style))
        formats.replace_files([(out, lambda file: file.write(stylefile.to_bytes(style)))])
        for text in style.notes:
            note(text)
        tones = ", ".join(f"{level.coverage:.2f}" for level in style.black.levels)
        whites = f", {len(style.white.glyphs)} white ones" if style.white else ""
        say(f"{plain(str(out))}: {len(style.black.glyphs)} marks{whites}, tones of {tones}")
        return 0
