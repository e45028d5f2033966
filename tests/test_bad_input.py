"""What cannot be drawn is refused: exit 2, one line that names it and says what to do, and nothing on disk has changed."""

from __future__ import annotations

import io
import os
import re
import resource
import shlex
import shutil
import signal
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pikepdf
import pytest
from hostile import BOX, CANVASES, DOT, GOOD, LIBRARIES, OPTIONS, PICTURES, RECIPES, svg

from crowquill.__main__ import main

LONGEST = 320  # characters: a name may have 255, and a cause and a remedy stand behind it
PATIENCE = 20  # s: no refusal may take longer, and a test that hangs says so
ROOM = 1 << 30  # bytes of memory that a refusal may take
SMALL = ["--paper", "60x40mm", "--margin", "5mm", "--iterations", "0"]  # what is wrongly accepted is soon drawn

# all that is typed, what the line must say, and the story
COMMANDS = [
    ("stiple good.png out.svg", "stiple", "a style misspelt"),
    ("../stipple good.png out.svg", "stipple", "a style by a path"),
    ("--pen 0.3mm", "--pen", "an option before the style"),
    ("stipple good.png", "OUT", "no file to write"),
    ("stipple good.png good.png", "good.png", "the picture to be written over"),
    ("stipple as.svg as.svg", "as.svg", "the same, and its suffix is a format's"),
    ("stipple as.svg ./desk/../as.svg", "as.svg", "the same by a way round"),
    ("stipple as.svg soft.svg", "soft.svg", "the same through a symbolic link"),
    ("stipple as.svg hard.svg", "hard.svg", "the same by its other name"),
    ("stipple good.png frame.svg --canvas frame.svg", "frame.svg", "the canvas to be written over"),
    ("stipple good.png dots.svg --glyphs dots.svg", "dots.svg", "the library to be written over"),
    ("stipple good.png out.pdf --report dots.svg --glyphs dots.svg", "dots.svg", "the library under the report"),
    ("stipple good.png out.dfx", "dfx", "a format there is not"),
    ("stipple good.png out", "out", "no suffix"),
    ("stipple good.png .svg", ".svg", "a suffix alone, which is a hidden name"),
    ("stipple good.png out.svg.", "out.svg.", "a point too many"),
    ("stipple good.png ''", "format", "no name"),
    ("stipple good.png desk.svg", "desk.svg", "a folder with a drawing's name"),
    ("stipple good.png pipe.svg", "pipe.svg", "a pipe"),
    ("stipple good.png full.svg", "full.svg", "a device, behind a link"),
    ("stipple good.png loop.svg", "loop.svg", "a link to itself"),
    ("stipple good.png out.svg out.svg", "out.svg", "one file twice"),
    ("stipple good.png out.pdf ./desk/../out.pdf", "out.pdf", "one file twice, the second time by a way round"),
    ("stipple good.png new.svg out.svg other.svg ./other.svg", "other.svg", "one of several twice"),
    ("stipple good.png out.svg --no-overwrite", "out.svg", "a file that is there and shall stay"),
    ("stipple good.png new.svg out.svg --no-overwrite", "out.svg", "one of two that shall stay"),
    ("stipple good.png new.svg --report old.json --no-overwrite", "old.json", "a report that shall stay"),
    ("stipple good.png nowhere/out.svg", "nowhere", "a folder that is not there"),
    ("stipple good.png good.png/out.svg", "out.svg", "a path below a file"),
    ("stipple good.png /proc/out.svg", "/proc/out.svg", "a folder nobody can write to, not even root"),
    (f"stipple good.png {'x' * 252}.svg", "xxxxxxxx", "a name longer than any folder takes"),
    ("stipple missing.png out.svg", "missing.png", "a picture that is not there"),
    ("stipple '' out.svg", "; ", "no picture"),
    ("stipple - out.svg", "-", "a dash for a picture"),
    ("stipple desk.svg out.svg", "desk.svg", "a folder for a picture"),
    ("stipple pipe.svg out.svg", "pipe.svg", "a pipe nobody fills"),
    ("stipple socket out.svg", "socket", "a socket"),
    ("stipple loop.svg out.svg", "loop.svg", "a link to itself"),
    ("stipple gone.png out.svg", "gone.png", "a link to nothing"),
    ("stipple /dev/zero out.svg", "/dev/zero", "a device that never ends"),
    ("stipple /proc/self/mem out.svg", "/proc/self/mem", "a file of the kernel's"),
    ("stipple good.png/x.png out.svg", "x.png", "a path through a file"),
    (f"stipple {'x' * 300}.png out.svg", "xxxxxxxx", "a name too long to be one"),
    (f"stipple {'x/' * 3000}a.png out.svg", "x/x/x/", "a path too long to be one"),
    ("stipple good.png out.svg --canvas missing.svg", "missing.svg", "a canvas that is not there"),
    ("stipple good.png out.svg --canvas desk", "desk", "a folder for a canvas"),
    ("stipple good.png out.svg --canvas pipe.svg", "pipe.svg", "a pipe for a canvas"),
    ("stipple good.png out.svg --canvas full.svg", "full.svg", "a device without end for a canvas"),
    ("stipple good.png out.svg --glyphs missing.svg", "missing.svg", "a library that is not there"),
    ("stipple good.png out.svg --glyphs desk.svg", "desk.svg", "a folder for a library"),
    ("stipple good.png out.svg --glyphs pipe.svg", "pipe.svg", "a pipe for a library"),
    ("stipple good.png out.svg --glyphs full.svg", "full.svg", "a device without end for a library"),
    ("stipple good.png out.svg --recipe missing.toml", "missing.toml", "a recipe that is not there"),
    ("stipple good.png out.svg --recipe desk", "desk", "a folder for a recipe"),
    ("stipple good.png out.svg --recipe pipe.svg", "pipe.svg", "a pipe for a recipe"),
    ("stipple good.png out.pdf --separate", "separate", "a setting that no file written takes"),
]

