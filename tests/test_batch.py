"""Many drawings: the bytes of single ones, each made once, whatever fails, is killed or stopped on the way."""

from __future__ import annotations

import csv
import errno
import importlib.metadata
import inspect
import io
import json
import os
import signal
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path

import clusters
import numpy as np
import pytest
from PIL import Image

from crowquill import formats, styles
from crowquill.__main__ import main
from crowquill.batch import JOURNAL, Job, Journal, Outcome, UnfitError
from crowquill.cluster import GoneError, LostError, Workers
from crowquill.commands import _telling
from crowquill.commands.batch import _batch
from crowquill.formats import alive
from crowquill.recipe import TABLES, takes_of

SETTINGS = ("--style", "stipple", "--dots", "60", "--iterations", "2", "--paper", "60x50mm", "--margin", "5mm", "--tone", "grey")
ALONE = SETTINGS[2:]
PATIENCE = clusters.PATIENCE


def furnished(folder: Path) -> Path:
    """A folder with five pictures and a broken one, and one for drawings."""
    for k in range(5):
        Image.fromarray(np.tile(np.linspace(90 + 10 * k, 255, 40).astype(np.uint8), (30, 1))).save(folder / f"p{k}.png")
    (folder / "bad.png").write_bytes(b"no picture")
    (folder / "out").mkdir()
    return folder


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Such a folder, which is where we are."""
    monkeypatch.chdir(tmp_path)
    return furnished(tmp_path)


PICTURES = [f"p{k}.png" for k in range(5)]


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory):
    with clusters.cluster(tmp_path_factory.mktemp("dask"), 2) as made:
        yield made


class Inline(Workers):
    """A pool that does each task at once, here, and says how often."""

    count, here = 1, True

    def __init__(self) -> None:
        self.done = 0

    def submit(self, fn, /, *args, **kwargs):
        self.done += 1
        future: Future[object] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def inline(monkeypatch: pytest.MonkeyPatch) -> Inline:
    """In place of processes, a pool that works here: the command with all else as it is."""
    pool = Inline()

    class Context:
        def __init__(self, *_: object) -> None: ...

        def __enter__(self) -> Inline:
            return pool

        def __exit__(self, *_: object) -> None: ...

    monkeypatch.setattr("crowquill.cluster.workers", Context)
    return pool


def held(folder: str | Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path(folder).iterdir() if path.name != JOURNAL}


def alone(*pictures: str, kinds: tuple[str, ...] = ("svg",)) -> dict[str, bytes]:
    """The drawings of pictures, each by a command of its own."""
    made = {}
    Path("alone").mkdir(exist_ok=True)
    for picture in pictures:
        files = [f"alone/{Path(picture).stem}.{kind}" for kind in kinds]
        assert main(["stipple", picture, *files, *ALONE, "--quiet"]) == 0
        made |= {Path(file).name: Path(file).read_bytes() for file in files}
    return made


def batch(*arguments: str) -> int:
    return main(["batch", *arguments, "--out", "out"])


def test_drawings_of_a_batch_have_the_bytes_of_single_ones_and_one_that_fails_is_said_once(capfd):
    kinds = ("--format", "svg", "--format", "pdf")
    assert batch(*PICTURES[:2], "bad.png", PICTURES[2], *SETTINGS, *kinds, "--workers", "2", "--report", "told.json") == 1
    assert held("out") == alone(*PICTURES[:3], kinds=("svg", "pdf"))
    said = capfd.readouterr()
    assert said.err.count("\n") == 1
    assert said.err.startswith("crowquill: bad.png: not a picture that can be read; give one of PNG")
    assert "3 drawn, 1 failed" in said.out
    told = json.loads(Path("told.json").read_text())
    assert [row["drawing"] for row in told["drawings"]] == [*PICTURES[:2], "bad.png", PICTURES[2]]
    assert (told["drawn"], told["kept"], told["failed"]) == (3, 0, 1)


@pytest.mark.usefixtures("inline")
def test_recipes_and_drawings_that_hold_one_are_drawn_as_redo_draws_them(capfd):
    assert main(["stipple", "p0.png", "a.svg", *ALONE, "--quiet"]) == 0
    assert main(["stipple", "p1.png", "b.pdf", *ALONE, "--seed", "4", "--embed", "--quiet"]) == 0
    assert main(["stipple", "p2.png", "c.svg", *ALONE, "--size-by", "tone", "--quiet"]) == 0
    capfd.readouterr()
    assert main(["recipe", "c.svg"]) == 0
    Path("c.toml").write_text(capfd.readouterr().out)
    Path("p1.png").unlink()  # b.pdf keeps it inside
    assert batch("a.svg", "b.pdf", "c.toml", "--quiet") == 0
    for file in ("a.svg", "b.pdf", "c.toml"):
        assert main(["redo", file, "again.svg", "--quiet"]) == 0
        assert Path("again.svg").read_bytes() == Path("out", file).with_suffix(".svg").read_bytes()


def test_what_is_made_is_kept_and_what_has_changed_is_made_again(inline, capfd):
    assert batch(*PICTURES, *SETTINGS) == 0
    first = {path.name: path.stat().st_mtime_ns for path in Path("out").glob("*.svg")}
    assert (len(first), inline.done) == (5, 5)
    assert batch(*PICTURES, *SETTINGS) == 0
    assert "5 kept" in capfd.readouterr().out
    assert inline.done == 5
    whole = held("out")
    Path("out/p0.svg").unlink()
    Path("out/p1.svg").write_text("edited")
    assert batch(*PICTURES, *SETTINGS, "--dry-run") == 0
    assert "2 to do, 3 kept" in capfd.readouterr().out
    assert batch(*PICTURES, *SETTINGS) == 0
    assert held("out") == whole
    assert inline.done == 7
    Path("p2.png").write_bytes(Path("p4.png").read_bytes())  # another picture of the same name
    assert batch(*PICTURES, *SETTINGS) == 0
    assert inline.done == 8
    assert {path.name for path in Path("out").glob("*.svg") if path.stat().st_mtime_ns == first[path.name]} == {"p3.svg", "p4.svg"}
    assert batch(*PICTURES, *SETTINGS, "--seed", "1") == 0  # another recipe
    assert inline.done == 13


@pytest.mark.usefixtures("inline")
def test_settings_of_a_recipe_are_those_of_all_and_what_is_typed_goes_before(capfd):
    Path("sub").mkdir()
    Image.fromarray(np.pad(np.full((20, 30), 255, np.uint8), 5)).save("sub/mask.png")
    Path("sub/settings.toml").write_text('style = "stipple"\nseed = 5\n[tone]\ncanvas = "mask.png"\n[knobs]\ndots = 40\n')
    assert batch(*PICTURES[:2], *SETTINGS, "--recipe", "sub/settings.toml", "--report", "-") == 0
    told = json.loads(capfd.readouterr().out)
    assert [row["marks"] for row in told["drawings"]] == [60, 60]
    assert main(["stipple", "p1.png", "one.svg", *ALONE, "--recipe", "sub/settings.toml", "--quiet"]) == 0
    assert Path("one.svg").read_bytes() == Path("out/p1.svg").read_bytes()
    assert batch("p0.png", "--style", "cells", "--recipe", "sub/settings.toml") == 2
    assert "is a recipe for the style stipple; say crowquill stipple" in capfd.readouterr().err


def test_another_format_is_made_beside_those_that_are_there(inline):
    assert batch("p0.png", *SETTINGS) == 0
    assert batch("p0.png", *SETTINGS, "--format", "pdf") == 0
    assert batch("p0.png", *SETTINGS, "--format", "pdf", "--format", "svg", "--no-overwrite", "--quiet") == 0
    assert inline.done == 2


def test_a_journal_that_was_cut_short_keeps_what_is_whole(tmp_path):
    journal = Journal(tmp_path)
    (tmp_path / "a.svg").write_bytes(b"a")
    (tmp_path / "b.svg").write_bytes(b"b")
    journal.add("one", {"a.svg": b"a"})
    whole = journal.path.read_bytes()
    journal.path.write_bytes(whole + whole[:30])  # the power went while a line was written
    Journal(tmp_path).add("two", {"b.svg": b"b"})
    again = Journal(tmp_path)
    assert again.has("one", [tmp_path / "a.svg"])
    assert again.has("two", [tmp_path / "b.svg"])
    assert not again.has("one", [tmp_path / "b.svg"])
    assert not again.has("three", [tmp_path / "a.svg"])
    for odd in (b"[]\n", b'{"key": 3}\n', b"\xff\xfe\n", b'"text"\n', b'{"key": [], "files": 3}\n', b'{"key": "k", "files": [1]}\n'):
        journal.path.write_bytes(odd + whole)
        assert Journal(tmp_path).has("one", [tmp_path / "a.svg"])


REFUSED = {
    "twice the same name": (["p0.png", "sub/p0.png", *SETTINGS], "sub/p0.png: would be written to out/p0.svg, as p0.png would; give one"),
    "twice the same": (["p0.png", "p0.png", *SETTINGS], "p0.png: is given twice; give it once"),
    "no style": (["p0.png", "--style", "stiple"], "no style 'stiple'; did you mean stipple?"),
    "no format": (["p0.png", *SETTINGS, "--format", "jpg"], "out/p0.jpg: no format 'jpg'; there are gcode,"),
    "no format of recipes": (["p0.svg", "--format", "jpg"], "out/p0.jpg: no format 'jpg'; there are gcode,"),
    "strokes": (["p0.png", *SETTINGS, "--format", "hpgl"], "out/p0.hpgl: takes strokes only; add --for plotter"),
    "idle knob": (["p0.png", *SETTINGS, "--dpi", "600"], "none of the formats written has knob 'dpi'"),
    "bad knob": (["p0.png", *SETTINGS, "--dots", "-3"], "--dots is -3; it takes a whole number from 1"),
    "bad report": (["p0.png", *SETTINGS, "--report", "told.txt"], "told.txt: a report is a table or JSON; give a name that ends in"),
    "both": (["p0.png", *SETTINGS, "--workers", "2", "--scheduler", "tcp://a:1"], "--workers are of this machine"),
    "none there": (["p0.png", *SETTINGS, "--scheduler", "tcp://127.0.0.1:9"], "tcp://127.0.0.1:9: no scheduler answers; begin one with"),
    "no address": (["p0.png", *SETTINGS, "--scheduler", "here"], "'here' is no address of a scheduler; give one such as tcp://host:8786"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_begun_is_refused_in_one_line_before_any_work(capfd, case):
    arguments, said = REFUSED[case]
    assert batch(*arguments) == 2
    told = capfd.readouterr()
    assert told.err.startswith(f"crowquill: {said}")
    assert told.err.count("\n") == 1
    assert not told.out
    assert not list(Path("out").iterdir())


def test_a_folder_that_is_none_is_refused(capfd):
    for name, why in (("p0.png", "is no folder"), ("nowhere", "there is no such folder; make it first")):
        assert main(["batch", "p0.png", *SETTINGS, "--out", name]) == 2
        assert capfd.readouterr().err.startswith(f"crowquill: {name}: {why}")


def test_without_dask_the_remedy_is_one_line(capfd, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert batch("p0.png", *SETTINGS, "--scheduler", "tcp://127.0.0.1:9") == 2
    assert capfd.readouterr().err == 'crowquill: a scheduler takes Dask; install it with: pip install "crowquill[cluster]"\n'


@pytest.mark.usefixtures("inline")
def test_recipes_that_cannot_be_followed_fail_by_name_and_the_others_are_drawn(capfd):
    assert main(["stipple", "p0.png", "good.svg", *ALONE, "--quiet"]) == 0
    Path("alone.toml").write_text('style = "stipple"\n')
    Path("newer.toml").write_text('schema = 99\nstyle = "stipple"\n')
    Path("torn.toml").write_text("style = ")
    Path("lost.toml").write_text('style = "stipple"\n[sources.picture]\nname = "gone.png"\n')
    names = ["alone.toml", "newer.toml", "torn.toml", "lost.toml", "p1.png", "nothing.svg", "out", "good.svg"]
    assert batch(*names, "--quiet", "--report", "told.csv") == 1
    lines = capfd.readouterr().err.splitlines()
    assert len(lines) == 7
    assert all(line.startswith(f"crowquill: {name}: ") and "; " in line for line, name in zip(lines, names, strict=False)), lines
    assert "give pictures, with --style stipple --recipe alone.toml" in lines[0]
    assert list(held("out")) == ["good.svg"]
    rows = list(csv.DictReader(io.StringIO(Path("told.csv").read_text())))
    assert [row["status"] for row in rows] == ["failed"] * 7 + ["drawn"]
    assert rows[-1]["files"] == "out/good.svg"
    assert int(rows[-1]["marks"]) == 60
    assert rows[2]["error"].startswith("torn.toml: not sound TOML")


def test_any_error_of_one_leaves_the_others(inline, capfd, monkeypatch):
    original, calls = formats.replace_files, []

    def full(plan):
        if plan[0][0].name == "p1.svg" and not calls:
            calls.append(plan)
            raise OSError(errno.ENOSPC, "No space left on device", str(plan[0][0]))
        original(plan)

    monkeypatch.setattr(formats, "replace_files", full)
    assert batch(*PICTURES[:3], *SETTINGS, "--quiet") == 1
    assert capfd.readouterr().err == "crowquill: p1.png: out/p1.svg: no space left on device; free some space\n"
    assert set(held("out")) == {"p0.svg", "p2.svg"}
    assert batch(*PICTURES[:3], *SETTINGS, "--quiet") == 0
    assert inline.done == 4


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "p0.png: not enough memory; use a smaller picture or fewer dots"),
        (LostError("its workers ended; have fewer"), "p0.png: its workers ended; have fewer"),
        (TypeError("odd"), "p0.png: failed (TypeError: odd); tell us, it should not"),
        (ValueError("max_pixels is 0; it takes more"), "p0.png: --max-pixels is 0; it takes more"),
        (FileNotFoundError(errno.ENOENT, "No such file", "p0.png"), "p0.png: no such file; check the name"),
    ],
)
def test_errors_are_told_in_words(capfd, error, said):
    job = Job("p0.png", (Path("p0.svg"),), lambda _: ({}, {}))
    told = _telling.Told([job], None, True, ["max_pixels"])
    told.add(Outcome(job, "failed", error=error))
    assert capfd.readouterr().err == f"crowquill: {said}\n"
    assert told.end() == 1


def test_notes_that_many_share_are_said_once(capfd):
    jobs = [Job(f"p{k}.png", (Path(f"p{k}.svg"),), lambda _: ({}, {})) for k in range(3)]
    told = _telling.Told(jobs, None, False, [])
    for job in reversed(jobs):
        told.add(Outcome(job, "drawn", {"warnings": [f"{jobs.index(job)}.5% of it is dark", *(["is odd"] if job is jobs[1] else [])]}))
    assert told.end() == 0
    said = capfd.readouterr()
    assert said.err.splitlines() == ["crowquill: note: p0.png and 2 more: 0.5% of it is dark", "crowquill: note: p1.png: is odd"]
    assert [line.split()[0] for line in said.out.splitlines()[1:4]] == ["p0.png", "p1.png", "p2.png"]


def test_on_a_terminal_bars_show_all_and_each(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stderr", screen := Terminal())
    monkeypatch.setenv("TERM", "xterm")
    jobs = [Job(name, (Path(name),), lambda _: ({}, {})) for name in ("[red]one.png", "two.png")]
    told = _telling.Told(jobs, None, False, [])
    with told.live({"a": jobs[0], "b": jobs[1]}) as heard:
        heard(("a", "relax", 7, 40))
        heard(("elsewhere", "relax", 1, 40))
        told._bars._progress.refresh()
        assert "[red]one.png relax" in screen.getvalue()
        assert "7/40" in screen.getvalue()
        told.add(Outcome(jobs[0], "failed", error=ValueError("[blue]bad; mend it")))
        heard(("a", "relax", 8, 40))  # late
        told._bars._progress.refresh()
        assert "crowquill: [red]one.png: [blue]bad; mend it\n" in screen.getvalue()
        assert "1/2" in screen.getvalue()
        assert "8/40" not in screen.getvalue()


def test_no_option_of_a_batch_has_the_name_of_a_knob():
    own = set(inspect.signature(_batch).parameters) | {"seed", "recipe"}
    for style in styles.names():
        for table in TABLES:
            assert not own & set(takes_of(table, style)), f"{style}: {table}"


def test_help_has_the_options_of_the_style_that_is_named(capfd):
    assert main(["batch", "--help"]) == 0
    assert "--relaxation" not in capfd.readouterr().out
    assert main(["batch", "--style=mosaic", "--help"]) == 0
    assert "--grout" in capfd.readouterr().out


# what is killed or stopped

SLOWLY = (*SETTINGS[:2], "--dots", "3000", "--iterations", "20", "--until", "0", *SETTINGS[6:], "--quiet")
COMMAND = (sys.executable, "-m", "crowquill", "batch", *PICTURES, "--out", "out", *SLOWLY, "--workers", "2")
STOPPABLE = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\nfrom crowquill.__main__ import run; run()"


def children(process: int) -> list[int]:
    """Those that a process began."""
    return [int(word) for task in Path(f"/proc/{process}/task").iterdir() for word in (task / "children").read_text().split()]


def lines() -> list[str]:
    return Path("out", JOURNAL).read_text().splitlines() if Path("out", JOURNAL).exists() else []


@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What COMMAND makes when nothing befalls it."""
    folder = furnished(tmp_path_factory.mktemp("slow"))
    for name in PICTURES:
        assert main(["stipple", str(folder / name), str(folder / "out" / Path(name).with_suffix(".svg")), *SLOWLY[2:]]) == 0
    return held(folder / "out")


