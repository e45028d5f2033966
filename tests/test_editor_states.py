"""States kept beside the log: who comes back does again only what came after the last, and finds the bytes that the log gives."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import shapely
from editing import PATIENCE, Page, digest, drawing, picture, serving, way

from crowquill import formats
from crowquill.editor import packing, session, states
from crowquill.editor.drawing import Drawing, sheet_of
from crowquill.editor.drawing import Layer as Edited
from crowquill.editor.items import Items
from crowquill.editor.log import Entry
from crowquill.editor.opening import Header
from crowquill.editor.packing import packed, parts, unpacked
from crowquill.editor.session import Session, replayed
from crowquill.lettering import Words
from crowquill.recipe import Recipe, Source
from crowquill.sheet import Art, Bitmap, Ink, Layer

WORK: list[tuple[str, dict[str, Any]]] = [
    ("redraw stipple", {"dots": 200, "iterations": 1}),
    ("wall", {"path": way((15, 15), (60, 15), (60, 45))}),
    ("paint", {"path": way((40, 30)), "size": 10, "map": "importance"}),
    ("insert", {"path": way((40, 30)), "size": 10, "glyph": "leaves", "rate": 40, "diameter": 1, "gap": -5}),
    ("layer add", {"spot": "Gold", "cmyk": [0, 0.2, 0.6, 0]}),
    ("redraw halftone", {"path": way((12, 12), (30, 12), (30, 40))}),
    ("tile", {"side": 6}),
    ("cut", {}),
    ("paper", {"paper": "100x80mm"}),
    ("jitter", {"on": "all"}),
    ("select", {"by": "rectangle", "path": way((20, 20), (60, 60))}),
    ("resize", {"on": "selection", "factor": 1.3}),
]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(session, "OFTEN", 0.0)  # a state after each entry
    picture(Path("ramp.png"))
    return tmp_path


def opened() -> Session:
    return Session(Path("ramp.png"))


def worked(work: list[tuple[str, dict[str, Any]]] = WORK) -> Session:
    """A session that has done some work, a state kept after each entry that may be; it is not closed, as if it were killed."""
    made = Session(Path("ramp.png"), Recipe("stipple", paper={"paper": "80x60mm", "margin": 10}))
    for k, (op, params) in enumerate(work):
        assert made.apply(op, params, None, k + 1), op
        keep = made.write()
        assert keep and keep() == ""
    made.lock.release()
    return made


def kept() -> list[int]:
    return sorted(int(path.stem) for path in Path("ramp.png.edits.states").glob("*.state"))


def whole() -> Drawing:
    """What the log gives when all of it is done again."""
    *_, (_, _, found, _) = replayed(Path("ramp.png.edits"))
    return found


def written(of: Drawing) -> bytes:
    return formats.to_bytes(sheet_of(of), "svg") + digest(of).encode()


def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The operations done from now on."""
    done: list[str] = []
    real = session.performed

    def perform(of: Drawing, entry: Entry, *more: Any) -> Drawing:
        done.append(entry.op)
        return real(of, entry, *more)

    monkeypatch.setattr(session, "performed", perform)
    return done


@pytest.mark.usefixtures("desk")
def test_who_comes_back_does_again_only_what_came_after_the_last_state(monkeypatch):
    worked(WORK[:-2])
    first = opened()
    first._worked = -1e9  # no state from here on
    for k, (op, params) in enumerate(WORK[-2:]):
        assert first.apply(op, params, None, 100 + k) and first.write() is None
    first.lock.release()
    done = counted(monkeypatch)
    again = opened()
    assert done == [op for op, _ in WORK[-2:]]
    assert written(again.drawing) == written(first.drawing) == written(whole())
    again.close()


@pytest.mark.usefixtures("desk")
def test_every_state_is_the_one_that_the_log_gives():
    made = worked()
    assert len(kept()) == states.MOST and kept()[-1] == len(WORK)
    for count in kept():
        found = made.states.last(count - 1, count, made.history.entries)
        assert found and found[0] == count
        assert written(found[1]) == written(made.history._state(count))
        assert [kind.name for kind in found[1].kinds] == [kind.name for kind in made.history._state(count).kinds]
    made.journal.close()


def damaged(change: Callable[[bytes], bytes]) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(change(path.read_bytes())) and None


def told(**other: Any) -> Callable[[Path], None]:
    """Another first line."""

    def change(data: bytes) -> bytes:
        first, _, body = data.partition(b"\n")
        return json.dumps({**json.loads(first), **other}).encode() + b"\n" + body

    return damaged(change)


