"""Draw an edited drawing from its log: the same bytes as the editor's own export.

The file that was edited lies beside its log, under its own name.
"""

from __future__ import annotations

import inspect
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import formats, options
from crowquill.commands import note, say
from crowquill.recipe import takes_of
from crowquill.sheet import Sheet


def add(app: typer.Typer) -> None:
    """Adds the command."""
    knobs = [replace(knob, default=None) for key, knob in takes_of("files", "").items() if key != "embed"]
    own = list(inspect.signature(_replayed, eval_str=True).parameters.values())[:-1]

    def called(**values: Any) -> int:
        chosen = {knob.name: values.pop(knob.name) for knob in knobs}
        return _replayed(**values, values={key: value for key, value in chosen.items() if value is not None})

    every = [*own, *(options.option(knob, "files") for knob in knobs)]
    app.command("replay", help=__doc__, no_args_is_help=True)(options.signed(called, every))


def _replayed(
    file: Annotated[Path, typer.Argument(help="The log that the editor kept: FILE.edits.", show_default=False, metavar="LOG")],
    out: Annotated[list[Path], typer.Argument(help=options.WRITTEN, show_default=False, metavar="OUT")],
    overwrite: Annotated[bool, typer.Option(help="Replace files that are there.")] = True,
    values: dict[str, Any] | None = None,
) -> int:
    from crowquill.editor import log
    from crowquill.editor.session import edited, replayed, written

    beside = edited(file, log.read(file).header)
    formats.check(out, overwrite=overwrite, sources=[file, beside])
    formats.writers(Sheet((1, 1)), [(path, None) for path in out], values or {})
    for _, total, drawing, header in replayed(file):  # noqa: B007
        pass
    sheet = written(header, drawing)
    formats.save(sheet, *out, overwrite=overwrite, **(values or {}))
    for text in drawing.notes:
        note(text)
    say(f"{total} edits, {sum(len(layer.art) for layer in sheet.layers)} marks and paths: {', '.join(map(str, out))}")
    return 0
