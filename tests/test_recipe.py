"""A recipe holds all that made a drawing, comes back from SVG, PDF and TOML the same, and refuses what it does not know."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import crowquill
from crowquill import formats
from crowquill.__main__ import main
from crowquill.recipe import Recipe, Source, parsed, read_toml

pytestmark = pytest.mark.usefixtures("desk")
QUICK = ["--paper", "60x50mm", "--margin", "5mm", "--dots", "60", "--iterations", "2", "--quiet"]
DOT = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M1 0C1 1 0 1 0 0C0 -1 1 -1 1 0Z"/></svg>'
KEEPING = [format for format in formats.names() if hasattr(formats.module(format, format), "recipe")]
FRAME = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"><path d="M5 5H35V25H5Z"/></svg>'


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder where we are: it has ramp.png, a library dot.svg and an outline frame.svg."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile(np.linspace(60, 255, 40).astype(np.uint8), (30, 1))).save("ramp.png")
    Path("dot.svg").write_text(DOT, encoding="utf-8")
    Path("frame.svg").write_text(FRAME, encoding="utf-8")
    return tmp_path


def run(*arguments: str) -> None:
    assert main([str(argument) for argument in arguments]) == 0


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line, line
    return line


SETTINGS: dict[str, Any] = {
    "paper": {"paper": "a5", "margin": 12.5, "width": 100.0, "check_bar": True},
    "tone": {"gamma": 1.2, "crop": (0.1, 0.0, 0.8, 1.0), "invert": True},
    "knobs": {"pen": 0.3, "iterations": 7},
    "files": {"embed": True},
    "sources": {"picture": Source('Möwe \'n "Ente".png', "0" * 64)},
}


def test_a_recipe_read_back_from_toml_and_json_is_the_same():
    made = Recipe("stipple", 3, **SETTINGS)
    assert read_toml(made.toml().encode(), "r.toml").data() == made.data()
    assert parsed(json.loads(json.dumps(made.data())), "r").data() == made.data()
    assert tomllib.loads(made.toml())["knobs"]["pen"] == 0.3


def test_what_is_not_said_in_a_toml_has_its_default():
    short = read_toml(b'style = "stipple"\n[knobs]\npen = "0.5mm"\n', "r.toml")
    assert short.data() == Recipe("stipple", knobs={"pen": 0.5}).data()


@pytest.mark.parametrize("kind", KEEPING)
def test_a_drawing_made_again_is_the_same_to_the_byte(desk: Path, kind: str):
    run("stipple", "ramp.png", f"a.{kind}", *QUICK, "--seed", "5", "--glyphs", "dot.svg", "--canvas", "frame.svg", "--check-bar")
    other = desk / "other" / "folder"
    other.mkdir(parents=True)
    for name in (f"a.{kind}", "ramp.png", "dot.svg", "frame.svg"):
        shutil.move(name, other)
    run("redo", other / f"a.{kind}", *(f"b.{format}" for format in KEEPING), "--quiet")
    kept = other / f"a.{kind}"
    assert (desk / f"b.{kind}").read_bytes() == kept.read_bytes()
    recipes = [formats.recipe_of(Path(f"b.{format}"))[0] for format in KEEPING]
    assert all(made == recipes[0] for made in recipes)


@pytest.mark.parametrize("kind", ["svg", "pdf"])
def test_a_drawing_with_its_sources_inside_needs_nothing_beside(desk: Path, kind: str):
    run("stipple", "ramp.png", "a.svg", "a.pdf", *QUICK, "--glyphs", "dot.svg", "--canvas", "frame.svg", "--embed")
    (desk / "far").mkdir()
    shutil.move(f"a.{kind}", "far/a." + kind)
    for name in ("ramp.png", "dot.svg", "frame.svg"):
        Path(name).unlink()
    run("redo", f"far/a.{kind}", f"b.{kind}", "--quiet")
    assert Path(f"b.{kind}").read_bytes() == Path(f"far/a.{kind}").read_bytes()
    assert sorted(formats.recipe_of(Path(f"b.{kind}"))[1]) == ["dot.svg", "frame.svg", "ramp.png"]


def test_a_picture_given_under_another_name_is_the_same_picture():
    run("stipple", "ramp.png", "a.svg", *QUICK)
    Path("ramp.png").rename("renamed.png")
    run("redo", "a.svg", "b.svg", "--picture", "renamed.png", "--quiet")
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes()


def test_a_recipe_printed_and_taken_gives_the_same_drawing(capsys: pytest.CaptureFixture[str]):
    run("stipple", "ramp.png", "a.svg", *QUICK, "--seed", "9", "--gamma", "1.5", "--crop", "0.1,0,0.8,1", "--glyphs", "dot.svg")
    capsys.readouterr()
    run("recipe", "a.svg")
    Path("r.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    run("stipple", "ramp.png", "b.svg", "--recipe", "r.toml", "--quiet")
    run("redo", "r.toml", "c.svg", "--quiet")
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes() == Path("c.svg").read_bytes()
    run("stipple", "ramp.png", "d.svg", "--recipe", "r.toml", "--quiet", "--dots", "30")
    assert len(crowquill.load("d.svg").marks) == 30, "an option typed goes before the recipe"


def test_a_recipe_taken_for_another_picture_says_so(capsys: pytest.CaptureFixture[str]):
    run("stipple", "ramp.png", "a.svg", *QUICK)
    run("recipe", "a.svg")
    Path("r.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    shutil.copy("ramp.png", "other.png")
    run("stipple", "other.png", "b.svg", "--recipe", "r.toml", "--quiet")
    assert "note: r.toml was made for ramp.png" in capsys.readouterr().err


def test_what_is_typed_takes_the_place_of_what_a_recipe_has(capsys: pytest.CaptureFixture[str]):
    run("stipple", "ramp.png", "a.svg", "a.png", *QUICK, "--invert", "--dpi", "100", "--separate")
    capsys.readouterr()
    run("recipe", "a.svg")
    Path("r.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    run("stipple", "ramp.png", "b.pdf", "--recipe", "r.toml", "--quiet", "--no-invert", "--sizes", "2mm,3mm")
    made, _ = formats.recipe_of(Path("b.pdf"))
    assert made["tone"]["invert"] is False and made["knobs"]["sizes"] == [2.0, 3.0] and "dots" not in made["knobs"]
    assert "separate" in refused(capsys, "stipple", "ramp.png", "b.pdf", "--recipe", "r.toml", "--separate")


def test_redo_finds_every_source_that_is_given():
    run("stipple", "ramp.png", "a.svg", *QUICK, "--glyphs", "dot.svg", "--canvas", "frame.svg", "--importance", "ramp.png")
    for name in ("dot.svg", "frame.svg", "ramp.png"):
        Path(name).rename(f"other-{name}")
    given = ["--picture", "other-ramp.png", "--importance", "other-ramp.png", "--glyphs", "other-dot.svg", "--canvas", "other-frame.svg"]
    run("redo", "a.svg", "b.svg", "--quiet", *given)
    assert Path("b.svg").read_bytes() == Path("a.svg").read_bytes()


def test_a_picture_that_is_its_own_map_is_embedded_once():
    run("stipple", "ramp.png", "a.svg", *QUICK, "--importance", "ramp.png", "--embed")
    assert list(formats.recipe_of(Path("a.svg"))[1]) == ["ramp.png"]


def test_a_hand_written_recipe_takes_the_picture_given():
    Path("r.toml").write_text("style = 'stipple'\n[knobs]\ndots = 20\niterations = 1\n", encoding="utf-8")
    run("redo", "r.toml", "a.svg", "--picture", "ramp.png", "--quiet")
    assert len(crowquill.load("a.svg").marks) == 20


def test_what_cannot_be_written_is_refused_before_the_work(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.setattr("crowquill.relax.scatter", lambda *_: pytest.fail("the work had begun"))
    many = ["--dots", "30000", "--paper", "a4"]
    assert "separate" in refused(capsys, "stipple", "ramp.png", "a.svg", *many, "--separate")
    assert "dpi" in refused(capsys, "stipple", "ramp.png", "a.png", "--paper", "1900x2000mm", "--dots", "9", "--dpi", "2400")


def test_from_python_a_drawing_is_made_again_too():
    run("stipple", "ramp.png", "a.svg", *QUICK)
    assert crowquill.to_bytes(crowquill.redo("a.svg"), "svg") == Path("a.svg").read_bytes()


def test_a_drawing_edited_since_can_be_made_anew():
    run("stipple", "ramp.png", "a.svg", *QUICK)
    data = Path("a.svg").read_bytes()
    Path("edited.svg").write_bytes(data.replace(b'fill="#000000"', b'fill="#ff0000"'))
    run("redo", "edited.svg", "b.svg", "--quiet")
    assert Path("b.svg").read_bytes() == data


def test_what_only_another_format_takes_is_kept_for_it():
    run("stipple", "ramp.png", "a.svg", *QUICK, "--separate")
    run("redo", "a.svg", "b.pdf", "b.svg", "--quiet")
    assert Path("b.svg").read_bytes() == Path("a.svg").read_bytes()
    run("redo", "b.pdf", "c.svg", "--quiet")
    assert Path("c.svg").read_bytes() == Path("a.svg").read_bytes()


def test_files_hold_no_folder_no_user_and_no_time(desk: Path):
    run("stipple", str(desk / "ramp.png"), "a.svg", "a.pdf", *QUICK, "--glyphs", str(desk / "dot.svg"), "--embed")
    for name in ("a.svg", "a.pdf"):
        assert str(desk).encode() not in Path(name).read_bytes()
    data, _ = formats.recipe_of(Path("a.pdf"))
    assert data["sources"]["picture"]["name"] == "ramp.png" and data["knobs"]["glyphs"] == "dot.svg"


def test_a_picture_that_is_missing_or_another_is_refused(capsys: pytest.CaptureFixture[str]):
    run("stipple", "ramp.png", "a.svg", *QUICK)
    Image.new("L", (40, 30), 9).save("ramp.png")
    assert "SHA-256" in refused(capsys, "redo", "a.svg", "b.svg")
    Path("ramp.png").unlink()
    assert "--picture" in refused(capsys, "redo", "a.svg", "b.svg") and not Path("b.svg").exists()


def test_a_drawing_from_an_array_says_who_can_draw_it_again(capsys: pytest.CaptureFixture[str]):
    tone = crowquill.Tone(np.full((3, 4), 0.5), (20, 15))
    crowquill.save(crowquill.draw("stipple", tone, dots=9), "a.svg", "a.pdf")
    for name in ("a.svg", "a.pdf"):
        assert "names no picture" in refused(capsys, "redo", name, "b.svg")


def test_a_bitmap_alone_keeps_no_picture_and_says_so(capsys: pytest.CaptureFixture[str]):
    assert "--embed" in refused(capsys, "stipple", "ramp.png", "a.png", *QUICK, "--embed")
    run("stipple", "ramp.png", "a.png", "a.svg", *QUICK, "--embed")


def test_two_sources_of_one_name_are_not_both_embedded(capsys: pytest.CaptureFixture[str]):
    Path("one").mkdir()
    shutil.copy("dot.svg", "one/frame.svg")
    assert "rename one" in refused(
        capsys, "stipple", "ramp.png", "a.svg", *QUICK, "--canvas", "frame.svg", "--glyphs", "one/frame.svg", "--embed"
    )
