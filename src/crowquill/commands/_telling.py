"""How many drawings are told of: bars while they are made, a line for each that fails, and at the end a table and a report."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import re
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from crowquill import formats
from crowquill.batch import Job, Outcome
from crowquill.commands import line, note, plain, say, spelt

FACTS = ("marks", "ink_asked_mm2", "ink_placed_mm2")  # of a drawing's report
COLUMNS = ("drawing", "status", "files", "width_mm", "height_mm", *FACTS, "seconds", "warnings", "error")


class Told:
    """What became of drawings so far, a row each, and where it is said."""

    def __init__(self, jobs: Sequence[Job], report: Path | None, quiet: bool, spelling: Sequence[str]) -> None:
        self._rows: dict[str, dict[str, Any]] = {}
        self._jobs, self._report, self._quiet, self._spelling = jobs, report, quiet, list(spelling)
        self._bars, self._began = _Bars(), time.perf_counter()

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The rows so far, in the order of the jobs."""
        return [self._rows[job.name] for job in self._jobs if job.name in self._rows]

    def check(self, overwrite: bool, sources: Sequence[Path]) -> None:
        """Raises the error that writing the report would raise."""
        if self._report and str(self._report) != "-":
            if self._report.suffix.lower() not in (".csv", ".json"):
                raise ValueError(f"{self._report}: a report is a table or JSON; give a name that ends in .csv or .json")
            formats.check([self._report], overwrite=overwrite, sources=sources)

    @contextlib.contextmanager
    def live(self, tokens: Mapping[str, Job]) -> Iterator[Callable[[Any], None]]:
        """Bars on a terminal, moved by the messages that are handed to what it gives."""
        if self._quiet or not sys.stderr.isatty():
            yield lambda _: None
            return
        with self._bars.shown(tokens, len(self._jobs)):
            yield self._bars.hear

    def add(self, outcome: Outcome) -> None:
        """Keeps what became of a job; of one that failed it is said at once."""
        row = _row(outcome)
        if outcome.error is not None:
            said = spelt(line(_words(outcome.error)), self._spelling)
            row["error"] = said if said.startswith(outcome.job.name) else f"{outcome.job.name}: {said}"
            self.line(row["error"])
        self._rows[outcome.job.name] = row
        self._bars.end(outcome.job)

    def line(self, text: str) -> None:
        """A line on stderr, above the bars where there are any."""
        self._bars.write(f"crowquill: {line(text)}\n")

    def note(self, text: str) -> None:
        """A line on stderr that is of no drawing alone."""
        self._bars.write(f"crowquill: note: {plain(text)}\n")

    def end(self) -> int:
        """Writes the report, says what is to be said of all, and gives the exit code: 1 where a drawing is not made."""
        rows = self.rows
        counts = {status: sum(row["status"] == status for row in rows) for status in ("to do", "drawn", "kept", "failed")}
        told = {"drawings": rows, **counts, "seconds": round(time.perf_counter() - self._began, 3)}
        if self._report and str(self._report) != "-":
            text = _csv(rows) if self._report.suffix.lower() == ".csv" else f"{json.dumps(told, indent=2)}\n"
            formats.replace_files([(self._report, lambda file: file.write(text.encode("utf-8", "replace")))])
        for text, names in _alike(rows):
            note(f"{names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''}: {text}")
        if self._report and str(self._report) == "-":
            say(json.dumps(told, indent=2))
        elif not self._quiet:
            say(_table(rows))
            say(f"{', '.join(f'{n} {status}' for status, n in counts.items() if n)}, {told['seconds']:.1f} s")
        return int(counts["failed"] > 0 or len(rows) < len(self._jobs))


