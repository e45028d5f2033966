"""The command line's options: those of knobs, from signatures, and those of the running itself."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import layout, recipe, styles, units
from crowquill.knobs import Choice, Flag, Knob, Numbers, Range, Text, of
from crowquill.recipe import TABLES, Recipe
from crowquill.vector import contents

PANELS = {
    "paper": "Paper and size",
    "tone": "Picture and tone",
    "knobs": "The style's knobs",
    "inks": "Inks",
    "finish": "Lines, bars and print",
    "files": "Files",
    "plot": "For a plotter",
}
NAMES = {"purpose": "--for"}  # a word that no parameter may have
RUN = "Running"
WRITTEN = "Files to write, by suffix: .svg, .pdf, .png, .tiff; for plotters .hpgl, .gcode."


def _running(
    out: Annotated[list[Path], typer.Argument(help=WRITTEN, show_default=False, metavar="OUT")],
    *,
    report: Annotated[
        Path | None, typer.Option(help="Write what came of it as JSON; - prints it.", rich_help_panel=RUN, metavar="FILE")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no summary.", rich_help_panel=RUN)] = False,
    overwrite: Annotated[bool, typer.Option(help="Replace files that are there.", rich_help_panel=RUN)] = True,
    plates: Annotated[
        Path | None,
        typer.Option(help="Write the plate of each ink too, into this folder.", rich_help_panel=RUN, metavar="DIR"),
    ] = None,
    plates_as: Annotated[
        str | None, typer.Option(help="The plates' format: pdf, or tiff of 1 bit at --dpi, or 2400.", rich_help_panel=RUN, metavar="KIND")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say size, dots and time, and write nothing.", rich_help_panel=RUN)] = False,
) -> None:
    """Only its signature is used: the options of all that draws."""


def drawing(style: str, draw: Callable[..., int]) -> Callable[..., int]:
    """A function for Typer to read, whose options are those of a style.

    It calls draw(wanted, picture=, recipe=, typed=, **running); `recipe` is the TOML that settings were taken from, or
    None, `typed` the names of options given by hand.
    """
    picture = Annotated[Path, typer.Argument(help="The picture: PNG, JPEG, TIFF, WebP, GIF, BMP.", show_default=False, metavar="PICTURE")]
    out, *rest = inspect.signature(_running, eval_str=True).parameters.values()
    return styled(style, draw, [_parameter("picture", picture), out], rest)


def styled(style: str, draw: Callable[..., int], first: list[inspect.Parameter], rest: list[inspect.Parameter]) -> Callable[..., int]:
    """A function for Typer to read: parameters that come first, the options of a style, and those of the running.

    It calls draw(wanted, recipe=, typed=, ...) with all others by keyword.
    """
    taken = typer.Option(
        help="Settings from this TOML; options given here go before.",
        rich_help_panel=RUN,
        metavar="FILE",
        is_eager=True,
        callback=lambda context, path: _settings(context, style, path),
    )
    seed = typer.Option(help="Same seed, same drawing.", rich_help_panel=RUN, min=0)
    tables = {table: recipe.takes_of(table, style) for table in TABLES}
    every = [*first, *(option(knob, table) for table, takes in tables.items() for knob in takes.values())]
    every += [_parameter("seed", Annotated[int, seed], 0), _parameter("recipe", Annotated[Path | None, taken], None), *rest]

    def called(context: typer.Context, **values: Any) -> int:
        """Parts the settings from the options of the running."""
        typed = {key for key in values if getattr(context.get_parameter_source(key), "name", "") == "COMMANDLINE"}
        either = getattr(sys.modules[styles.style(style).__module__], "EITHER", ())
        if values["recipe"] is not None and typed & set(either):  # what is typed takes the place of what the recipe has
            values |= {key: None for key in either if key not in typed}
        settings: dict[str, Any] = {table: {key: values.pop(key) for key in takes} for table, takes in tables.items()}
        settings["files"] = {key: value for key, value in settings["files"].items() if value is not None}
        return draw(Recipe(style, values.pop("seed"), **settings), typed=typed, **values)

    return signed(called, [_parameter("context", typer.Context), *every])


def running(call: Callable[..., int]) -> Callable[..., int]:
    """A function for Typer to read: the parameters of `call` that have a place, and the options of the running.

    It calls `call` with all by keyword.
    """
    own = inspect.signature(call, eval_str=True).parameters.values()
    extra = inspect.signature(_running, eval_str=True).parameters.values()

    def called(**values: Any) -> int:
        return call(**values)

    return signed(called, [*(p for p in own if p.kind is p.POSITIONAL_OR_KEYWORD), *extra])


def lit(call: Callable[..., int]) -> Callable[..., int]:
    """A function for Typer to read: the parameters of `call` that have a place, and options of tone, each None when left out."""
    own = [p for p in inspect.signature(call, eval_str=True).parameters.values() if p.kind is p.POSITIONAL_OR_KEYWORD]
    light = [option(replace(knob, default=None), "tone") for knob in of(layout.lit).values()]

    def called(**values: Any) -> int:
        return call(**values)

    return signed(called, [*own, *light])


def source(key: str) -> inspect.Parameter:
    """The option that says where a file is that a drawing was made from."""
    words = typer.Option(
        help=f"Its {key.replace('_', ' ')}, where it is not beside it.", rich_help_panel="Files it was made from", metavar="FILE"
    )
    return _parameter(key, Annotated[Path | None, words], None)


def signed(function: Callable[..., int], parameters: list[inspect.Parameter]) -> Callable[..., int]:
    """The function with these parameters for a signature, all by keyword."""
    function.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [p.replace(kind=p.KEYWORD_ONLY) for p in parameters]
    )
    function.__annotations__ = {p.name: p.annotation for p in parameters}
    return function


def _settings(context: typer.Context, style: str, path: Path | None) -> Path | None:
    """Puts the settings of a TOML recipe in place of the options' defaults; the files it names are looked for beside it."""
    if path is None:
        return None
    taken = recipe.read_toml(contents(path), str(path))
    if taken.style != style:
        raise ValueError(f"{path}: is a recipe for the style {taken.style}; say crowquill {taken.style}")
    taken = taken.with_paths({key: path.parent / name for key, name in recipe.files_of(taken).items()})
    values = {key: value for table in TABLES for key, value in getattr(taken, table).items() if value is not None}
    context.default_map = {**values, "seed": taken.seed}
    return path


