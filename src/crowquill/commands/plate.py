"""Draw a plate: several drawings on one page at true size, with letters, scale bars and captions, from a TOML file.

crowquill plate --init writes an example to begin with.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import formats, options, plate
from crowquill.commands import note, say
from crowquill.commands._running import Run, silence
from crowquill.knobs import Knob
from crowquill.plate.drawing import Opened, foretold
from crowquill.recipe import takes_of

FILE = Path("plate.toml")
STROKES = "takes strokes only, and a plate is for print; give an SVG or a PDF"
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".gif", ".bmp")


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("plate", help=__doc__, no_args_is_help=True)(_with_files(options.running(_plated)))


def _plated(
    file: Annotated[Path | None, typer.Argument(help="The plate, a TOML file.", show_default=False, metavar="PLATE")] = None,
    init: Annotated[bool, typer.Option("--init", help="Write an example to PLATE, or to plate.toml; replaces nothing.")] = False,
    *,
    out: list[Path] | None,
    **running: Any,
) -> int:
    if init:
        return _begun(file or FILE, out)
    if file is None or not out:
        raise ValueError("give a plate and the files to write; crowquill plate --init writes an example")
    asked = {key: value for key in _knobs() if (value := running.pop(key)) is not None}
    run = Run(out, **running)
    run.check([file], asked, strokes=STROKES)
    with silence():
        opened = plate.opened(file, **asked)
    return draw(opened, run, said=[])


def draw(opened: Opened, run: Run, *, said: list[str]) -> int:
    """The files of a plate; `said` are notes for the end."""
    sources = opened.folder.paths()
    run.check(sources, {"embed": opened.files.get("embed")}, strokes=STROKES)
    run.foresee(opened.composition.size, 0, opened.files)
    if run.sets_text:
        opened.foresee_pdf()
    if run.dry_run:
        return _foretold(opened)
    work = plate.steps(opened, embed=bool(opened.files.get("embed")))
    return run.write(run.done(work), opened.files, sources, said)


def _foretold(opened: Opened) -> int:
    """What the plate will be, panel by panel."""
    width, height = opened.composition.size
    say(f"page   {width:g} x {height:g} mm")
    for placed, part, facts in foretold(opened):
        art = placed.art
        more = "".join(f", {value:g} {name}" for name, value in facts.items() if name not in ("seconds", "bytes"))
        say(f"{placed.label:<6} {part.name or 'drawing'}, {art.width:.4g} x {art.height:.4g} mm at {art.left:.4g}, {art.top:.4g}{more}")
    for warning in opened.composition.notes:
        note(warning)
    return 0


def _begun(file: Path, out: list[Path] | None) -> int:
    """An example in a new file, for the first picture beside it."""
    if out:
        raise ValueError(f"{out[0]}: --init writes one file; give no other")
    formats.check([file], overwrite=False)
    beside = sorted(
        path.name for path in file.parent.iterdir() if path.suffix.lower() in PICTURES and re.fullmatch(r"[\w .()-]+", path.name)
    )
    text = (Path(plate.__file__).parent / "example.toml").read_text(encoding="utf-8")
    name = next(iter(beside), "picture.png")
    data = text.replace("picture.png", name).replace("plate.toml", file.name).encode()
    formats.replace_files([(file, lambda target: target.write(data))])
    say(f"{file}: draws {name}; crowquill plate {file} plate.pdf")
    return 0


def _knobs() -> dict[str, Knob]:
    """The knobs of all formats that print, and whether files are kept inside."""
    strokes = {key for name in formats.names() if hasattr(formats.module(name, name), "STROKES") for key in formats.knobs(name)}
    return {key: knob for key, knob in takes_of("files", "").items() if key not in strokes}


def _with_files(call: Callable[..., int]) -> Callable[..., int]:
    """A function for Typer to read: the parameters of `call`, of which files to write may be left out, and options of formats."""
    written = typer.Argument(help="Files to write, by suffix: .svg, .pdf, .png, .tiff.", show_default=False, metavar="OUT")
    own = inspect.signature(call).parameters
    out = own["out"].replace(annotation=Annotated[list[Path] | None, written], default=None)
    every = [out if name == "out" else parameter for name, parameter in own.items()]
    every += [options.option(replace(knob, default=None), "files") for knob in _knobs().values()]

    def called(**values: Any) -> int:
        return call(**values)

    return options.signed(called, every)
