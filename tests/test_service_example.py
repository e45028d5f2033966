"""The example of a web service: what it draws, refuses, and gives up; and, for a minute, twenty clients at once."""

from __future__ import annotations

import contextlib
import http.client
import importlib.util
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import clusters
import numpy as np
import pytest
import uvicorn
from PIL import Image
from test_service import QUICK, png

from crowquill import kernel
from crowquill.service import LimitError, drawing, read

FILE = Path(__file__).parent.parent / "examples" / "service.py"
QUERY = "?" + "&".join(f"{key}={value}" for key, value in QUICK.items())


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Any, int]]:
    """The example as a module and the port where it listens, in a thread of ours."""
    monkeypatch.setattr(kernel, "CORES", kernel.CORES)  # put back what it takes its share of
    spec = importlib.util.spec_from_file_location("service_example", FILE)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    with contextlib.closing(socket.create_server(("127.0.0.1", 0))) as listening:
        server = uvicorn.Server(uvicorn.Config(module.app, log_level="error"))
        thread = threading.Thread(target=server.run, args=([listening],))
        thread.start()
        yield module, listening.getsockname()[1]
        server.should_exit = True
        thread.join()
        module.at_work.shutdown()


def asked(port: int, path: str, body: Any = None) -> tuple[int, bytes]:
    """Status and body of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=clusters.PATIENCE)
    with contextlib.closing(connection):
        connection.request("POST", path, png() if body is None else body)
        answer = connection.getresponse()
        return answer.status, answer.read()


def test_it_is_short():
    assert len(FILE.read_text().splitlines()) < 80


def test_it_draws_what_drawing_gives(service):
    _, port = service
    assert asked(port, f"/stipple.pdf{QUERY}") == (200, drawing(png(), "stipple", "pdf", QUICK))
    assert asked(port, f"/stipple.png{QUERY}&dpi=100") == (200, drawing(png(), "stipple", "png", QUICK | {"dpi": 100}))


@pytest.mark.parametrize(
    ("path", "body", "code", "said"),
    [
        ("/stiple.pdf", None, 400, b"no style 'stiple'; did you mean stipple?"),
        ("/stipple.exe", None, 404, b"there are pdf, svg, png, tiff"),
        ("/stipple.svg?dots=many", None, 400, b"dots is 'many'; it takes a number"),
        ("/stipple.svg?glyphs=/etc/hosts.svg", None, 400, b"glyphs is '/etc/hosts.svg'; here it takes no file"),
        ("/stipple.svg?dots=50001", None, 413, b"the drawing takes 50,001 dots, and 50,000 are the limit; ask for less"),
        ("/stipple.svg", b"no picture", 400, b"picture: not a picture that can be read"),
        ("/stipple.svg", b"", 400, b"picture: the file is empty"),
    ],
)
def test_what_is_refused_is_said(service, path, body, code, said):
    found, told = asked(service[1], path, body)
    assert found == code
    assert told.startswith(said)


def test_a_body_that_is_too_large_is_refused_while_it_comes_in(service):
    module, port = service
    with socket.create_connection(("127.0.0.1", port), timeout=clusters.PATIENCE) as client:
        client.sendall(b"POST /stipple.svg HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n")
        sent, part = 0, b"%x\r\n" % 100_000 + b"0" * 100_000 + b"\r\n"
        with contextlib.suppress(ConnectionError):
            while sent < 20 * module.BYTES:  # it does not wait for the end, for there is none
                client.sendall(part)
                sent += 100_000
                client.settimeout(0.001)
                with contextlib.suppress(TimeoutError):
                    answer = client.recv(1000)
                    break
                client.settimeout(clusters.PATIENCE)
    assert answer.startswith(b"HTTP/1.1 413 ")
    assert sent < 3 * module.BYTES


class Stuck:
    """In place of drawing: at work until it is let go or cancelled."""

    def __init__(self) -> None:
        self.begun, self.cancelled, self.go = 0, 0, threading.Event()

    def __call__(self, *_: object, cancelled: Any, **__: object) -> bytes:
        self.begun += 1
        while not self.go.wait(0.01):
            if cancelled():
                self.cancelled += 1
                raise CancelledError
        return b"drawn"


def test_a_client_that_goes_gives_up_its_drawing(service, monkeypatch):
    module, port = service
    monkeypatch.setattr(module, "drawing", stuck := Stuck())
    with socket.create_connection(("127.0.0.1", port)) as client:
        client.sendall(b"POST /stipple.svg HTTP/1.1\r\nHost: a\r\nContent-Length: 1\r\n\r\n0")
        clusters.waited_for(lambda: stuck.begun)
    clusters.waited_for(lambda: stuck.cancelled)
    stuck.go.set()
    assert asked(port, "/stipple.svg") == (200, b"drawn")


def test_two_are_at_work_twenty_wait_and_more_are_sent_away(service, monkeypatch):
    module, port = service
    monkeypatch.setattr(module, "drawing", stuck := Stuck())
    answers: list[tuple[int, bytes]] = []
    clients = [threading.Thread(target=lambda: answers.append(asked(port, "/stipple.svg"))) for _ in range(22)]
    for client in clients:
        client.start()
    clusters.waited_for(module.admitted.locked)
    assert asked(port, "/stipple.svg") == (503, b"too many are waiting; come again")
    assert stuck.begun == 2
    stuck.go.set()
    for client in clients:
        client.join()
    assert answers == [(200, b"drawn")] * 22


def test_a_refusal_while_at_work_is_said_and_the_place_is_free_again(service, monkeypatch):
    module, port = service
    monkeypatch.setattr(module, "drawing", lambda *_, **__: (_ for _ in ()).throw(LimitError("seconds", 21, 20)))
    for _ in range(25):
        assert asked(port, "/stipple.svg") == (413, b"the drawing takes 21.0 seconds, and 20 are the limit; ask for less")


# twenty clients for a minute


def held(process: int) -> int:
    """The memory that a process holds, kB."""
    return int(Path(f"/proc/{process}/status").read_text().split("VmRSS:")[1].split()[0])


@pytest.mark.soak
def test_twenty_clients_for_a_minute_see_no_error_and_memory_stays_flat(tmp_path):
    pictures = []
    for k in range(4):
        rows, columns = np.mgrid[:300, :400]
        path = tmp_path / f"{k}.png"
        Image.fromarray((255 * (0.6 + 0.35 * np.sin(columns / (20 + k)) * np.cos(rows / 30))).astype(np.uint8)).save(path)
        pictures.append(path.read_bytes())
    kinds = ("pdf?", "svg?", "png?dpi=100&")
    paths = [*(f"/stipple.{kind}dots={dots}&paper=a5" for kind in kinds for dots in (300, 1500)), "/screen.pdf?paper=a5"]
    wanted = {(path, k): drawing(data, *split(path)) for path in paths for k, data in enumerate(pictures)}
    with contextlib.closing(socket.create_server(("127.0.0.1", 0))) as found:
        port = found.getsockname()[1]
    with subprocess.Popen([sys.executable, str(FILE), str(port)]) as run:
        clusters.waited_for(lambda: reached(port))
        end, errors, counts, memory = time.monotonic() + 60, [], [0] * 20, []

        def client(own: int) -> None:
            turn = own
            while time.monotonic() < end:
                path, k = paths[turn % len(paths)], turn % 4
                code, data = asked(port, path, pictures[k])
                if (code, data) != (200, wanted[path, k]):
                    errors.append((code, data[:80]))
                counts[own] += 1
                turn += 7

        clients = [threading.Thread(target=client, args=(own,)) for own in range(20)]
        for thread in clients:
            thread.start()
        while time.monotonic() < end:
            time.sleep(1)
            memory.append(held(run.pid))
        for thread in clients:
            thread.join()
        run.send_signal(signal.SIGINT)
        assert run.wait(timeout=clusters.PATIENCE) in (0, -signal.SIGINT)
    third = len(memory) // 3
    before, after = max(memory[third : 2 * third]), max(memory[-third:])
    print(f"{sum(counts)} drawings for 20 clients; at most {before // 1000} MB from 20 to 40 s, {after // 1000} MB after that")
    assert errors == []
    assert min(counts) > 0
    assert after < 1.05 * before


def split(path: str) -> tuple[str, str, dict[str, Any]]:
    """What drawing() takes for a path of the service."""
    name, _, query = path.removeprefix("/").partition("?")
    style, kind = name.split(".")
    return style, kind, read(style, dict(part.split("=") for part in query.split("&")))


def reached(port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
        return True
    return False
