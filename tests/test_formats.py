"""Every format: the same bytes twice, the same wherever they go, and never half a file."""

from __future__ import annotations

import errno
import hashlib
import io
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawings import NIB, drawable, everything, file

from crowquill import formats
from crowquill.formats import _text
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

FORMATS = pytest.mark.parametrize("format", formats.names())


@FORMATS
def test_the_same_sheet_gives_the_same_bytes_at_any_time(format: str, monkeypatch: pytest.MonkeyPatch) -> None:
    first = formats.to_bytes(drawable(format), format)
    monkeypatch.setattr(time, "time", lambda: 4e9)
    assert formats.to_bytes(replace(drawable(format), report={"seconds": 9.9}), format) == first
    assert formats.to_bytes(drawable(format, seed=2), format) != first


def test_the_same_bytes_come_from_another_process_time_zone_and_order_of_hashes() -> None:
    code = "import sys, drawings, hashlib; print(*(hashlib.sha256(drawings.file(f)).hexdigest() for f in sys.argv[1:]))"
    environ = {**os.environ, "PYTHONHASHSEED": "12345", "TZ": "Asia/Kathmandu", "LC_ALL": "C", "PYTHONPATH": str(Path(__file__).parent)}
    other = subprocess.run([sys.executable, "-c", code, *formats.names()], capture_output=True, text=True, env=environ, check=True)
    assert other.stdout.split() == [hashlib.sha256(file(format)).hexdigest() for format in formats.names()]


@FORMATS
def test_paths_open_files_and_bytes_get_the_same(format: str, tmp_path: Path) -> None:
    buffer, named = io.BytesIO(), tmp_path / f"b.{format}"
    with named.open("wb") as open_file:
        formats.save(drawable(format), tmp_path / f"a.{format.upper()}", str(tmp_path / f"c.{format}"), open_file)
    formats.save(drawable(format), buffer, format=format)
    assert {path.read_bytes() for path in tmp_path.iterdir()} == {buffer.getvalue()} == {file(format)}


@FORMATS
def test_sheets_with_nothing_on_them_are_files_too(format: str) -> None:
    for layers in (
        (),
        (Layer(Ink(), Marks.of([], NIB, scale=1)),),
        (Layer(Ink(), Marks.of([], (), scale=1)),),
        (Layer(Ink(), Paths.of([])),),
    ):
        data = formats.to_bytes(Sheet((50, 60), layers), format)
        assert len(data) > (10 if hasattr(formats.module(format, format), "STROKES") else 100)  # a header at the least


@FORMATS
@pytest.mark.parametrize(
    "trouble", [RuntimeError("bug"), KeyboardInterrupt(), OSError(errno.ENOSPC, "No space left on device"), MemoryError()]
)
def test_a_writer_that_fails_leaves_the_older_files_and_nothing_else(
    format: str, trouble: BaseException, tmp_path: Path, monkeypatch: Any
) -> None:
    older, new = tmp_path / f"older.{format}", tmp_path / f"new.{format}"
    older.write_bytes(b"older")

    def half(_sheet: Sheet, file: Any) -> None:
        file.write(b"half" * 10_000)
        raise trouble

    monkeypatch.setattr(formats.module(format, ""), "write", half)
    for targets in ((older,), (new,), (older, new)):
        with pytest.raises(type(trouble)):
            formats.save(everything(), *targets)
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {older.name: b"older"}


def test_one_target_that_fails_keeps_all_others_from_being_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formats.module("pdf", ""), "write", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        formats.save(everything(), tmp_path / "a.svg", tmp_path / "a.pdf")
    assert list(tmp_path.iterdir()) == []


