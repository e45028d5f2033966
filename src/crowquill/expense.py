"""What a drawing takes of time and memory: measured, and foretold."""

from __future__ import annotations

import time

import numpy as np


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
    return round(unit * dots / 100_000 * (0.35 * (iterations + 1) + 3) + 1, 1)
