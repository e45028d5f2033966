"""The command line from picture to files, in this process: what is drawn is read back and measured in mm."""

from __future__ import annotations

import io
import json
import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from PIL import Image

import crowquill
from crowquill import commands
from crowquill.__main__ import main
from crowquill.paths import Paths

UM = 1e-3 * (1 + 1e-6)  # mm: lengths are written in whole micrometres
FIELDS = {
    "style", "version", "seed", "paper_mm", "art_mm", "marks", "ink_asked_mm2", "ink_placed_mm2", "coverage_missing",
    "iterations", "energy", "movement", "seconds", "files", "warnings",
}  # fmt: skip
QUICK = ("--paper", "60x50mm", "--margin", "5mm", "--tone", "grey", "--dots", "80", "--iterations", "2")


class Told(NamedTuple):
    """What a run said, and its exit code."""

    code: int
    out: str
    err: str


Run = Callable[..., Told]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """crowquill stipple with these arguments, in a folder that has ramp.png of 40 x 30 pixels, dark at the left."""
    monkeypatch.chdir(tmp_path)
    picture(np.tile(np.linspace(120, 255, 40), (30, 1)), "ramp.png")

    def ran(*arguments: str) -> Told:
        capsys.readouterr()
        code = main(["stipple", *arguments])
        return Told(code, *capsys.readouterr())

    return ran


def picture(grey: Any, name: str) -> str:
    """A file of code values, 0 to 255."""
    Image.fromarray(np.asarray(grey, np.uint8)).save(name)
    return name


def here() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def drawn(run: Run, *arguments: str, out: str = "out.svg") -> crowquill.Sheet:
    """The sheet of a run that must do well."""
    told = run(arguments[0], out, *arguments[1:])
    assert told.code == 0, told.err
    return crowquill.load(out)


