"""The server: who may come in, what requests are refused, and what two pages, a crash and a full disk make of a drawing."""

from __future__ import annotations

import http.client
import io
import json
import secrets
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from editing import PATIENCE, Page, digest, full_disk, picture, serving, shown, way
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from crowquill import formats
from crowquill.__main__ import main
from crowquill.editor import telling
from crowquill.editor.server import Server
from crowquill.editor.session import Session
from crowquill.recipe import Recipe

SETTINGS = Recipe("stipple", paper={"paper": "80x60mm", "margin": 10})
BRUSH: dict[str, Any] = {"path": way((40, 30)), "size": 10}


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Server, Session]]:
    """A server that stays for all tests that leave it as it is, or do not mind how it is."""
    session = Session(picture(tmp_path_factory.mktemp("desk") / "ramp.png"), SETTINGS)
    with serving(session) as server:
        yield server, session


@pytest.fixture
def own(tmp_path: Path) -> Iterator[tuple[Server, Session]]:
    """A server for a test alone."""
    session = Session(picture(tmp_path / "ramp.png"), SETTINGS)
    with serving(session) as server:
        yield server, session


def got(server: Server, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, {key.lower(): value for key, value in answer.getheaders()}, answer.read()
    connection.close()
    return found


def test_it_listens_on_this_machine_alone_and_below_a_long_token(served):
    server, _ = served
    assert server.listener.getsockname()[0] == "127.0.0.1" and len(server.token) >= 32
    assert server.address == f"http://127.0.0.1:{server.port}/{server.token}/"


OUTSIDE = ["/", "/{other}/", "/{other}/picture.png", "/{token}x/", "/{token}", "/favicon.ico", "/{token}/nothing", "//{token}/"]


@pytest.mark.parametrize("path", OUTSIDE)
def test_without_the_token_there_is_nothing(served, path):
    server, _ = served
    status, _, _ = got(server, path.format(token=server.token, other=secrets.token_urlsafe(24)))
    assert status in (404, 307)  # a missing last slash is pointed out to who knows the rest


@pytest.mark.parametrize(
    "name",
    ["../hub.py", "..%2fhub.py", "%2e%2e/hub.py", "..%5chub.py", ".hidden", "index.html%00", "hub.py", "../../../../etc/passwd", "a/b.js"],
)
def test_only_files_of_the_page_are_served(served, name):
    server, _ = served
    assert got(server, f"/{server.token}/{name}")[0] == 404


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Host": "localhost:{port}"}, 200),
        ({"Origin": "http://127.0.0.1:{port}"}, 200),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example:{port}"}, 403),  # its name leads here by now: DNS rebinding
        ({"Host": "127.0.0.1"}, 403),
        ({"Host": "127.0.0.1:1"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "https://127.0.0.1:{port}"}, 403),
    ],
)
def test_foreign_hosts_and_origins_are_refused(served, headers, status):
    server, _ = served
    sent = {key: value.format(port=server.port) for key, value in headers.items()}
    assert got(server, f"/{server.token}/picture.png", **sent)[0] == status


@pytest.mark.parametrize(
    "origin", [None, "http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1:{port}", "http://127.0.0.1:{port}.evil"]
)
def test_a_socket_takes_its_own_origin_alone(served, origin):
    server, _ = served
    with pytest.raises(InvalidStatus) as error, connect(f"ws{server.address[4:]}socket", origin=origin and origin.format(port=server.port)):
        pass
    assert error.value.response.status_code == 403


def test_a_socket_takes_the_token_and_its_own_host_alone(served):
    server, _ = served
    origin = f"http://127.0.0.1:{server.port}"
    for path, more in [(f"/{secrets.token_urlsafe(24)}/socket", {}), (f"/{server.token}/socket", {"Host": f"evil.example:{server.port}"})]:
        line = socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE)
        headers = {"Host": f"127.0.0.1:{server.port}", "Origin": origin, **more}
        head = "".join(f"{key}: {value}\r\n" for key, value in headers.items())
        upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        upgrade += "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
        line.sendall(f"GET {path} HTTP/1.1\r\n{head}{upgrade}\r\n".encode())
        assert b" 403 " in line.recv(100)
        line.close()