FAULTS = {
    "empty": damaged(lambda _: b""),
    "cut off": damaged(lambda data: data[:-9]),
    "a bit turned": damaged(lambda data: data[:-40] + bytes([(data[-40] + 1) % 256]) + data[-39:]),
    "nonsense": damaged(lambda _: b"[" * 100_000 + b"\n"),
    "another version": told(version="0.0.9"),
    "a newer schema": told(schema=states.SCHEMA + 1),
    "another log": told(log="00"),
    "another number": told(entries=99),
}


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_what_is_damaged_or_of_another_version_is_passed_over(monkeypatch, fault):
    worked(WORK[:3])
    expected = written(whole())
    fault(Path("ramp.png.edits.states/0000003.state"))
    done = counted(monkeypatch)
    found = opened()
    assert done == ["paint"] and written(found.drawing) == expected  # the state before it is sound
    found.lock.release()
    for path in Path("ramp.png.edits.states").glob("*.state"):
        fault(path)
    done.clear()
    found = opened()
    assert done == [op for op, _ in WORK[:3]] and written(found.drawing) == expected  # the whole log
    found.close()


@pytest.mark.usefixtures("desk")
def test_states_of_what_was_undone_and_replaced_do_not_count():
    made = worked(WORK[:3])
    made.undo(2)
    made.apply("jitter", {"on": "all"}, None, 9)
    made.write()
    made.lock.release()
    assert kept() == [1, 2, 3]  # this time none was written after the undo
    found = opened()
    assert written(found.drawing) == written(made.drawing) == written(whole())
    keep = found.write()
    assert keep is not None and keep() == "" and kept() == [1, 2]
    found.close()


@pytest.mark.usefixtures("desk")
def test_an_undo_after_recovery_takes_the_state_before(monkeypatch):
    made = worked()
    found = opened()
    done = counted(monkeypatch)
    before = made.history._state(len(WORK) - 4)
    assert found.undo(4) == 4 and written(found.drawing) == written(before)
    assert done == []
    assert found.redo(4) == 4 and written(found.drawing) == written(made.drawing)
    found.close()


