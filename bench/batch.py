"""What workers bring: a batch of 16 drawings by one Dask worker and by two, in seconds and in seconds of processors.

On a machine that does other work too, seconds tell of that; the time that the busier worker's processor took is what the batch
would take on two cores of its own, as long as workers, scheduler and who hands out have them to themselves. Both are printed.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster
from PIL import Image

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


def processor(process: int) -> float:
    """Seconds of processors that a process has taken."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def taken(workers: int, names: list[str], folder: Path) -> tuple[float, float, float]:
    """Seconds of a batch, of the busier worker's processor, and of that of all others; workers have drawn before."""
    arguments = ["--style", "stipple", "--dots", str(DOTS), "--paper", "a5", "--out", str(folder), "--quiet"]
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        batch = ["batch", *names, *arguments, "--scheduler", cluster.scheduler_address]
        assert main([*batch, "--seed", "1"]) == 0
        with Client(cluster, set_as_default=False) as client:
            processes = list(client.run(os.getpid).values())
        before, own, began = [processor(process) for process in processes], processor(os.getpid()), time.perf_counter()
        assert main([*batch, "--seed", "2"]) == 0
        seconds = time.perf_counter() - began
        theirs = [processor(process) - was for process, was in zip(processes, before, strict=True)]
        return seconds, max(theirs), sum(theirs) - max(theirs) + processor(os.getpid()) - own


def compared(times: int) -> None:
    """Prints the least of some turns, by one worker and by two."""
    with tempfile.TemporaryDirectory() as folder:
        names = pictures(Path(folder))
        least = {}
        for workers in (1, 2):
            turns = [taken(workers, names, Path(folder)) for _ in range(times)]
            least[workers] = min(turn[0] for turn in turns), min(turn[1] for turn in turns)
            print(f"{DRAWINGS} drawings of {DOTS} dots, {workers} worker{'s'[: workers - 1]}:", end=" ")
            print(", ".join(f"{a:.1f} s, {b:.1f} s of the busier worker, {c:.1f} s of all else" for a, b, c in turns))
        clock, processors = (one / two for one, two in zip(least[1], least[2], strict=True))
        print(f"two against one: {clock:.2f} times as fast, {processors:.2f} times by processors", end="; ")
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")


if __name__ == "__main__":
    compared(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
