"""What a drawing takes of time and memory: measured, and foretold."""

from __future__ import annotations

import math
import os
import re
import time
from pathlib import Path

import numpy as np

from crowquill.levels import LARGE

SETTING = "CROWQUILL_MEMORY"  # of the environment: gigabytes that may be taken, or any
PROCESS = Path("/proc/self")
# Measured on drawings of 100 000 to a million dots on 4 and 16 Mpx, from the plan to the written file, a tenth added.
A_DOT = 900  # bytes: cells, moments, outlines
A_TILED = 300  # bytes of a dot relaxed in tiles, by the one who hands them out: 250 of ten million
A_PIXEL = 45  # bytes: the weight of cells, and its sums along rows
A_CODE = 4  # bytes of a pixel of a large picture, which is kept as codes


class Clock:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Ends a stage; what it took is added to its earlier rounds."""
        now = time.perf_counter()
        self.laps[stage] = round(self.laps.get(stage, 0.0) + now - self._last, 3)
        self._last = now


def expected_seconds(dots: int, iterations: int) -> float:
    """About how long a drawing will take here, from one small triangulation timed now and the ratios that bench/ prints."""
    from scipy.spatial import Delaunay

    sites = np.random.default_rng(0).random((5000, 2))
    began = time.perf_counter()
    Delaunay(sites)
    unit = 20 * (time.perf_counter() - began)  # about the time of 100 000 sites
    return round(unit * dots / 100_000 * (0.15 * (iterations + 8) + 2.5) + 1, 1)


def relaxed(dots: int, pixels: tuple[int, int], *, tiled: bool = False) -> float:
    """The bytes that so many dots take at most, from their plan on, relaxed over a picture of (rows, columns), whole or in tiles."""
    size = pixels[0] * pixels[1]
    return float((A_TILED if tiled else A_DOT) * dots + (A_PIXEL if size < LARGE and not tiled else A_CODE) * size)


def held() -> float:
    """The bytes that this program has now; 0 where the system does not say."""
    return _number(PROCESS / "status", "VmRSS:")


def afford(needed: float, what: str, remedy: str) -> None:
    """Raises ValueError for what takes more bytes than are free; `what` begins the sentence, `remedy` ends it."""
    free = available()
    if needed > free:
        raise ValueError(f"{what} about {said(needed)} of memory, and {said(max(free, 0))} are free; {remedy}, or set {SETTING}=any to try")


def said(size: float) -> str:
    """Bytes as people say them."""
    return f"{size / 1e9:.2g} GB" if size >= 1e9 else f"{size / 1e6:.3g} MB"


def available() -> float:
    """The bytes that this program may still take: what the system has free, and what a limit on the program leaves it.

    The environment may say the whole in GB, or `any`, which ends all questions. Infinite where nothing is known.
    """
    wish = os.environ.get(SETTING, "")
    if wish == "any":
        return math.inf
    if wish:
        try:
            return float(wish) * 1e9 - held()
        except ValueError:
            raise ValueError(f"{SETTING} is {wish!r}; it takes gigabytes, or any") from None
    return min(_number(Path("/proc/meminfo"), "MemAvailable:", math.inf), _grouped(), _limited())


def _number(file: Path, key: str, unknown: float = 0.0) -> float:
    """The bytes that a line of a file of the system says, in kB behind its key."""
    try:
        found = re.search(rf"^{key}\s*(\d+) kB", file.read_text(encoding="ascii"), re.MULTILINE)
    except OSError:
        return unknown
    return 1024.0 * int(found[1]) if found else unknown


def _grouped(groups: Path = Path("/sys/fs/cgroup"), own: Path = PROCESS / "cgroup") -> float:
    """What the limits of the program's control groups leave: those of the second kind up the tree, or the first's."""
    left = math.inf
    try:
        lines = [line.split(":", 2) for line in own.read_text(encoding="utf-8").splitlines()]
    except OSError:
        return left
    for _, kinds, path in lines:
        if kinds and "memory" not in kinds.split(","):
            continue
        root, most, used = groups, "memory.max", "memory.current"
        if kinds:
            root, most, used = groups / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        folder = root / path.lstrip("/")
        for group in (folder, *folder.parents):
            try:
                limit, now = ((group / name).read_text(encoding="ascii").strip() for name in (most, used))
                cache = re.search(r"^(?:total_)?inactive_file (\d+)", (group / "memory.stat").read_text(encoding="ascii"), re.MULTILINE)
                left = min(left, math.inf if limit == "max" else int(limit) - int(now) + (int(cache[1]) if cache else 0))
            except OSError:
                pass  # no such group here, or no limit at the root
            if group == root:
                break
    return left


def _limited() -> float:
    """What a limit on the program's addresses leaves it."""
    try:
        import resource
    except ImportError:
        return math.inf
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if most == resource.RLIM_INFINITY else most - _number(PROCESS / "status", "VmSize:")
