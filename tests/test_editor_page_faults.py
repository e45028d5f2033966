"""The editor's page when things go wrong beneath it: files of a newer version are refused, and a full disk is said; nothing is lost."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import Editor, browsing, log_of
from editing import full_disk, picture, serving
from playwright.sync_api import Browser

from crowquill.__main__ import main
from crowquill.editor.drawing import sheet_of
from crowquill.editor.log import read
from crowquill.editor.server import Server
from crowquill.editor.session import Session, replayed
from crowquill.formats import to_bytes
from crowquill.recipe import Recipe

SETTINGS = Recipe("stipple", paper={"paper": "80x60mm", "margin": 10})


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsing() as found:
        yield found


@pytest.fixture
def own(tmp_path: Path) -> Iterator[tuple[Server, Session]]:
    """A server of a picture that is stippled already, in this process."""
    session = Session(picture(tmp_path / "ramp.png"), SETTINGS)
    assert session.apply("redraw stipple", {"dots": 150, "iterations": 1}, None, 1)
    session.write()
    with serving(session) as server:
        yield server, session


def newer_log(folder: Path) -> Path:
    """A picture with edits whose log is of a schema to come."""
    path = folder / "later.png"
    shutil.copy(folder / "ramp.png", path)
    head = {"crowquill": "edits", "schema": 9, "version": "9.0", "file": {"name": path.name, "sha256": "0"}, "picture": {}}
    (folder / "later.png.edits").write_text(json.dumps(head) + '\n{"op":"insert"}\n')
    return path


def newer_drawing(folder: Path) -> Path:
    """A drawing whose SVG is of a schema to come."""
    path = folder / "later.svg"
    assert main(["stipple", str(folder / "ramp.png"), str(path), "--paper", "80x60mm", "--margin", "10mm", "--dots", "50"]) == 0
    text = path.read_text(encoding="utf-8")
    assert text.count('"schema": 1, "size_mm"') == 1
    path.write_text(text.replace('"schema": 1, "size_mm"', '"schema": 9, "size_mm"'), encoding="utf-8")
    return path


def newer_operation(folder: Path) -> Path:
    """A picture with edits of which one is an operation that is not known yet."""
    path = folder / "later.png"
    shutil.copy(folder / "ramp.png", path)
    made = Session(path, SETTINGS)
    made.apply("redraw stipple", {"dots": 20, "iterations": 1}, None, 1)
    made.close()
    log = folder / "later.png.edits"
    log.write_bytes(log.read_bytes() + b'{"op":"dissolve","params":{},"seed":1,"group":2}\n')
    return path


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (newer_log, "made by a newer crowquill (schema 9 of edits); update this one"),
        (newer_drawing, "made by a newer crowquill (schema 9); update this one"),
        (newer_operation, "no operation 'dissolve'"),
    ],
)
def test_what_a_newer_version_saved_is_refused_on_the_page_and_left_as_it_is(
    own: tuple[Server, Session], browser: Browser, make: Callable[[Path], Path], says: str
) -> None:
    server, session = own
    path = make(session.folder)
    before = {file.name: file.read_bytes() for file in session.folder.glob("later*") if file.is_file()}
    editor = Editor(browser, server.address)
    kept = editor.columns()
    editor.page.get_by_role("button", name="Open").click()
    editor.page.get_by_role("dialog").get_by_role("button", name=path.name, exact=True).click()
    line = editor.page.locator("#messages p.error")
    line.wait_for()
    assert says in line.inner_text() and path.name in line.inner_text()
    assert {file.name: file.read_bytes() for file in session.folder.glob("later*") if file.is_file()} == before
    editor.rest()
    assert editor.page.locator("#name").inner_text() == "ramp.png"
    assert all((kept[name] == column).all() for name, column in editor.columns().items())
    editor.take("e", size=8.0)
    editor.stroke((30, 30), (50, 30))  # editing goes on
    assert len(editor.columns()["id"]) < len(kept["id"]) and log_of(session.file)[-1]["op"] == "erase"
    assert editor.faults == []
    editor.page.close()


def test_a_full_disk_is_said_on_the_page_and_all_is_saved_once_there_is_room(own: tuple[Server, Session], browser: Browser) -> None:
    server, session = own
    editor = Editor(browser, server.address)
    saved = editor.page.locator("#saved")
    assert saved.inner_text() == "Every change is saved" and saved.get_attribute("role") == "status"
    editor.take("j", size=12.0, amount=1.0)
    lines = len(log_of(session.file))
    with full_disk(session):
        editor.stroke((30, 30), (50, 30))
        editor.until("document.getElementById('saved').getAttribute('role') === 'alert'")
        assert "edits are not written down (no space left on device); free some space" in saved.inner_text()
        first = editor.columns()
        editor.stroke((30, 40), (50, 40))  # editing goes on
        assert np.abs(editor.xy() - np.stack([first["x"], first["y"]], axis=1) / 1000).max() > 0.1
        other = Editor(browser, server.address)  # who comes now is told too
        other.until("document.getElementById('saved').getAttribute('role') === 'alert'")
        other.page.close()
        assert len(log_of(session.file)) == lines
    editor.until("document.getElementById('saved').getAttribute('role') === 'status'")
    assert saved.inner_text() == "Every change is saved"
    waiting = editor.page.evaluate("crowquill.desk.drawing.saved.value.waiting")
    assert waiting == 0 and len(read(session.path).done) == len(session.history.entries) > lines
    *_, (_, _, again, _) = replayed(session.path)
    assert to_bytes(sheet_of(again), "svg") == to_bytes(sheet_of(session.drawing), "svg")
    assert editor.faults == []
    editor.page.close()