@pytest.mark.usefixtures("desk")
def test_states_are_few_and_small_and_those_long_ago_lie_farther_apart(monkeypatch):
    made = worked(WORK[:1])
    for k in range(40):
        made.apply("jitter", {"on": "all"}, None, k + 2)
        keep = made.write()
        assert keep and keep() == ""
    numbers = kept()
    assert len(numbers) == states.MOST and numbers[-1] == 41
    gaps = np.diff([0, *numbers])
    assert gaps[0] >= gaps[-1] and gaps.max() < 25
    size = max(path.stat().st_size for path in Path("ramp.png.edits.states").iterdir())
    monkeypatch.setattr(states, "ROOM", 3 * size)
    assert made.states.keep(made.history.entries, made.drawing) == "" and len(kept()) <= 3
    monkeypatch.setattr(states, "ROOM", size // 10)
    made.states.clear()
    assert made.states.keep(made.history.entries, made.drawing) == "" and kept() == []  # too large a one is none
    made.journal.close()


def test_only_new_entries_are_read_for_a_state_and_another_entry_is_another_log(tmp_path, monkeypatch):
    read: list[str] = []
    real = Entry.data
    monkeypatch.setattr(Entry, "data", lambda entry: read.append(entry.op) or real(entry))
    of = states.States(tmp_path / "a.edits", Header(Source("a.png", "00")), drawing())
    entries = [Entry(name) for name in "abcdef"]
    whole, part = of._digest(entries), of._digest(entries[:3])
    assert read == list("abcdef")
    fresh = states.States(tmp_path / "a.edits", Header(Source("a.png", "00")), drawing())
    assert (fresh._digest(entries[:3]), fresh._digest(entries)) == (part, whole)
    other = of._digest([*entries[:3], Entry("x"), *entries[4:]])
    assert other != whole and of._digest(entries) == whole and of._digest([]) == fresh._digest([]) != part


@pytest.mark.usefixtures("desk")
def test_a_log_begun_anew_has_no_states_and_a_log_of_nothing_leaves_none():
    worked(WORK[:2]).journal.close()
    Path("ramp.png.edits").unlink()
    other = Path("ramp.png.edits.states/mine.txt")
    other.write_text("mine")
    found = opened()
    assert kept() == [] and len(found.history.entries) == 0 and other.read_text() == "mine"
    other.unlink()
    found.close()
    assert sorted(path.name for path in Path().iterdir()) == ["ramp.png"]


@pytest.mark.usefixtures("desk")
def test_a_state_is_kept_when_a_session_ends_that_took_its_time(monkeypatch):
    monkeypatch.setattr(session, "OFTEN", 1e9)
    made = Session(Path("ramp.png"))
    made.apply("redraw stipple", {"dots": 100}, None, 1)
    made._worked = 1.0
    made.close()
    assert kept() == [1]


@pytest.mark.usefixtures("desk")
def test_a_full_disk_while_a_state_is_kept_is_said_once_and_loses_nothing(monkeypatch):
    made = Session(Path("ramp.png"), Recipe("stipple", paper={"paper": "80x60mm", "margin": 10}))

    tries: list[int] = []

    def full(*_: Any) -> None:
        tries.append(1)
        raise OSError(errno.ENOSPC, "No space left on device", "x")

    with serving(made) as server:
        page = Page.at(server)
        with monkeypatch.context() as patch:
            patch.setattr(states, "replace_files", full)
            for k, (op, params) in enumerate(WORK[:3]):
                assert page.apply(op, **params)["say"] == "done"
                end = time.monotonic() + PATIENCE
                while len(tries) <= k and time.monotonic() < end:
                    time.sleep(0.01)
            while not (errors := [one for one in page.said if one["say"] == "error"]):
                page.hear()
        assert [one["n"] for one in errors] == [None] and "(no space left on device)" in errors[0]["text"]
        assert kept() == []
        assert page.apply(WORK[3][0], **WORK[3][1])["say"] == "done"
        page.socket.close()
    assert kept() == [4] and sum(one["say"] == "error" for one in page.said) == 1
    assert written(whole()) == written(made.drawing)


@pytest.mark.usefixtures("desk")
def test_a_killed_server_comes_back_by_its_states(monkeypatch):
    command = [sys.executable, "-c", "from crowquill.editor import session; session.OFTEN = 0.0; from crowquill.__main__ import run; run()"]
    with subprocess.Popen([*command, "edit", "ramp.png", "--no-browser"], stdout=subprocess.PIPE, text=True) as run:
        address = run.stdout.readline().strip() if run.stdout else ""
        page = Page.at(type("At", (), {"address": address}))
        for op, params in WORK[:4]:
            assert page.apply(op, **params)["say"] == "done"
        end = time.monotonic() + PATIENCE
        while kept() != [1, 2, 3, 4] and time.monotonic() < end:
            time.sleep(0.01)
        run.send_signal(signal.SIGKILL)
    done = counted(monkeypatch)
    found = opened()
    assert done == [] and written(found.drawing) == written(whole())
    found.close()


@pytest.mark.usefixtures("desk")
def test_a_kept_state_is_whole_or_not_there(monkeypatch):
    made = worked(WORK[:1])
    real = os.replace

    def killed(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", killed)
        with pytest.raises(KeyboardInterrupt):
            made.states.keep([*made.history.entries, Entry("jitter")], made.drawing)
    assert os.replace is real and kept() == [1] and len(list(Path("ramp.png.edits.states").iterdir())) == 1
    made.journal.close()


ARTS = {
    Words: Words.of([("Tafel", 1, 2)]),
    Bitmap: Bitmap.of(np.eye(5), 300),
    **{type(art): art for art in (sheet_of(drawing(5)).layers[0].art, drawing(1).kinds[0].paths)},
}


@pytest.mark.parametrize("kind", get_args(Art), ids=lambda kind: kind.__name__)
def test_any_art_is_packed_and_unpacked_to_the_bit(kind):
    still = Layer(Ink("Gold", pen=None, spot=True), ARTS[kind])
    begun = drawing(20)
    made = replace(begun, layers=(*begun.layers, Edited(2, "still", Ink(), Items.none(), still=still)), facts={}, margin=np.float64(3.5))
    again = unpacked(packed(made, parts(begun)), parts(begun))
    assert written(again) == written(made) and again.margin == 3.5
    assert again.tone is begun.tone and again.layers[0] is begun.layers[0]  # what both share is one
    alone = unpacked(packed(made, []), [])
    assert written(alone) == written(made) and shapely.equals(alone.picture.canvas, made.picture.canvas)


def test_what_is_not_ours_is_not_packed_and_bytes_of_others_are_not_unpacked():
    with pytest.raises(ValueError, match="object is not packed"):
        packed(object(), [])
    for data in (b"", b"nonsense", zlib.compress(b"short"), zlib.compress(b"\x05" + bytes(7) + b"[1,2]"), packed(drawing(3), [])[:-5]):
        with pytest.raises(ValueError, match=r"cannot be unpacked|cut off"):
            unpacked(data, [])
    tree = json.dumps(["c", "os.system", "true"]).encode()
    with pytest.raises(ValueError, match="cannot be unpacked"):
        unpacked(zlib.compress(len(tree).to_bytes(8, "little") + tree), [])
    assert set(packing.CLASSES) == {f"{cls.__module__}.{cls.__name__}" for cls in packing.NAMES}
