"""A Dask cluster of processes for tests, and tasks to be done by its workers or by processes of ours."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

HERE = Path(__file__).parent
PATIENCE = 240  # s, a guard against a hang


class Cluster:
    """A scheduler and its workers, each a process of one thread."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: list[subprocess.Popen[bytes]] = []
        found = folder / "scheduler.json"
        self._begin("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(found))
        self.address = waited_for(lambda: found.read_text().split('"address": "')[1].split('"')[0])

    def worker(self, **environment: str) -> subprocess.Popen[bytes]:
        """A worker more, without a nanny that would begin it again; it has joined when this returns."""
        from distributed import Client

        process = self._begin("worker", self.address, "--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder), **environment)
        with Client(self.address, timeout=PATIENCE, set_as_default=False) as client:  # type: ignore[no-untyped-call]
            client.wait_for_workers(sum(process.poll() is None for process in self.processes[1:]), timeout=PATIENCE)
        return process

    def _begin(self, what: str, *arguments: str, **environment: str) -> subprocess.Popen[bytes]:
        path = os.pathsep.join([*([environment.pop("FIRST")] if "FIRST" in environment else []), str(HERE)])
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments, "--no-dashboard"]
        with (self.folder / f"{what}-{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, env={**os.environ, "PYTHONPATH": path, **environment})
        self.processes.append(process)
        return process

    def end(self) -> None:
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@contextlib.contextmanager
def cluster(folder: Path, workers: int = 0, environments: Sequence[Mapping[str, str]] = ()) -> Iterator[Cluster]:
    """A cluster with so many workers, and one more for each environment."""
    made = Cluster(folder)
    try:
        for environment in [*[{}] * workers, *environments]:
            made.worker(**environment)
        yield made
    finally:
        made.end()


def waited_for(found):  # type: ignore[no-untyped-def]
    """What `found` gives, once it gives something."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        with contextlib.suppress(OSError, IndexError):
            if value := found():
                return value
        time.sleep(0.02)
    raise AssertionError("waited in vain")


def fallen(path: Path) -> int:
    """Kills the process that runs this the first time; the second it gives its number."""
    if not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def fallen_always(path: Path) -> None:
    """Kills the process that runs this, and counts how often."""
    with path.open("a") as file:
        file.write("x")
    os.kill(os.getpid(), signal.SIGKILL)


class OddError(Exception):
    """An exception that pickle cannot bring back."""

    def __init__(self, one: str, other: str) -> None:
        super().__init__(f"{one} and {other}")


def odd() -> None:
    raise OddError("this", "that")


def told(n: int) -> int:
    from crowquill.cluster import tell

    for k in range(n):
        tell(["step", k])
    return n


def asleep(path: Path) -> None:
    """Says its process in a file, then tells something a hundred times a second, for a minute."""
    from crowquill.cluster import tell

    beside = path.with_suffix(".new")
    beside.write_text(str(os.getpid()))
    beside.rename(path)
    try:
        for _ in range(6000):
            time.sleep(0.01)
            tell("asleep")
    finally:
        path.unlink()


def threads() -> int:
    """How many threads loops take here."""
    from crowquill import kernel

    return kernel.CORES
