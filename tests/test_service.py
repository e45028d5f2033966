"""Drawings for services: the bytes of the command line, within limits, without a file of the server's, and given up when nobody waits."""

from __future__ import annotations

import io
import pickle
import tempfile
import threading
from concurrent.futures import CancelledError, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from crowquill import service
from crowquill.__main__ import main
from crowquill.cluster import workers
from crowquill.service import LimitError, Limits, drawing, read

QUICK = {"dots": 60, "iterations": 2, "paper": "60x50mm", "margin": "5mm", "tone": "grey"}
TYPED = ("--dots", "60", "--iterations", "2", "--paper", "60x50mm", "--margin", "5mm", "--tone", "grey")


def png(columns: int = 40, rows: int = 30) -> bytes:
    file = io.BytesIO()
    Image.fromarray(np.tile(np.linspace(90, 255, columns).astype(np.uint8), (rows, 1))).save(file, "png")
    return file.getvalue()


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A folder with the picture, which is where we are, and one for what is passing, in which nothing is left."""
    monkeypatch.chdir(tmp_path)
    Path("picture").write_bytes(png())
    passing = tmp_path / "passing"
    passing.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(passing))
    yield tmp_path
    assert not list(passing.iterdir())


@pytest.fixture
def unbegun(monkeypatch: pytest.MonkeyPatch) -> None:
    """Any work is an error."""

    def begun(*_: object, **__: object) -> None:
        raise AssertionError("the work was begun")

    for name in ("relax.lloyd", "relax.scatter", "formats.to_bytes"):
        monkeypatch.setattr(f"crowquill.{name}", begun)


@pytest.mark.parametrize(("style", "kind", "more"), [("stipple", "svg", ()), ("stipple", "pdf", ()), ("inkdots", "png", ("dpi",))])
def test_the_bytes_are_those_of_the_command_line(style, kind, more):
    knobs = dict(QUICK) if style == "stipple" else {key: QUICK[key] for key in ("paper", "margin", "tone")}
    typed = TYPED if style == "stipple" else TYPED[4:]
    assert main([style, "picture", f"plate.{kind}", *typed, "--quiet", *(("--dpi", "300") if more else ())]) == 0
    assert drawing(png(), style, kind, knobs | ({"dpi": 300} if more else {})) == Path(f"plate.{kind}").read_bytes()


def test_texts_of_a_query_are_read_as_what_options_take():
    texts = {"dots": "60", "pen": "0.3mm", "gamma": "1.5", "invert": "Yes", "crop": "0,0,.5,.5", "paper": "a5", "sizes": "0.2mm,0.3mm"}
    found = read("stipple", texts)
    assert found == texts | {"dots": 60, "gamma": 1.5, "invert": True, "crop": [0, 0, 0.5, 0.5], "sizes": ["0.2mm", "0.3mm"]}
    assert type(found["dots"]) is int
    assert drawing(png(), "stipple", "svg", QUICK | read("stipple", {"check_bar": "no"})) == drawing(png(), "stipple", "svg", QUICK)


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ({"dots": "many"}, "dots is 'many'; it takes a number: "),
        ({"dots": "1.5"}, "dots is '1.5'; it takes a number: "),
        ({"invert": "perhaps"}, "invert is 'perhaps'; it takes true or false: "),
        ({"crop": "0,a,1,1"}, "crop is '0,a,1,1'; it takes numbers: "),
        ({"dotts": "3"}, "no option 'dotts'; did you mean dots?"),
        ({"limits": "3"}, "no option 'limits'; "),
        ({"files": "3"}, "no option 'files'; "),
    ],
)
def test_texts_that_are_none_are_refused(texts, said):
    with pytest.raises(ValueError, match=said):
        read("stipple", texts)


@pytest.mark.usefixtures("unbegun")
@pytest.mark.parametrize(
    ("style", "kind", "options", "limits", "what", "wanted"),
    [
        ("stipple", "svg", {}, Limits(pixels=1199), "pixels", 1200),
        ("stipple", "svg", {"max_pixels": 10**9}, Limits(pixels=1199), "pixels", 1200),
        ("stipple", "svg", {}, Limits(dots=59), "dots", 60),
        ("stipple", "png", {"dpi": 254}, Limits(pixels=299_999), "pixels", 600 * 500),
        ("stipple", "tif", {"bilevel": True}, Limits(pixels=1_000_000), "pixels", 1417 * 1181),
        ("stipple", "svg", {"dots": 2_000_000, "max_dots": 10**8}, Limits(dots=10**9, seconds=1), "seconds", None),
        ("stipple", "svg", {}, Limits(seconds=0), "seconds", None),
    ],
)
def test_what_is_over_the_limits_is_refused_before_the_work(style, kind, options, limits, what, wanted):
    with pytest.raises(LimitError, match=f"^the drawing takes .* {what}, and .* are the limit; ask for less$") as error:
        drawing(png(), style, kind, QUICK | options, limits=limits)
    assert error.value.what == what
    assert wanted is None or error.value.wanted == wanted
    assert error.value.wanted > error.value.most


def test_what_is_just_within_the_limits_is_drawn():
    assert drawing(png(), "stipple", "png", QUICK | {"dpi": 254}, limits=Limits(pixels=300_000, dots=60))


def test_tiles_and_pixels_of_halftones_count():
    paper = {key: QUICK[key] for key in ("paper", "margin")}
    with pytest.raises(LimitError, match="dots"):
        drawing(png(), "mosaic", "svg", paper | {"tile": "1mm"}, limits=Limits(dots=1000))
    with pytest.raises(LimitError, match="pixels"):
        drawing(png(), "halftone", "svg", paper | {"cells_per_inch": 1200}, limits=Limits(pixels=1_000_000))


def test_a_bitmap_as_fine_as_what_is_drawn_is_refused_before_it_is_written(monkeypatch):
    monkeypatch.setattr("crowquill.formats.to_bytes", lambda *_, **__: pytest.fail("it was written"))
    options = {"paper": "200x200mm", "width": "10mm", "form": "pixels", "cells_per_inch": 2400}
    with pytest.raises(LimitError, match="pixels"):
        drawing(png(), "halftone", "tiff", options, limits=Limits(pixels=30_000_000))


def test_work_ends_at_the_next_step_once_it_is_cancelled():
    asked = []

    def cancelled() -> bool:
        asked.append(1)
        return len(asked) > 5

    with pytest.raises(CancelledError):
        drawing(png(), "stipple", "svg", QUICK | {"iterations": 50, "until": 0}, cancelled=cancelled)
    assert len(asked) == 6


def test_work_that_takes_longer_than_it_may_is_ended(monkeypatch):
    clock = iter(range(1000))
    monkeypatch.setattr(service.time, "monotonic", lambda: float(next(clock)))
    with pytest.raises(LimitError, match=r"^the drawing takes 8\.0 seconds, and 7 are the limit; ask for less$"):
        drawing(png(), "stipple", "svg", QUICK | {"iterations": 50, "until": 0}, limits=Limits(seconds=7))


@pytest.mark.parametrize("name", ["/etc/passwd.svg", "../mine.svg", "mine.svg", "..", "a/b", "a\\b"])
def test_options_name_no_files(desk, name):
    (desk / "mine.svg").write_bytes(b"<svg/>")
    for key in ("glyphs", "canvas", "importance", "outline", "tone_curve", "icc", "profile"):
        with pytest.raises(ValueError, match=f"^{key} is .*; here it takes no file, only what comes with crowquill$"):
            drawing(png(), "stipple", "pdf", QUICK | {key: name})


def test_files_of_the_service_are_taken_and_words_too(desk):
    Image.fromarray(np.pad(np.full((20, 30), 255, np.uint8), 5)).save(desk / "mask.png")
    plain = drawing(png(), "stipple", "svg", QUICK)
    assert drawing(png(), "stipple", "svg", QUICK, files={"canvas": desk / "mask.png"}) != plain
    assert drawing(png(), "stipple", "svg", QUICK | {"glyphs": "brush"}) != plain
    with pytest.raises(ValueError, match="dots takes no file; give it among the options"):
        drawing(png(), "stipple", "svg", QUICK, files={"dots": desk / "mask.png"})


@pytest.mark.parametrize(
    ("data", "style", "kind", "options", "said"),
    [
        (b"", "stipple", "svg", {}, "^picture: the file is empty"),
        (b"no picture", "stipple", "svg", {}, "^picture: not a picture that can be read"),
        (png(400, 300)[:200], "stipple", "svg", {}, "^picture: the picture is broken"),
        (png(), "stiple", "svg", {}, "^no style 'stiple'; did you mean stipple"),
        (png(), "stipple", "jpg", {}, "no format 'jpg'; there are gcode,"),
        (png(), "stipple", "hpgl", {}, "^drawing.hpgl: takes strokes only, and the recipe is not for a plotter"),
        (png(), "stipple", "svg", {"max_pixels": 1000}, "^picture: 40 x 30 pixels are over the limit of 1000; make it smaller"),
        (png(), "stipple", "svg", {"dots": -3}, "^dots is -3; it takes"),
        (png(), "stipple", "svg", {"dots": "60"}, "^dots is '60'; it takes"),
        (png(), "stipple", "svg", {"dotts": 3}, "^no option 'dotts'; did you mean dots"),
    ],
)
@pytest.mark.usefixtures("unbegun")
def test_what_cannot_be_followed_is_one_line_that_names_no_place(data, style, kind, options, said):
    with pytest.raises(ValueError, match=said) as error:
        drawing(data, style, kind, QUICK | options)
    assert "\n" not in str(error.value)
    assert "passing" not in str(error.value)
    assert not isinstance(error.value, LimitError)


def test_several_at_once_give_the_same_bytes():
    alone = [drawing(png(), "stipple", "svg", QUICK, seed=seed) for seed in range(4)]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda seed: drawing(png(), "stipple", "svg", QUICK, seed=seed), range(4))) == alone
    assert len(set(alone)) == 4


def test_a_refusal_travels_between_processes():
    error = pickle.loads(pickle.dumps(LimitError("dots", 3, 2)))
    assert (error.what, error.wanted, error.most, str(error)) == ("dots", 3, 2, str(LimitError("dots", 3, 2)))


@pytest.mark.soak
def test_a_process_can_be_left_in_the_middle_of_a_step():
    began = threading.Event()
    with workers(None, 1, lambda _: began.set()) as pool:
        future = pool.submit(drawing, png(), "stipple", "svg", QUICK)
        assert future.result() == drawing(png(), "stipple", "svg", QUICK)
        stuck = pool.submit(drawing, png(400, 300), "objects", "svg", {"dots": 20_000})
        threading.Event().wait(2)
    assert isinstance(stuck.exception(), CancelledError)
