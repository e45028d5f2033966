"""What takes minutes: kills and faults at every moment, many drawings in a row, and the same bytes whatever the surroundings."""

from __future__ import annotations

import builtins
import errno
import gc
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from crowquill.__main__ import main

pytestmark = pytest.mark.soak

KILLS = 200
DRAWINGS = 60
OPEN = open  # as it is before it is made to fail
PATIENCE = 120  # s, a guard against a hang
QUICK = ("--paper", "60x50mm", "--margin", "5mm", "--tone", "grey", "--pen", "0.5mm", "--iterations", "2")
# draws over the same files again and again, in two seeds by turns, and says so when the first drawing is done
AGAIN = """
import itertools, sys
from crowquill.__main__ import main
for seed in itertools.count():
    code = main([*sys.argv[1:], "--seed", str(seed % 2)])
    if code or not seed:
        print(code, flush=True)
"""


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a picture, which is where we are."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(80, 255, 80).astype(np.uint8), (60, 1))).save("ramp.png")
    return tmp_path


def drawn(*arguments: str, files: tuple[str, ...]) -> tuple[bytes, ...]:
    """The bytes of files drawn in this process."""
    assert main(["stipple", "ramp.png", *files, *QUICK, "--quiet", *arguments]) == 0
    return tuple(Path(name).read_bytes() for name in files)


def test_two_hundred_kills_leave_no_half_file(desk):
    files = ("a.svg", "b.pdf", "c.svg", "d.pdf", "e.svg", "f.pdf")  # so many that a third of the time goes into writing
    whole = [set(pair) for pair in zip(drawn("--seed", "0", files=files), drawn("--seed", "1", files=files), strict=True)]
    chance, litter, littered = random.Random(7), set[str](), 0
    for kill in range(KILLS):
        arguments = [sys.executable, "-c", AGAIN, "stipple", "ramp.png", *files, *QUICK, "--quiet"]
        with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as run:
            assert run.stdout is not None and run.stdout.readline() == "0\n"
            stale = litter & {path.name for path in desk.iterdir()}
            assert not stale, f"a run left the litter of one that was killed: {stale}"
            time.sleep(chance.uniform(0, 1))  # two drawings or so
            run.send_signal(signal.SIGKILL)
        for name, good in zip(files, whole, strict=True):
            assert Path(name).read_bytes() in good, f"{name} is half written after kill {kill}"
        litter = {path.name for path in desk.iterdir()} - {"ramp.png", *files}
        littered += bool(litter)
    assert littered, "no kill fell into the writing of a file; the test has missed its moment"
    drawn(files=files)
    assert {path.name for path in desk.iterdir()} == {"ramp.png", *files}


