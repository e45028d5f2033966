"""Draw a drawing again from the recipe that its file keeps: the same bytes.

The picture, or what a plate is made from, is looked for beside the drawing, unless it was drawn with --embed, or is given.
"""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import making, options, plate, styles
from crowquill.commands import _drawing
from crowquill.commands import plate as plates
from crowquill.commands._running import Run
from crowquill.knobs import Text
from crowquill.recipe import PICTURE, TABLES, takes_of


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("redo", help=__doc__, no_args_is_help=True)(_with_sources(options.running(_redone)))


def _redone(
    file: Annotated[Path, typer.Argument(help="A drawing, SVG, PDF, PNG, TIFF, or a TOML recipe.", show_default=False, metavar="FILE")],
    picture: Annotated[Path | None, typer.Option(help="The picture it was drawn from, where it is not beside it.", metavar="FILE")] = None,
    folder: Annotated[Path | None, typer.Option(help="Where a plate's files are, if not beside it.", metavar="FOLDER")] = None,
    *,
    out: list[Path],
    sources: dict[str, Path | None],
    **running: Any,
) -> int:
    run = Run(out, **running)
    given = {key: path for key, path in {PICTURE: picture, **sources}.items() if path is not None}
    with tempfile.TemporaryDirectory() as inside:
        if kept := plate.kept(file):
            if given:
                word = next(iter(given)).replace("_", "-")
                raise ValueError(f"--{word} is for drawings of one picture; say where a plate's files are with --folder")
            again = plate.again(file, *kept, folder=folder, inside=Path(inside))
            run.check([file], {})
            return plates.draw(again, run, said=_older(file, again.version))
        if folder is not None:
            raise ValueError("--folder is for plates; say where a drawing's picture is with --picture")
        wanted, paths = making.found(file, given, Path(inside))
        run.check([file, *paths.values()], {})
        return _drawing.draw(wanted, paths, run, said=_older(file, wanted.version))


def _with_sources(call: Callable[..., int]) -> Callable[..., int]:
    """A function for Typer to read: the parameters of `call`, and an option for each file that any drawing may be made from."""
    own = list(inspect.signature(call).parameters.values())
    takes = {key: knob for style in styles.names() for table in TABLES for key, knob in takes_of(table, style).items()}
    files = sorted(key for key, knob in takes.items() if isinstance(knob.takes, Text) and knob.takes.file)

    def called(**values: Any) -> int:
        return call(sources={key: values.pop(key) for key in files}, **values)

    return options.signed(called, [*own, *(options.source(key) for key in files)])


def _older(file: Path, made: str) -> list[str]:
    """What is said of a drawing by another version of the program."""
    now = version("crowquill")
    return [f"{file} was made by crowquill {made}, this is {now}; the drawing may differ"] if made != now else []
