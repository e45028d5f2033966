"""The log: what is written down is drawn again to the same bytes; nothing is lost to a full disk, a crash or a second process."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from editing import digest, drawing, full_disk, items, picture, way

import crowquill
from crowquill import formats, styles
from crowquill.__main__ import main
from crowquill.editor import log
from crowquill.editor.history import History
from crowquill.editor.log import Entry
from crowquill.editor.session import Session, performed, replayed
from crowquill.recipe import Recipe
from crowquill.sheet import Ink, Layer, Sheet

SMALL = {"paper": "80x60mm", "margin": 10}
BRUSH: dict[str, Any] = {"path": way((40, 30)), "size": 10}
WORK: list[tuple[str, dict[str, Any]]] = [
    ("redraw stipple", {"dots": 80, "iterations": 1, "glyphs": "disc"}),
    ("insert", {**BRUSH, "rate": 30, "gap": -5}),
    ("erase", {**BRUSH, "strength": 0.5}),
    ("push", {"path": way((40, 30), (42, 31)), "size": 8}),
    ("relax", {}),
    ("select", {"by": "rectangle", "path": way((20, 20), (40, 40))}),
    ("turn", {"on": "selection", "by": "random"}),
    ("paint", BRUSH),
    ("relax", {"variant": "objects", "on": "selection"}),
    ("layer add", {"cmyk": [1, 0, 0, 0]}),
    ("layer take", {"layer": 2}),
]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a picture, which is where we are."""
    monkeypatch.chdir(tmp_path)
    picture(Path("ramp.png"))
    return tmp_path


def session(**more: Any) -> Session:
    return Session(Path("ramp.png"), Recipe("stipple", paper=SMALL, **more))


def work(on: Session) -> Session:
    for k, (op, params) in enumerate(WORK):
        assert on.apply(op, params, None, k + 1)
    on.journal.write()
    return on


@pytest.mark.usefixtures("desk")
def test_a_log_is_drawn_again_to_the_bytes_that_were_exported():
    edited = work(session())
    assert edited.undo(2) == 2 and edited.redo(1) == 1
    edited.journal.write()
    names = ["a.svg", "a.pdf", "a.png"]
    edited.export(names, {"dpi": 100})
    edited.close()
    assert main(["replay", "ramp.png.edits", "b.svg", "b.pdf", "b.png", "--dpi", "100"]) == 0
    assert [Path(name).read_bytes() for name in names] == [Path(f"b{name[1:]}").read_bytes() for name in names]
    *_, (done, total, again, _) = replayed(Path("ramp.png.edits"))
    assert done == total == len(WORK) - 1 and digest(again) == digest(edited.drawing)


@pytest.mark.usefixtures("desk")
def test_a_file_and_its_log_may_get_another_name(capsys):
    work(session()).close()
    assert main(["replay", "ramp.png.edits", "a.svg"]) == 0
    Path("ramp.png").rename("slope.png")
    Path("ramp.png.edits").rename("slope.png.edits")
    assert main(["replay", "slope.png.edits", "b.svg"]) == 0
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes()
    Path("slope.png.edits").rename("other.edits")
    assert main(["replay", "other.edits", "c.svg"]) == 2
    assert "ramp.png: there is no such file" in capsys.readouterr().err


@pytest.mark.usefixtures("desk")
def test_fifty_undos_and_redos_give_every_state_again():
    edited = session()
    seen = [digest(edited.drawing)]
    for k in range(50):
        assert edited.apply("insert", {"path": way((20 + k / 2, 30)), "size": 6, "rate": 5, "gap": -5}, None, k + 1)
        seen.append(digest(edited.drawing))
    for k in range(50, 0, -1):
        assert digest(edited.drawing) == seen[k] and edited.undo() == 1
    assert digest(edited.drawing) == seen[0] and edited.undo() == 0
    for k in range(1, 51):
        assert edited.redo() == 1 and digest(edited.drawing) == seen[k]
    assert edited.redo() == 0
    edited.close()