TWO = '<circle cx="2" cy="2" r="1"/><circle cx="8" cy="7" r="1"/>'
SQUARE = 'width="10mm" height="10mm" viewBox="0 0 10 10"'

# what is typed without the options of a drawing, what the line must say, and the story
VERBS = [
    ("redo missing.svg out.svg", "missing.svg", "a drawing that is not there"),
    ("redo good.png out.svg", "good.png", "a picture for a drawing"),
    ("redo frame.svg new.svg", "frame.svg", "somebody else's SVG"),
    ("redo as.svg new.svg", "as.svg", "a picture called a drawing"),
    ("redo bad.pdf new.svg", "bad.pdf", "a PDF that is none"),
    ("redo plain.pdf new.svg", "plain.pdf", "somebody else's PDF"),
    ("redo pipe.svg new.svg", "pipe.svg", "a pipe"),
    ("redo desk.svg new.svg", "desk.svg", "a folder"),
    ("redo as.svg", "OUT", "no file to write"),
    ("recipe frame.svg", "frame.svg", "somebody else's SVG asked for its recipe"),
    ("recipe missing.svg", "missing.svg", "a recipe of nothing"),
    ("glyphs shwo nib-03 -o out.svg", "shwo", "a command misspelt"),
    ("glyphs show nib-99 -o new.svg", "nib-99", "a library there is not"),
    ("glyphs show nib-03", "--out", "no page to draw"),
    ("glyphs show nib-03 -o new.dfx", "dfx", "a page in a format there is not"),
    ("glyphs show dots.svg -o dots.svg", "dots.svg", "the library under its page"),
    ("glyphs show frame2.svg -o new.pdf", "frame2.svg", "an SVG without a shape"),
    ("glyphs scan missing.png -o new.svg", "missing.png", "a scan that is not there"),
    ("glyphs scan good.png -o new.pdf", "new.pdf", "a library that is no SVG"),
    ("glyphs scan good.png -o new.svg", "good.png", "a scan of no known size, and no scan at all"),
    ("glyphs scan good.png -o new.svg --dpi 72", "72", "a scan too coarse"),
    ("glyphs scan good.png -o new.svg --dpi nan", "dpi", "a scan of no number"),
    ("glyphs scan good.png -o new.svg --dpi 1200", "good.png", "a scan without dots"),
    ("glyphs scan good.png -o new.svg --pen 0.3", "--pen", "a pen without a unit"),
    ("glyphs scan desk.svg -o new.svg --dpi 1200", "desk.svg", "a folder for a scan"),
    ("glyphs scan pipe.svg -o new.svg --dpi 1200", "pipe.svg", "a pipe for a scan"),
    ("glyphs scan good.png -o nowhere/new.svg --dpi 1200", "nowhere", "a folder that is not there"),
    ("measure missing.svg", "missing.svg", "a drawing that is not there"),
    ("measure good.png", "dpi", "a bitmap of no known size"),
    ("measure good.png --dpi 0", "--dpi", "no pixels to the inch"),
    ("measure frame2.svg", "no dots", "a drawing without dots"),
    ("measure dots.svg", "one dot", "a drawing of one dot"),
    ("measure two.svg --against good.png", "good.png", "a picture of another shape"),
    ("measure two.svg --against missing.png", "missing.png", "a picture that is not there"),
    ("measure two.svg --gamma 2", "--against", "tone options without a picture"),
    ("measure two.svg --against good.png --gamma 0", "gamma", "a gamma that makes all one"),
    ("measure two.svg two.svg two.svg", "3", "three drawings side by side"),
    ("measure two.svg --figure new.dfx", "dfx", "a figure in a format there is not"),
    ("measure two.svg --figure two.svg", "two.svg", "a figure over the drawing"),
    ("measure two.svg --report nowhere/r.json", "nowhere", "a report in a folder that is not there"),
    ("measure pipe.svg", "pipe.svg", "a pipe nobody fills"),
    ("measure desk", "desk", "a folder"),
    ("points two.svg -o new.txt", "new.txt", "points in a form there is not"),
    ("points two.svg", "--out", "no file for the points"),
    ("points missing.svg -o new.csv", "missing.svg", "points of nothing"),
]


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with good and bad files and an older drawing, which is where we are."""
    folder = tmp_path_factory.mktemp("desk")
    before = Path.cwd()
    os.chdir(folder)
    files = {name: data for table in (PICTURES,) for name, (data, _) in table.items()}
    files |= {"good.png": GOOD, "as.svg": GOOD, "out.svg": b"older", "old.json": b"older"}
    files |= {
        "frame.svg": svg(BOX),
        "dots.svg": svg(DOT),
        "frame2.svg": svg(""),
        "two.svg": svg(TWO, SQUARE),
        "bad.pdf": b"%PDF-1.4 no more",
        "plain.pdf": plain_pdf(),
    }
    for kind, table in (("canvas", CANVASES), ("glyphs", LIBRARIES)):
        files |= {f"{kind}-{name}": data for name, (data, _) in table.items()}
    for name, data in files.items():
        Path(name).write_bytes(data)
    Path("desk").mkdir()
    Path("desk.svg").mkdir()
    os.mkfifo("pipe.svg")
    os.mknod("socket", stat.S_IFSOCK | 0o600)
    os.link("as.svg", "hard.svg")
    for name, target in (("soft.svg", "as.svg"), ("full.svg", "/dev/full"), ("loop.svg", "loop.svg"), ("gone.png", "nothing.png")):
        Path(name).symlink_to(target)
    yield folder
    os.chdir(before)
    shutil.rmtree(folder, ignore_errors=True)


def plain_pdf() -> bytes:
    """A sound PDF that no crowquill wrote."""
    file = io.BytesIO()
    with pikepdf.new() as pdf:
        pdf.add_blank_page()
        pdf.save(file)
    return file.getvalue()


def held(folder: Path) -> dict[str, bytes]:
    """Everything in the folder: names, and the bytes of the plain files."""
    return {str(path): path.read_bytes() if path.is_file() and not path.is_symlink() else b"" for path in folder.rglob("*")}


@pytest.fixture
def bounded() -> Iterator[None]:
    """A call that hangs or eats all memory fails instead of taking the machine along."""

    def rang(*_: object) -> None:
        raise AssertionError(f"no answer after {PATIENCE} s")

    old = signal.signal(signal.SIGALRM, rang)
    limits = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, limits[1]))
    signal.alarm(PATIENCE)
    yield
    signal.alarm(0)
    resource.setrlimit(resource.RLIMIT_AS, limits)
    signal.signal(signal.SIGALRM, old)


def refusal(folder: Path, capfd: pytest.CaptureFixture[str], arguments: list[str], says: str) -> None:
    """Runs the command line and checks all that a refusal must be."""
    before = held(folder)
    code = main(arguments)
    out, line = capfd.readouterr()
    assert code == 2 and held(folder) == before, f"exit {code}, {set(held(folder)) ^ set(before)} changed: {line}"
    assert not out and line.startswith("crowquill: ") and line.endswith("\n"), f"{out!r} on stdout, {line!r} on stderr"
    text = line[:-1]
    assert text.isprintable(), f"more than a line, or what a terminal would obey: {text!r}"
    assert len(text) <= LONGEST, f"{len(text)} characters: {text}"
    assert says in text or says in re.sub("[ _]", "-", text), f"{says!r} is not named: {text}"
    assert "; " in text, f"no remedy: {text}"


def rows(table: dict[str, tuple[bytes, str]]) -> list[Any]:
    return [pytest.param(name, id=story) for name, (_, story) in table.items()]


def told(name: str) -> str:
    """The part of a file's name that any honest line repeats: the longest run of plain characters, not all of a very long one."""
    runs = "".join(letter if letter.isascii() and letter.isprintable() else "\n" for letter in name).split("\n")
    return max(runs, key=len)[:60]


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("name", rows(PICTURES))
def test_a_bad_picture_is_refused_in_one_line(desk, capfd, name):
    refusal(desk, capfd, ["stipple", name, "out.svg", *SMALL], told(name))


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("name", rows(CANVASES))
def test_a_bad_canvas_is_refused_in_one_line(desk, capfd, name):
    refusal(desk, capfd, ["stipple", "good.png", "out.svg", "--canvas", f"canvas-{name}", *SMALL], f"canvas-{name}")


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("name", rows(LIBRARIES))
def test_a_bad_glyph_library_is_refused_in_one_line(desk, capfd, name):
    refusal(desk, capfd, ["stipple", "good.png", "out.svg", "--glyphs", f"glyphs-{name}", *SMALL], f"glyphs-{name}")


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("row", [pytest.param(row, id=f"{row[1]}: {row[0][:40]}") for row in OPTIONS])
def test_a_bad_option_is_refused_in_one_line(desk, capfd, row):
    words = shlex.split(row[0])
    typed = [word.lstrip("-").split("=")[0] for word in words if re.match("--?[a-z]", word)]
    refusal(desk, capfd, ["stipple", "good.png", "out.svg", *SMALL, *words], row[2] if len(row) > 2 else typed[-1])


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("row", [pytest.param(row, id=f"{row[2]}: {row[0][:40]}") for row in COMMANDS])
def test_a_bad_command_is_refused_in_one_line(desk, capfd, row):
    refusal(desk, capfd, [*shlex.split(row[0]), *SMALL], row[1])


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("row", [pytest.param(row, id=f"{row[2]}: {row[0][:40]}") for row in VERBS])
def test_a_bad_verb_is_refused_in_one_line(desk, capfd, row):
    refusal(desk, capfd, shlex.split(row[0]), row[1])


@pytest.mark.usefixtures("bounded")
@pytest.mark.parametrize("row", [pytest.param(row, id=row[2]) for row in RECIPES])
def test_a_bad_recipe_is_refused_in_one_line(desk, capfd, row):
    (desk / "r.toml").write_text(row[0], encoding="utf-8")
    for typed in ("stipple good.png out.svg --recipe r.toml", "redo r.toml out.svg", "recipe r.toml"):
        refusal(desk, capfd, typed.split(), row[1])


def test_there_are_as_many_stories_as_cases():
    stories = [row[1] for row in OPTIONS] + [row[2] for row in (*COMMANDS, *VERBS, *RECIPES)]
    stories += [story for table in (PICTURES, CANVASES, LIBRARIES) for _, story in table.values()]
    assert len(stories) >= 200 and all(stories)  # the list only grows


@pytest.mark.usefixtures("bounded")
def test_a_refusal_is_seen_to_fail_where_a_drawing_is_made(desk, capfd):
    with pytest.raises(AssertionError, match="exit 0"):
        refusal(desk, capfd, ["stipple", "good.png", "made.svg", "--dots", "5", "--quiet"], "")
    (desk / "made.svg").unlink()
