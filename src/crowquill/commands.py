"""Commands: one a style, with the style's own knobs and the options that all styles share."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import sys
import time
import unicodedata
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crowquill import options, styles, units

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
    return "".join("?" if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp") else letter for letter in text)


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
        function = options.command(name, _drawn) if name == chosen else lambda: None
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
    check_bar: bool,
    **layout: Any,
) -> int:
    """One drawing from picture to files."""
    from crowquill import formats

    began = time.perf_counter()
    for path in out:
        formats.module(path.suffix[1:].lower(), str(path))
    to_file = report is not None and str(report) != "-"
    texts = [Path(value) for key, value in knobs.items() if isinstance(styles.knobs(name)[key].takes, styles.Text)]
    sources = [path for path in (picture, layout["canvas"], *texts) if path is not None]
    formats.check([*out, *([report] if report and to_file else [])], overwrite=overwrite, sources=sources)
    page, tone = _laid_out(picture, **layout)
    work = styles.steps(name, tone, seed=seed, **knobs)
    if dry_run:
        return _foretold(work, tone, page)
    sheet = styles.run(work) if quiet else _watched(work)
    sheet = sheet.on(page, margin=layout["margin"], orientation="as it is")
    if check_bar:
        sheet = _with_bar(sheet, layout["margin"])
    told = _Report({**sheet.report, "paper_mm": list(sheet.size), "files": [str(path) for path in out]}, began)
    plan = [(path, formats.writer(sheet, path)) for path in out]
    if report and to_file:
        plan.append((report, lambda file: file.write(f"{told.text()}\n".encode())))
    formats.replace_files(plan)
    for warning in told.facts["warnings"]:
        sys.stderr.write(f"crowquill: note: {plain(warning)}\n")
    if report and not to_file:
        say(told.text())
    elif not quiet:
        say(told.summary())
    return 0


class _Report:
    """What came of a drawing, as JSON and as a line; the time of writing is known only when it is asked for."""

    def __init__(self, facts: dict[str, Any], began: float) -> None:
        self.facts, self._began, self._drawn = facts, began, time.perf_counter()

    def text(self) -> str:
        """The report as JSON."""
        now = time.perf_counter()
        last = {"write": round(now - self._drawn, 3), "total": round(now - self._began, 3)}
        return json.dumps({**self.facts, "seconds": {**self.facts["seconds"], **last}}, indent=2)

    def summary(self) -> str:
        """What was drawn, how large, with how much ink, where."""
        facts, art, page = self.facts, self.facts["art_mm"], self.facts["paper_mm"]
        return (
            f"{facts['marks']} marks, {art[0]:.4g} x {art[1]:.4g} mm on {page[0]:g} x {page[1]:g} mm, "
            f"ink {facts['ink_placed_mm2']:.0f} of {facts['ink_asked_mm2']:.0f} mm2, "
            f"{time.perf_counter() - self._began:.1f} s: {plain(', '.join(facts['files']))}"
        )


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
    from crowquill.sheet import check_fit, turned
    from crowquill.tone import Tone
    from crowquill.vector import canvas as outline
    from crowquill.vector import contents

    units.paper(paper)
    if margin < 0:
        raise ValueError(f"margin is {margin:g} mm; it takes 0 or more")
    with _silence():
        tone = Tone.load(picture, **light)
    art = (width, height) if width and height and fit != "contain" else tone.size
    size = turned(paper, art, orientation)
    room = (size[0] - 2 * margin, size[1] - 2 * margin)
    if min(room) <= 0:
        raise ValueError(f"a margin of {margin:g} mm leaves no room on a paper of {size[0]:g} x {size[1]:g} mm; make it smaller")
    tone = tone.fitted(width, height, fit) if width is not None or height is not None else tone.fitted(*room, fit)
    check_fit(tone.size, size, margin)
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
