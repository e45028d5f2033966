"""The command as a process of its own: signals, closed pipes, homes that cannot be written to, start-up, and threads."""

from __future__ import annotations

import contextlib
import os
import pty
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import crowquill
from crowquill import styles
from crowquill.__main__ import main

PATIENCE = 60  # s, a guard against a hang: compiled code may have to be compiled first
QUICK = ("--paper", "60x50mm", "--margin", "5mm", "--tone", "grey", "--dots", "80", "--iterations", "2")
COMMAND = (sys.executable, "-m", "crowquill")
# the program as it is, but for a line on stdout once relaxation is under way
WATCHED = """
import signal, sys
from crowquill import relax
from crowquill.__main__ import run

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job, and all it starts, ignores Ctrl-C

def lloyd(*arguments, **options):
    for state in original(*arguments, **options):
        if state.done == 2:
            print("relaxing", flush=True)
        yield state

original, relax.lloyd = relax.lloyd, lloyd
run()
"""
# and but for a halt in the middle of writing
SLOW = """
import os, sys
from crowquill.__main__ import run

def fsync(handle):
    print("writing", flush=True)
    sys.stdin.readline()
    original(handle)

original, os.fsync = os.fsync, fsync
run()
"""


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a picture and an older drawing, which is where we are."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(120, 255, 40).astype(np.uint8), (30, 1))).save("ramp.png")
    Path("old.svg").write_bytes(b"older")
    return tmp_path