@pytest.mark.usefixtures("desk")
def test_who_comes_back_finds_what_was_and_what_could_be_done_again():
    first = work(session())
    first.undo(3)
    first.journal.write()
    state = digest(first.drawing)
    first.close()
    again = Session(Path("ramp.png"))
    assert digest(again.drawing) == state and again.redo() == 1
    again.close()
    by_log = Session(Path("ramp.png.edits"))
    assert by_log.file == Path("ramp.png")
    by_log.close()


def test_states_that_found_no_room_are_made_again():
    kept = 0

    def perform(state: Any, entry: Entry) -> Any:
        nonlocal kept
        kept += 1
        return performed(state, entry, Path())

    narrow = History(drawing(200), (), 0, perform, room=8_000)  # where 200 marks lie takes 1.6 kB
    wide = History(drawing(200), (), 0, lambda state, entry: performed(state, entry, Path()))
    for k in range(20):
        entry = Entry("jitter", {"on": "all"}, k, k + 1)
        for history in (narrow, wide):
            history.push(entry, performed(history.drawing(), entry, Path()))
    for back in (1, 7, 3, 9):
        assert narrow.go(narrow.back(back)) == wide.go(wide.back(back)) == back
        assert digest(narrow.drawing()) == digest(wide.drawing())
    assert narrow.go(narrow.ahead(20)) == wide.go(wide.ahead(99)) == 20
    assert digest(narrow.drawing()) == digest(wide.drawing())
    assert kept > 0


def test_groups_are_undone_together_and_what_was_undone_goes_with_the_next_entry():
    history = History(drawing(5), (), 0, lambda state, entry: performed(state, entry, Path()))
    for k, group in enumerate([1, 1, 1, 2, 3, 3]):
        entry = Entry("jitter", {"on": "all"}, k, group)
        history.push(entry, performed(history.drawing(), entry, Path()))
    assert history.names() == (["jitter"] * 3, [])
    went = [history.go(way(count)) for way, count in ((history.back, 1), (history.back, 1), (history.ahead, 1), (history.back, 2))]
    assert went == [2, 1, 1, 4]
    history.go(history.ahead(1))
    entry = Entry("resize", {"on": "all"}, 0, 4)
    history.push(entry, performed(history.drawing(), entry, Path()))
    assert history.names() == (["resize", "jitter"], []) and len(history.entries) == 4


@pytest.mark.usefixtures("desk")
def test_an_undo_that_cannot_be_made_leaves_all_as_it_is(monkeypatch):
    edited = work(session())
    state, at = digest(edited.drawing), edited.history.at
    edited.history._kept = {0: edited.begun, at: edited.drawing}
    with monkeypatch.context() as patch:
        patch.setattr("crowquill.editor.session.work", lambda *_: (_ for _ in ()).throw(ValueError("a file is gone")))
        with pytest.raises(ValueError, match="a file is gone"):
            edited.undo()
    assert (digest(edited.drawing), edited.history.at, edited.journal.waiting) == (state, at, 0)
    assert edited.undo() == 1 and edited.redo() == 1 and digest(edited.drawing) == state
    edited.close()


@pytest.mark.usefixtures("desk")
def test_what_changes_nothing_is_not_written_down():
    edited = session()
    assert not edited.apply("erase", {"path": way((1, 1)), "size": 1}, None, 1)
    assert not edited.apply("insert", {"path": way((40, 30)), "rate": 0}, None, 2)
    edited.close()
    assert not Path("ramp.png.edits").exists()  # nor is there a log of nothing


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("cut", [1, 7, 40])
def test_a_line_that_was_cut_off_does_not_count(cut):
    work(session()).close()
    path = Path("ramp.png.edits")
    whole = path.read_bytes()
    path.write_bytes(whole[:-cut])
    edited = Session(Path("ramp.png"))
    assert len(edited.history.entries) == len(WORK) - 1
    edited.apply("jitter", {"on": "all"}, None, 99)
    edited.journal.write()
    edited.close()
    lines = path.read_bytes().splitlines()
    assert len(lines) == len(WORK) + 1 and json.loads(lines[-1])["op"] == "jitter"


