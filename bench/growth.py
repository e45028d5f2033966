"""How time and memory grow with dots and with pixels, for a whole drawing and for one iteration; stages, threads, a million dots."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common import HERE, Report, Taken, painted, process

PROGRAM = str(Path(sys.executable).parent / "crowquill")
DOTS = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)  # on 1 Mpx
SIDES = (500, 1000, 2000, 4000, 8000)  # pixels, squared .25 to 64 Mpx, with MIDDLE dots
MIDDLE, MANY = 100_000, 1_000_000
FEW = 10_000  # dots, from which on a dot is to cost about the same


def drawn(folder: Path, side: int, dots: int, **more: Any) -> dict[str, Any]:
    """What drawing.py finds of one drawing of a shaded picture, to a compact PDF, or of what is asked else.

    Raises ChildProcessError where it fails.
    """
    picture = folder / f"{side}.png"
    if not picture.exists():
        painted(side, picture)
    wanted = {"picture": str(picture), "out": str(folder / "out.pdf"), "dots": dots, **more}
    done = subprocess.run([sys.executable, str(HERE / "drawing.py"), json.dumps(wanted)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise ChildProcessError((done.stderr.strip().splitlines() or ["failed"])[-1])
    return {"side": side, "dots": dots, **json.loads(done.stdout)}


def growth(report: Report, most: int = 64) -> None:
    """Whole drawings and iterations over dots on 1 Mpx, and over pixels up to `most` Mpx."""
    dots = (1_000, 10_000, 100_000) if report.quick else DOTS
    sides = (500, 1000, 2000) if report.quick else [side for side in SIDES if side * side <= most * 1e6]
    sides = [*sides, *([round(np.sqrt(most * 1e6))] if most > 64 else [])]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        middle = FEW if report.quick else MIDDLE
        for axis, pairs in (("dots", [(1000, n) for n in dots]), ("pixels", [(side, middle) for side in sides])):
            points = []
            for side, n in pairs:
                point = drawn(folder, side, n, repeats=2 if n > MIDDLE else 5)
                points.append(point)
                where = f"{n} dots, {side * side / 1e6:g} Mpx"
                said = f"{point['iterations']} iterations, {1e6 * point['seconds'] / n:.0f} us a dot, {point['memory']:.0f} MB"
                report.row(f"whole drawing, {where}", once(point["seconds"], point["cpu"]), said)
                report.row(
                    f"one iteration, {where}", once(point["iteration"], point["iteration_cpu"]), f"{point['iteration_memory']:.0f} MB"
                )
            report.figure(axis, points)
            for missing in points[0]["missing"]:
                report.missing(f"the stage of {missing}", "there is no function of that name any more; its time is in another stage")
            if axis == "dots":
                a_dot(report, points)


def a_dot(report: Report, points: list[dict[str, Any]]) -> None:
    """What a dot costs among the most, over what it costs among ten thousand."""
    few, many = next(point for point in points if point["dots"] == FEW), points[-1]
    for what, key, cpu in (("whole drawing", "seconds", "cpu"), ("iteration", "iteration", "iteration_cpu")):
        ratio = (many[key] / many["dots"]) / (few[key] / few["dots"])
        per = once(many[key], many[cpu])
        bar = 1.5 if many["dots"] == MANY else None
        report.row(f"time a dot of one {what}, {many['dots']} dots over {FEW}", per, "" if bar else f"{ratio:.2f} times",
                   bar=bar, got=ratio, unit="times")  # fmt: skip


def once(seconds: float, cpu: float) -> Taken:
    return Taken(seconds, seconds, 0.0, cpu)


def threads(report: Report) -> None:
    """One iteration on one processor and on two, in processes that may use no more."""
    n = MIDDLE if report.quick else MANY
    with tempfile.TemporaryDirectory() as name:
        try:
            taken = {k: drawn(Path(name), 1000, n, processors=k, out=None, repeats=3) for k in (1, 2)}
        except ChildProcessError as error:
            report.missing("one thread against two", str(error))
            return
    for k, point in taken.items():
        report.row(f"one iteration, {n} dots, 1 Mpx, {k} thread{'s' * (k > 1)}", once(point["iteration"], point["iteration_cpu"]))
    ratio = taken[1]["iteration"] / taken[2]["iteration"]
    least = once(taken[2]["iteration"], taken[2]["iteration_cpu"])
    report.row("two threads against one", least, bar=1.6, got=ratio, unit="times as fast", least=True)
    report.figure("threads", {str(k): point["iteration"] for k, point in taken.items()} | {"dots": n})


def million(report: Report) -> None:
    """A million dots on 16 Mpx by the command line, from picture to compact PDF."""
    n, side = (100_000, 2000) if report.quick else (MANY, 4000)
    with tempfile.TemporaryDirectory() as name:
        picture, out = Path(name, "shaded.png"), Path(name, "out.pdf")
        painted(side, picture)
        run = process(PROGRAM, "stipple", str(picture), str(out), "--compact", "--dots", str(n), "--tone", "grey", "--quiet")
        size = out.stat().st_size
    what = f"{n} dots on {side * side / 1e6:g} Mpx, picture to compact PDF"
    report.row(what, run.taken, f"{size / n:.1f} bytes a dot", bar=None if report.quick else 40)
    report.row(f"{what}: memory", run.taken, bar=4096, got=run.memory, unit="MB")