def test_targets_that_cannot_be_written_are_refused_before_any_is(tmp_path: Path) -> None:
    (tmp_path / "there.svg").write_bytes(b"older")
    (tmp_path / "folder.svg").mkdir()
    os.mkfifo(tmp_path / "pipe.svg")
    before = sorted(path.name for path in tmp_path.iterdir())
    for name, error, says in (
        ("there.svg", FileExistsError, r"there\.svg: is there already; "), ("folder.svg", IsADirectoryError, r"folder\.svg: is a folder; "),
        ("no/a.svg", FileNotFoundError, r"a\.svg: there is no folder .*; "), ("pipe.svg", ValueError, r"pipe\.svg: is not a regular"),
        ("a.dfx", ValueError, r"a\.dfx: no format 'dfx'; there are .*pdf, .*svg"),
        ("a", ValueError, "no format ''; there are .*pdf, .*svg"),
        ("new.svg", ValueError, r"new\.svg: is named twice; "),
    ):  # fmt: skip
        with pytest.raises(error, match=says):
            formats.save(everything(), tmp_path / "new.svg", tmp_path / name, overwrite=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == before and (tmp_path / "there.svg").read_bytes() == b"older"


@pytest.fixture
def locked() -> Iterator[Path]:
    """A folder with an older drawing that we may not write to; the superuser becomes somebody else for the while."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        (path / "a.svg").write_bytes(b"older")
        path.chmod(0o555)
        root = os.geteuid() == 0
        if root:
            os.seteuid(65534)  # nobody
        yield path
        if root:
            os.seteuid(0)
        path.chmod(0o755)


def test_a_folder_that_may_not_be_written_to_is_refused(locked: Path) -> None:
    for name in ("a.svg", "b.svg"):
        with pytest.raises(PermissionError, match=name):
            formats.save(everything(), locked / name)
    assert [(path.name, path.read_bytes()) for path in locked.iterdir()] == [("a.svg", b"older")]


def test_litter_of_dead_processes_is_removed_and_work_of_live_ones_is_not(tmp_path: Path) -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    ours, theirs = (formats._mark(Path(name)) for name in ("a[1].svg", "b.svg"))
    litter = tmp_path / f"{ours}{dead.pid}.x1{formats.PART}"
    others = {
        f"{ours}{os.getpid()}.x2{formats.PART}",
        f"{theirs}{dead.pid}.x3{formats.PART}",
        f"a[1].svg.{dead.pid}{formats.PART}",
        "a1.svg",
    }
    for path in (litter, *(tmp_path / name for name in others)):
        path.touch()
    formats.save(everything(), tmp_path / "a[1].svg")
    assert {path.name for path in tmp_path.iterdir()} == others | {"a[1].svg"}


@pytest.mark.parametrize(
    "name", ["鴉" * 80 + ".svg", "a" * 251 + ".svg", "-.svg", "a b\n.svg"], ids=["80 letters of 3 bytes", "255", "dash", "odd"]
)
def test_a_name_that_the_disk_takes_is_taken(name: str, tmp_path: Path) -> None:
    formats.save(everything(), tmp_path / name)
    assert (tmp_path / name).read_bytes() == file("svg")


def test_a_replaced_file_keeps_its_mode_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    (tmp_path / "a.svg").touch(0o600)
    (tmp_path / "plain").touch()
    formats.save(everything(), tmp_path / "a.svg", tmp_path / "b.svg")
    assert [(tmp_path / name).stat().st_mode & 0o777 for name in ("a.svg", "b.svg")] == [0o600, (tmp_path / "plain").stat().st_mode & 0o777]


def test_a_suffix_names_the_format_beside_an_open_file_that_takes_another(tmp_path: Path) -> None:
    formats.save(everything(), tmp_path / "a.svg", buffer := io.BytesIO(), format="pdf")
    assert buffer.getvalue() == file("pdf") and (tmp_path / "a.svg").read_bytes() == file("svg")


def test_a_hole_goes_into_the_element_of_its_outline(monkeypatch):
    monkeypatch.setattr(_text, "POINTS", 6)
    square = np.array([(0, 0), (3, 0), (3, 3), (0, 3)])
    hole = np.array([(1, 1), (1, 2), (2, 2), (2, 1)])
    rings = Paths.of([np.add(ring, (4 * k, 0)) for k in range(5) for ring in (square, hole)])
    parts = list(_text.chunks(rings))
    assert len(parts) > 1
    assert all(part.areas.tolist() == [9, -1] * (len(part) // 2) for part in parts)
    assert np.array_equal(np.concatenate([part.xy for part in parts]), rings.xy)
    turned = Paths.of([ring[::-1] for ring in rings])
    assert all(part.areas.tolist() == [-9, 1] * (len(part) // 2) for part in _text.chunks(turned))
    monkeypatch.setattr(_text, "POINTS", 1000)
    assert len(list(_text.chunks(rings.take(np.arange(1, 10))))) == 1  # what is small is one, whatever comes first