def test_pages_are_told_to_keep_to_themselves(served):
    server, _ = served
    _, headers, data = got(server, f"/{server.token}/picture.png")
    assert headers["referrer-policy"] == "no-referrer" and headers["x-content-type-options"] == "nosniff"
    assert "frame-ancestors 'none'" in headers["content-security-policy"] and "default-src 'none'" in headers["content-security-policy"]
    assert "server" not in headers and headers["cache-control"] == "no-store"
    assert Image.open(io.BytesIO(data)).size == (60, 40)


def test_a_page_is_told_all_it_needs(served):
    server, session = served
    page = Page.at(server)
    told = page.hello
    assert (told["protocol"], told["name"], told["size"], told["art"]) == (telling.PROTOCOL, "ramp.png", [80, 60], [10, 10, 60, 40])
    assert {one["name"] for one in told["operations"]} >= {"insert", "relax", "cut", "redraw mosaic"}
    for one in told["operations"]:
        for knob in one["knobs"]:
            assert knob["kind"] in ("range", "numbers", "choice", "text", "flag") and knob["help"]
    assert {"svg", "pdf"} <= set(told["formats"])
    assert page.items == shown(session.drawing) and page.maps[0].shape == (40, 60)
    libraries = json.loads(got(server, f"/{server.token}/libraries.json")[2])
    assert {"nib-03", "leaves"} <= set(libraries) and libraries["nib-03"][0]["d"].startswith("m")
    page.socket.close()


MALFORMED = [
    "",
    "nonsense",
    "[]",
    "7",
    '"do"',
    "{}",
    '{"do":"undo"}',
    '{"n":1}',
    '{"do":"undo","n":-1}',
    '{"do":"undo","n":true}',
    '{"do":"undo","n":1.5}',
    '{"do":"undo","n":1e300}',
    '{"do":"undo","n":1,"count":0}',
    '{"do":"undo","n":1,"count":"1"}',
    '{"do":"undo","n":1,"more":1}',
    '{"do":"destroy","n":1}',
    '{"do":"_work","n":1}',
    '{"do":["undo"],"n":1}',
    '{"do":"apply","n":1}',
    '{"do":"apply","n":1,"op":null}',
    '{"do":"apply","n":1,"op":"erase","params":[]}',
    '{"do":"apply","n":1,"op":"erase","params":{},"seed":-1}',
    '{"do":"apply","n":1,"op":"erase","params":{"on":"all"},"seed":1e5}',
    '{"do":"apply","n":1,"op":"erase","params":{"on":"all"},"times":-1}',
    '{"do":"apply","n":1,"op":"erase","params":{"on":"all"},"group":"a"}',
    '{"do":"apply","n":1,"op":"erase","params":{"size":NaN}}',
    '{"do":"apply","n":1,"op":"erase","params":{"size":Infinity,"on":"all"}}',
    '{"do":"apply","n":1,"op":"erase","params":{"path":[[1,2,3]]}}',
    '{"do":"apply","n":1,"op":"erase","params":{"path":{"0":1}}}',
    '{"do":"apply","n":1,"op":"__init__","params":{}}',
    '{"do":"show","n":1,"what":"secrets"}',
    '{"do":"show","n":1}',
    '{"do":"export","n":1,"files":[]}',
    '{"do":"export","n":1,"files":["../a.svg"]}',
    '{"do":"export","n":1,"files":[7]}',
    '{"do":"export","n":1,"files":["a.exe"]}',
    '{"do":"export","n":1,"files":["a.pdf"],"options":{"icc":"/etc/passwd"}}',
    '{"do":"check","n":1,"file":"../ramp.png"}',
    '{"do":"open","n":1,"file":"/etc/passwd"}',
    '{"do":"open","n":1,"file":"nothing.svg"}',
    '{"do":"stop","n":1}',
    '{"do":"undo","n":1,"n":' + "9" * 5000 + "}",
    '{"a":' * 50_000,
    "[" * 100_000,
]


@pytest.mark.parametrize("text", MALFORMED, ids=range(len(MALFORMED)))
def test_a_malformed_request_is_an_error_and_changes_nothing(served, text):
    server, session = served
    page = Page.at(server)
    before = digest(session.drawing)
    page.socket.send(text)
    while (found := page.hear())["say"] != "error":
        assert found["say"] in ("tabs", "state", "done")
    assert found["text"] and "\n" not in found["text"] and "fault" not in found["text"]
    assert digest(session.drawing) == before and page.ask("refresh")["say"] == "done"
    page.socket.close()