def held(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def process(*arguments: str, **more: Any) -> subprocess.CompletedProcess[str]:
    """`crowquill stipple ramp.png new.svg` as a process, with these arguments behind."""
    whole = {"stdin": subprocess.DEVNULL, "text": True, "timeout": PATIENCE, "check": False, "capture_output": "stdout" not in more}
    return subprocess.run([*COMMAND, "stipple", "ramp.png", "new.svg", *QUICK, *arguments], **(whole | more))


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The drawing that process() makes, made here."""
    folder = tmp_path_factory.mktemp("reference")
    Image.fromarray(np.tile(np.linspace(120, 255, 40).astype(np.uint8), (30, 1))).save(folder / "ramp.png")
    assert main(["stipple", str(folder / "ramp.png"), str(folder / "new.svg"), *QUICK, "--quiet"]) == 0
    return (folder / "new.svg").read_bytes()


@pytest.mark.parametrize(
    ("stop", "code", "says"), [(signal.SIGINT, 130, ["crowquill: stopped; nothing was written"]), (signal.SIGTERM, 143, [])]
)
def test_a_signal_in_the_middle_of_relaxation_stops_it_and_leaves_nothing(desk, stop, code, says):
    before = held(desk)
    endless = [*QUICK, "--dots", "20000", "--iterations", "100000"]
    arguments = [sys.executable, "-c", WATCHED, "stipple", "ramp.png", "old.svg", "new.pdf", *endless]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None and run.stdout.readline() == "relaxing\n"
        run.send_signal(stop)
        try:
            out, err = run.communicate(timeout=PATIENCE)
        finally:
            run.kill()
    assert (run.returncode, out, err.splitlines()) == (code, "", says)
    assert held(desk) == before


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("report", [[], ["--report", "-"]])
def test_a_reader_of_stdout_that_has_gone_does_not_spoil_the_drawing(report, reference):
    reader, writer = os.pipe()
    os.close(reader)
    found = process(*report, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (found.returncode, found.stderr) == (0, "")
    assert Path("new.svg").read_bytes() == reference


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_the_drawing_is_made_with_standard_files_closed(closed, reference):
    line = f'exec "$0" "$@" {closed}'
    arguments = ["sh", "-c", line, *COMMAND, "stipple", "ramp.png", "new.svg", *QUICK]
    found = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (found.returncode, found.stderr) == (0, "")
    assert Path("new.svg").read_bytes() == reference


@pytest.mark.usefixtures("desk")
def test_no_home_and_no_cache_to_write_to_is_no_hindrance(reference):
    """In /proc not even root can make a file; permissions alone would not stop it."""
    homeless = {"HOME": "/proc", "XDG_CACHE_HOME": "/proc", "NUMBA_CACHE_DIR": "/proc/none", "TMPDIR": "/proc"}
    found = process(env={**os.environ, **homeless})
    assert (found.returncode, found.stderr) == (0, "")
    assert Path("new.svg").read_bytes() == reference


def test_a_cache_that_cannot_be_filled_is_no_hindrance(desk, reference):
    """Compiled code that finds no room on disk is used all the same; a full cache is played by failing each save."""
    full = """
import errno, sys
from numba.core.caching import IndexDataCacheFile
def save(*_):
    raise OSError(errno.ENOSPC, "No space left on device")
IndexDataCacheFile.save = save
from crowquill.__main__ import run
run()
"""
    arguments = [sys.executable, "-c", full, "stipple", "ramp.png", "new.svg", *QUICK]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(desk / "cache")}
    found = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False, env=environment)
    assert (found.returncode, found.stderr) == (0, "")
    assert Path("new.svg").read_bytes() == reference


@pytest.mark.usefixtures("desk")
def test_without_a_terminal_nothing_is_painted(reference):
    bare = {name: value for name, value in os.environ.items() if name not in ("TERM", "COLUMNS", "LINES", "FORCE_COLOR")}
    found = process(env=bare, start_new_session=True)
    assert (found.returncode, found.stderr) == (0, "") and found.stdout.count("\n") == 1 and found.stdout[:-1].isprintable()
    assert Path("new.svg").read_bytes() == reference


@pytest.mark.usefixtures("desk")
def test_on_a_terminal_progress_is_shown_and_the_drawing_is_the_same(reference):
    ours, theirs = pty.openpty()
    heard: list[bytes] = []

    def listen() -> None:  # a terminal holds 4 KB and then keeps its writer waiting
        with contextlib.suppress(OSError):  # how Linux says that the other end has gone
            while part := os.read(ours, 4096):
                heard.append(part)

    listener = threading.Thread(target=listen)
    listener.start()
    found = process("--iterations", "2", stdout=subprocess.PIPE, stderr=theirs, env={**os.environ, "TERM": "xterm"})
    os.close(theirs)
    listener.join(PATIENCE)
    os.close(ours)
    shown = b"".join(heard).decode()
    assert found.returncode == 0 and "relax" in shown and "Traceback" not in shown
    assert Path("new.svg").read_bytes() == reference


def test_a_refusal_is_one_line_and_exit_code_two(desk):
    before = held(desk)
    found = process("--pen", "0.3px")
    assert (found.returncode, found.stdout) == (2, "")
    assert found.stderr.startswith("crowquill: ") and found.stderr.count("\n") == 1
    assert held(desk) == before


@pytest.mark.parametrize("arguments", [["--help"], ["--version"]])
def test_help_is_answered_before_anything_heavy_is_imported(arguments):
    """Help of a style imports the style, whose signature has the knobs, and so takes longer."""
    code = "import sys; from crowquill.__main__ import main; main(sys.argv[1:]); print(*sys.modules, file=sys.stderr)"
    found = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, timeout=PATIENCE, check=True)
    modules = set(found.stderr.split())
    assert "crowquill.commands" in modules
    assert not modules & {"numpy", "scipy", "numba", "shapely", "PIL", "reportlab", "pikepdf"}


def test_two_threads_at_once_draw_the_bytes_that_one_draws():
    tone = crowquill.Tone(np.tile(np.linspace(0, 0.6, 40), (30, 1)), (20.0, 15.0))

    def draw() -> tuple[bytes, bytes]:
        sheet = crowquill.draw("stipple", tone, dots=500, iterations=5, seed=3)
        return crowquill.to_bytes(sheet, "svg"), crowquill.to_bytes(sheet, "pdf")

    alone, together = draw(), []
    start = threading.Barrier(2)

    def meet() -> None:
        start.wait()
        together.extend(draw() for _ in range(3))

    threads = [threading.Thread(target=meet) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == [alone] * 6


def test_a_run_removes_what_a_killed_one_left_and_leaves_a_living_one_alone(desk, reference):
    def begun() -> subprocess.Popen[str]:
        arguments = [sys.executable, "-c", SLOW, "stipple", "ramp.png", "new.svg", *QUICK, "--quiet"]
        run = subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert run.stdout is not None and run.stdout.readline() == "writing\n"
        return run

    old = set(held(desk))
    with begun() as living:
        own = set(held(desk)) - old
        with begun() as killed:
            killed.kill()
        litter = set(held(desk)) - old - own
        assert own and litter  # a file under way each
        assert main(["stipple", "ramp.png", "new.svg", *QUICK, "--quiet"]) == 0
        assert set(held(desk)) == old | own | {"new.svg"}
        living.communicate("go on\n", timeout=PATIENCE)
    assert living.returncode == 0 and set(held(desk)) == old | {"new.svg"}
    assert Path("new.svg").read_bytes() == reference


@pytest.mark.parametrize("arguments", [["--help"], ["-h"], ["stipple", "--help"], ["stipple", "-h"], ["--version"]])
def test_help_and_version_are_printed_and_are_no_failure(arguments, capsys):
    assert main(arguments) == 0
    told = capsys.readouterr()
    assert told.out.strip() and not told.err


@pytest.mark.parametrize("name", styles.names())
def test_help_of_a_style_names_every_knob_it_has(name, capsys):
    assert main([name, "--help"]) == 0
    told = capsys.readouterr().out
    assert [key for key in styles.knobs(name) if f"--{key.replace('_', '-')}" not in told] == []


@pytest.mark.parametrize("arguments", [[], ["stipple"]])
def test_nothing_typed_is_answered_with_help_and_is_no_drawing(arguments, capsys):
    assert main(arguments) == 2
    told = capsys.readouterr()
    assert "Usage" in told.out + told.err and not told.err.startswith("crowquill: \n")
