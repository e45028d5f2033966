"""The command that learns a style from a scan: one file, whole or not at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from crowquill import exemplar
from crowquill.__main__ import main


@pytest.mark.soak
def test_learning_a_shipped_example_again_gives_its_file(tmp_path, capsys):
    out = tmp_path / "mine.style"
    assert main(["learn", str(exemplar.FOLDER / "even.png"), str(out)]) == 0
    assert out.read_bytes() == (exemplar.FOLDER / "even.style").read_bytes()
    assert "300 marks, 300 white ones" in capsys.readouterr().out


def test_what_teaches_nothing_is_refused_in_one_line_and_writes_nothing(tmp_path, capsys):
    scan, out = tmp_path / "white.png", tmp_path / "mine.style"
    Image.fromarray(np.full((400, 400), 250, np.uint8)).save(scan, dpi=(600, 600))
    assert main(["learn", str(scan), str(out)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"crowquill: {scan}: ") and said.count("\n") == 1
    assert sorted(path.name for path in Path(tmp_path).iterdir()) == ["white.png"]


def test_a_scan_is_not_written_over(tmp_path, capsys):
    scan = tmp_path / "scan.png"
    Image.fromarray(np.full((40, 40), 250, np.uint8)).save(scan, dpi=(600, 600))
    before = scan.read_bytes()
    assert main(["learn", str(scan), str(scan)]) == 2
    assert "written over" in capsys.readouterr().err and scan.read_bytes() == before


def test_a_style_that_is_there_is_kept_where_it_shall_be(tmp_path, capsys):
    (tmp_path / "mine.style").write_text("older")
    assert main(["learn", str(exemplar.FOLDER / "even.png"), str(tmp_path / "mine.style"), "--no-overwrite"]) == 2
    assert "is there already" in capsys.readouterr().err and (tmp_path / "mine.style").read_text() == "older"