def _parameter(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def option(knob: Knob, table: str) -> inspect.Parameter:
    """The option of a knob. Lengths are text on the command line, defaults too; of files only what is asked for is passed on."""
    takes = knob.takes
    default, shown = knob.default, None
    more: dict[str, Any] = {}
    kind: Any = str
    text = takes.help[0].upper() + takes.help[1:]
    if isinstance(takes, Choice):
        text = f"{text}: {', '.join(takes.names)}"
    elif isinstance(takes, Flag):
        kind = bool
    elif isinstance(takes, Range):
        kind = int if knob.whole else float
        if takes.unit == "mm":
            more = {"parser": lengths, "metavar": "LENGTH"}
            default = f"{default:g}mm" if default is not None else None
    elif isinstance(takes, Numbers):
        more = {"parser": lambda value: _several(value, takes), "metavar": "A,B,..."}
    elif isinstance(takes, Text) and takes.file:
        more = {"metavar": "NAME|FILE"}
    if table == "files":
        default, shown = None, None if default in (None, False) else str(default)
    dashed = knob.name.replace("_", "-")
    names = [f"--{dashed}/--no-{dashed}"] if kind is bool else [NAMES.get(knob.name, f"--{dashed}")]
    option = typer.Option(
        *names, help=f"{text}.", rich_help_panel=PANELS[table], show_default=shown or default not in (None, False), **more
    )
    return _parameter(knob.name, Annotated[kind | None if default is None else kind, option], default)


def lengths(value: Any) -> float:
    """A length typed, or taken from a recipe, where it is a number of millimetres."""
    return float(value) if isinstance(value, (int, float)) else _asked(units.length, value)


def _several(value: Any, takes: Numbers) -> tuple[float, ...]:
    """Numbers parted by commas, or from a recipe."""
    parts = value.split(",") if isinstance(value, str) else value
    if takes.unit == "mm":
        return tuple(lengths(part) for part in parts)
    try:
        return tuple(float(part) for part in parts)
    except ValueError:
        raise typer.BadParameter(f"{value!r} is not {takes.count or 'some'} numbers parted by commas: {takes.help}") from None


def _asked(read: Callable[[str], float], text: str) -> float:
    try:
        return read(text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
