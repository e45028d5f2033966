"""The command line's options: those of a style from its signature, and those that all styles share."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import styles, units


def _length(text: str) -> float:
    try:
        return units.length(text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


def _crop(text: str) -> tuple[float, ...]:
    parts = text.split(",")
    try:
        if len(parts) == 4:
            return tuple(float(part) for part in parts)
    except ValueError:
        pass
    raise typer.BadParameter(f"{text!r} is not left,top,width,height as shares of the picture, such as 0.1,0,0.8,1")


def _option(help: str, panel: str, **more: Any) -> Any:
    return typer.Option(help=help, rich_help_panel=panel, **more)


def _flag(name: str, help: str, panel: str) -> Any:
    return typer.Option(name, help=help, rich_help_panel=panel)


def _mm(help: str, panel: str) -> Any:
    return _option(help, panel, parser=_length, metavar="LENGTH")


PAPER, TONE, RUN = "Paper and size", "Tone", "Running"


def _shared(
    picture: Annotated[Path, typer.Argument(help="The picture: PNG, JPEG, TIFF, WebP, GIF, BMP.", show_default=False, metavar="PICTURE")],
    out: Annotated[list[Path], typer.Argument(help="Files to write, by suffix: .svg, .pdf.", show_default=False, metavar="OUT")],
    *,
    paper: Annotated[str, _option("a4, a5, letter, or a size such as 120x80mm.", PAPER)] = "a4",
    orientation: Annotated[str, _option("auto, portrait or landscape.", PAPER)] = "auto",
    margin: Annotated[float, _mm("White kept around the drawing.", PAPER)] = "15mm",  # type: ignore[assignment]
    width: Annotated[float | None, _mm("Width of the drawing; all the room when left out.", PAPER)] = None,
    height: Annotated[float | None, _mm("Height of the drawing.", PAPER)] = None,
    fit: Annotated[str, _option("contain, cover or stretch, when both sides are known.", PAPER)] = "contain",
    canvas: Annotated[Path | None, _option("SVG outline to draw in, its page laid over the picture.", PAPER, metavar="FILE")] = None,
    check_bar: Annotated[bool, _flag("--check-bar", "Draw a 10 mm bar in the margin.", PAPER)] = False,
    tone: Annotated[str, _option("auto: suits the pen; linear: physically exact; grey: by code value.", TONE)] = "auto",
    gamma: Annotated[float, _option("Power of coverage; above 1 opens shadows.", TONE)] = 1.0,
    black_point: Annotated[float | None, _option("Code value, 0 to 1, that is full ink.", TONE)] = None,
    white_point: Annotated[float | None, _option("Code value, 0 to 1, that is white paper.", TONE)] = None,
    invert: Annotated[bool, _flag("--invert", "Swap light and dark.", TONE)] = False,
    crop: Annotated[str | None, _option("left,top,width,height, shares of 1.", TONE, parser=_crop, metavar="L,T,W,H")] = None,
    local_contrast: Annotated[float, _option("0 to 1, stress on detail.", TONE)] = 0.0,
    max_pixels: Annotated[int, _option("Refuse larger pictures.", TONE)] = 200_000_000,
    seed: Annotated[int, _option("Same seed, same drawing.", RUN, min=0)] = 0,
    report: Annotated[Path | None, _option("Write what came of it as JSON; - prints it.", RUN, metavar="FILE")] = None,
    quiet: Annotated[bool, _flag("--quiet", "No progress and no summary.", RUN)] = False,
    overwrite: Annotated[bool, _option("Replace files that are there.", RUN)] = True,
    dry_run: Annotated[bool, _flag("--dry-run", "Say size, dots and time, and write nothing.", RUN)] = False,
) -> None:
    """Only its signature is used: the options of every style."""


def command(name: str, draw: Callable[..., int]) -> Callable[..., int]:
    """A function for Typer to read: the options of a style and the shared ones are its signature.

    It calls draw(name, knobs, **shared).
    """
    knobs = styles.knobs(name)
    parameters = [
        inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=_default(knob), annotation=_annotation(knob))
        for key, knob in knobs.items()
    ]
    shared = inspect.signature(_shared, eval_str=True).parameters

    def called(**values: Any) -> int:
        """Parts the style's own values from the shared ones."""
        chosen = {key: values.pop(key) for key in knobs}
        return draw(name, chosen, **values)

    every = [*shared.values(), *parameters]
    called.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    called.__annotations__ = {p.name: p.annotation for p in every}
    return called


def _default(knob: styles.Knob) -> Any:
    """Lengths are text on the command line, defaults too."""
    is_length = isinstance(knob.takes, styles.Range) and knob.takes.unit == "mm"
    return f"{knob.default:g}mm" if is_length and knob.default is not None else knob.default


def _annotation(knob: styles.Knob) -> Any:
    takes, panel = knob.takes, "The style's knobs"
    kind: Any = str
    help = takes.help[0].upper() + takes.help[1:]
    option = _option(f"{help}.", panel)
    if isinstance(takes, styles.Choice):
        option = _option(f"{help}: {', '.join(takes.names)}.", panel)
    elif isinstance(takes, styles.Range):
        kind = int if knob.whole else float
        if takes.unit == "mm":
            option = _mm(f"{help}.", panel)
    return Annotated[kind | None if knob.default is None else kind, option]