def test_a_binary_request_is_an_error_and_an_oversized_one_closes_the_socket(served):
    server, _ = served
    page = Page.at(server)
    page.socket.send(b"\1\2\3")
    while page.hear()["say"] != "error":
        pass
    page.socket.send(b" " * telling.FRAME + b"{}")
    with pytest.raises(ConnectionClosed) as error:
        while True:
            page.hear()
    assert error.value.rcvd and error.value.rcvd.code == 1009
    again = Page.at(server)
    assert again.ask("refresh")["say"] == "done"
    again.socket.close()


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20), lambda inner: st.lists(inner, max_size=4), max_leaves=6
)


@settings(max_examples=40)
@given(
    op=st.sampled_from([name for name in (one["name"] for one in telling.operations()) if not name.startswith(("redraw", "layer rem"))]),
    params=st.dictionaries(
        st.sampled_from(["path", "size", "on", "layer", "rate", "glyph", "by", "mode", "variant", "value", "name", "dx", "side", "x"]),
        VALUES,
        max_size=4,
    ),
)
def test_chance_requests_are_answered(served, op, params):
    server, session = served
    page = Page.at(server)
    found = page.apply(op, **params)
    assert found["say"] == "done" or "fault" not in found["text"], found
    assert page.items == shown(session.drawing)
    page.socket.close()


def test_an_edit_is_seen_by_every_page_and_undone_for_all(own):
    server, session = own
    one, two = Page.at(server), Page.at(server)
    assert one.apply("insert", **BRUSH, rate=40)["facts"]["inserted"] == len(one.items) > 10
    two.ask("refresh")
    assert one.items == two.items == shown(session.drawing)
    assert two.apply("erase", path=way((40, 30)), size=4)["say"] == "done"
    assert two.ask("undo")["facts"] == {"entries": 1} and one.ask("undo")["facts"] == {"entries": 1}
    two.ask("refresh")
    assert not two.items and two.state["redo"] == ["insert", "erase"] and two.state["undo"] == []
    assert [message["count"] for message in one.said if message["say"] == "tabs"] == [1, 2]
    two.socket.close()
    while one.said[-1] != {"say": "tabs", "count": 1}:
        one.hear()
    one.socket.close()


def test_a_stroke_in_pieces_is_undone_as_one_and_two_pages_have_groups_of_their_own(own):
    server, session = own
    one, two = Page.at(server), Page.at(server)
    for k in range(4):
        one.apply("insert", path=way((20 + k, 20)), size=3, rate=20, gap=-5, group=7)
    two.apply("insert", path=way((50, 40)), size=3, rate=20, gap=-5, group=7)
    assert [entry.group for entry in session.history.entries] == [1, 1, 1, 1, 2]
    assert one.ask("undo")["facts"] == {"entries": 1} and one.ask("undo")["facts"] == {"entries": 4}
    assert one.ask("redo", count=5)["facts"] == {"entries": 5}
    one.socket.close()
    two.socket.close()


def begun(server: Server) -> Page:
    page = Page.at(server)
    assert page.apply("redraw stipple", dots=300, iterations=1, glyphs="disc")["say"] == "done"
    return page


def test_relaxation_shows_each_step_with_its_figures(own):
    server, session = own
    page = begun(server)
    found = page.apply("relax", variant="uniform", times=5)
    assert found["facts"]["steps"] == 5 and found["facts"]["energy"] > 0
    steps = [message for message in page.said if message["say"] == "step" and message["stage"] == "relax" and message["n"] == found["n"]]
    assert steps and steps[-1]["done"] == steps[-1]["total"] == 5 and {"energy", "movement"} <= set(steps[-1]["facts"])
    assert page.items == shown(session.drawing) and page.state["undo"] == ["relax", "redraw stipple"] and page.state["busy"] is None
    assert page.ask("undo")["facts"] == {"entries": 5}
    page.socket.close()


