"""What all parts of the bench share: D, how work is timed, rows for the console, the file and the page, and pictures to work on."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from scipy.spatial import Delaunay

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
SITES = 100_000
LISTS = ("parts", "d", "rows", "missing")  # of a report
LIBRARIES = ("crowquill", "numpy", "scipy", "numba", "PythonCDT", "shapely", "pillow", "scikit-image", "vpype")


class Taken(NamedTuple):
    """Seconds of a call: least, mean and spread of its runs, and the processors' time of the least."""

    least: float
    mean: float
    spread: float
    cpu: float

    @classmethod
    def of(cls, walls: list[float], cpus: list[float]) -> Taken:
        """Of runs in order."""
        return cls(min(walls), float(np.mean(walls)), float(np.std(walls)), cpus[int(np.argmin(walls))])


def spent() -> float:
    """The processors' seconds of this process and of those it waited for."""
    return time.process_time() + sum(os.times()[2:4])


def seconds(work: Callable[[], Any], times: int = 5, warm: Callable[[], Any] | None = None) -> Taken:
    """What a call takes, warmed by one, or by another that compiles the same."""
    (warm or work)()
    walls, cpus = [], []
    for _ in range(times):
        began, used = time.perf_counter(), spent()
        work()
        walls.append(time.perf_counter() - began)
        cpus.append(spent() - used)
    return Taken.of(walls, cpus)


# a small program between: Linux would count what the bench itself holds to its child, and all children together
CHILD = """
import resource, subprocess, sys, time
began = time.perf_counter()
try:
    done = subprocess.run(sys.argv[2:], stdout=subprocess.DEVNULL, timeout=float(sys.argv[1]))
except subprocess.TimeoutExpired:
    sys.exit(f"ended after {sys.argv[1]} s")
took, used = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
print(took, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
sys.exit(done.returncode)
"""


class Run(NamedTuple):
    """What a command took: wall seconds, the processors' seconds, and the most memory it held in MB (its VmHWM)."""

    seconds: float
    cpu: float
    memory: float

    @property
    def taken(self) -> Taken:
        """As a row has it."""
        return Taken(self.seconds, self.seconds, 0.0, self.cpu)


