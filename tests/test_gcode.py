"""G-code, read back as a machine reads it: every stroke in its place, dots with their dwell, pens changed; profiles checked."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawings import everything, strokes
from hypothesis import given
from hypothesis import strategies as st
from plotter import PAGE, Stroke, faults, gcode, scribble

from crowquill import formats
from crowquill.__main__ import main
from crowquill.formats.gcode import load, names
from crowquill.formats.gcode import parsed as profile_of
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

WIDTH, HEIGHT = PAGE
Words = dict[str, float]
SOUND = 'pen_down = ["M3 S90"]\npen_up = ["M5"]\nfeed_down = 1000\nfeed_up = 3000\ndecimals = 2\npen_change = ["M0"]\n'
LOWERED = {  # what puts the pen down or lifts it, by profile; written from the machines' manuals, not from the profiles
    "servo": lambda words: {3: True, 5: False}.get(words.get("M", -1)),
    "z": lambda words: words["Z"] <= 0 if "Z" in words else None,
    "marlin-servo": lambda words: words["S"] < 70 if words.get("M") == 280 else None,
}
PROFILES = pytest.mark.parametrize("profile", names())


def read(sheet: Sheet, profile: str) -> list[Stroke]:
    """The strokes that the machine of a profile of ours draws, y down."""
    drawn = gcode(formats.to_bytes(sheet, "gcode", profile=profile), LOWERED[profile], milliseconds="marlin" in profile)
    return [replace(stroke, places=[(x, sheet.size[1] - y) for x, y in stroke.places]) for stroke in drawn]


def own(folder: Path, more: str = "", base: str = SOUND) -> str:
    """The path of a profile: a sound one with lines more, which may replace its own."""
    keys = {line.split(" = ")[0] for line in more.splitlines()}
    kept = [line for line in base.splitlines() if line.split(" = ")[0] not in keys]
    path = folder / "own.toml"
    path.write_text("\n".join([*kept, more]), encoding="utf-8")
    return str(path)


@PROFILES
@pytest.mark.parametrize("seed", range(3))
def test_every_stroke_is_drawn_within_a_step_in_order(profile: str, seed: int):
    sheet = scribble(seed)
    drawn = read(sheet, profile)
    numbers = {1: 1, 2: 3, 3: 4}  # the second layer is empty, and asks for no pen
    assert faults([replace(stroke, pen=numbers[stroke.pen]) for stroke in drawn], sheet, 0.01) == []


@PROFILES
def test_the_comparison_sees_a_dot_moved_and_a_dot_lost(profile: str):
    sheet = scribble(names=("one",))
    drawn = read(sheet, profile)
    assert faults(drawn, sheet, 0.01) == [] and len(drawn[3].places) == 1
    x, y = drawn[3].places[0]
    assert faults([*drawn[:3], Stroke(1, [(x, y + 0.01)]), *drawn[4:]], sheet, 0.01)[0].startswith("stroke 3 strays")
    assert faults(drawn[:3] + drawn[4:], sheet, 0.01) == ["5 strokes for 6"]


@PROFILES
def test_a_dot_has_the_dwell_of_the_profile_and_lines_do_not(profile: str):
    drawn = read(scribble(names=("one",)), profile)
    settles = min(stroke.rest for stroke in drawn)
    rests = [stroke.rest - settles for stroke in drawn]
    wanted = [load(profile).machine.dwell * (len(stroke.places) == 1) for stroke in drawn]
    assert rests == pytest.approx(wanted) and sum(map(bool, wanted)) == 2


def test_dots_without_dwell_have_no_lines_of_their_own(tmp_path: Path):
    sheet = Sheet(PAGE, (Layer(Ink(pen=0.3), Paths.of([[(1, 39)]], closed=False)),))
    written = {
        dwell: formats.to_bytes(sheet, "gcode", profile=own(tmp_path, f'dwell = {dwell}\ndot = ["G4 P{{seconds}} S{{milliseconds}}"]'))
        for dwell in (0, 0.25)
    }
    assert written[0].splitlines()[-3:] == [b"G0 X1.00 Y1.00 F3000", b"M3 S90", b"M5"]
    assert written[0.25].splitlines()[-2] == b"G4 P0.25 S250"


def test_the_small_case_by_hand(tmp_path: Path):
    art = Paths.of([[(1, 2), (3, 4), (3, 4), (5, 6.5)]], closed=False)
    sheet = Sheet(PAGE, (Layer(Ink("red", pen=0.3), art), Layer(Ink(pen=0.3), art.take([])), Layer(Ink("blue", pen=0.3), art)))
    more = 'decimals = 1\nheader = ["G21"]\nfooter = ["M2"]\npen_change = ["T{pen} ({name})"]\ncomment = "()"\ninvert_y = false'
    stroke = "G0 X1.0 Y2.0 F3000\nM3 S90\nG1 X3.0 Y4.0 F1000\nG1 X5.0 Y6.5\nM5\n"
    head = "G21\n(crowquill drawing)\n(sheet 60 x 40 mm from its top left, y down)\nM5\n(pen 1 red)\n"
    text = formats.to_bytes(sheet, "gcode", profile=own(tmp_path, more)).decode()
    assert text == f"{head}{stroke}(pen 3 blue)\nT3 (blue)\n{stroke}M2\n"
    first = formats.to_bytes(sheet, "gcode", profile=own(tmp_path, more + "\nchange_first = true")).decode()
    assert first == text.replace("(pen 1 red)\n", "(pen 1 red)\nT1 (red)\n")
    bare = formats.to_bytes(sheet, "gcode", profile=own(tmp_path, more.replace("()", "none"))).decode()
    assert bare == f"G21\nM5\n{stroke}T3 (blue)\n{stroke}M2\n"


def test_y_goes_up_from_the_bottom_or_down_from_the_top(tmp_path: Path):
    up, down = (
        gcode(formats.to_bytes(scribble(), "gcode", profile=own(tmp_path, f"invert_y = {word}")), LOWERED["servo"])
        for word in ("true", "false")
    )
    for one, other in zip(up, down, strict=True):
        assert np.array(one.places) == pytest.approx(
            np.array([(x, HEIGHT - y) for x, y in other.places]), abs=0.0101
        )  # a tie may round away


@pytest.mark.parametrize("decimals", range(5))
def test_the_step_is_as_fine_as_the_decimals_say(tmp_path: Path, decimals: int):
    sheet = scribble(names=("one",))
    data = formats.to_bytes(sheet, "gcode", profile=own(tmp_path, f"decimals = {decimals}\ninvert_y = false"))
    assert {len(number.partition(b".")[2]) for number in re.findall(rb"[XY]([\d.]+)", data)} == {decimals}
    assert faults(gcode(data, LOWERED["servo"]), sheet, 10.0**-decimals) == []


@PROFILES
def test_nothing_is_drawn_off_the_page(profile: str):
    size = (20.004, 30.006)
    sheet = Sheet(
        size, (Layer(Ink(pen=0.3), Paths.of([[(-9, -9), (40, 50)], [(0, 0), size], [(25, 1)], [(25, 1), (19, 1)]], closed=False)),)
    )
    drawn = read(sheet, profile)
    places = np.concatenate([stroke.places for stroke in drawn])
    assert len(drawn) == 3 and places.min() >= -1e-9 and (places <= size).all()


def test_fills_are_refused_and_several_pens_without_a_change(tmp_path: Path):
    with pytest.raises(ValueError, match=r"^gcode draws strokes only; draw with --for plotter$"):
        formats.to_bytes(everything(), "gcode")
    assert formats.to_bytes(strokes(), "gcode")
    with pytest.raises(ValueError, match=r"own\.toml: has no pen_change lines, and 3 pens draw; "):
        formats.to_bytes(scribble(), "gcode", profile=own(tmp_path, "pen_change = []"))
    assert formats.to_bytes(scribble(names=("one",)), "gcode", profile=own(tmp_path, "pen_change = []"))


def test_a_sheet_larger_than_the_bed_is_refused_before_the_work_too(tmp_path: Path):
    assert formats.to_bytes(scribble(), "gcode", profile=own(tmp_path, "bed = [60, 40]"))
    for bed, wish in (("[40, 60]", "turn the paper with orientation, or give"), ('["3cm", 90]', "give")):
        profile = own(tmp_path, f"bed = {bed}")
        says = rf"own\.toml: a sheet of 60 x 40 mm is larger than the bed of \d\d x \d\d mm; {wish} paper of at most"
        with pytest.raises(ValueError, match=says):
            formats.to_bytes(scribble(), "gcode", profile=profile)
        with pytest.raises(ValueError, match=says):
            formats.foresee([tmp_path / "a.nc"], PAGE, 0, {"profile": profile})


NASTY = "red)\nM3 S999\r\nG0 X999 (; ! ? ~ $H % * {pen} \x18 \u2028 Möwe 鴉 \x00" * 2


@pytest.mark.parametrize("comment", [";", "()", "none"])
@given(name=st.one_of(st.just(NASTY), st.text(st.sampled_from(NASTY)), st.text()))
def test_a_name_is_text_and_never_a_command(tmp_path_factory: pytest.TempPathFactory, comment: str, name: str):
    profile = own(tmp_path_factory.getbasetemp(), f'comment = "{comment}"\npen_change = ["M0", "M117 {{pen}} {{name}}"]')
    texts = []
    for label in (name, "plain"):
        sheet = replace(scribble(names=(label, label, label)), recipe={"style": label})
        texts.append(formats.to_bytes(sheet, "gcode", profile=profile).decode("ascii"))
    ours, theirs = (re.sub(r"(?m)^(; .*|\([^()\n]*\)|(M117 \d).*)$", r"\2", text) for text in texts)
    assert ours == theirs and "\r" not in texts[0]
    assert not set("!?~$%*{}") & set(texts[0]) and max(map(len, texts[0].split("\n"))) < 70


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("pen_dwon = []", "no key 'pen_dwon'; did you mean pen_down?"),
        ("zzz = 1", "no key 'zzz'; there are feed_down, "),
        ("pen_down = []", "has no pen_down; give the lines that put the pen down"),
        ("pen_up = []", "has no pen_up; give the lines that lift the pen"),
        ("feed_down = 0", "feed_down is 0; it takes a number from 1 to 100000 mm/min"),
        ("feed_up = -3", "feed_up is -3; it takes a number from 1"),
        ("feed_up = inf", "feed_up is inf; it takes a number"),
        ('feed_up = "fast"', "feed_up is 'fast'; it takes a number"),
        ("decimals = 5", "decimals is 5; it takes a whole number from 0 to 4"),
        ("decimals = 1.5", "decimals is 1.5; it takes a whole number"),
        ("dwell = -1", "dwell is -1; it takes a number from 0 to 60 s"),
        ("invert_y = 1", "invert_y is 1; it takes true or false"),
        ("bed = [200]", "bed is [200]; it takes 2 numbers"),
        ("bed = [200, 0]", "bed is 0; it takes a number from 1"),
        ('comment = "#"', "no comment '#'; there are ;, (), none"),
        ('header = "G21"', "header is 'G21'; it takes a list of lines"),
        ("pen_up = [5]", "pen_up has 5; it takes lines of ASCII"),
        ('pen_up = ["M5\\nM3"]', "pen_up has 'M5\\nM3'; it takes lines of ASCII, each a text of its own"),
        ('pen_up = ["ü"]', "pen_up has 'ü'; it takes lines of ASCII"),
        ('pen_up = [""]', "pen_up has ''; it takes lines of ASCII"),
        ('pen_change = ["M0 {nane}"]', "pen_change has no field 'nane'; did you mean name?"),
        ('header = ["{pen}"]', "header has no field 'pen'; it takes none"),
        ("[header]", "header is {}; it takes a list of lines"),
        ("pen_up =", "not sound TOML ("),
    ],
)
def test_what_is_wrong_with_a_profile_is_one_line_with_its_name(tmp_path: Path, more: str, says: str):
    path = own(tmp_path, more.replace("[header]", "header = {}"))
    with pytest.raises(ValueError, match=rf"^{re.escape(path)}: {re.escape(says)}") as caught:
        formats.to_bytes(scribble(), "gcode", profile=path)
    assert "\n" not in str(caught.value) and "; " in str(caught.value)


@pytest.mark.parametrize("key", ["pen_down", "pen_up", "feed_down", "feed_up"])
def test_what_a_profile_must_say_is_asked_for(key: str):
    rest = "\n".join(line for line in SOUND.splitlines() if not line.startswith(f"{key} ="))
    assert profile_of(SOUND.encode(), "own").machine.feed_down == 1000
    with pytest.raises(ValueError, match=rf"^own: has no {key}; give the "):
        profile_of(rest.encode(), "own")


def test_unknown_profiles_and_missing_files_are_refused_by_name(tmp_path: Path):
    with pytest.raises(ValueError, match=r"^no profile 'sevro'; there are marlin-servo, servo, z, or the path of a TOML file$"):
        formats.to_bytes(scribble(), "gcode", profile="sevro")
    with pytest.raises(FileNotFoundError, match=r"none\.toml"):
        formats.to_bytes(scribble(), "gcode", profile=str(tmp_path / "none.toml"))
    (tmp_path / "latin.toml").write_bytes(b"# M\xf6we\n")
    with pytest.raises(ValueError, match=r"latin\.toml: not sound TOML \(.*\); mend it"):
        load(tmp_path / "latin.toml")


def test_gcode_keeps_no_recipe_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    formats.save(scribble(), tmp_path / "a.nc", tmp_path / "a.gcode")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "a.gcode").read_bytes()
    for name in ("a.nc", "a.gcode"):
        assert main(["redo", str(tmp_path / name), str(tmp_path / "b.svg")]) == 2
        assert f"{name}: this format keeps no recipe; give the drawing's SVG or PDF" in capsys.readouterr().err
