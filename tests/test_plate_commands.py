"""The command plate, and redo of plates: an example that works, the same bytes anywhere, and all that other commands promise."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pikepdf
import pytest
from PIL import Image

import crowquill
from crowquill import formats, plate
from crowquill.__main__ import main

SPECIMEN = Path(__file__).parent.parent / "gallery" / "specimen.png"
LATER = 'at = ["100 mm", "20 mm"]'  # in the example
PLATE = """
seed = 3
[page]
journal = "amnh"
columns = 1
margin = 0
caption = "*Ramphus grisea*: two ramps"
[grid]
columns = 2
[inks.sky]
cmyk = [0.6, 0.1, 0, 0]
[[panel]]
picture = "ramp.png"
pixel = "20 um"
knobs = { dots = 60, iterations = 2 }
[[panel]]
recipe = "inner/own.toml"
ink = "sky"
"""
OWN = 'style = "stipple"\nseed = 5\n[sources.picture]\nname = "dark.png"\n[knobs]\ndots = 40\niterations = 2\n'


class Told(NamedTuple):
    """What a run said, and its exit code."""

    code: int
    out: str
    err: str


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a plate of two panels, one of them a recipe's in a folder of its own, which is where we are."""
    folder = tmp_path / "desk"
    (folder / "inner").mkdir(parents=True)
    monkeypatch.chdir(folder)
    ramp = np.tile(np.linspace(120, 255, 40).astype(np.uint8), (30, 1))
    Image.fromarray(ramp).save("ramp.png")
    Image.fromarray(ramp // 2).save("inner/dark.png")
    Path("inner/own.toml").write_text(OWN)
    Path("plate.toml").write_text(PLATE)
    return folder


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]):
    def ran(*arguments: str) -> Told:
        capsys.readouterr()
        return Told(main(list(arguments)), *capsys.readouterr())

    return ran


def specimen(name: str) -> None:
    """The gallery's ammonite, a sixth as wide."""
    with Image.open(SPECIMEN) as image:
        Image.fromarray(np.asarray(image)[::6, ::6]).save(name)


def here() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def test_a_plate_is_drawn_into_every_format_that_prints(run):
    told = run("plate", "plate.toml", "out.svg", "out.pdf", "out.png", "out.tiff", "--dpi", "150")
    assert told.code == 0
    assert "100 marks, 70 x 24.75 mm on 70 x " in told.out
    assert [path.suffix for path in sorted(Path().glob("out.*"))] == [".pdf", ".png", ".svg", ".tiff"]
    sheet = crowquill.load("out.svg")
    assert {"A stipple", "B stipple", "A letter", "A scale bar", "caption italic"} <= {layer.name for layer in sheet.layers}


