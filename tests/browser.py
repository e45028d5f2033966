"""A page of the editor in a browser, on the real server: what tests do there, and what they find on its screen and in its store."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright
from rendering import Window, require

Array = npt.NDArray[np.float64]
PATIENCE = 60.0  # seconds after which what is waited for will not come
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
BESIDE = "#overlay, #across, #down, #ring, #status, #messages"  # what lies over the drawing
COLUMNS = """() => {
  const { items } = crowquill.desk.drawing, id = [];
  for (let k = 0; k < items.end; k++) if (items.layer[k]) id.push(k);
  const of = (column) => id.map((k) => column[k]);
  return { id, layer: of(items.layer), x: of(items.x), y: of(items.y), scale: of(items.scale), turn: of(items.turn), kind: of(items.kind),
           fill: of(items.fill), flags: of(items.flags) };
}"""
QUIET = """() => {
  const { link, drawing } = crowquill.desk, state = drawing.state.value, painted = crowquill.painted.value;
  return link.line.value === 'open' && state && !state.busy && drawing.missing === 0 && link.waiting.size === 0
    && painted?.revision === state.revision;
}"""


@contextmanager
def serving(file: Path, *options: str) -> Iterator[str]:
    """The address of a server that edits a file, in a process of its own; it ends with the block."""
    command = [sys.executable, "-m", "crowquill", "edit", str(file), "--no-browser", *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    try:
        assert process.stdout
        yield next(line for line in process.stdout if line.startswith("http")).strip()
    finally:
        process.terminate()
        process.communicate(timeout=PATIENCE)


@contextmanager
def browsing() -> Iterator[Browser]:
    """A browser without a window, with a profile of its own."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=require("chromium"), args=FLAGS)
        yield browser
        browser.close()


class Editor:
    """The editor's page."""

    def __init__(self, browser: Browser, address: str, width: int = 1200, height: int = 800, **context: Any) -> None:
        self.page: Page = browser.new_page(viewport={"width": width, "height": height}, **context)
        self.faults: list[str] = []
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.goto(address)
        self.rest()

    def until(self, condition: str, what: str = "") -> None:
        """Waits for a condition in the page's own words."""
        end = time.monotonic() + PATIENCE
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, f"waited in vain for {what or condition}; the page says {self.said()}"
            time.sleep(0.02)

    def rest(self) -> None:
        """Waits until nothing is under way and all is on the screen."""
        self.until(QUIET, "the page to come to rest")

    def said(self) -> list[str]:
        """The messages on the page."""
        return self.page.locator("#messages p").all_inner_texts()

    def state(self) -> dict[str, Any]:
        """What the server said of the drawing last."""
        return dict(self.page.evaluate("crowquill.desk.drawing.state.value"))

    def columns(self) -> dict[str, npt.NDArray[np.int64]]:
        """Every item's columns, by rising id."""
        return {name: np.array(values, np.int64) for name, values in self.page.evaluate(COLUMNS).items()}

    def xy(self) -> Array:
        """Where all items lie, mm."""
        found = self.columns()
        return np.stack([found["x"], found["y"]], axis=1) / 1000.0

    def apply(self, op: str, **params: Any) -> None:
        """Has an operation done, by the page's own road."""
        self.page.evaluate("([op, params]) => crowquill.desk.apply(op, params)", [op, params])
        self.rest()

    def show(self, left: float, top: float, scale: float) -> None:
        """Brings a place on the paper, mm, to the corner of the canvas beside the rulers, at px to the mm."""
        self.page.evaluate(
            "([x, y, s]) => { const v = crowquill.desk.viewport; v.scale = s; v.x = 20 - x * s; v.y = 20 - y * s; v.changed.say(); }",
            [left, top, scale],
        )
        time.sleep(0.2)  # the painter waits for the end of a zoom
        self.page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        self.rest()

    def screen(self, x: float, y: float) -> tuple[float, float]:
        """The place in the window, px, of one on the paper, mm."""
        left, top = self.page.evaluate("([x, y]) => crowquill.desk.viewport.px(x, y)", [float(x), float(y)])
        box = self.page.locator("#surface").bounding_box()
        assert box
        return left + box["x"], top + box["y"]

    def stroke(self, *points: tuple[float, float], steps: int = 6) -> None:
        """Draws from point to point, mm, with the tool in hand."""
        self.page.mouse.move(*self.screen(*points[0]))
        self.page.mouse.down()
        for point in points[1:]:
            self.page.mouse.move(*self.screen(*point), steps=steps)
        self.page.mouse.up()
        self.rest()

    def take(self, key: str, **knobs: Any) -> None:
        """Takes the tool of a key in hand and sets its knobs."""
        self.page.locator("#surface").focus()
        self.page.keyboard.press(key)
        set_ = "([name, value]) => { const { desk } = crowquill; desk.settings.set(desk.tool.value.operation, name, value); }"
        for name, value in knobs.items():
            self.page.evaluate(set_, [name, value])

    def press(self, keys: str) -> None:
        """Presses keys on the canvas and waits for what comes of it."""
        self.page.locator("#surface").focus()
        self.page.keyboard.press(keys)
        self.rest()

    def tab(self, name: str) -> None:
        """Shows a panel."""
        self.page.get_by_role("tab", name=name).click()

    def ink(self, window: Window, scale: float) -> Array:
        """How dark each pixel of a window of the paper is on the screen, 0 to 1, at px to the mm; nothing but the drawing is shown."""
        self.show(window.x, window.y, scale)
        hide = f"(how) => document.querySelectorAll('{BESIDE}').forEach((e) => {{ e.style.visibility = how; }})"
        self.page.evaluate(hide, "hidden")
        x, y = self.screen(window.x, window.y)
        clip = {"x": x, "y": y, "width": window.width * scale, "height": window.height * scale}
        shot = self.page.screenshot(clip=clip, type="png")  # type: ignore[arg-type]
        self.page.evaluate(hide, "")
        with Image.open(io.BytesIO(shot)) as image:
            return 1 - np.asarray(image.convert("L"), np.float64) / 255


def log_of(file: Path) -> list[dict[str, Any]]:
    """The lines of a file's log."""
    return [json.loads(line) for line in file.with_name(file.name + ".edits").read_text(encoding="utf-8").splitlines()]
