"""How all that draws is run: what is checked before the work, its progress, what is written and said at the end."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Collection, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from crowquill import formats, styles
from crowquill.commands import note, plain, say
from crowquill.formats import _plates
from crowquill.sheet import Sheet, Shown, Step

Found = TypeVar("Found")


@dataclass(frozen=True)
class Run:
    """The options of the running, as options.running and options.drawing hand them on."""

    out: list[Path]
    report: Path | None
    quiet: bool
    overwrite: bool
    dry_run: bool
    plates: Path | None
    plates_as: str | None
    began: float = field(default_factory=time.perf_counter)

    @property
    def kind(self) -> str:
        """The format of the plates."""
        return self.plates_as or "pdf"

    @property
    def sets_text(self) -> bool:
        """Whether a PDF is written, which takes words from their fonts; other formats draw outlines."""
        return any(path.suffix.lower() == ".pdf" for path in self.out) or bool(self.plates and self.kind == "pdf")

    def modules(self) -> list[Any]:
        """The formats written, one a file."""
        return [formats.module(path.suffix[1:].lower(), str(path)) for path in self.out]

    def shown(self, files: Mapping[str, Any]) -> list[Shown]:
        """How each file, and the plates, will show what is drawn, by knobs of formats."""
        plates = [Shown(str(self.plates), pixels=False, grey=False)] if self.plates else []
        return [formats.shown(path, files) for path in self.out] + plates

    def check(self, sources: Sequence[Path], asked: Mapping[str, Any], *, strokes: str = "") -> None:
        """Raises the error that writing would raise, before any work is done; asked and strokes are those of suit()."""
        self.suit(asked, strokes=strokes)
        if self.plates:
            if not self.plates.is_dir():
                why = "is no folder; give one" if self.plates.exists() else "there is no such folder; make it first"
                raise ValueError(f"{self.plates}: {why}")
            formats.check([self.plates / "plates.pdf"])  # may be written to; what they are called is known once the inks are
        reports = [self.report] if self.report and str(self.report) != "-" else []
        formats.check([*self.out, *reports], overwrite=self.overwrite, sources=sources)

    def suit(self, asked: Mapping[str, Any], *, strokes: str = "") -> None:
        """Raises the error of formats that are none, or do not take what is asked of them, wherever they are to be.

        asked    knobs of formats that were asked for by hand
        strokes  what is to be said of a file that takes strokes only, where the sheet will have more
        """
        if self.plates_as is not None and self.plates is None:
            raise ValueError("--plates-as is for plates; add --plates DIR")
        modules = self.modules()
        told = [*self.out, *(_plates.targets(self.kind) if self.plates else [])]
        formats.writers(Sheet((1, 1)), [(path, None) for path in told], {key: value for key, value in asked.items() if key != "embed"})
        for path, module in zip(self.out, modules, strict=True):
            if strokes and getattr(module, "STROKES", False):
                raise ValueError(f"{path}: {strokes}")
        if asked.get("embed") and not any(hasattr(module, "KEEPS_FILES") for module in modules):
            raise ValueError(f"{self.out[0]}: keeps no picture inside; leave out --embed, or write an SVG or a PDF too")

    def foresee(self, size: tuple[float, float], marks: int, files: Mapping[str, Any]) -> None:
        """Raises the error that writing a sheet of this size and number of marks would raise, where that is known before."""
        formats.foresee(self.out, size, marks, self._taken(files))
        if self.plates:
            _plates.foresee(size, kind=self.kind, values=files)

    def done(self, work: styles.Work) -> Sheet:
        """The sheet of work run to its end, with a progress bar on a terminal."""
        return styles.run(work) if self.quiet else watched(work)

    def write(self, sheet: Sheet, files: Mapping[str, Any], sources: Sequence[Path], said: Collection[str] = ()) -> int:
        """Writes all files of a sheet, or none, and says what came of it.

        files  knobs of formats by a recipe's table; said are notes beside the sheet's own
        """
        plan = list(zip(self.out, formats.writers(sheet, [(path, None) for path in self.out], self._taken(files)), strict=True))
        if self.plates:
            every = _plates.plan(sheet, self.plates, self.out[0].stem, kind=self.kind, values=files)
            formats.check([*self.out, *(path for path, _ in every)], overwrite=self.overwrite, sources=sources)
            plan += every
        warnings = [*said, *sheet.report["warnings"], *styles.remarks(sheet.report, self.shown(files))]
        facts = {**sheet.report, "paper_mm": list(sheet.size), "files": [str(path) for path, _ in plan], "warnings": warnings}
        told = _Report(facts, self.began)
        to_file = self.report is not None and str(self.report) != "-"
        if self.report and to_file:
            plan.append((self.report, lambda file: file.write(f"{told.text()}\n".encode())))
        formats.replace_files(plan)
        for warning in warnings:
            note(warning)
        if self.report and not to_file:
            say(told.text())
        elif not self.quiet:
            say(told.summary())
        return 0

    def _taken(self, files: Mapping[str, Any]) -> dict[str, Any]:
        """Those knobs that a format written takes."""
        takes = {key for path in self.out for key in formats.knobs(path.suffix[1:].lower())}
        return {key: value for key, value in files.items() if key in takes}


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
        asked = facts["ink_asked_mm2"]
        ink = f"ink {facts['ink_placed_mm2']:.0f} of {asked:.0f} mm2, " if asked else ""  # none is asked of ready drawings
        drawn = (
            f"{facts['marks']} marks, {art[0]:.4g} x {art[1]:.4g} mm on {page[0]:g} x {page[1]:g} mm, "
            f"{ink}{time.perf_counter() - self._began:.1f} s: {plain(', '.join(facts['files']))}"
        )
        if not plot:
            return drawn
        return (
            f"{drawn}\n{plot['strokes']} strokes, {plot['pen_down_mm'] / 1000:.1f} m drawn, {plot['pen_up_mm'] / 1000:.1f} m with "
            f"the pen up, {plot['lifts']} lifts: about {long(plot['seconds'])} of plotting"
        )


def long(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 120:
        return f"{seconds:g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


@contextlib.contextmanager
def silence() -> Iterator[None]:
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


def watched(work: Generator[Step, None, Found]) -> Found:
    """What work comes to, with a progress bar on a terminal."""
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
