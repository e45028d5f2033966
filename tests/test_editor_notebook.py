"""The editor in a notebook's cell: the same page, without a network."""

from __future__ import annotations

import base64
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import PATIENCE, browsing

from crowquill import Ink, Layer, Marks, Sheet
from crowquill.editor.notebook import Canvas
from crowquill.glyphs import load

HOST = """([esm]) => {
  const heard = [], lives = [];
  window.page = (content, bytes) => {
    const buffers = bytes.map((one) => new DataView(Uint8Array.from(atob(one), (c) => c.charCodeAt(0)).buffer));
    heard.forEach((one) => one(content, buffers));
  };
  const model = { get: (name) => window.values[name], send: (content) => window.kernel(content),
                  on: (what, one) => of(what).push(one), off: (what, one) => of(what).splice(of(what).indexOf(one), 1) };
  const of = (what) => ({ 'msg:custom': heard, comm_live_update: lives })[what];
  window.dead = () => lives.forEach((one) => one());
  const url = URL.createObjectURL(new Blob([esm], { type: 'text/javascript' }));
  return import(url).then((found) => { window.gone = found.default.render({ model, el: document.body }); });
}"""


@pytest.fixture
def canvas() -> Iterator[Canvas]:
    """A canvas over 400 discs on a grid."""
    x, y = np.meshgrid(np.arange(20) * 2 + 11.0, np.arange(20) * 2 + 11.0)
    marks = Marks.of(np.stack([x.ravel(), y.ravel()], axis=1), load("disc").glyphs, scale=0.5)
    found = Canvas(Sheet((60, 60), (Layer(Ink(), marks),)))
    yield found
    found.close()


def until(condition: Callable[[], Any], meanwhile: Callable[[], None] = lambda: time.sleep(0.02)) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        meanwhile()


def test_what_a_view_asks_for_is_done_to_the_sheet(canvas: Canvas, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[tuple[dict[str, Any], list[bytes]]] = []
    monkeypatch.setattr(canvas, "send", lambda content, buffers=(): said.append((content, list(buffers))))
    canvas.hear({"view": "a", "open": True})
    canvas.hear({"view": "a", "text": '{"do": "apply", "n": 1, "op": "erase", "params": {"path": [20, 20, 1], "size": 10}}'})
    until(lambda: any('"say": "done"' in content.get("text", "") for content, _ in said))
    assert [content for content, _ in said if '"say": "hello"' in content.get("text", "")]
    assert [buffers for content, buffers in said if "frame" in content]
    left = canvas.sheet.marks.xy
    assert len(left) < 400 and np.hypot(*(left - 20).T).min() > 5
    canvas.hear({"view": "a", "get": "libraries.json"})
    canvas.hear({"view": "a", "get": "../secret"})
    until(lambda: sum("got" in content for content, _ in said) == 2)
    got = {content["got"]: buffers for content, buffers in said if "got" in content}
    assert got["libraries.json"][0].startswith(b"{") and got["../secret"] == []


def test_the_page_in_a_cell_draws_and_shows(canvas: Canvas, monkeypatch: pytest.MonkeyPatch) -> None:
    waiting: list[tuple[dict[str, Any], list[str]]] = []
    monkeypatch.setattr(
        canvas, "send", lambda content, buffers=(): waiting.append((content, [base64.b64encode(one).decode() for one in buffers]))
    )
    with browsing() as browser:
        page = browser.new_page(viewport={"width": 1100, "height": 700})
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.expose_function("kernel", canvas.hear)
        page.evaluate("(values) => { window.values = values; }", {"page": canvas.page, "height": 640})
        page.evaluate(HOST, [canvas._esm])

        def carry() -> None:
            while waiting:
                page.evaluate("([content, buffers]) => page(content, buffers)", list(waiting.pop(0)))
            page.wait_for_timeout(20)

        frame = page.frames[1]
        until(lambda: frame.evaluate("window.crowquill?.desk.drawing.state.value?.marks === 400"), carry)
        frame.locator("#surface").focus()
        page.keyboard.press("e")
        page.keyboard.press("Enter")  # in the middle of the paper
        until(lambda: frame.evaluate("crowquill.desk.drawing.state.value.marks < 400"), carry)
        until(lambda: frame.evaluate("crowquill.painted.value.revision === crowquill.desk.drawing.state.value.revision"), carry)
        page.evaluate("dead()")  # as a kernel that begins anew
        until(lambda: frame.evaluate("!document.getElementById('banner').hidden"), carry)
        assert "run the cell again" in frame.locator("#banner").inner_text()
        page.wait_for_timeout(1000)  # it tries to come back
        assert frame.locator("#banner").is_visible()
        page.evaluate("gone()")
        assert faults == []
    assert np.hypot(*(canvas.sheet.marks.xy - 30).T).min() > 2


def test_a_widget_that_is_closed_says_so_to_its_views(canvas: Canvas, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[dict[str, Any]] = []
    monkeypatch.setattr(canvas, "send", lambda content, _=(): said.append(content))
    canvas.hear({"view": "a", "open": True})
    until(lambda: said)
    canvas.close()
    assert {"view": "a", "closed": 1001} in said


def test_a_file_keeps_its_edits_beside_it(canvas: Canvas, tmp_path: Path) -> None:
    from crowquill import save

    save(canvas.sheet, tmp_path / "dots.svg")
    found = Canvas(tmp_path / "dots.svg")
    found.hear({"view": "a", "open": True})
    found.hear({"view": "a", "text": '{"do": "apply", "n": 1, "op": "erase", "params": {"on": "all"}}'})
    until(lambda: (tmp_path / "dots.svg.edits").exists() and not sum(len(layer.art) for layer in found.sheet.layers))
    found.close()
    assert (tmp_path / "dots.svg.edits").exists()
