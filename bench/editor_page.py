"""What the editor's page costs in software rendering: frames while panning, and from the brush to the screen.

100 000 dots of a nib on A4, Debian's Chromium without a GPU. Prints frames a second while the paper is dragged at four zooms, and
for each brush the least, the median and the worst time from the pen coming down to the pixels that show what it did; last, what a step
of relaxation costs on the page and without it.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from browser import FLAGS, QUIET, Array, Editor, browsing, serving
from rendering import require
from websockets.sync.client import connect

from crowquill import Ink, Layer, Sheet, Tone, glyphs, save
from crowquill.marks import Marks
from crowquill.relax import lloyd

Ask = Callable[..., Any]
COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
PAPER, MARGIN = (210.0, 297.0), 15.0  # mm
ZOOMS = (1.0, 2.0, 6.0, 20.0)  # times the whole paper
BRUSHES = {"insert": "b", "erase": "e", "push": "p", "jitter": "j", "resize": "s", "relax": "r", "relax objects": "r"}
DABS = 15
TIMES = 5  # steps of relaxation
STEPS = """async (times) => {
  const { desk, painted } = crowquill, began = performance.now();
  await desk.apply('relax', { variant: 'uniform', on: 'all' }, { times });
  while (painted.value.revision < desk.drawing.state.value.revision) await new Promise((done) => setTimeout(done, 1));
  return performance.now() - began;
}"""
PAN = """async (seconds) => {
  const { desk, painted } = crowquill, before = painted.value.frames, costs = [], began = performance.now();
  let counting = true;
  painted.changed.on((now) => counting && costs.push(now.cost));
  await new Promise((done) => {
    const step = () => {
      const t = performance.now() - began;
      if (t > 1000 * seconds) return done();
      desk.viewport.pan(9 * Math.cos(t / 700), 7 * Math.sin(t / 500));
      requestAnimationFrame(step);
    };
    step();
  });
  counting = false;
  return [(painted.value.frames - before) / ((performance.now() - began) / 1000), Math.max(...costs)];
}"""
WATCH = """() => {
  const { desk, painted } = crowquill;
  let down = 0, revision = 0;
  window.delays = [];
  document.getElementById('surface').addEventListener('pointerdown', (event) => {
    down = performance.timeOrigin + event.timeStamp;
    revision = desk.drawing.state.value.revision;
  }, true);
  painted.changed.on((now) => {
    if (down && now.revision > revision) { delays.push(now.at - down); down = 0; }
  });
}"""


def drawing(file: Path) -> None:
    """Draws dots on a shaken grid."""
    rng = np.random.default_rng(0)
    width, height = PAPER[0] - 2 * MARGIN, PAPER[1] - 2 * MARGIN
    across = round(np.sqrt(COUNT * width / height))
    down = COUNT // across
    x, y = np.meshgrid((np.arange(across) + 0.5) * width / across, (np.arange(down) + 0.5) * height / down)
    xy = np.stack([x.ravel(), y.ravel()], axis=1) + MARGIN
    nib = glyphs.load("nib-02").glyphs
    n = len(xy)
    marks = Marks.of(xy + rng.normal(0, 0.1, xy.shape), nib, scale=0.2, angle=rng.uniform(0, 7, n), glyph=rng.integers(len(nib), size=n))
    save(Sheet(PAPER, (Layer(Ink(), marks),)), file)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "dots.svg"
        drawing(file)
        with serving(file) as address, browsing() as browser:
            editor = Editor(browser, address, 1360, 860)
            print(f"{editor.state()['marks']} marks, window 1360 x 860")
            for zoom in ZOOMS:
                editor.page.evaluate("(zoom) => { const v = crowquill.desk.viewport; v.all(); v.zoom(zoom); }", zoom)
                editor.page.wait_for_timeout(1000)
                frames, worst = editor.page.evaluate(PAN, 3)
                print(f"pan at {zoom:g} x: {frames:.0f} frames a second, the dearest {worst:.1f} ms of the painter")
            editor.page.evaluate("crowquill.desk.viewport.all()")
            editor.page.evaluate(WATCH)
            for row, (name, key) in enumerate(BRUSHES.items()):
                delays = dabs(editor, key, 40.0 + 32 * row, "objects" if "objects" in name else "uniform")
                print(f"{name} to the screen: {delays[0]:.0f} ms at least, median {delays[len(delays) // 2]:.0f}, worst {delays[-1]:.0f}")
            xy = editor.xy()
        with serving(file) as address, looking(address) as ask:
            shown, bare = steps(ask, xy)
            print(f"a step of relaxation, all seen: {shown:.0f} ms; as commands do it: {bare:.0f} ms, {shown / bare:.2f} times as much")


@contextmanager
def looking(address: str) -> Iterator[Ask]:
    """A page of an address that nothing listens to: what a test's browser reports of each frame costs as much as showing it.

    Gives what a function of the page's own words comes to, called with a number.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        own = [f"--user-data-dir={profile}", "--remote-debugging-port=0", "--window-size=1360,860", address]
        with subprocess.Popen([require("chromium"), *FLAGS, *own], stderr=subprocess.PIPE, text=True) as browser:
            try:
                lines = iter(browser.stderr or [])
                port = next(line for line in lines if "DevTools listening" in line).split(":")[2].split("/")[0]
                threading.Thread(target=lambda: list(lines), daemon=True).start()
                yield from asking(port)
            finally:
                browser.terminate()


def asking(port: str) -> Iterator[Ask]:
    """The one page of a browser, once it is at rest."""
    with urlopen(f"http://127.0.0.1:{port}/json/list") as answer:
        (page,) = [one for one in json.load(answer) if one["type"] == "page"]
    with connect(page["webSocketDebuggerUrl"], max_size=None) as socket:

        def ask(words: str, value: float = 0) -> Any:
            params = {"expression": f"({words})({value})", "awaitPromise": True, "returnByValue": True}
            socket.send(json.dumps({"id": 1, "method": "Runtime.evaluate", "params": params}))
            return json.loads(socket.recv()).get("result", {}).get("result", {}).get("value")  # none while the page is loaded

        while not ask(QUIET):
            time.sleep(0.1)
        yield ask


def steps(ask: Ask, xy: Array) -> tuple[float, float]:
    """ms for a step of uniform relaxation of all dots, seen on the page, and as commands do it, side by side."""
    tone = Tone(np.ones((297, 210)), PAPER)
    shown, bare = [], []
    for _ in range(3):
        shown.append(ask(STEPS, TIMES) / TIMES / 1000)
        states = lloyd(xy, tone, exponent=0.0)
        next(states)
        began = time.perf_counter()
        for _ in range(TIMES):
            next(states)
        bare.append((time.perf_counter() - began) / TIMES)
    return 1000 * min(shown), 1000 * min(bare)


def dabs(editor: Editor, key: str, y: float, variant: str) -> list[float]:
    """How long each of some dabs took to be seen, ms, the least first; the first two, which compile, are left out."""
    editor.take(key, size=5.0, variant=variant)  # without a picture there is no tone to weigh by; other brushes know no variant
    editor.page.evaluate("delays.length = 0")
    for k in range(DABS + 2):
        x = 25 + 9 * k
        editor.stroke((x, y), (x + 2, y), steps=2)
    return sorted(editor.page.evaluate("delays")[2:])


if __name__ == "__main__":
    main()