def art(sheet: crowquill.Sheet) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Where the drawing lies on its paper, and its size, mm."""
    return np.array(sheet.recipe["art_at_mm"]), np.array(sheet.recipe["art_mm"])


def reported(run: Run, *arguments: str) -> dict[str, Any]:
    told = run(*arguments, "--report", "-")
    assert told.code == 0, told.err
    found: dict[str, Any] = json.loads(told.out)
    return found


def test_an_ordinary_run_says_in_one_line_what_it_drew(run):
    told = run("ramp.png", "out.svg", *QUICK)
    assert told.code == 0 and not told.err
    assert told.out.count("\n") == 1 and "80 marks" in told.out and "50 x 37.5 mm on 60 x 50 mm" in told.out and "out.svg" in told.out
    assert len(crowquill.load("out.svg").marks) == 80


def test_a_white_picture_gives_an_empty_sheet_and_says_so(run):
    told = run(picture(np.full((30, 40), 255), "white.png"), "out.svg", "out.pdf", *QUICK)
    assert told.code == 0 and told.err.startswith("crowquill: note: no ink")
    sheet = crowquill.load("out.svg")
    assert len(sheet.marks) == 0 and sheet.size == (60, 50)
    assert Path("out.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("dots", [1, 2, 3])
def test_a_few_dots_are_as_many_as_asked_and_in_the_art(run, dots):
    sheet = drawn(run, "ramp.png", *QUICK, "--dots", str(dots))
    corner, size = art(sheet)
    assert len(sheet.marks) == dots
    assert ((sheet.marks.xy >= corner) & (sheet.marks.xy <= corner + size)).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1)])
def test_a_picture_of_few_pixels_is_drawn(run, shape):
    assert len(drawn(run, picture(np.zeros(shape), "few.png"), *QUICK, "--dots", "9").marks) == 9


def test_every_out_is_written_and_holds_the_same_drawing(run):
    told = run("ramp.png", "a.svg", "b.SVG", "c.pdf", "d.svg", *QUICK)
    assert told.code == 0 and all(name in told.out for name in ("a.svg", "b.SVG", "c.pdf", "d.svg"))
    assert Path("a.svg").read_bytes() == Path("b.SVG").read_bytes() == Path("d.svg").read_bytes()
    assert Path("c.pdf").stat().st_size > 500  # bytes: a page with something on it


def test_the_report_has_its_fields_on_paper_and_on_the_screen(run):
    assert run("ramp.png", "out.svg", "out.pdf", *QUICK, "--seed", "7", "--report", "report.json").code == 0
    report = json.loads(Path("report.json").read_text(encoding="utf-8"))
    assert set(report) >= FIELDS
    assert (report["style"], report["seed"], report["marks"], report["iterations"]) == ("stipple", 7, 80, 2)
    assert (report["paper_mm"], report["art_mm"], report["files"]) == ([60, 50], [50, 37.5], ["out.svg", "out.pdf"])
    assert report["warnings"] == []
    assert report["coverage_missing"] == max(0, 1 - report["ink_placed_mm2"] / report["ink_asked_mm2"])
    assert {"write", "total"} <= set(report["seconds"]) and min(report["seconds"].values()) >= 0
    screen = reported(run, "ramp.png", "out.svg", "out.pdf", *QUICK, "--seed", "7")
    assert {**screen, "seconds": 0} == {**report, "seconds": 0}


def test_a_report_on_the_screen_is_all_that_is_said(run):
    told = run("ramp.png", "out.svg", *QUICK, "--report", "-")
    assert json.loads(told.out)["marks"] == 80 and not told.err and not Path("-").exists()


def test_a_dry_run_says_size_dots_and_time_and_writes_nothing(run):
    told = run("ramp.png", "out.svg", "--report", "report.json", *QUICK, "--dry-run")
    assert told.code == 0 and not told.err and here() == ["ramp.png"]
    rows = dict(line.split(maxsplit=1) for line in told.out.splitlines())
    assert rows["paper"] == "60 x 50 mm" and rows["art"] == "50 x 37.5 mm" and rows["dots"] == "80"
    assert float(rows["time"].split()[1]) >= 0 and rows["time"].endswith(" s")


def test_a_quiet_run_says_nothing(run):
    assert run("ramp.png", "out.svg", *QUICK, "--quiet") == Told(0, "", "")


def test_a_check_bar_of_ten_millimetres_lies_in_the_margin(run):
    plain = drawn(run, "ramp.png", *QUICK)
    sheet = drawn(run, "ramp.png", *QUICK, "--check-bar")
    extra = [layer for layer in sheet.layers if isinstance(layer.art, Paths)]
    assert len(sheet.layers) == len(plain.layers) + 1 and len(extra) == 1 and "10 mm" in extra[0].label
    low, high = extra[0].art.xy.min(axis=0), extra[0].art.xy.max(axis=0)
    assert high[0] - low[0] == pytest.approx(10, abs=UM)
    corner, size = art(sheet)
    assert (low > 0).all() and (high < sheet.size).all() and low[1] > corner[1] + size[1]


PLACED = [
    ("--paper a5", (210, 148), (157.333, 118), "auto turns A5 to suit a picture that is wider than high"),
    ("--paper a5 --orientation portrait", (148, 210), (118, 88.5), "held upright, 15 mm of white all round"),
    ("--paper a5 --orientation landscape", (210, 148), (157.333, 118), "lying"),
    ("--paper 148x210mm --margin 0mm", (148, 210), (148, 111), "a paper given by its sides is not turned; and no white at all"),
    ("--paper letter --orientation portrait", (215.9, 279.4), (185.9, 139.425), "in inches, and in mm all the same"),
    ("--paper 60x50mm --margin 5mm", (60, 50), (50, 37.5), "all the room"),
    ("--paper 60x50mm --margin 5mm --width 20mm", (60, 50), (20, 15), "width gives height"),
    ("--paper 60x50mm --margin 5mm --height 3cm", (60, 50), (40, 30), "height gives width"),
    ("--paper 60x50mm --margin 5mm --width 20mm --height 30mm", (60, 50), (20, 15), "both are a box"),
    ("--paper 60x50mm --margin 5mm --fit cover", (60, 50), (50, 40), "the room is covered"),
    ("--paper 60x50mm --margin 5mm --fit stretch", (60, 50), (50, 40), "the room is filled"),
    ("--paper 60x50mm --fit stretch --width 30mm --height 10mm", (60, 50), (30, 10), "stretched to both"),
    ("--paper 60x60mm --margin 5mm --crop 0,0,0.5,1", (60, 60), (33.333, 50), "cut to a half, which stands upright"),
]  # fmt: skip


@pytest.mark.parametrize(("options", "paper", "size", "story"), PLACED, ids=[row[-1] for row in PLACED])
def test_paper_and_art_are_as_large_as_asked_and_the_art_in_the_middle(run, options, paper, size, story):
    sheet = drawn(run, "ramp.png", *options.split(), "--dots", "200", "--iterations", "1")
    at, found = art(sheet)
    assert sheet.size == pytest.approx(paper, abs=1e-9), story
    assert found == pytest.approx(size, abs=UM)
    assert at == pytest.approx((np.array(paper) - found) / 2, abs=UM)
    low, high = sheet.marks.xy.min(axis=0), sheet.marks.xy.max(axis=0)
    assert (low >= at - UM).all() and (high <= at + found + UM).all()
    assert (high - low > 0.7 * found).all()  # 200 dots reach from side to side, if less far where the ramp is light


def test_cover_cuts_what_stands_over_and_stretch_keeps_it(run):
    sides = np.full((30, 40), 255)
    sides[:, [0, 1, 38, 39]] = 0
    name = picture(sides, "sides.png")
    options = ("--paper", "40x40mm", "--margin", "5mm", "--dots", "50", "--iterations", "1")
    assert "no ink" in run(name, "out.svg", *options, "--fit", "cover").err
    marks = drawn(run, name, *options, "--fit", "stretch").marks
    assert len(marks) == 50 and ((marks.xy[:, 0] < 6.5 + UM) | (marks.xy[:, 0] > 33.5 - UM)).all()  # 2 of 40 columns on 30 mm


def test_a_crop_draws_that_part_alone(run):
    half = np.full((30, 40), 255)
    half[:, :20] = 0
    name = picture(half, "half.png")
    assert "no ink" in run(name, "out.svg", *QUICK, "--crop", "0.5,0,0.5,1").err
    left = reported(run, name, "out.svg", *QUICK, "--crop", "0,0,0.5,1")
    assert left["ink_asked_mm2"] == pytest.approx(40 * 40 * 20 / 30)  # 40 mm high and two thirds as wide, all black


def test_a_canvas_is_laid_over_the_picture_and_keeps_the_dots_in(run):
    outline = '<rect x="100" y="30" width="50" height="60"/><circle cx="125" cy="60" r="10"/>'
    Path("outline.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="120mm" viewBox="0 0 200 120">{outline}</svg>', encoding="utf-8"
    )
    sheet = drawn(run, picture(np.zeros((30, 40)), "black.png"), *QUICK, "--canvas", "outline.svg", "--dots", "200")
    at, size = art(sheet)
    share = (sheet.marks.xy - at) / size
    assert len(sheet.marks) == 200
    assert (share >= (0.5 - 1e-4, 0.25 - 1e-4)).all() and (share <= (0.75 + 1e-4, 0.75 + 1e-4)).all()  # a micrometre of 50 mm is 2e-5
    hole = np.hypot(*((share - (0.625, 0.5)) * (200, 120)).T)
    assert hole.min() > 10 - 0.2  # the circle inside is a hole, flattened to a thousandth of 50 mm, four times as large on its page


@pytest.mark.parametrize(
    ("options", "coverage", "story"),
    [
        (("--tone", "grey"), 1 - 128 / 255, "by code value"),
        (("--tone", "linear"), 1 - ((128 / 255 + 0.055) / 1.055) ** 2.4, "by light: 21.6 % of it comes back"),
        (("--tone", "grey", "--invert"), 128 / 255, "light and dark swapped"),
        (("--tone", "grey", "--gamma", "2"), (1 - 128 / 255) ** 2, "coverage squared"),
        (("--tone", "grey", "--black-point", "0.25", "--white-point", "0.75"), (0.75 - 128 / 255) / 0.5, "between two points"),
        (("--tone", "grey", "--local-contrast", "1"), 1 - 128 / 255, "no detail, nothing to stress"),
    ],
)
def test_a_flat_grey_asks_for_the_ink_its_tone_says(run, options, coverage, story):
    report = reported(run, picture(np.full((30, 40), 128), "grey.png"), "out.svg", *QUICK, *options)
    assert report["ink_asked_mm2"] == pytest.approx(coverage * 50 * 37.5, rel=1e-9), story


def test_what_is_not_a_number_in_a_float_picture_is_white(run):
    values = np.repeat(np.float32([[0, 1]]), 20, axis=1).repeat(30, axis=0)
    values.view(np.uint32)[0, 0] = 0x7F800001  # a signalling one, at which processors complain
    Image.fromarray(values).save("float.tif")
    report = reported(run, "float.tif", "out.svg", *QUICK)
    assert report["ink_asked_mm2"] == pytest.approx(599 / 1200 * 50 * 37.5)


def test_the_limit_of_pixels_can_be_raised_and_lowered(run):
    assert run("ramp.png", "out.svg", *QUICK, "--max-pixels", "1199").code == 2
    assert run("ramp.png", "out.svg", *QUICK, "--max-pixels", "1200").code == 0


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(run):
    names = ("a.svg", "b.svg", "c.svg")
    for name, seed in zip(names, "112", strict=True):
        assert run("ramp.png", name, *QUICK, "--seed", seed).code == 0
    one, same, other = (Path(name).read_bytes() for name in names)
    assert one == same != other


def test_a_library_of_dots_is_taken_by_name_and_by_path(run):
    circle = drawn(run, "ramp.png", *QUICK, "--glyphs", "disc")
    assert len(circle.marks.glyphs) == 1
    dot = '<script>alert(1)</script><path d="M1 0C1 1 0 1 0 0C0 -1 1 -1 1 0Z" onclick="alert(2)"/>'
    Path("own.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{dot}</svg>', encoding="utf-8")
    own = drawn(run, "ramp.png", *QUICK, "--glyphs", "own.svg")
    assert len(own.marks.glyphs) == 1 and own.marks.scale.sum() == pytest.approx(circle.marks.scale.sum(), rel=1e-3)  # rounded each
    assert b"alert" not in Path("out.svg").read_bytes()


def test_a_librarys_own_pen_is_drawn_with_where_nothing_else_is_said(run):
    assert reported(run, "ramp.png", "out.svg", *QUICK[:-4], "--iterations", "1", "--glyphs", "nib-05")["pen_mm"] == 0.5
    told = run("ramp.png", "out.svg", *QUICK[:-4], "--iterations", "1", "--glyphs", "nib-05", "--pen", "1mm")
    assert "enlarged 2 times" in told.err


def test_letters_that_the_terminal_has_not_are_question_marks(run, monkeypatch):
    assert run("ramp.png", "out.svg", *QUICK, "--quiet").code == 0
    Path("ramp.png").rename("é.png")
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    assert main(["stipple", "é.png", "é.svg", *QUICK]) == 0
    assert stream.buffer.getvalue().rstrip().endswith(b"?.svg") and Path("é.svg").exists()


def test_a_new_file_has_the_usual_mode_and_an_older_one_keeps_its_own(run):
    mask = os.umask(0o027)
    try:
        assert run("ramp.png", "new.svg", *QUICK, "--no-overwrite").code == 0
        Path("old.svg").write_bytes(b"older")
        Path("old.svg").chmod(0o604)
        assert run("ramp.png", "old.svg", *QUICK).code == 0
    finally:
        os.umask(mask)
    assert stat.S_IMODE(Path("new.svg").stat().st_mode) == 0o640
    assert stat.S_IMODE(Path("old.svg").stat().st_mode) == 0o604
    assert Path("new.svg").read_bytes() == Path("old.svg").read_bytes()


NAMES = {
    "漢" * 83 + ".svg": "83 letters of three bytes",
    "x" * 251 + ".svg": "251 letters of one",
    "two\nlines.svg": "a line break",
    "it's 100 %.svg": "signs",
    "-[a]*?.svg": "an option, or a pattern",
    os.fsdecode(b"latin\xe9.svg"): "bytes that are not UTF-8",
}


@pytest.mark.parametrize("name", NAMES, ids=NAMES.values())
def test_any_name_a_folder_takes_is_written_and_leaves_nothing_beside(run, name):
    told = run(*QUICK, "--report", "report.json", "--", "ramp.png", name)
    assert told.code == 0, told.err
    assert here() == sorted(["ramp.png", "report.json", name])
    assert len(json.loads(Path("report.json").read_text(encoding="utf-8"))["files"]) == 1
    assert told.out.count("\n") == 1 and told.out[:-1].isprintable()


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("min_gap is 1000.0; it takes a number", "--min-gap is 1000.0; it takes a number"),
        ("pen is 99 mm; it takes less", "--pen is 99 mm; it takes less"),
        ("pen: length '3' has no unit; write 3mm", "--pen: length '3' has no unit; write 3mm"),
        ("dots are over the limit; raise max_dots", "dots are over the limit; raise --max-dots"),
        ("pen: not a picture; give another", "pen: not a picture; give another"),
        ("min_gap.png: not a picture", "min_gap.png: not a picture"),
        ("a/min_gap: not a picture", "a/min_gap: not a picture"),
        ("r.toml: min_gap is 1; it takes less", "r.toml: min_gap is 1; it takes less"),
    ],
)
def test_a_refusal_spells_options_as_they_are_typed_and_leaves_files_alone(message: str, said: str) -> None:
    assert commands.spelt(message, ["pen", "min_gap", "max_dots"]) == said
