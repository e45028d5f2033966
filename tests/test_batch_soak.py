"""Many drawings for long: five hundred of which some are bad, and kills at any moment."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import clusters
import numpy as np
import pytest
from PIL import Image
from test_batch import ALONE, SETTINGS, held
from test_service_example import held as memory_of

from crowquill.__main__ import main
from crowquill.batch import JOURNAL

pytestmark = pytest.mark.soak

COMMAND = (sys.executable, "-m", "crowquill", "batch", "--out", "out", *SETTINGS, "--quiet")
KILLS = 12


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for drawings in one which is where we are."""
    monkeypatch.chdir(tmp_path)
    Path("out").mkdir()
    return tmp_path


def pictures(count: int, bad: int = 0) -> list[str]:
    """Names of pictures no two of which are alike; every so often one is broken, each in its own way."""
    every = count // bad if bad else count + 1
    names = []
    for k in range(count):
        names.append(f"p{k:03}.png")
        rows, columns = np.mgrid[:60, : 60 + k % 40]
        Image.fromarray((255 * (0.6 + 0.35 * np.sin(columns / (5 + k % 17)) * np.cos(rows / 9 + k))).astype(np.uint8)).save(names[-1])
        if k % every == every - 1:
            whole = Path(names[-1]).read_bytes()
            Path(names[-1]).write_bytes((b"", b"no picture", whole[: len(whole) // 3], whole[:20], b"\0" * 500)[k // every % 5])
    return names


def made() -> int:
    return Path("out", JOURNAL).read_bytes().count(b"\n") if Path("out", JOURNAL).exists() else 0


def everyone(process: int) -> list[int]:
    """A process and those it began."""
    return [process, *(int(word) for task in Path(f"/proc/{process}/task").iterdir() for word in (task / "children").read_text().split())]


def test_of_five_hundred_the_good_are_drawn_the_bad_are_said_and_memory_stays_flat():
    names = pictures(500, 25)
    most: dict[str, list[int]] = {"from the 50th": [], "at the last": []}
    with subprocess.Popen([*COMMAND, *names, "--workers", "2"], stderr=subprocess.PIPE, text=True) as run:
        while run.poll() is None and (done := made()) < 475:
            if when := "from the 50th" if 50 <= done < 80 else "at the last" if done >= 445 else "":
                sizes = [memory_of(process) for process in everyone(run.pid)]
                most[when] = [max(pair) for pair in zip(sizes, most[when] or sizes, strict=True)]
            time.sleep(0.02)
        said = run.communicate(timeout=clusters.PATIENCE)[1].splitlines()
    said = [line for line in said if not line.startswith("crowquill: note: ")]  # of tones out of reach
    print({when: [f"{size // 1000} MB" for size in sizes] for when, sizes in most.items()})
    assert run.returncode == 1
    assert len(said) == 25, "\n".join(said)
    assert {line.split()[1] for line in said} == {f"{name}:" for name in names[19::20]}
    assert len(held("out")) == 475
    for first, last in zip(*most.values(), strict=True):  # that of who hands out, and of each worker
        assert last < 1.05 * first
    for name in random.Random(3).sample([name for name in names if f"{name}:" not in " ".join(said)], 5):
        assert main(["stipple", name, "one.svg", *ALONE, "--quiet"]) == 0
        assert Path("one.svg").read_bytes() == Path("out", name).with_suffix(".svg").read_bytes()


@pytest.mark.parametrize("here", [True, False])
def test_kills_of_workers_and_of_the_command_at_any_moment_make_every_drawing_once(desk, here):
    names = pictures(60)
    Path("alone").mkdir()
    for name in names:
        assert main(["stipple", name, f"alone/{name[:-4]}.svg", *ALONE, "--quiet"]) == 0
    chance = random.Random(5)
    with clusters.cluster(desk, 0 if here else 2) as dask:
        where = ["--workers", "2"] if here else ["--scheduler", dask.address]
        kept: dict[str, int] = {}
        for kill in range(KILLS):
            before = len(kept)
            with subprocess.Popen([*COMMAND, *names, *where]) as run:
                clusters.waited_for(lambda run=run, before=before: made() > before or run.poll() is not None)
                time.sleep(chance.uniform(0, 0.5))
                if run.poll() is not None:
                    break
                if kill % 2 and here:  # a worker, then the command
                    os.kill(everyone(run.pid)[-1], signal.SIGKILL)
                    time.sleep(chance.uniform(0, 0.5))
                elif kill == 3:
                    dask.processes[1].kill()
                    dask.processes[1].wait()
                    dask.worker()
                run.kill()
            for name, when in kept.items():
                assert Path("out", name).stat().st_mtime_ns == when, f"{name} was made again"
            journal = Path("out", JOURNAL).read_text().splitlines()
            kept = {name: Path("out", name).stat().st_mtime_ns for line in journal for name in json.loads(line)["files"]}
        assert subprocess.run([*COMMAND, *names, *where], check=False, timeout=clusters.PATIENCE).returncode == 0
    journal = [name for line in Path("out", JOURNAL).read_text().splitlines() for name in json.loads(line)["files"]]
    assert len(journal) == len(set(journal)) == 60
    assert held("out") == held("alone")
    print(f"{kill + 1} kills, {len(kept)} drawings were there before the last turn")