@pytest.mark.usefixtures("desk")
def test_room_that_the_file_system_made_for_a_line_that_never_came_does_not_count():
    work(session()).close()
    path = Path("ramp.png.edits")
    path.write_bytes(path.read_bytes() + bytes(100) + b"\n")
    assert len(log.read(path).done) == len(WORK)


HEAD = '{"crowquill":"edits","schema":1,"version":"0.1.0","file":{"name":"ramp.png","sha256":"00"},"picture":{}}'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no whole line"),
        ("{}", "no whole line"),
        ("nonsense\n", "no whole line"),
        ("nonsense\n{}\n", "is no log of the editor"),
        ("[]\n", "is no log of the editor"),
        (HEAD.replace('"schema":1', '"schema":2') + "\n", "made by a newer crowquill"),
        (HEAD.replace('"schema":1', '"schema":"x"') + "\n", "schema is 'x'"),
        (HEAD.replace('"name":"ramp.png"', '"name":"../ramp.png"') + "\n", "bare name"),
        (HEAD.replace('"sha256":"00"', '"sha256":7') + "\n", "does not say what was edited"),
        (HEAD + '\nnonsense\n{"undo":1}\n', "line 2 is not sound JSON"),
        (HEAD + '\n{"undo":1}\n', "line 2 has undo 1 where there are 0"),
        (HEAD + '\n{"op":"erase"}\n{"redo":1}\n', "line 3 has redo 1 where there are 0"),
        (HEAD + '\n{"op":"erase"}\n{"undo":true}\n', "line 3 has undo True"),
        (HEAD + '\n{"op":7}\n', "line 2 is no sound operation"),
        (HEAD + '\n{"op":"erase","seed":-1}\n', "line 2 is no sound operation"),
        (HEAD + '\n{"op":"erase","more":1}\n', "line 2 is no sound operation"),
        (HEAD + "\n7\n", "line 2 is no JSON object"),
        (HEAD + "\n" + "[" * 100_000 + "\n{}\n", "line 2 is not sound JSON"),
    ],
)
def test_what_is_no_log_is_refused_by_its_line(tmp_path, text, says):
    path = tmp_path / "ramp.png.edits"
    path.write_text(text)
    with pytest.raises(ValueError, match=says):
        log.read(path)


@pytest.mark.usefixtures("desk")
def test_a_log_of_another_file_and_one_that_cannot_be_followed_are_refused():
    work(session()).close()
    kept = Path("ramp.png").read_bytes()
    picture(Path("ramp.png"), (61, 40))
    with pytest.raises(ValueError, match="is not the file that was edited"):
        Session(Path("ramp.png"))
    Path("ramp.png").unlink()
    assert main(["replay", "ramp.png.edits", "b.svg"]) == 2
    Path("ramp.png").write_bytes(kept)
    with Path("ramp.png.edits").open("a") as file:
        file.write('{"op":"layer remove","params":{"layer":77},"seed":0,"group":99}\n')
    with pytest.raises(ValueError, match=r"cannot be followed.*there is no layer 77"):
        Session(Path("ramp.png"))
    assert main(["replay", "ramp.png.edits", "b.svg"]) == 2
    assert not list(Path().glob("*.lock")) and not Path("b.svg").exists()


@pytest.mark.usefixtures("desk")
def test_files_that_operations_read_must_be_what_they_were(capsys):
    shape = formats.to_bytes(Sheet((10, 10), (Layer(Ink(), drawing(1).kinds[0].paths.moved(np.eye(2), (5, 5))),)), "svg")
    Path("mine.svg").write_bytes(shape)
    edited = session()
    assert edited.apply("insert", {**BRUSH, "glyph": "mine.svg", "diameter": 1, "gap": -5}, None, 1)
    edited.journal.write()
    assert list(edited.history.entries[0].files) == ["mine.svg"]
    edited.close()
    assert main(["replay", "ramp.png.edits", "b.svg"]) == 0
    Path("mine.svg").write_bytes(shape.replace(b"</svg>", b" </svg>"))
    assert main(["replay", "ramp.png.edits", "b.svg"]) == 2
    assert "mine.svg: is not the file that was read" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["../ramp.png", "/etc/passwd", "a/b.svg", "..", "", "x\0.svg", "C:x.svg"])