def test_the_example_works_as_it_is_with_a_picture_beside_it(run, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    specimen("specimen.png")
    assert run("plate", "--init").out == "plate.toml: draws specimen.png; crowquill plate plate.toml plate.pdf\n"
    told = run("plate", "plate.toml", "plate.pdf", "plate.svg")
    assert (told.code, told.err) == (0, "")
    assert crowquill.load("plate.svg").size[0] == 174
    with pikepdf.open("plate.pdf") as pdf:
        assert float(pdf.pages[0].MediaBox[2]) * 25.4 / 72 == pytest.approx(174, abs=1e-3)


def test_every_line_of_the_example_that_is_left_out_works_too(run, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    specimen("specimen.png")
    (fonts,) = {crowquill.lettering.file("bold").parent}
    for name, font in (("MyFont.ttf", "Vera.ttf"), ("MyFont-Italic.ttf", "VeraIt.ttf"), ("MyFont-Bold.ttf", "VeraBd.ttf")):
        shutil.copy(fonts / font, name)
    Path("map.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="3mm"><rect width="9mm" height="3mm"/></svg>')
    assert run("plate", "--init", "mine.toml").code == 0
    lines = Path("mine.toml").read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if line == "[page]")
    off = [line.removeprefix("# ") if line.startswith("# ") and ("=" in line or line.startswith("# [")) else line for line in lines[head:]]
    at = next(k for k, line in enumerate(off) if line.startswith("height"))
    off[at] = 'height = "160 mm"'
    Path("mine.toml").write_text("\n".join(off).replace('pen = "0.4 mm"', "dots = 90").replace(LATER, "at = [105, 120]"))
    told = run("plate", "mine.toml", "out.svg")
    assert told.code == 0, told.err
    names = {layer.name for layer in crowquill.load("out.svg").layers}
    assert {"A stipple", "b1 caption", "B black"} <= names


def test_init_never_overwrites_and_names_a_picture_where_there_is_none(run, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert run("plate", "--init", "new.toml").out.startswith("new.toml: draws picture.png; ")
    kept = Path("new.toml").read_bytes()
    told = run("plate", "--init", "new.toml")
    assert told.code == 2 and "is there already" in told.err and Path("new.toml").read_bytes() == kept


def test_nothing_but_a_plate_or_files_to_write_is_refused(run):
    assert run("plate", "plate.toml").err.startswith("crowquill: give a plate and the files to write; ")
    assert run("plate", "--init", "a.toml", "b.svg").code == 2


@pytest.mark.parametrize("suffix", ["svg", "pdf", "png"])
def test_redo_gives_the_same_bytes(run, suffix):
    assert run("plate", "plate.toml", f"out.{suffix}").code == 0
    assert run("redo", f"out.{suffix}", f"again.{suffix}").code == 0
    assert Path(f"again.{suffix}").read_bytes() == Path(f"out.{suffix}").read_bytes()


def test_redo_finds_the_files_in_a_folder_it_is_given(run, tmp_path):
    run("plate", "plate.toml", "../out.svg")
    told = run("redo", "../out.svg", "again.svg")
    assert told.code == 2 and "there is no file 'ramp.png' in the plate's folder; check the name" in told.err
    assert run("redo", "../out.svg", "again.svg", "--folder", ".").code == 0
    assert Path("again.svg").read_bytes() == (tmp_path / "out.svg").read_bytes()


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
def test_redo_of_a_plate_with_its_pictures_inside_needs_no_other_file(run, suffix, tmp_path):
    assert run("plate", "plate.toml", f"../out.{suffix}", "--embed").code == 0
    shutil.rmtree("inner")
    assert run("redo", f"../out.{suffix}", f"again.{suffix}").code == 0
    assert Path(f"again.{suffix}").read_bytes() == (tmp_path / f"out.{suffix}").read_bytes()


def test_redo_refuses_a_picture_that_is_another(run):
    run("plate", "plate.toml", "out.svg")
    Image.new("L", (40, 30), 9).save("inner/dark.png")
    told = run("redo", "out.svg", "again.svg")
    assert told.code == 2 and "its SHA-256 differs" in told.err and not Path("again.svg").exists()


def test_redo_takes_no_single_picture_for_a_plate(run):
    run("plate", "plate.toml", "out.svg")
    assert "--picture is for drawings of one picture" in run("redo", "out.svg", "again.svg", "--picture", "ramp.png").err


def test_the_recipe_in_the_file_is_a_plate_again_as_toml(run):
    run("plate", "plate.toml", "out.svg")
    found = plate.kept(Path("out.svg"))
    assert found is not None
    data = found[0]
    assert set(data["sources"]) == {"ramp.png", "inner/own.toml", "inner/dark.png"}
    Path("printed.toml").write_text(plate.toml(data))
    for arguments in (("plate", "printed.toml", "b.svg"), ("redo", "printed.toml", "c.svg")):
        assert run(*arguments).code == 0
        assert Path(arguments[-1]).read_bytes() == Path("out.svg").read_bytes()


def test_python_draws_the_same_from_a_file_or_a_table_and_redoes_it(run):
    import tomllib

    run("plate", "plate.toml", "out.svg")
    whole = Path("out.svg").read_bytes()
    for sheet in (plate.drawn("plate.toml"), plate.drawn(tomllib.loads(PLATE)), plate.redo("out.svg")):
        assert formats.to_bytes(sheet, "svg") == whole
    with pytest.raises(ValueError, match=r"plate.toml: keeps no plate; "):
        plate.redo("plate.toml")


def test_another_folder_time_zone_and_hash_seed_give_the_same_bytes(run, desk, tmp_path):
    run("plate", "plate.toml", "out.pdf", "out.svg")
    other = tmp_path / "öther place"
    shutil.copytree(desk, other)
    more = {"TZ": "Asia/Kolkata", "PYTHONHASHSEED": "7", "LC_ALL": "C"}
    command = [sys.executable, "-m", "crowquill", "plate", str(other / "plate.toml"), str(other / "b.pdf"), str(other / "b.svg")]
    subprocess.run(command, check=True, cwd=tmp_path, env={**os.environ, **more}, capture_output=True)
    for suffix in ("pdf", "svg"):
        assert (other / f"b.{suffix}").read_bytes() == Path(f"out.{suffix}").read_bytes()
        assert str(tmp_path).encode() not in Path(f"out.{suffix}").read_bytes()


def test_knobs_of_formats_are_options_and_kept_for_redo(run):
    run("plate", "plate.toml", "plain.pdf")
    assert run("plate", "plate.toml", "out.pdf", "--compact").code == 0
    assert Path("plain.pdf").read_bytes() != Path("out.pdf").read_bytes()
    assert run("redo", "out.pdf", "again.pdf").code == 0
    assert Path("again.pdf").read_bytes() == Path("out.pdf").read_bytes()
    told = run("plate", "plate.toml", "new.svg", "--compact")
    assert told.code == 2 and "none of the formats written has knob 'compact'" in told.err and not Path("new.svg").exists()


def test_the_plates_of_its_inks_are_written_too(run):
    told = run("plate", "plate.toml", "out.pdf", "--plates", ".")
    assert told.code == 0, told.err
    assert {name.lower() for name in here() if name.startswith("out-")} == {"out-black.pdf", "out-cyan.pdf", "out-magenta.pdf"}


def test_a_report_says_what_each_panel_is(run):
    told = run("plate", "plate.toml", "out.svg", "--report", "-")
    report = json.loads(told.out)
    assert [each["panel"] for each in report["panels"]] == ["A", "B"]
    assert report["marks"] == sum(layer["marks"] for each in report["panels"] for layer in each["layers"]) == 100
    assert report["panels"][0]["scale"] == pytest.approx(33 / 40 / 0.02)  # 33 mm for 40 pixels of 20 um
    assert report["files"] == ["out.svg"] and report["seconds"]["total"] >= 0


def test_a_dry_run_says_what_will_be_and_writes_nothing(run):
    before = here()
    told = run("plate", "plate.toml", "out.svg", "--dry-run")
    assert told.code == 0 and here() == before
    assert "A      stipple, 33 x 24.75 mm at 0, 0, 60 dots" in told.out


@pytest.mark.parametrize(("out", "code"), [(["o.pdf"], 2), (["o.svg", "--plates", "."], 2), (["o.svg"], 0), (["o.PDF", "--dry-run"], 2)])
def test_letters_that_a_pdf_lacks_are_refused_before_the_work(run, monkeypatch, out, code):
    Path("plate.toml").write_text(PLATE + 'letter = "β"\n')
    if code:
        monkeypatch.setattr("crowquill.plate.steps", None)  # nothing is drawn
    before = here()
    told = run("plate", "plate.toml", *out)
    assert told.code == code and "panel 2: letter: font bold has no β (U+03B2)" in told.err
    assert not code or (told.err.startswith("crowquill: plate.toml: panel 2: ") and told.err.count("\n") == 1)
    assert (here() == before) == bool(code)


def test_a_plate_of_ready_drawings_says_nothing_of_ink(run):
    Path("map.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="3mm"><rect width="9mm" height="3mm"/></svg>')
    Path("ready.toml").write_text('[page]\nwidth = 20\n[[panel]]\ndrawing = "map.svg"\nletter = ""\n')
    told = run("plate", "ready.toml", "ready.svg").out
    assert told.startswith("1 marks, 9 x 3 mm on 20 x 4 mm, ") and "ink" not in told


def test_what_is_there_is_replaced_only_where_it_may_be(run):
    Path("out.svg").write_text("older")
    assert run("plate", "plate.toml", "out.svg", "--no-overwrite").code == 2
    assert Path("out.svg").read_text() == "older"
    for source in ("plate.toml", "ramp.png", "inner/dark.png"):
        told = run("plate", "plate.toml", source if source.endswith("png") else "out.svg", source)
        assert told.code == 2, source
    assert run("plate", "plate.toml", "out.hpgl").err.startswith("crowquill: out.hpgl: takes strokes only, and a plate is for print; ")


def test_an_interrupt_within_a_panel_leaves_nothing(run, monkeypatch):
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("crowquill.relax.lloyd", stopped)
    before = here()
    told = run("plate", "plate.toml", "out.svg")
    assert told.code == 130 and here() == before


def test_steps_say_panel_and_stage():
    stages = []
    plate.drawn("plate.toml", watch=lambda step: stages.append(step.stage))
    assert {stage.split()[0] for stage in stages} == {"A", "B"}
    assert stages == sorted(stages, key=lambda stage: stage[0])


def test_a_plate_printed_as_toml_draws_the_same_again(run):
    assert run("plate", "plate.toml", "out.svg").code == 0
    told = run("recipe", "out.svg")
    assert told.code == 0
    Path("again.toml").write_text(told.out, encoding="utf-8")
    assert run("plate", "again.toml", "again.svg").code == 0
    assert Path("again.svg").read_bytes() == Path("out.svg").read_bytes()


def test_a_plate_is_no_recipe_of_a_style(run):
    assert run("plate", "plate.toml", "out.svg").code == 0
    Path("again.toml").write_text(run("recipe", "out.svg").out, encoding="utf-8")
    assert "is a plate of several drawings; use crowquill plate" in run("stipple", "ramp.png", "x.svg", "--recipe", "again.toml").err