@pytest.mark.usefixtures("inline")
def test_a_command_that_is_killed_and_begun_again_makes_every_drawing_once(slow):
    with subprocess.Popen(COMMAND) as run:
        clusters.waited_for(lines)
        workers = children(run.pid)
        assert len(workers) == 2
        run.kill()
    before = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in Path("out").glob("*.svg")}
    journal = lines()
    assert 0 < len(journal) < 5
    assert main([*COMMAND[3:]]) == 0
    assert held("out") == slow
    assert lines()[: len(journal)] == journal
    assert sorted(name for line in lines() for name in json.loads(line)["files"]) == sorted(slow)
    kept = [path for path, (data, when) in before.items() if (path.read_bytes(), path.stat().st_mtime_ns) == (data, when)]
    assert len(kept) >= len(journal)
    clusters.waited_for(lambda: not any(alive(worker) for worker in workers))


@pytest.mark.soak
def test_a_worker_that_is_killed_costs_no_drawing(slow):
    with subprocess.Popen(COMMAND, stderr=subprocess.PIPE, text=True) as run:
        clusters.waited_for(lines)
        os.kill(children(run.pid)[0], signal.SIGKILL)
        assert run.communicate(timeout=PATIENCE)[1] == ""
    assert run.returncode == 0
    assert held("out") == slow
    assert len(lines()) == 5


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.soak)])
@pytest.mark.usefixtures("inline")
def test_who_is_stopped_ends_the_workers_leaves_no_debris_and_goes_on(desk, slow, number, code):
    with subprocess.Popen(
        [sys.executable, "-c", STOPPABLE, *COMMAND[3:]], stderr=subprocess.PIPE, text=True, env={**os.environ, "TMPDIR": str(desk)}
    ) as run:
        clusters.waited_for(lines)
        workers = children(run.pid)
        run.send_signal(number)
        said = run.communicate(timeout=PATIENCE)[1]
    made = len(lines())
    assert run.returncode == code
    assert said == ("" if code == 143 else f"crowquill: stopped; {made} of 5 drawings are made, and the same command goes on\n")
    assert not any(alive(worker) for worker in workers)
    assert {path.name for path in desk.iterdir()} == {*PICTURES, "bad.png", "out"}
    assert set(held("out")) <= set(slow)
    assert main([*COMMAND[3:]]) == 0
    assert held("out") == slow
    assert len(lines()) == 5