def process(*command: str, cache: str | None = None, limit: float = 3600.0) -> Run:
    """Runs a command; cache: a folder, empty at first, for compiled code; limit: seconds after which it is ended.

    Raises ChildProcessError with the last line it said where it fails.
    """
    env = {**os.environ, **({"NUMBA_CACHE_DIR": cache} if cache else {})}
    child = [sys.executable, "-c", CHILD, str(limit), *command]
    done = subprocess.run(child, capture_output=True, text=True, env=env, check=False)
    if done.returncode:
        raise ChildProcessError(f"{Path(command[0]).name}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return Run(*map(float, done.stdout.split()))


def shaded(side: int) -> np.ndarray:
    """A picture of side x side pixels with every tone from .05 to .75 and no two rows alike."""
    return rows(side, 0, side)


def rows(side: int, first: int, last: int) -> np.ndarray:
    """Some rows of that picture."""
    y, x = np.arange(first, last)[:, None] / side, np.arange(side)[None, :] / side
    return 0.4 + 0.35 * np.sin(9 * x + 4 * y * y) * np.cos(7 * y)


def painted(side: int, file: Path) -> None:
    """Writes that picture as code values, a band at a time: a large one as numbers would take gigabytes."""
    bands = [np.uint8(255 * (1 - rows(side, first, min(first + 256, side)))) for first in range(0, side, 256)]
    Image.fromarray(np.concatenate(bands)).save(file, compress_level=1)


def release(name: str) -> str:
    """A library's version, or nothing where it is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def machine() -> dict[str, Any]:
    """What the figures are of: processor, system and versions."""
    info = Path("/proc/cpuinfo")
    names = [line.split(":")[1].strip() for line in info.read_text().splitlines() if "model name" in line] if info.exists() else []
    gigabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    node = shutil.which("node") and subprocess.run(["node", "--version"], capture_output=True, text=True, check=False).stdout.strip()
    versions = {**{name: release(name) for name in LIBRARIES}, "Node": node}
    return {
        "processor": names[0] if names else platform.processor() or platform.machine(),
        "cores": cores,
        "memory_gb": round(gigabytes, 1),
        "system": f"{platform.system()} {platform.release()}, Python {platform.python_version()}",
        "versions": {name: found for name, found in versions.items() if found},
        "when": datetime.now(UTC).isoformat(timespec="seconds"),
    }


@dataclass
class Report:
    """All rows and figures of one run, kept in a file as they come; the page is made of nothing else."""

    file: Path | None
    quick: bool = False
    data: dict[str, Any] = field(default_factory=lambda: {"machine": machine(), **{key: [] for key in LISTS}, "figures": {}})

    def begun(self) -> None:
        """Says on what machine and with which versions it runs."""
        here = self.data["machine"]
        print(f"{here['processor']}, {here['cores']} processors, {here['memory_gb']} GB; {here['system']}; {here['when']}")
        print(", ".join(f"{name} {number}" for name, number in here["versions"].items()), flush=True)

    @property
    def d(self) -> float:
        """D as it was last measured, in seconds."""
        return float(self.data["d"][-1]["seconds"])

    def part(self, title: str) -> None:
        """Begins a part of the run, with D and the load as they are now."""
        sites = np.random.default_rng(0).random((SITES, 2)) * 100
        taken, load = seconds(lambda: Delaunay(sites), 3), os.getloadavg()[0]
        self.data["parts"].append(title)
        self.data["d"].append({"part": title, "seconds": taken.least, "cpu": taken.cpu, "load": load})
        print(f"\n{title}: D is {taken.least:.3f} s, load {load:.1f}", flush=True)

    def row(
        self, what: str, taken: Taken, said: str = "", *, bar: float | None = None, got: float | None = None, unit: str = "D",
        least: bool = False,
    ) -> None:  # fmt: skip
        """A row: what was timed, and what else there is to say.

        bar   the limit that was set for it: a most, or a least, in units of D unless another is named
        got   what is held against the bar; the ratio to D unless it is given
        """
        got = float(taken.least / self.d if got is None else got)
        verdict = None if bar is None else bool(got >= bar if least else got <= bar)
        self.data["rows"].append({
            "part": self.data["parts"][-1], "what": what, "seconds": taken.least, "mean": taken.mean, "spread": taken.spread,
            "cpu": taken.cpu, "d": taken.least / self.d, "said": said, "bar": bar, "got": got, "unit": unit, "least": least, "met": verdict,
        })  # fmt: skip
        more = "; ".join(filter(None, [said, told(self.data["rows"][-1])]))
        times = f"{taken.least:8.3f} s  {taken.mean:8.3f} +- {taken.spread:.3f}  {taken.least / self.d:7.2f} D"
        print(f"{what:<66} {times}  {more}", flush=True)
        self.save()

    def line(self, what: str) -> None:
        """A line in the words of a part that has figures of its own."""
        self.data["rows"].append({"part": self.data["parts"][-1], "what": what})
        print(what, flush=True)
        self.save()

    def missing(self, what: str, why: str) -> None:
        """Says loudly what was not run."""
        self.data["missing"].append({"what": what, "why": why})
        print(f"NOT RUN: {what}: {why}", flush=True)
        self.save()

    def figure(self, name: str, data: Any) -> None:
        """What a plot is drawn from."""
        self.data["figures"][name] = data
        self.save()

    def save(self) -> None:
        """Keeps all there is so far."""
        if self.file:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            self.file.write_text(json.dumps(self.data, indent=1), encoding="utf-8")


def told(row: dict[str, Any]) -> str:
    """A row's bar in words, and whether it was met."""
    if row["bar"] is None:
        return ""
    word = "at least " if row["least"] else ""
    own = "" if row["unit"] == "D" else f"{row['got']:.2f} {row['unit']}; "
    return f"{own}bar {word}{row['bar']:g}{' D' if row['unit'] == 'D' else ''}, {'met' if row['met'] else 'MISSED'}"