class _Bars:
    """A bar for all drawings and one for each under way. Messages come from threads of their own, late ones too."""

    def __init__(self) -> None:
        self._progress: Any = None
        self._guard, self._tokens, self._tasks = threading.Lock(), dict[str, Job](), dict[int, Any]()

    @contextlib.contextmanager
    def shown(self, tokens: Mapping[str, Job], count: int) -> Iterator[None]:
        """Shows them."""
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
            self._tokens = dict(tokens)
            self._all = progress.add_task("all", total=count)
            self._progress = progress
            try:
                yield
            finally:
                self._progress = None

    def hear(self, message: Any) -> None:
        """Moves the bar of a drawing, by its token, stage, and how much of how much is done."""
        token, stage, done, total = message
        with self._guard:
            job = self._tokens.get(token)
            if job is None or self._progress is None:
                return
            task = self._tasks.setdefault(id(job), None)
            if task is None:
                task = self._tasks[id(job)] = self._progress.add_task("")
            self._progress.update(task, description=f"{plain(Path(job.name).name)[-40:]} {stage}", completed=done, total=total)

    def end(self, job: Job) -> None:
        """Takes away the bar of a drawing, and moves that of all."""
        with self._guard:
            if self._progress is None:
                return
            self._tokens = {token: other for token, other in self._tokens.items() if other is not job}
            if (task := self._tasks.pop(id(job), None)) is not None:
                self._progress.remove_task(task)
            self._progress.advance(self._all)

    def write(self, text: str) -> None:
        """Writes to stderr, above the bars."""
        if self._progress is None:
            sys.stderr.write(text)
        else:
            self._progress.console.print(text, end="", markup=False, highlight=False, soft_wrap=True)


def _row(outcome: Outcome) -> dict[str, Any]:
    """What became of a job, as plain data."""
    report = outcome.report
    width, height = report.get("art_mm", (None, None))
    shared = {key: report.get(key) for key in FACTS}
    files = [str(path) for path in outcome.job.out] if outcome.status in ("drawn", "kept") else []
    about = {"drawing": outcome.job.name, "status": outcome.status, "files": files, **shared, "width_mm": width, "height_mm": height}
    more = {"seconds": report.get("seconds", {}).get("total"), "warnings": list(report.get("warnings", ())), "error": ""}
    return {key: (about | more)[key] for key in COLUMNS}


def _alike(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[str]]]:
    """Warnings with the drawings that they are of; of those that differ in numbers alone the first stands for all."""
    found: dict[str, tuple[str, list[str]]] = {}
    for row in rows:
        for text in row["warnings"]:
            found.setdefault(re.sub(r"\d+", "0", text), (text, []))[1].append(row["drawing"])
    return list(found.values())


def _words(error: Exception) -> Exception | str:
    """An error as it can be told to a person."""
    if isinstance(error, MemoryError):
        return "not enough memory; use a smaller picture or fewer dots"
    if isinstance(error, (ValueError, OSError)) or type(error).__module__.startswith("crowquill."):
        return error
    return f"failed ({type(error).__name__}: {error}); tell us, it should not"


def _csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """The rows as CSV; several files or warnings of one stand in one field, parted by semicolons."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        writer.writerow(["; ".join(value) if isinstance(value, list) else value for value in (row[key] for key in COLUMNS)])
    return file.getvalue()


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    """The rows as a table of text, as wide as the terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for name in ("drawing", "", "marks", "mm", "s"):
        table.add_column(name, justify="left" if name in ("drawing", "") else "right", overflow="fold")
    for row in rows:
        size = f"{row['width_mm']:.4g} x {row['height_mm']:.4g}" if row["width_mm"] is not None else ""
        seconds = None if row["seconds"] is None else f"{row['seconds']:.1f}"
        cells = [row["drawing"], row["status"], row["marks"], size, seconds]
        table.add_row(*(Text(plain("" if cell is None else str(cell))) for cell in cells))
    file = io.StringIO()
    Console(file=file, width=shutil.get_terminal_size((100, 24)).columns, color_system=None).print(table)
    return "\n".join(part.rstrip() for part in file.getvalue().splitlines())