class Faulty:
    """A file whose write fails."""

    def __init__(self, file: Any, error: OSError) -> None:
        self.file, self.error = file, error

    def __enter__(self) -> Faulty:
        self.file.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.file.__exit__(*error)

    def write(self, data: bytes) -> int:
        self.file.write(data[: len(data) // 2])  # some of it arrives
        raise self.error

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


def failing(call: Callable[..., Any], at: int, error: OSError, *, writes: bool = False) -> Callable[..., Any]:
    """The same call, but that its `at`-th use raises, or gives a file that cannot be written; reading a file is no use."""
    uses = iter(range(1, 1_000_000))

    def called(*arguments: Any, **options: Any) -> Any:
        if call is OPEN and arguments[1:2] != ("xb",):
            return call(*arguments, **options)
        broken = next(uses) == at
        if broken and not writes:  # the system's own error has the first path that was given
            raise OSError(error.errno, error.strerror, *[str(path) for path in arguments[:1] if isinstance(path, (str, Path))])
        found = call(*arguments, **options)
        return Faulty(found, error) if broken else found

    return called


CALLS = {
    "make": (builtins, "open"),
    "write": (builtins, "open"),
    "sync": (os, "fsync"),
    "mode": (Path, "chmod"),
    "rename": (os, "replace"),
}
FAULTS = [errno.ENOSPC, errno.EIO, errno.EACCES, errno.EMFILE, errno.EROFS, errno.EDQUOT]
FILES = ("out.svg", "out.pdf", "report.json")


@pytest.mark.parametrize("fault", FAULTS, ids=[errno.errorcode[fault] for fault in FAULTS])
@pytest.mark.parametrize("at", [1, 2, 3])
@pytest.mark.parametrize("kind", CALLS)
def test_a_fault_at_any_file_leaves_every_file_older_or_whole(desk, monkeypatch, capsys, kind, at, fault):
    arguments = ["stipple", "ramp.png", "out.svg", "out.pdf", *QUICK, "--report", "report.json"]
    older = {name: f"older {name}".encode() for name in FILES}
    for name, data in older.items():
        Path(name).write_bytes(data)
    owner, name = CALLS[kind]
    with monkeypatch.context() as patched:
        patched.setattr(owner, name, failing(getattr(owner, name), at, OSError(fault, os.strerror(fault)), writes=kind == "write"))
        code = main(arguments)
    line = capsys.readouterr().err
    assert code == 2 and line.startswith(f"crowquill: {FILES[at - 1]}: ") and line.count("\n") == 1 and "; " in line
    found = {path.name: path.read_bytes() for path in desk.iterdir() if path.name != "ramp.png"}
    assert set(found) == set(FILES), "litter"
    renamed = FILES[: at - 1] if kind == "rename" else ()  # what was whole and in its place stays there
    assert {name: data for name, data in found.items() if name not in renamed} == {
        name: data for name, data in older.items() if name not in renamed
    }
    if renamed:
        assert found["out.svg"] == drawn(files=("out.svg",))[0]


def test_a_limit_on_the_size_of_files_leaves_the_older_one(desk, capsys):
    """A fault of the system's own: the kernel stops the write in the middle."""
    Path("out.svg").write_bytes(b"older")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        code = main(["stipple", "ramp.png", "out.svg", *QUICK])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    line = capsys.readouterr().err
    assert code == 2 and line.startswith("crowquill: out.svg: ") and line.count("\n") == 1
    assert {path.name for path in desk.iterdir()} == {"ramp.png", "out.svg"} and Path("out.svg").read_bytes() == b"older"


def resident() -> int:
    """Bytes of memory this process holds now."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize()


def test_sixty_drawings_in_a_row_take_no_more_memory_than_twenty(capsys):
    held = []
    for number in range(DRAWINGS):
        bad = number % 12 == 11  # some are refused half way
        code = main(["stipple", "ramp.png", f"{number}.svg", f"{number}.pdf", *QUICK, "--seed", str(number), *["--pen", "45mm"] * bad])
        assert code == (2 if bad else 0)
        capsys.readouterr()
        held.append(resident())
    assert len(list(Path().glob("*.svg"))) == DRAWINGS - DRAWINGS // 12
    # a drawing's own tables are 2 MB and more; forty of them kept would be 80 MB
    assert held[-1] - held[19] < 12e6, [round(size / 1e6) for size in held]


def surroundings(desk: Path) -> dict[str, dict[str, Any]]:
    """Environments, and other things about a process, that a drawing must not show."""
    (desk / "home").mkdir()
    return {
        "as we are": {},
        "another hash seed": {"PYTHONHASHSEED": "1"},
        "and another": {"PYTHONHASHSEED": "4242"},
        "far east": {"TZ": "Asia/Tokyo"},
        "far west": {"TZ": "America/Los_Angeles"},
        "no locale": {"LC_ALL": "C", "LANG": "C"},
        "a locale with a decimal comma, where there is one": {"LC_ALL": "de_DE.UTF-8", "LC_NUMERIC": "de_DE.UTF-8"},
        "Latin letters": {"PYTHONUTF8": "0", "PYTHONIOENCODING": "latin-1"},
        "another home": {"HOME": str(desk / "home"), "USER": "somebody", "LOGNAME": "somebody"},
        "code compiled anew": {"NUMBA_CACHE_DIR": str(desk / "cache")},
        "a library's threads": {"OMP_NUM_THREADS": "3", "OPENBLAS_NUM_THREADS": "3", "NUMBA_NUM_THREADS": "2"},
        "a wide terminal": {"COLUMNS": "400", "FORCE_COLOR": "1", "TERM": "xterm-256color"},
    }


def test_the_same_bytes_whatever_the_surroundings(desk):
    """20 000 dots: so many are shared out over the cores there are."""
    arguments = ["stipple", str(desk / "ramp.png"), "out.svg", "out.pdf", "--dots", "20000", "--iterations", "3", "--report", "-"]
    pinned = ["taskset", "-c", str(min(os.sched_getaffinity(0)))] if shutil.which("taskset") else []
    seen: dict[str, tuple[bytes, bytes, str]] = {}
    kinds = [(name, environment, []) for name, environment in surroundings(desk).items()]
    kinds += [("one core", {}, pinned), ("code without assertions", {"PYTHONOPTIMIZE": "2"}, [])]
    for name, environment, before in kinds:
        folder = desk / name.replace(" ", "-")  # another folder each, whose name must not show either
        folder.mkdir()
        command = [*before, sys.executable, "-m", "crowquill", *arguments]
        found = subprocess.run(
            command, cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, timeout=PATIENCE, check=True
        )
        report = json.loads(found.stdout)
        del report["seconds"]
        seen[name] = (folder / "out.svg").read_bytes(), (folder / "out.pdf").read_bytes(), json.dumps(report)
    assert {name: found == seen["as we are"] for name, found in seen.items()} == dict.fromkeys(seen, True)
