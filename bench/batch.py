"""What workers bring: a batch of 16 drawings by one Dask worker and by two, in seconds, and in seconds as if the machine were ours alone.

On a machine that does other work too, seconds tell of that. What a batch would take with nothing beside it follows from the time
that processors spent: that of the busier worker, loops shared out over its threads, and no less than that of all there is to do,
workers, scheduler and who hands out, over all cores. Both are printed.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster
from PIL import Image

from crowquill import kernel
from crowquill.__main__ import main

DRAWINGS = 16
DOTS = 8000


def pictures(folder: Path) -> list[str]:
    """Pictures of 480 x 360 pixels, no two alike."""
    rows, columns = np.mgrid[:360, :480]
    names = []
    for k in range(DRAWINGS):
        names.append(str(folder / f"{k}.png"))
        Image.fromarray((255 * (0.6 + 0.35 * np.sin(columns / (30 + k)) * np.cos(rows / 40))).astype(np.uint8)).save(names[-1])
    return names


def spent(process: int | str) -> float:
    """Seconds of processors that a process has taken, or one of its threads, given as PROCESS/task/THREAD."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def living(process: int) -> float:
    """The same, of those of its threads that go on; those of loops end with them."""
    return sum(spent(f"{process}/task/{thread.name}") for thread in Path(f"/proc/{process}/task").iterdir())


def taken(workers: int, names: list[str], folder: Path) -> tuple[float, float]:
    """Seconds of a batch as they were, and as if alone; the workers have drawn before."""
    arguments = ["--style", "stipple", "--dots", str(DOTS), "--paper", "a5", "--out", str(folder), "--quiet"]
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0") as cluster:
        batch = ["batch", *names, *arguments, "--scheduler", cluster.scheduler_address]
        assert main([*batch, "--seed", "1"]) == 0
        with Client(cluster, set_as_default=False) as client:
            processes = list(client.run(os.getpid).values())
        everyone, began = [*processes, os.getpid()], time.perf_counter()
        before = {process: (spent(process), living(process)) for process in everyone}
        assert main([*batch, "--seed", "2"]) == 0
        seconds = time.perf_counter() - began
        all_, lasting = ({process: f(process) - before[process][k] for process in everyone} for k, f in enumerate((spent, living)))
    threads = max(1, kernel.CORES // workers)
    busier = max(lasting[process] + (all_[process] - lasting[process]) / threads for process in processes)
    return seconds, max(busier, sum(all_.values()) / kernel.CORES)


def compared(times: int) -> None:
    """Prints the least of some turns, by one worker and by two."""
    with tempfile.TemporaryDirectory() as folder:
        names = pictures(Path(folder))
        least = {}
        for workers in (1, 2):
            turns = [taken(workers, names, Path(folder)) for _ in range(times)]
            least[workers] = [min(kind) for kind in zip(*turns, strict=True)]
            told = ", ".join(f"{clock:.1f} s, alone {alone:.1f} s" for clock, alone in turns)
            print(f"{DRAWINGS} drawings of {DOTS} dots, {workers} worker{'s'[: workers - 1]}: {told}", flush=True)
        clock, alone = (one / two for one, two in zip(least[1], least[2], strict=True))
        print(f"two against one: {clock:.2f} times as fast, alone {alone:.2f}; load {os.getloadavg()[0]:.1f} on {kernel.CORES} cores")


if __name__ == "__main__":
    compared(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