# on a cluster


def test_a_cluster_gives_the_bytes_that_are_made_here(dask, capfd):
    assert batch(*PICTURES[:2], "bad.png", *SETTINGS, "--scheduler", dask.address, "--quiet") == 1
    assert held("out") == alone(*PICTURES[:2])
    assert capfd.readouterr().err.startswith("crowquill: bad.png: not a picture that can be read")


def test_sources_kept_in_a_drawing_reach_a_cluster(dask):
    assert main(["stipple", "p1.png", "b.svg", *ALONE, "--canvas", "mask.png", "--embed", "--quiet"]) == 2  # there is no mask
    Image.fromarray(np.pad(np.full((20, 30), 255, np.uint8), 5)).save("mask.png")
    assert main(["stipple", "p1.png", "b.svg", *ALONE, "--canvas", "mask.png", "--embed", "--quiet"]) == 0
    Path("mask.png").unlink()
    Path("p1.png").unlink()
    assert batch("b.svg", "--scheduler", dask.address, "--quiet") == 0
    assert Path("out/b.svg").read_bytes() == Path("b.svg").read_bytes()


def test_a_source_that_goes_away_before_it_is_sent_fails_alone(inline, capfd, monkeypatch):
    original = Path.read_bytes

    def read_bytes(path: Path) -> bytes:
        if path.name == "p1.png":
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", str(path))
        return original(path)

    monkeypatch.setattr(inline, "here", False)
    monkeypatch.setattr(Path, "read_bytes", read_bytes)
    assert batch(*PICTURES[:3], *SETTINGS, "--quiet") == 1
    assert capfd.readouterr().err == "crowquill: p1.png: no such file or directory; check the name\n"
    assert set(held("out")) == {"p0.svg", "p2.svg"}