@pytest.mark.parametrize("order", ["stop", "cancel"])
def test_what_is_played_is_paused_resumed_and_ended_and_a_brush_works_meanwhile(own, order):
    server, session = own
    page = begun(server)
    n = page.send("apply", op="relax", params={}, times=0)
    while page.hear()["say"] != "step":
        pass
    assert page.ask("pause")["say"] == "done"
    assert page.apply("jitter", on="all")["say"] == "done"  # paused: no step comes between this and the next
    done = len(session.history.entries)
    page.ask("refresh")
    assert page.state["busy"] == {"n": n, "op": "relax", "paused": True, "single": False} and len(session.history.entries) == done
    refused = page.apply("relax", times=3)
    assert refused["say"] == "error" and "stop it first" in refused["text"]
    assert page.ask("undo")["say"] == "done"  # which ends what is under way, too
    ended = next(message for message in page.said if message.get("n") == n and message["say"] == "done")
    assert ended["stopped"] and ended["facts"]["steps"] >= 1
    n = page.send("apply", op="relax", params={}, times=0)
    while page.hear().get("n") != n:
        pass
    assert page.ask("pause")["say"] == page.ask("resume")["say"] == page.ask(order)["say"] == "done"
    if not any(message.get("n") == n and message["say"] == "done" for message in page.said):
        page.answer(n)
    assert (session.history.entries[session.history.at - 1].seed == session.history.at - 1) if order == "stop" else True
    kinds = [entry.op for entry in session.history.entries[: session.history.at]]
    assert kinds.count("relax") == (kinds.count("relax") if order == "stop" else done - 2)
    page.ask("refresh")
    assert page.items == shown(session.drawing) and page.state["busy"] is None
    page.socket.close()


def test_a_stop_right_behind_what_it_is_meant_for_is_not_lost(own):
    server, session = own
    page = begun(server)
    played, stopped = page.send("apply", op="relax", params={}, times=0), page.send("stop")
    answers = {}
    while len(answers) < 2:
        message = page.hear()
        if message["say"] in ("done", "error"):
            answers[message["n"]] = message
    assert answers[stopped]["say"] == "done" and answers[played]["stopped"]
    assert page.ask("stop")["text"] == "nothing is under way"
    page.ask("refresh")
    assert page.state["busy"] is None and page.items == shown(session.drawing)
    page.socket.close()


def test_a_long_operation_tells_its_steps_and_can_be_stopped(own):
    server, session = own
    page = Page.at(server)
    n = page.send("apply", op="redraw stipple", params={"dots": 20_000, "iterations": 100_000})
    while (message := page.hear())["say"] != "step" or message["stage"] != "relax":
        pass
    assert page.ask("stop")["say"] == "done"
    found = next((message for message in page.said if message.get("n") == n and message["say"] == "done"), None) or page.answer(n)
    assert found["stopped"] and not session.history.entries
    assert any(message["say"] == "state" and message["busy"] and message["busy"]["op"] == "redraw stipple" for message in page.said)
    page.socket.close()


def test_what_only_reads_is_answered_while_a_long_operation_is_under_way(own):
    server, session = own
    page = begun(server)
    before = formats.to_bytes(session.sheet(), "svg")
    n = page.send("apply", op="redraw stipple", params={"dots": 20_000, "iterations": 100_000})
    while page.hear()["say"] != "step":
        pass
    assert page.ask("export", files=["meanwhile.svg"])["facts"]["files"] == ["meanwhile.svg"]
    assert page.ask("check", file="meanwhile.svg")["facts"]["findings"] is not None
    assert "ramp.png" in page.ask("files")["facts"]["files"]
    assert page.ask("show", what="cells")["say"] == "done" and page.lines[-1][0] == 0
    page.ask("refresh")
    assert page.state["busy"] == {"n": n, "op": "redraw stipple", "paused": False, "single": True}
    assert not any(message.get("n") == n and message["say"] in ("done", "error") for message in page.said)
    brush, later = page.send("apply", op="jitter", params={"on": "all"}), page.send("export", files=["later.svg"])
    assert page.ask("cancel")["say"] == "done"
    while not {n, brush, later} <= {message["n"] for message in page.said if message["say"] == "done"}:
        page.hear()
    order = [message["n"] for message in page.said if message["say"] == "done" and message["n"] in (n, brush, later)]
    assert order == [n, brush, later]  # what came after a change is of what that made
    page.socket.close()
    assert (session.folder / "meanwhile.svg").read_bytes() == before
    assert (session.folder / "later.svg").read_bytes() == formats.to_bytes(session.sheet(), "svg") != before


