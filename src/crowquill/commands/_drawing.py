"""Drawing on the command line: from a recipe and its sources to files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

from crowquill import expense, making, options, plotting, styles
from crowquill.commands import say
from crowquill.commands._running import Run, long, silence
from crowquill.recipe import PICTURE, Recipe, files_of
from crowquill.tone import Tone

TIMES = {"seconds": "time", "plot": "plot"}  # of the facts of a plan, and what they are called


def command(style: str) -> Callable[..., int]:
    """The command of a style, for Typer to read."""
    return options.drawing(style, _drawn)


def _drawn(wanted: Recipe, *, picture: Path, recipe: Path | None, typed: Set[str], **running: Any) -> int:
    """One drawing from picture to files; `typed` are the options given by hand."""
    run, said = Run(**running), []
    sources = making.read(recipe)[0].sources if recipe else {}
    if PICTURE in sources and sources[PICTURE].name != picture.name:
        said = [f"{recipe} was made for {sources[PICTURE].name}; its settings are used for {picture.name}"]
    paths = {PICTURE: picture, **{key: Path(value) for key, value in files_of(wanted).items()}}
    wanted = suited(wanted, typed, run)
    run.check(list(paths.values()), {})
    return draw(wanted, paths, run, said=said, named=making.named)


def suited(wanted: Recipe, typed: Set[str], run: Run) -> Recipe:
    """The recipe as it suits the files to be written; `typed` are the options given by hand.

    Raises ValueError where they do not go together.
    """
    plotter = wanted.plot["purpose"] == "plotter"
    if not plotter and (idle := sorted(typed & set(wanted.plot))):
        raise ValueError(f"--{idle[0].replace('_', '-')} is for plotters; add --for plotter")
    asked = {key: value for key, value in wanted.files.items() if key in typed}
    run.suit(asked, strokes="" if plotter else "takes strokes only; add --for plotter")
    return replace(wanted, knobs=styles.suited(wanted.style, wanted.knobs, run.shown(wanted.files)))


def draw(
    wanted: Recipe,
    paths: Mapping[str, Path],
    run: Run,
    *,
    said: list[str],
    named: Callable[[Recipe, Mapping[str, Path]], Recipe] = lambda wanted, _: wanted,
) -> int:
    """The files that a recipe and its sources give; `named` makes of them what the files keep, once they have been read.

    said  notes for the end: a refusal is one line
    """
    with silence():
        page, tone, over = making.laid_out(wanted, paths)
    work = making.steps(named(wanted, paths), paths, page, tone, over)
    files = wanted.with_paths(paths).files
    planned = next(work).facts
    run.foresee(page, int(planned.get("dots", 0)), files)
    if run.dry_run:
        work.close()
        if wanted.plot["purpose"] == "plotter":
            dots = int(planned.get("dots", 0))
            planned = {**planned, "plot": plotting.expected(dots, making.inked(tone), **making.plotter(wanted))}
        return _foretold(planned, tone, page)
    return run.write(run.done(work), files, list(paths.values()), [*said, *tone.notes])


def _foretold(facts: Mapping[str, float], tone: Tone, page: tuple[float, float]) -> int:
    """What a style's first Step says of the work to come."""
    say(f"paper  {page[0]:g} x {page[1]:g} mm")
    say(f"art    {tone.size[0]:.4g} x {tone.size[1]:.4g} mm")
    say(f"ink    {tone.ink:.1f} mm2 asked")
    for name, value in facts.items():
        if name == "bytes":
            say(f"memory about {expense.said(expense.held() + value)}")
        else:
            say(f"{name:<6} {value:g}" if name not in TIMES else f"{TIMES[name]:<6} about {long(value)}")
    return 0