FULL = """
import errno, pathlib
original = pathlib.Path.write_bytes
def write_bytes(path, data):
    if "crowquill-" in str(path):
        raise OSError(errno.ENOSPC, "No space left on device", str(path))
    return original(path, data)
pathlib.Path.write_bytes = write_bytes
"""


def test_a_worker_whose_disk_is_full_is_said_once_and_the_others_do_its_drawings(capfd):
    Path("full").mkdir()
    Path("full/sitecustomize.py").write_text(FULL)
    with clusters.cluster(Path(), 1, [{"FIRST": "full"}]) as made:
        assert batch(*PICTURES, *SETTINGS, "--scheduler", made.address, "--quiet") == 0
    said = capfd.readouterr().err
    assert said.startswith("crowquill: note: worker tcp://127.0.0.1:")
    assert said.endswith(": no space left on device; free some space there, others do its drawings\n")
    assert said.count("\n") == 1
    assert held("out") == alone(*PICTURES)


def test_a_worker_of_another_version_that_joins_late_gets_no_drawings(inline, capfd, monkeypatch):
    versions = iter(["0.0.9"])  # of the first worker; all others are of ours
    monkeypatch.setattr(inline, "here", False)
    monkeypatch.setattr(inline, "avoid", lambda _: True, raising=False)
    submit = inline.submit

    def submitted(fn, *arguments):
        if other := next(versions, None):
            arguments = (*arguments[:-1], other)
        return submit(fn, *arguments)

    monkeypatch.setattr(inline, "submit", submitted)
    assert batch(*PICTURES[:2], *SETTINGS, "--quiet") == 0
    ours = importlib.metadata.version("crowquill")
    said = f"crowquill: note: worker : has crowquill {ours}, and 0.0.9 is wanted; install the same there, others do its drawings\n"
    assert capfd.readouterr().err == said
    assert held("out") == alone(*PICTURES[:2])


