"""Commands: one a style, with the style's own knobs and the options that all styles share."""

from __future__ import annotations

import contextlib
import errno
import inspect
import json
import os
import sys
import time
import unicodedata
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crowquill import styles, units

if TYPE_CHECKING:
    from crowquill.sheet import Sheet, Step
    from crowquill.tone import Tone

REFUSED = 2
STOPPED = 130
LONGEST = 280  # characters of a refusal
BAR_MARGIN = 4.0  # mm; a check bar needs that much
REMEDIES = {
    errno.ENOENT: "check the name",
    errno.EACCES: "check its permissions",
    errno.EPERM: "check its permissions",
    errno.EROFS: "choose another folder",
    errno.ENOSPC: "free some space",
    errno.EDQUOT: "free some space",
    errno.ENAMETOOLONG: "give a shorter name",
    errno.EISDIR: "give a file name in it",
    errno.ENOTDIR: "check the path",
    errno.ELOOP: "check the path",
}


def application(arguments: list[str]) -> int:
    """Runs the command line; usage errors are refused in one line like any other."""
    command = typer.main.get_command(_application(next((a for a in arguments if not a.startswith("-")), None)))
    try:
        code = command(args=arguments, prog_name="crowquill", standalone_mode=False)
    except typer.Exit as stop:
        code = stop.exit_code
    except typer.TyperException as error:
        message = error.format_message() if hasattr(error, "format_message") else str(error)
        if not message:  # no arguments: the help has been shown
            return REFUSED
        message = message.rstrip(".").replace(". Did you mean", "; did you mean")
        return refused(message if "; " in message else f"{message}; --help shows what there is")
    except typer.Abort:
        raise KeyboardInterrupt from None
    if code == STOPPED:  # what Typer makes of Ctrl-C
        raise KeyboardInterrupt
    return code if isinstance(code, int) else 0


def refused(error: Exception | str) -> int:
    """One line on stderr: the file, the cause, the remedy. Returns the exit code."""
    if isinstance(error, OSError) and error.errno:
        name = f"{os.fsdecode(error.filename)}: " if error.filename else ""
        error = f"{name}{(error.strerror or 'failed').lower()}; {REMEDIES.get(error.errno, 'try another file or folder')}"
    line = plain(str(error))
    if len(line) > LONGEST:  # a name can be long: its beginning, the cause and the remedy are what helps
        line = f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"
    sys.stderr.write(f"crowquill: {line}\n")
    return REFUSED


def plain(text: str) -> str:
    """The text in one line that no terminal can misread: control and bidirectional characters become a question mark."""
    line = " ".join(text.split(" "))
    return "".join("?" if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp") else letter for letter in line)


def _application(chosen: str | None) -> typer.Typer:
    """The command line; only the chosen style is imported for its options, the others show their first line."""
    app = typer.Typer(
        name="crowquill",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )

    @app.callback(epilog="Try: crowquill stipple photo.jpg plate.pdf plate.svg --pen 0.3mm --paper a4")
    def about(  # its options are what it is for
        version: Annotated[bool, typer.Option("--version", is_eager=True, callback=_version, help="Print the version.")] = False,
    ) -> None:
        """Pictures become drawings of dots at true size: SVG to edit, PDF to print."""

    for name in styles.names():
        function = _command(name) if name == chosen else lambda: None
        app.command(name, help=styles.summary(name), no_args_is_help=True)(function)
    return app


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        say(f"crowquill {version('crowquill')}")
        raise typer.Exit


def say(text: str) -> None:
    """A line on stdout; where nobody listens any more, the work goes on."""
    try:
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


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


def _command(name: str) -> Callable[..., int]:
    """A function with the style's options and the shared ones as its signature, for Typer to read."""
    knobs = styles.knobs(name)
    parameters = [
        inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=_default(knob), annotation=_annotation(knob))
        for key, knob in knobs.items()
    ]
    shared = inspect.signature(_shared, eval_str=True).parameters

    def command(**values: Any) -> int:
        chosen = {key: values.pop(key) for key in knobs}
        return _drawn(name, chosen, **values)

    every = [*shared.values(), *parameters]
    command.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in every}
    return command


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