def test_names_that_lead_out_of_the_folder_are_refused(desk, name):
    (desk.parent / "ramp.png").write_bytes(b"")
    edited = session()
    for attempt in (
        lambda: edited.export([name], {}),
        lambda: edited.checked(name),
        lambda: edited.within(name),
        lambda: edited.apply("redraw mosaic", {"palette": name or "/"}, None, 1),
    ):
        with pytest.raises(ValueError, match="without folders"):
            attempt()
    edited.close()


@pytest.mark.usefixtures("desk")
def test_links_that_lead_out_of_the_folder_are_refused_and_files_that_are_read_are_not_written(tmp_path_factory):
    away = tmp_path_factory.mktemp("away") / "secret.svg"
    away.write_text("secret")
    Path("link.svg").symlink_to(away)
    edited = session()
    with pytest.raises(ValueError, match="is a link to another place"):
        edited.export(["link.svg"], {}, overwrite=True)
    assert away.read_text() == "secret"
    with pytest.raises(ValueError, match="would be written over a file that is read"):
        edited.export(["ramp.png"], {}, overwrite=True)
    edited.export(["a.svg"], {})
    with pytest.raises(FileExistsError):
        edited.export(["a.svg"], {})
    with pytest.raises(ValueError, match="did you mean dpi"):
        edited.export(["a.png"], {"dpo": 7})
    edited.close()


@pytest.mark.usefixtures("desk")
def test_a_full_disk_loses_nothing_and_the_log_is_whole_once_there_is_room(monkeypatch):
    edited = session()
    edited.apply("redraw stipple", {"dots": 100, "iterations": 1}, None, 1)
    edited.journal.write()
    path, whole = Path("ramp.png.edits"), Path("ramp.png.edits").read_bytes()
    write = os.write

    def full(handle: int, data: Any) -> int:
        if len(data) > 10:
            return write(handle, bytes(data)[:10])  # some of it fits
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        for k in range(3):
            edited.apply("jitter", {"on": "all"}, None, k + 2)
            edited.journal.write()
    assert edited.journal.waiting == 3 and edited.journal.error == "no space left on device"
    assert path.read_bytes() == whole  # no half line
    edited.journal.write()
    assert edited.journal.waiting == 0 and not edited.journal.error
    assert [entry.op for entry in log.read(path).done] == ["redraw stipple", "jitter", "jitter", "jitter"]
    state = digest(edited.drawing)
    edited.close()
    again = Session(Path("ramp.png"))
    assert digest(again.drawing) == state
    again.close()


@pytest.mark.usefixtures("desk")
def test_edits_that_never_found_room_are_rescued_elsewhere(monkeypatch, tmp_path_factory):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path_factory.mktemp("elsewhere")))
    edited = work(session())
    edited.undo(2)
    with full_disk(edited):
        edited.apply("jitter", {"on": "all"}, None, 99)
        edited.undo()
        edited.close()
    state = digest(edited.drawing)
    assert edited.journal.waiting == 3
    Path("ramp.png.edits").write_bytes(edited.rescued().read_bytes())
    again = Session(Path("ramp.png"))
    assert digest(again.drawing) == state and again.redo() == 1
    again.close()