def test_what_is_played_ends_when_nothing_changes_any_more_or_the_last_page_goes(own):
    server, session = own
    page = Page.at(server)
    page.apply("insert", path=way((40, 30)), size=0, rate=1)
    found = page.apply("relax", variant="uniform", times=0, step=1)
    assert found["notes"] == ["nothing changes any more"]
    page.apply("insert", path=way((20, 20)), size=0, rate=1)
    page.send("apply", op="jitter", params={"on": "all"}, times=0)
    while page.hear()["say"] != "step":
        pass
    page.socket.close()
    again = Page.at(server)
    end = time.monotonic() + PATIENCE
    while again.state["busy"] and time.monotonic() < end:
        again.ask("refresh")
    assert again.state["busy"] is None and session.history.entries
    again.socket.close()


def test_a_step_that_fails_is_said_and_what_was_done_before_it_stays(own):
    server, session = own
    page = begun(server)
    found = page.apply("relax", variant="mosaic", times=3)
    assert found["say"] == "error" and "there are no tiles here" in found["text"]
    assert page.state["busy"] is None and len(session.history.entries) == 1
    page.socket.close()


def test_cells_axes_and_flow_are_shown_where_they_lie(own):
    server, session = own
    page = Page.at(server)
    for what in ("cells", "axes", "flow"):  # of nothing
        assert page.ask("show", what=what)["say"] == "done"
    page.apply("insert", path=way((25, 30), (55, 30)), size=0, rate=1)
    page.lines.clear()
    for what in ("cells", "axes", "flow"):
        assert page.ask("show", what=what)["say"] == "done"
    (cells, axes, flow) = (found for _, found in page.lines)
    assert len(cells) == 2 and sorted(np.ptp(cell, axis=0).tolist() for cell in cells) == [[30, 40], [30, 40]]
    assert len(axes) == 4 and np.abs(axes[0].mean(axis=0) - session.drawing.layers[0].items.xy[0]).max() < 0.2
    slope = np.array([line[1] - line[0] for line in flow])
    assert np.abs(slope[:, 0]).max() < 0.05 * np.abs(slope[:, 1]).min()  # the tone changes along x alone
    page.socket.close()


def test_a_page_exports_checks_lists_and_opens_files_of_the_folder(own):
    server, session = own
    page = begun(server)
    assert page.ask("export", files=["a.svg", "a.pdf"], options={"compact": True})["facts"]["files"] == ["a.svg", "a.pdf"]
    again = page.ask("export", files=["a.svg"])
    assert again["say"] == "error" and "is there already" in again["text"]
    assert page.ask("export", files=["a.svg"], overwrite=True)["say"] == "done"
    assert page.ask("check", file="a.pdf")["facts"]["errors"] == 0
    assert page.ask("files")["facts"]["files"] == ["a.svg", "ramp.png"]
    (session.folder / "newer.svg").write_bytes(
        (session.folder / "a.svg").read_bytes().replace(b'"schema": 1, "size', b'"schema": 9, "size')
    )
    refused = page.ask("open", file="newer.svg")
    assert refused["say"] == "error" and "made by a newer crowquill" in refused["text"] and page.hello["name"] == "ramp.png"
    before = page.items
    assert page.ask("open", file="a.svg")["say"] == "done"
    assert (
        page.hello["name"] == "a.svg"
        and page.state["reset"]
        and [one["um"] for one in page.items.values()] == [one["um"] for one in before.values()]
    )
    assert page.ask("open", file="ramp.png")["say"] == "done" and page.state["undo"] == ["redraw stipple"]
    page.socket.close()


def test_what_is_not_edited_is_shown_as_it_is(tmp_path):
    picture(tmp_path / "ramp.png")
    made = ["halftone", str(tmp_path / "ramp.png"), str(tmp_path / "bits.svg"), "--form", "pixels", "--cells-per-inch", "100"]
    made += ["--paper", "80x60mm", "--margin", "10mm"]
    assert main(made) == 0
    with serving(Session(tmp_path / "bits.svg")) as server:
        page = Page.at(server)
        (layer,) = page.state["layers"]
        assert layer["kind"] == "still" and layer["items"] == 0
        status, headers, data = got(server, f"/{server.token}/still-{layer['id']}.svg")
        assert status == 200 and headers["content-type"] == "image/svg+xml" and b"<image" in data
        assert got(server, f"/{server.token}/still-77.svg")[0] == 404
        assert page.apply("layer edit", layer=layer["id"], cmyk=[1, 0, 0, 0])["say"] == "error"
        page.socket.close()