def test_where_all_disks_are_full_each_worker_is_said_once_and_the_batch_ends(inline, capfd, monkeypatch):
    submit, avoided = inline.submit, []

    def full(*_: object) -> None:
        raise UnfitError("tcp://a:1", "no space left on device; free some space there")

    def submitted(_, *arguments):
        if avoided:
            raise GoneError("tcp://s:1: no worker is left that has room; free some space there")
        return submit(full, *arguments)

    monkeypatch.setattr(inline, "submit", submitted)
    monkeypatch.setattr(inline, "avoid", avoided.append, raising=False)
    assert batch(*PICTURES, *SETTINGS, "--quiet") == 1
    lines = capfd.readouterr().err.splitlines()
    assert lines[0] == "crowquill: note: worker tcp://a:1: no space left on device; free some space there"
    assert lines[-1].endswith("no worker is left that has room; free some space there; then the same command goes on")
    assert len([line for line in lines if line.startswith("crowquill: note: ")]) == 1


@pytest.mark.soak
@pytest.mark.usefixtures("inline")
def test_a_scheduler_that_goes_away_is_said_once_and_what_is_made_is_kept(desk, slow):
    with clusters.cluster(desk, 1) as made:
        code = [sys.executable, *COMMAND[1:-2], "--scheduler", made.address]
        with subprocess.Popen(code, stderr=subprocess.PIPE, text=True) as run:
            clusters.waited_for(lines)
            made.end()
            said = run.communicate(timeout=PATIENCE)[1]
    assert run.returncode == 1
    assert said == f"crowquill: {made.address}: the scheduler is gone; begin it again; then the same command goes on\n"
    assert 0 < len(lines()) < 5
    assert main([*COMMAND[3:]]) == 0
    assert held("out") == slow
    assert len(lines()) == 5