@pytest.mark.usefixtures("desk")
def test_a_disk_that_is_full_at_the_start_is_refused_and_leaves_nothing(monkeypatch):
    def full(_handle: int, _data: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch, pytest.raises(OSError, match="No space left"):
        patch.setattr(os, "write", full)
        session()
    assert sorted(path.name for path in Path().iterdir()) == ["ramp.png"]


@pytest.mark.usefixtures("desk")
def test_a_second_start_on_the_same_drawing_says_so(capsys):
    first = session()
    with pytest.raises(ValueError, match=rf"is being edited already, by process {os.getpid()}"):
        session()
    assert main(["edit", "ramp.png", "--no-browser"]) == 2
    assert "is being edited already" in capsys.readouterr().err
    first.close()
    session().close()


@pytest.mark.usefixtures("desk")
def test_the_lock_of_a_process_that_was_killed_is_taken_over():
    with subprocess.Popen([sys.executable, "-c", "pass"]) as gone:
        gone.wait()
    for text in (str(gone.pid), "", "nonsense"):
        Path("ramp.png.edits.lock").write_text(text)
        session().close()
    assert not Path("ramp.png.edits.lock").exists()


@pytest.mark.usefixtures("desk")
def test_settings_beside_a_log_are_refused():
    work(session()).close()
    with pytest.raises(ValueError, match="has edits made with other settings"):
        session()


@pytest.mark.usefixtures("desk")
def test_settings_of_a_drawing_and_files_that_are_elsewhere_are_refused(tmp_path_factory):
    away = picture(tmp_path_factory.mktemp("away") / "wish.png")
    with pytest.raises(ValueError, match=r"put the importance beside ramp\.png"):
        Session(Path("ramp.png"), Recipe("stipple", tone={"importance": str(away)}))
    Path("a.svg").write_text("<svg/>")
    with pytest.raises(ValueError, match="settings of paper and tone are for pictures"):
        Session(Path("a.svg"), Recipe("stipple", paper=SMALL))
    assert sorted(path.name for path in Path().iterdir()) == ["a.svg", "ramp.png"]


@pytest.mark.usefixtures("desk")
def test_the_settings_of_a_picture_lay_it_out_and_a_check_bar_cannot_be_moved():
    picture(Path("wish.png"))
    edited = session(tone={"invert": True, "importance": "wish.png"})
    assert edited.drawing.wish and edited.drawing.tone.values[0, 0] > edited.drawing.tone.values[0, -1]
    edited.close()
    barred = Session(Path("ramp.png"), Recipe("stipple", paper={**SMALL, "check_bar": True}))
    assert [layer.locked for layer in barred.drawing.layers] == [False, True]
    assert [layer.label for layer in barred.sheet().layers] == ["check bar 10 mm"]
    barred.apply("redraw stipple", {"dots": 20, "iterations": 1}, None, 1)
    barred.journal.write()
    state = digest(barred.drawing)
    barred.close()
    again = Session(Path("ramp.png"))
    assert digest(again.drawing) == state
    again.close()


@pytest.fixture(scope="module")
def stippled() -> Sheet:
    tone = crowquill.Tone(np.tile(np.linspace(0, 0.9, 60), (40, 1)), (60.0, 40.0))
    return styles.run(styles.steps("stipple", tone, dots=200, iterations=3)).on((80, 60), margin=5)


@pytest.mark.usefixtures("desk")
def test_a_drawing_that_was_only_opened_is_exported_as_it_was(capsys):
    assert main(["stipple", "ramp.png", "dots.svg", "--paper", "80x60mm", "--margin", "10mm", "--dots", "120", "--iterations", "2"]) == 0
    before = crowquill.load("dots.svg")
    edited = Session(Path("dots.svg"))
    assert edited.drawing.picture.rgb is not None and not edited.notes  # its picture lies beside it
    assert edited.drawing.picture.corner.tolist() == before.recipe["art_at_mm"]
    after = edited.sheet()
    for name in ("xy", "angle", "scale", "glyph"):
        assert (getattr(after.marks, name) == getattr(before.marks, name)).all()
    assert [glyph.paths.xy.tolist() for glyph in after.marks.glyphs] == [glyph.paths.xy.tolist() for glyph in before.marks.glyphs]
    edited.apply("erase", BRUSH, None, 1)
    edited.export(["edited.svg"], {})
    edited.journal.write()
    edited.close()
    again = Session(Path("edited.svg"))  # an edited drawing still knows its picture
    assert again.drawing.picture.rgb is not None and len(items(again.drawing)) == len(items(edited.drawing))
    again.close()
    assert main(["redo", "edited.svg", "c.svg"]) == 2
    assert "was edited by hand" in capsys.readouterr().err


COARSE = {
    "mosaic": ["--tile", "8mm", "--iterations", "2"],
    "objects": ["--dots", "20", "--iterations", "2"],
    "cells": ["--dots", "60", "--iterations", "2"],
    "screen": ["--pitch", "3mm"],
}


@pytest.mark.parametrize(("style", "size"), COARSE.items())
@pytest.mark.usefixtures("desk")
def test_drawings_of_other_styles_are_exported_as_they_were(style, size):
    assert main([style, "ramp.png", "a.svg", "--paper", "80x60mm", "--margin", "10mm", *size]) == 0
    before = crowquill.load("a.svg")
    edited = Session(Path("a.svg"))
    after = edited.sheet()
    edited.close()
    for one, other in zip(before.layers, after.layers, strict=True):
        assert (one.name, one.ink) == (other.name, other.ink)
        if isinstance(one.art, crowquill.Paths):
            assert isinstance(other.art, crowquill.Paths) and one.art.xy.tolist() == other.art.xy.tolist()
            assert one.art.start.tolist() == other.art.start.tolist()
        if one.fill is not None:
            assert (
                other.fill is not None and np.abs(one.fill - other.fill).max() <= 0.5 / 255 + 1e-4
            )  # colours are kept as a screen shows them


@pytest.mark.usefixtures("desk")
def test_an_svg_of_shapes_is_opened_as_objects_and_each_keeps_its_outline():
    Path("shapes.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="60mm" viewBox="0 0 80 60">'
        '<path d="M10 10h10v10h-10zM13 13h4v4h-4z" fill="#cc0000" fill-rule="evenodd"/><circle cx="40" cy="30" r="5"/>'
        '<path d="M50 50l10 2" fill="none" stroke="#0000ff" stroke-width="1"/><path d="M60 10l8 0 0 8z"/></svg>'
    )
    edited = Session(Path("shapes.svg"))
    layers = edited.drawing.layers
    assert [(layer.ink.rgb, len(layer.items)) for layer in layers] == [((204, 0, 0), 1), ((0, 0, 0), 1), ((0, 0, 255), 1), ((0, 0, 0), 1)]
    assert layers[1].items.xy.tolist() == [[40, 30]] and layers[2].ink.pen == pytest.approx(1)
    sheet = edited.sheet()
    first = sheet.layers[0].art
    assert isinstance(first, crowquill.Paths) and first.xy.min(axis=0).tolist() == [10, 10] and len(first) == 2
    assert edited.apply("select", {"by": "pick", "path": way((40, 30))}, None, 1)
    assert edited.apply("move", {"dx": 3}, None, 2) and edited.apply("relax", {"variant": "objects"}, None, 3)
    edited.close()


@pytest.mark.usefixtures("desk")
def test_what_cannot_be_opened_is_refused_in_a_line_and_leaves_nothing(capsys, stippled):
    crowquill.save(stippled, "drawn.pdf")
    data = formats.to_bytes(stippled, "svg")
    Path("newer.svg").write_bytes(data.replace(b'"schema": 1', b'"schema": 9', 1))
    Path("broken.svg").write_text("<svg")
    Path("empty.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="60mm"/>')
    Path("text.png").write_text("no picture")
    before = sorted(path.name for path in Path().iterdir())
    for name, says in [
        ("drawn.pdf", "edit its SVG"),
        ("newer.svg", "made by a newer crowquill"),
        ("broken.svg", "not sound SVG"),
        ("empty.svg", "draws nothing that can be edited"),
        ("text.png", "text.png"),
        ("missing.png", "check the name"),
        ("missing.svg", "check the name"),
    ]:
        assert main(["edit", name, "--no-browser"]) == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1 and says in lines[0], (name, lines)
    assert sorted(path.name for path in Path().iterdir()) == before