def test_a_full_disk_is_said_in_the_page_and_so_is_room(own, monkeypatch):
    server, session = own
    page = Page.at(server)
    monkeypatch.setattr("crowquill.editor.hub.RETRY", 0.05)
    with full_disk(session):
        assert page.apply("insert", **BRUSH, rate=20)["say"] == "done"
        page.ask("refresh")
        saved = [message for message in page.said if message["say"] == "saved"]
        assert saved == [{"say": "saved", "ok": False, "waiting": 1, "text": saved[0]["text"]}] and "no space left" in saved[0]["text"]
    while (message := page.hear())["say"] != "saved":
        pass
    assert message["ok"] and message["waiting"] == 0
    assert len(session.path.read_bytes().splitlines()) == 2
    page.socket.close()


COMMAND = (sys.executable, "-m", "crowquill", "edit")


def started(folder: Path, *arguments: str) -> tuple[subprocess.Popen[str], str]:
    """The editor as a process of its own, and its address."""
    run = subprocess.Popen([*COMMAND, *arguments, "--no-browser"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert run.stdout is not None
    return run, run.stdout.readline().strip()


class At:
    """What Page.at asks of a server."""

    def __init__(self, address: str) -> None:
        self.address = address


def test_a_killed_editor_goes_on_where_it_was_and_ctrl_c_leaves_no_debris(tmp_path):
    picture(tmp_path / "ramp.png")
    run, address = started(tmp_path, "ramp.png", "--paper", "80x60mm", "--margin", "10mm")
    page = Page.at(At(address))
    assert page.apply("insert", **BRUSH, rate=40)["say"] == "done"
    assert page.apply("relax", times=3)["say"] == "done"
    n = page.send("apply", op="relax", params={}, times=0)
    while page.hear().get("n") != n:
        pass
    seen = dict(page.items)
    run.kill()
    run.communicate(timeout=PATIENCE)
    assert (tmp_path / "ramp.png.edits.lock").exists()
    page.socket.close()

    again, address = started(tmp_path, "ramp.png")
    page = Page.at(At(address))
    assert len(page.items) == len(seen) and page.state["undo"][-2:] == ["relax", "insert"]
    assert page.ask("export", files=["a.svg"])["say"] == "done"
    second = subprocess.run(
        [*COMMAND, "ramp.png", "--no-browser"], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert second.returncode == 2 and f"is being edited already, by process {again.pid}" in second.stderr
    again.send_signal(signal.SIGINT)
    with pytest.raises(ConnectionClosed) as error:
        while True:
            page.hear()
    assert error.value.rcvd and error.value.rcvd.code == 1001 and page.said[-1]["say"] == "closed"
    out, err = again.communicate(timeout=PATIENCE)
    assert (again.returncode, err) == (0, "") and "edits are in ramp.png.edits" in out
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == ["a.svg", "ramp.png", "ramp.png.edits"]
    assert {path.name for path in tmp_path.iterdir() if path.is_dir()} <= {"ramp.png.edits.states"}
    assert main(["replay", str(tmp_path / "ramp.png.edits"), str(tmp_path / "b.svg")]) == 0
    assert (tmp_path / "b.svg").read_bytes() == (tmp_path / "a.svg").read_bytes()


@pytest.mark.parametrize(("stop", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143)])
def test_an_editor_that_was_only_looked_at_leaves_nothing(tmp_path, stop, code):
    picture(tmp_path / "ramp.png")
    run, address = started(tmp_path, "ramp.png")
    Page.at(At(address)).socket.close()
    run.send_signal(stop)
    _, err = run.communicate(timeout=PATIENCE)
    assert (run.returncode, err) == (code, "")
    assert [path.name for path in tmp_path.iterdir()] == ["ramp.png"]


def test_a_port_in_use_is_refused_in_a_line(tmp_path, capsys):
    picture(tmp_path / "ramp.png")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        assert main(["edit", str(tmp_path / "ramp.png"), "--no-browser", "--port", str(taken.getsockname()[1])]) == 2
    line = capsys.readouterr().err
    assert "already in use" in line and "--port" in line and line.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["ramp.png"]


def test_the_checks_of_this_file_see_a_frame_that_is_cut_off():
    page = Page(None)  # type: ignore[arg-type]
    with pytest.raises((AssertionError, ValueError, struct.error)):
        page._take(struct.pack("<4I4II", 1, 1, 1, 0, 1, 2, 63, 0, 5))
