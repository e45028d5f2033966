"""Drawing on the command line: from a recipe and its sources to files, with progress, a report and a line at the end."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from pathlib import Path
from typing import Any

from crowquill import formats, making, options, plotting, styles
from crowquill.commands import note, plain, say
from crowquill.recipe import PICTURE, Recipe, files_of
from crowquill.sheet import Sheet, Step
from crowquill.tone import Tone

TIMES = {"seconds": "time", "plot": "plot"}  # of the facts of a plan, and what they are called


def command(style: str) -> Callable[..., int]:
    """The command of a style, for Typer to read."""
    return options.drawing(style, _drawn)


def _drawn(wanted: Recipe, *, picture: Path, out: list[Path], recipe: Path | None, typed: Set[str], **run: Any) -> int:
    """One drawing from picture to files; `typed` are the options given by hand."""
    began, said = time.perf_counter(), []
    sources = making.read(recipe)[0].sources if recipe else {}
    if PICTURE in sources and sources[PICTURE].name != picture.name:
        said = [f"{recipe} was made for {sources[PICTURE].name}; its settings are used for {picture.name}"]
    paths = {PICTURE: picture, **{key: Path(value) for key, value in files_of(wanted).items()}}
    plotter = wanted.plot["purpose"] == "plotter"
    if not plotter and (idle := sorted(typed & set(wanted.plot))):
        raise ValueError(f"--{idle[0].replace('_', '-')} is for plotters; add --for plotter")
    asked = {key: value for key, value in wanted.files.items() if key in typed and key != "embed"}
    formats.writers(Sheet((1, 1)), [(path, None) for path in out], asked)
    modules = [formats.module(path.suffix[1:].lower(), str(path)) for path in out]
    strokes = [path for path, module in zip(out, modules, strict=True) if getattr(module, "STROKES", False)]
    if strokes and not plotter:
        raise ValueError(f"{strokes[0]}: takes strokes only; add --for plotter")
    if "embed" in typed and wanted.files.get("embed") and not any(hasattr(module, "KEEPS_FILES") for module in modules):
        raise ValueError(f"{out[0]}: keeps no picture inside; leave out --embed, or write an SVG or a PDF too")
    check(paths.values(), out, **run)
    return draw(wanted, paths, out, began=began, said=said, named=making.named, **run)


def check(sources: Iterable[Path], out: list[Path], *, report: Path | None, overwrite: bool, **_: Any) -> None:
    """Raises the error that writing would raise, before any work is done."""
    for path in out:
        formats.module(path.suffix[1:].lower(), str(path))
    told = [report] if report and str(report) != "-" else []
    formats.check([*out, *told], overwrite=overwrite, sources=list(sources))


def draw(
    wanted: Recipe,
    paths: Mapping[str, Path],
    out: list[Path],
    *,
    began: float,
    said: list[str],
    named: Callable[[Recipe, Mapping[str, Path]], Recipe] = lambda wanted, _: wanted,
    report: Path | None,
    quiet: bool,
    dry_run: bool,
    **_: Any,
) -> int:
    """The files that a recipe and its sources give; `named` makes of them what the files keep, once they have been read.

    said  notes for the end: a refusal is one line
    """
    with _silence():
        page, tone = making.laid_out(wanted, paths)
    work = making.steps(named(wanted, paths), paths, page, tone)
    takes = {key for path in out for key in formats.knobs(path.suffix[1:].lower())}
    values = {key: value for key, value in wanted.with_paths(paths).files.items() if key in takes}
    planned = next(work).facts
    formats.foresee(out, page, int(planned.get("dots", 0)), values)
    if dry_run:
        work.close()
        if wanted.plot["purpose"] == "plotter":
            dots = int(planned.get("dots", 0))
            planned = {**planned, "plot": plotting.expected(dots, making.inked(tone), **making.plotter(wanted))}
        return _foretold(planned, tone, page)
    sheet = styles.run(work) if quiet else _watched(work)
    warnings = [*said, *tone.notes, *sheet.report["warnings"]]
    facts = {**sheet.report, "paper_mm": list(sheet.size), "files": [str(path) for path in out], "warnings": warnings}
    told = _Report(facts, began)
    plan = list(zip(out, formats.writers(sheet, [(path, None) for path in out], values), strict=True))
    to_file = report is not None and str(report) != "-"
    if report and to_file:
        plan.append((report, lambda file: file.write(f"{told.text()}\n".encode())))
    formats.replace_files(plan)
    for warning in warnings:
        note(warning)
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
        plot = facts.get("plot")
        drawn = (
            f"{facts['marks']} marks, {art[0]:.4g} x {art[1]:.4g} mm on {page[0]:g} x {page[1]:g} mm, "
            f"ink {facts['ink_placed_mm2']:.0f} of {facts['ink_asked_mm2']:.0f} mm2, "
            f"{time.perf_counter() - self._began:.1f} s: {plain(', '.join(facts['files']))}"
        )
        if not plot:
            return drawn
        return (
            f"{drawn}\n{plot['strokes']} strokes, {plot['pen_down_mm'] / 1000:.1f} m drawn, {plot['pen_up_mm'] / 1000:.1f} m with "
            f"the pen up, {plot['lifts']} lifts: about {_long(plot['seconds'])} of plotting"
        )


def _long(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 120:
        return f"{seconds:g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


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


def _foretold(facts: Mapping[str, float], tone: Tone, page: tuple[float, float]) -> int:
    """What a style's first Step says of the work to come."""
    say(f"paper  {page[0]:g} x {page[1]:g} mm")
    say(f"art    {tone.size[0]:.4g} x {tone.size[1]:.4g} mm")
    say(f"ink    {tone.ink:.1f} mm2 asked")
    for name, value in facts.items():
        say(f"{name:<6} {value:g}" if name not in TIMES else f"{TIMES[name]:<6} about {_long(value)}")
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
