"""What a drawing takes of memory is told before it is drawn, and what there is not room for is refused in one line."""

from __future__ import annotations

import math
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from crowquill import expense, styles
from crowquill.__main__ import main
from crowquill.tone import Tone

QUICK = ("--paper", "60x50mm", "--margin", "5mm", "--iterations", "1")


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a picture, which is where we are, and a system that has all the memory there may be."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(80, 255, 80).astype(np.uint8), (60, 1))).save("ramp.png")
    return tmp_path


def group(folder: Path, most: str, used: int, cache: int = 0, names: tuple[str, str] = ("memory.max", "memory.current")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in zip((*names, "memory.stat"), (most, str(used), f"anon 5\ninactive_file {cache}\n"), strict=True):
        (folder / name).write_text(text + "\n")


def test_more_dots_than_memory_holds_are_refused_before_any_is_placed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(expense, "available", lambda: 200e6)
    assert main(["stipple", "ramp.png", "out.svg", *QUICK, "--dots", "1000000"]) == 2
    said = capsys.readouterr()
    assert said.err.startswith("crowquill: 1000000 dots on 80 x 60 pixels take about ") and said.err.count("\n") == 1 and not said.out
    assert "and 200 MB are free; draw fewer dots" in said.err and not Path("out.svg").exists()
    assert main(["stipple", "ramp.png", "out.svg", *QUICK, "--dots", "100"]) == 0


def test_a_picture_too_large_for_memory_is_refused_from_its_header(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(expense, "available", lambda: 5000.0)
    assert main(["stipple", "ramp.png", "out.svg", *QUICK]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ramp.png: 80 x 60 pixels take about 0.0096 MB of memory, and 0.005 MB are free; make it smaller, or")


def test_who_says_so_goes_on_whatever_is_free(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(expense, "_grouped", lambda: 0.0)
    assert main(["stipple", "ramp.png", "out.svg", *QUICK, "--quiet"]) == 2
    monkeypatch.setenv(expense.SETTING, "any")
    assert main(["stipple", "ramp.png", "out.svg", *QUICK, "--quiet"]) == 0


def test_a_limit_in_gigabytes_counts_what_is_held_already(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(expense.SETTING, "64")
    assert expense.available() == pytest.approx(64e9 - expense.held(), rel=1e-3)


def test_a_setting_that_means_nothing_is_refused(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(expense.SETTING, "lots")
    assert main(["stipple", "ramp.png", "out.svg", *QUICK]) == 2
    assert capsys.readouterr().err == "crowquill: CROWQUILL_MEMORY is 'lots'; it takes gigabytes, or any\n"


def test_a_dry_run_says_how_much_memory_it_would_take_and_refuses_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(expense, "available", lambda: 1e6)
    assert main(["stipple", "ramp.png", "out.svg", *QUICK, "--dots", "1500000", "--dry-run"]) == 0
    rows = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert rows["memory"].startswith("about ") and rows["memory"].endswith(" GB")


def test_a_group_s_limit_less_what_it_uses_but_for_old_files_is_left(tmp_path: Path):
    (tmp_path / "own").write_text("0::/a/b\n")
    group(tmp_path / "groups/a/b", "max", 100)
    assert expense._grouped(tmp_path / "groups", tmp_path / "own") == math.inf
    group(tmp_path / "groups/a", "1000", 700, cache=50)
    assert expense._grouped(tmp_path / "groups", tmp_path / "own") == 350
    group(tmp_path / "groups/a/b", "90", 60)
    assert expense._grouped(tmp_path / "groups", tmp_path / "own") == 30


def test_groups_of_the_first_kind_are_known_too(tmp_path: Path):
    (tmp_path / "own").write_text("9:name=systemd:/\n4:memory,cpu:/x\n")
    group(tmp_path / "groups/memory/x", "500", 120, names=("memory.limit_in_bytes", "memory.usage_in_bytes"))
    assert expense._grouped(tmp_path / "groups", tmp_path / "own") == 380
    assert expense._grouped(tmp_path / "groups", tmp_path / "none") == math.inf


def test_a_limit_on_addresses_is_kept_to_in_a_program_of_its_own():
    code = (
        "import resource, sys\n"
        "from crowquill.expense import PROCESS, _number\n"
        "from crowquill.__main__ import main\n"
        "main(['stipple', 'ramp.png', 'first.svg', '--paper', '60x50mm', '--iterations', '1', '--quiet'])\n"
        "now = int(_number(PROCESS / 'status', 'VmSize:'))\n"
        "resource.setrlimit(resource.RLIMIT_AS, (now + 300_000_000, resource.RLIM_INFINITY))\n"
        "sys.exit(main(['stipple', 'ramp.png', 'out.svg', '--paper', '60x50mm', '--dots', '1900000', '--quiet']))\n"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert told.returncode == 2 and told.stderr.startswith("crowquill: 1900000 dots on 80 x 60 pixels take about "), told.stderr
    assert told.stderr.count("\n") == 1 and not Path("out.svg").exists()
    assert resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY


def test_python_is_refused_too(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(expense, "available", lambda: 1e6)
    with pytest.raises(ValueError, match="50000 dots on 20 x 30 pixels take about"):
        styles.run(styles.steps("stipple", Tone(np.full((30, 20), 0.5), (40, 60)), dots=50_000))
