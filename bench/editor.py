"""What the editor takes, measured at its socket: a process of its own serves, this one is the page.

Steps of relaxation are beside the library's own in the same run; brushes are in milliseconds from the request to the last byte of
what they changed. Nothing is asserted.
"""

import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from common import SITES, seconds, shaded
from PIL import Image
from websockets.sync.client import ClientConnection, connect

from crowquill import relax
from crowquill.editor.session import Session

STROKES = {
    "insert": {"rate": 5, "gap": -50},
    "erase": {},
    "push": {},
    "attract": {},
    "jitter": {},
    "resize": {},
    "turn": {},
    "turn along the flow": {"by": "flow"},
    "swap": {},
    "select": {"by": "brush"},
    "paint": {},
    "relax, uniform": {"on": "brush", "variant": "uniform"},
    "relax, weighted": {"on": "brush"},
    "relax, objects": {"on": "brush", "variant": "objects"},
}


@contextmanager
def served(folder: str) -> Iterator[ClientConnection]:
    """A page of an editor of 100 000 dots."""
    picture = Path(folder, "shaded.png")
    Image.fromarray((255 * (1 - shaded(1000))).astype(np.uint8)).save(picture)
    command = [sys.executable, "-m", "crowquill", "edit", str(picture), "--no-browser", "--tone", "grey"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as run:
        address = run.stdout.readline().strip() if run.stdout else ""
        try:
            with connect(f"ws{address[4:]}socket", origin=address.rsplit("/", 2)[0], max_size=None) as page:
                asked(page, "redraw stipple", {"dots": SITES, "iterations": 1})
                yield page
        finally:
            run.send_signal(signal.SIGINT)


def asked(page: ClientConnection, op: str, params: dict[str, Any], times: int = 1) -> list[float]:
    """Seconds from a request to each state that it gave, its frames included."""
    began, states = time.perf_counter(), []
    page.send(json.dumps({"do": "apply", "n": 1, "op": op, "params": params, "times": times}))
    while True:
        message = json.loads(text) if isinstance(text := page.recv(), str) else {"say": "frame"}
        if message["say"] == "state":
            for _ in range(message["frames"]):
                page.recv()
            states += [time.perf_counter() - began] if message["frames"] else []
        if message["say"] in ("done", "error") and message.get("n") == 1:
            if message["say"] == "error":
                raise ValueError(message["text"])
            return states


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, served(folder) as page:
        for variant, exponent in (("weighted", 2.0), ("uniform", 0.0)):
            states, shown, own = library(folder, exponent), [], []
            for _ in range(5):  # side by side, as machines have better and worse moments
                shown += np.diff(asked(page, "relax", {"variant": variant}, 4)).tolist()
                own.append(seconds(lambda states=states: next(states), 2)[0])
            ratio = min(shown) / min(own)
            print(f"a {variant} step of {SITES} dots: {min(shown):.3f} s shown, {min(own):.3f} s by itself, {ratio:.2f} times; bar 1.5")
        rng = np.random.default_rng(0)
        for name, params in STROKES.items():
            taken = []
            for _ in range(12):
                x, y = rng.uniform(60, 140, 2).round(2).tolist()
                way = [x, y, 1, x + 1, y, 1, x + 2, y + 1, 1]
                taken += asked(page, name.split(",")[0].split(" along")[0], {"path": way, "size": 6, **params})[:1]
            least, middle = 1000 * min(taken), 1000 * float(np.median(taken))
            print(f"{name:<20} {least:6.1f} ms at least, {middle:6.1f} ms in the middle; bar 50")


def library(folder: str, exponent: float) -> Iterator[relax.State]:
    """Steps of relax.lloyd on as many dots over the same picture."""
    copy = Path(folder, "copy.png")
    copy.write_bytes(Path(folder, "shaded.png").read_bytes())
    session = Session(copy)
    tone = session.drawing.toned()
    session.close()
    return relax.lloyd(relax.scatter(tone, SITES, np.random.default_rng(0)), tone, exponent=exponent)


if __name__ == "__main__":
    main()
