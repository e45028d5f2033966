"""What drawing costs, beside other programs: python bench/bench.py [quick] [--only PART,PART] [--pixels MPX] [--out FOLDER].

All is told in D, the time of scipy.spatial.Delaunay on 100 000 uniform random sites in the same run: machines differ and so
do their hours; the ratio travels. Everything is seeded, what is timed is named, nothing is asserted. Rows go to the console, to
bench/out/rows.json and to a copy named for the time, and to bench/out/report.html, one page of plots. `quick` takes under three minutes.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import growth
import kernels
import page
import peers
import solvers
import whole
from common import HERE, OUT, Report


def placed(report: Report) -> None:
    """Solvers, and other programs against them."""
    ways = solvers.traces(report, (20_000,) if report.quick else (20_000, 50_000, 100_000))
    report.part("peers")
    peers.compared(report, ways)


def falling(report: Report) -> None:
    """Steps early and late, and the way to the energy of plain iterations."""
    n = 20_000 if report.quick else 100_000
    solvers.early_and_late(report, n)
    solvers.downhill(report, n)


def grown(report: Report, most: int) -> None:
    """Dots, pixels, threads, and a million dots."""
    growth.growth(report, most)
    growth.threads(report)
    growth.million(report)


def edited(report: Report) -> None:
    """The editor's own programs, whose lines are kept as they come."""
    for name in ("editor.py", "editor_page.py"):
        with tempfile.TemporaryFile("w+") as wrong:
            with subprocess.Popen([sys.executable, "-u", str(HERE / name)], stdout=subprocess.PIPE, stderr=wrong, text=True) as run:
                for line in run.stdout or []:
                    report.line(line.rstrip())
            wrong.seek(0)
            if run.returncode:
                report.missing(name, (wrong.read().strip().splitlines() or ["failed"])[-1])


def parts(quick: bool, most: int) -> dict[str, list[Callable[[Report], None]]]:
    """The parts of a run, by name, in order."""
    kernel = [kernels.exact, kernels.started, kernels.halftoned, kernels.settled, partial(kernels.routed, quick=quick)]
    styles = [whole.stippled, whole.structured]
    long = [whole.mosaics, whole.aligned, whole.exampled, kernels.judged]
    found = {
        "kernels": kernel,
        "solvers": [placed],
        "steps": [falling],
        "growth": [partial(grown, most=most)],
        "styles": styles if quick else [*styles, *long],
        "plates": [whole.plates],
        "editor": [edited],
    }
    return {name: works for name, works in found.items() if not quick or name not in ("plates", "editor")}


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("quick", nargs="?", choices=("quick",), help="fewer and smaller, in under three minutes")
    asked.add_argument("--only", default="", help="parts to run, by comma: " + ", ".join(parts(False, 64)))
    asked.add_argument("--pixels", type=int, default=64, help="the largest picture of the growth, in Mpx (64)")
    asked.add_argument("--out", type=Path, default=OUT, help="the folder for rows.json and report.html")
    given = asked.parse_args()
    every = parts(bool(given.quick), given.pixels)
    chosen = list(filter(None, given.only.split(","))) or list(every)
    if unknown := [name for name in chosen if name not in every]:
        asked.error(f"no part {', '.join(unknown)}; there are {', '.join(every)}")
    report = Report(given.out / "rows.json", quick=bool(given.quick))
    report.begun()
    began = time.perf_counter()
    for name in chosen:
        report.part(name)
        for work in every[name]:
            try:
                work(report)
            except (ChildProcessError, OSError, ValueError, subprocess.SubprocessError) as error:
                report.missing(f"a part of {name}", f"{type(error).__name__}: {error}")
    report.data["seconds"] = time.perf_counter() - began
    report.save()
    when = report.data["machine"]["when"].replace(":", "").split("+")[0]
    shutil.copy(given.out / "rows.json", given.out / f"rows-{when}.json")
    page.written(report.data, given.out / "report.html")
    print(f"\n{given.out / 'report.html'}: {report.data['seconds'] / 60:.1f} minutes", flush=True)


if __name__ == "__main__":
    main()