def _drawn(
    name: str,
    knobs: dict[str, Any],
    *,
    picture: Path,
    out: list[Path],
    report: Path | None,
    quiet: bool,
    overwrite: bool,
    dry_run: bool,
    seed: int,
    **options: Any,
) -> int:
    """One drawing from picture to files."""
    from crowquill import formats

    began = time.perf_counter()
    printed = report is not None and str(report) == "-"
    files = [*out, *([report] if report and not printed else [])]
    for path in out:
        formats.module(path.suffix[1:].lower(), str(path))
    texts = [Path(value) for key, value in knobs.items() if isinstance(styles.knobs(name)[key].takes, styles.Text)]
    sources = [path for path in (picture, options["canvas"], *texts) if path is not None]
    formats.check(files, overwrite=overwrite, sources=sources)
    page, tone = _laid_out(picture, **{key: options[key] for key in options if key not in ("check_bar",)})
    work = styles.steps(name, tone, seed=seed, **knobs)
    if dry_run:
        return _foretold(work, tone, page)
    sheet = styles.run(work, None) if quiet else _watched(work)
    sheet = sheet.on(page, margin=options["margin"], orientation="as it is")
    if options["check_bar"]:
        sheet = _with_bar(sheet, options["margin"])
    drawn = time.perf_counter()
    found: dict[str, Any] = {**sheet.report, "paper_mm": list(sheet.size), "files": [str(path) for path in out]}

    def told() -> str:
        seconds = {**found["seconds"], "write": round(time.perf_counter() - drawn, 3), "total": round(time.perf_counter() - began, 3)}
        return json.dumps({**found, "seconds": seconds}, indent=2)

    plan = [(path, formats.writer(sheet, path)) for path in out]
    if report and not printed:
        plan.append((report, lambda file: file.write(f"{told()}\n".encode())))
    formats.replace_files(plan)
    if printed:
        say(told())
    for warning in found["warnings"]:
        sys.stderr.write(f"crowquill: note: {plain(warning)}\n")
    if not (quiet or printed):
        _said(found, time.perf_counter() - began)
    return 0


def _laid_out(
    picture: Path,
    *,
    paper: str,
    orientation: str,
    margin: float,
    width: float | None,
    height: float | None,
    fit: str,
    canvas: Path | None,
    **light: Any,
) -> tuple[tuple[float, float], Tone]:
    """The paper in its orientation and the tone in its size."""
    from crowquill.sheet import turned
    from crowquill.tone import Tone
    from crowquill.vector import canvas as outline
    from crowquill.vector import contents

    size = units.paper(paper)
    if margin < 0:
        raise ValueError(f"margin is {margin:g} mm; it takes 0 or more")
    with _silence():
        tone = Tone.load(picture, **light)
    art = (width, height) if width and height and fit != "contain" else tone.size
    size = turned(size, art, orientation)
    room = (size[0] - 2 * margin, size[1] - 2 * margin)
    if min(room) <= 0:
        raise ValueError(f"a margin of {margin:g} mm leaves no room on a paper of {size[0]:g} x {size[1]:g} mm; make it smaller")
    tone = tone.fitted(width, height, fit) if width is not None or height is not None else tone.fitted(*room, fit)
    if tone.size[0] > room[0] + 1e-9 or tone.size[1] > room[1] + 1e-9:
        raise ValueError(
            f"a drawing of {tone.size[0]:g} x {tone.size[1]:g} mm does not fit a paper of {size[0]:g} x {size[1]:g} mm "
            f"with a margin of {margin:g} mm; make it smaller, or the paper larger"
        )
    if canvas is not None:
        shape = outline(contents(canvas), str(canvas), tone.size)
        try:
            tone = replace(tone, canvas=shape)
        except ValueError as error:
            raise ValueError(f"{canvas}: {error}") from None
    return size, tone


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keeps C libraries that read pictures from writing to stderr themselves: what is wrong is said once, by us."""
    sys.stderr.flush()
    kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def _with_bar(sheet: Sheet, margin: float) -> Sheet:
    from crowquill.paths import Paths
    from crowquill.sheet import check_bar

    bar = check_bar(margin, sheet.size[1] - margin / 2)
    if margin < BAR_MARGIN or not isinstance(bar.art, Paths) or bar.art.xy[:, 0].max() > sheet.size[0] - BAR_MARGIN / 2:
        raise ValueError(f"a check bar of 10 mm has no room in a margin of {margin:g} mm; make margin or paper larger")
    return replace(sheet, layers=(*sheet.layers, bar))


def _foretold(work: styles.Work, tone: Tone, page: tuple[float, float]) -> int:
    """What a style's first Step says of the work to come."""
    facts = next(work).facts
    work.close()
    say(f"paper  {page[0]:g} x {page[1]:g} mm")
    say(f"art    {tone.size[0]:.4g} x {tone.size[1]:.4g} mm")
    say(f"ink    {tone.ink:.1f} mm2 asked")
    for name, value in facts.items():
        say(f"{name:<6} {value:g}" if name != "seconds" else f"time   about {value:g} s")
    return 0


def _watched(work: styles.Work) -> Sheet:
    """The sheet, with a progress bar on a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description:<8}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:
        shown: dict[str, Any] = {}

        def watch(step: Step) -> None:
            if step.stage not in shown:
                shown[step.stage] = bars.add_task(step.stage, total=step.total)
            bars.update(shown[step.stage], completed=step.done, total=step.total)

        return styles.run(work, watch)


def _said(report: dict[str, Any], seconds: float) -> None:
    """The summary: what was drawn, how large, with how much ink, where."""
    art, page = report["art_mm"], report["paper_mm"]
    say(
        f"{report['marks']} marks, {art[0]:.4g} x {art[1]:.4g} mm on {page[0]:g} x {page[1]:g} mm, "
        f"ink {report['ink_placed_mm2']:.0f} of {report['ink_asked_mm2']:.0f} mm2, {seconds:.1f} s: {plain(', '.join(report['files']))}"
    )
