"""The command that learns a style from a scan: one file, whole or not at all."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from PIL import Image

from crowquill import Tone, draw, exemplar
from crowquill.__main__ import main
from crowquill.exemplar import learning
from crowquill.raster import covered

PIXEL = 25.4 / 600  # mm


@pytest.mark.soak
def test_learning_a_shipped_example_again_gives_its_file(tmp_path, capsys):
    out = tmp_path / "mine.style"
    assert main(["learn", str(exemplar.FOLDER / "even.png"), str(out)]) == 0
    assert out.read_bytes() == (exemplar.FOLDER / "even.style").read_bytes()
    assert "300 marks, 300 white ones" in capsys.readouterr().out


@cache
def page(*coverages: float) -> np.ndarray:
    """A scan at 600 dpi of patches of 14 mm, code values 0 to 255."""
    side = round(18 / PIXEL)
    parts = []
    for coverage in coverages:
        marks = draw("stipple", Tone(np.full((4, 4), coverage), (14, 14)), pen=0.35).marks.moved((2, 2))
        parts.append(covered(marks, (side, side), pixel=(PIXEL, PIXEL)))
    return np.round(230 - 200 * np.concatenate(parts, axis=1)).astype(np.uint8)


def giant() -> np.ndarray:
    y, x = np.indices((600, 600)) - 300
    return np.where(np.hypot(x, y) < 200, 20, 235).astype(np.uint8)


BAD = {
    "a single tone": (lambda: page(0.2), (600, 600), "has one tone at most; give an example with patches of light and dark"),
    "no dots": (lambda: np.full((400, 400), 250, np.uint8), (600, 600), "no dots; scan dark ink on light paper"),
    "one giant dot": (giant, (600, 600), "no dots of a pen (1 giant); give an example in whose lights dots stand apart"),
    "a colour cast": (
        lambda: page(0.2)[..., None] * np.array([1, 0.72, 0.45]),
        (600, 600),
        "colour cast, its paper is 230, 165, 103",
    ),
    "72 dpi": (lambda: page(0.2), (72, 72), "72 dpi"),
    "no tag": (lambda: page(0.2), None, "not known"),
}


@pytest.mark.parametrize("command", ["learn", "byexample"])
@pytest.mark.parametrize(("scan", "dpi", "said"), BAD.values(), ids=BAD)
def test_an_example_that_teaches_nothing_is_refused_in_a_line_that_says_what_to_do(command, scan, dpi, said, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Image.fromarray(scan().astype(np.uint8)).save("scan.png", **({"dpi": dpi} if dpi else {}))
    Image.fromarray(np.full((40, 40), 128, np.uint8)).save("picture.png")
    typed = ["scan.png", "out.style"] if command == "learn" else ["picture.png", "out.svg", "--example", "scan.png"]
    assert main([command, *typed]) == 2
    told = capsys.readouterr().err
    assert told.startswith("crowquill: scan.png: ") and told.count("\n") == 1 and said in told and "; " in told
    assert " --dpi" not in told and (dpi == (600, 600) or "--example-dpi" in told)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["picture.png", "scan.png"]


def test_old_yellow_paper_is_no_cast(tmp_path):
    Image.fromarray((page(0.2)[..., None] * np.array([1, 0.93, 0.76])).astype(np.uint8)).save(tmp_path / "scan.png", dpi=(600, 600))
    with pytest.raises(ValueError, match="has one tone at most"):
        learning.learn(tmp_path / "scan.png")


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
