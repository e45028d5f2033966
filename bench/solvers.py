"""How soon each way to place dots comes to what energy and what tone, and what one step costs early and late.

A solver gives states: sites, as many as asked for in the end, better from one to the next. One more is one line in SOLVERS.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import numpy as np
from common import SITES, Report, Taken, seconds, shaded
from scoring import camera, darkness, scored

from crowquill import relax
from crowquill.paths import Array
from crowquill.tone import Tone

Solver = Callable[[Tone, int, np.random.Generator], Iterator[relax.State]]
HALFTONE = "Floyd-Steinberg start, step 1.8"
DEFAULT = "default: start by levels, step 1.8"
EVEN = "even start, step 1.8"
PLAIN = "plain Lloyd: random start, step 1"
SOLVERS: dict[str, Solver] = {
    PLAIN: lambda tone, n, rng: relax.lloyd(relax.scatter(tone, n, rng, "random"), tone, step=1.0),
    EVEN: lambda tone, n, rng: relax.lloyd(relax.scatter(tone, n, rng), tone),
    DEFAULT: lambda tone, n, rng: relax.lloyd(relax.scatter(tone, n, rng, "levels"), tone),
    HALFTONE: lambda tone, n, rng: relax.lloyd(relax.scatter(tone, n, rng, "floyd-steinberg"), tone),
}
LOOKED_AT = (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50)  # states that are measured, off the clock
STILL = 0.01  # spacings: a movement below is late
LATEST = 150  # steps, after which late is what it is
Point = dict[str, float]


def traced(solver: Solver, coverage: Array, n: int, look: Callable[[Array, Tone], Point]) -> list[Point]:
    """Seconds from the picture's array on, wall and processors', for some of the first states, and what a look at them tells.

    Looks are off the clock. States of another number of dots than n (coarser ones on the way) count as time only; a halftone's
    start may be off by 4 %.
    """
    wall, cpu, points = 0.0, 0.0, []
    began, spent = time.perf_counter(), time.process_time()
    tone = Tone(coverage, (coverage.shape[1], coverage.shape[0]))
    for k, state in enumerate(solver(tone, n, np.random.default_rng(0))):
        wall, cpu = wall + time.perf_counter() - began, cpu + time.process_time() - spent
        if k in LOOKED_AT and abs(len(state.sites) - n) <= 0.04 * n:
            points.append({"step": k, "seconds": wall, "cpu": cpu, **look(state.sites, tone)})
        if k >= LOOKED_AT[-1]:
            break
        began, spent = time.perf_counter(), time.process_time()
    return points


def energies(sites: Array, tone: Tone) -> Point:
    return {"energy": energy(sites, tone)}


def scores(sites: Array, tone: Tone) -> Point:
    return {"energy": energy(sites, tone), **scored(sites, tone.coverage)._asdict()}


def timed(solver: Solver, coverage: Array, n: int, look: Callable[[Array, Tone], Point], times: int = 2) -> list[Point]:
    """The same, with the least seconds of several runs; sites are the same each time and looked at once."""
    points = traced(solver, coverage, n, look)
    runs = [points, *(traced(solver, coverage, n, lambda *_: {}) for _ in range(times - 1))]
    return [{**all_[0], **{key: min(point[key] for point in all_) for key in ("seconds", "cpu")}} for all_ in zip(*runs, strict=True)]


def energy(sites: Array, tone: Tone) -> float:
    """Of any solver's sites the same: the integral of coverage squared times squared distance to the site."""
    return relax.measured(sites, tone, tone.mapped(lambda coverage: coverage**2)).energy


def until(solver: Solver, coverage: Array, n: int, step: float, times: int = 3) -> Taken:
    """Seconds from the picture's array to the sites of a step."""
    walls, cpus = [], []
    for _ in range(times):
        began, spent = time.perf_counter(), time.process_time()
        tone = Tone(coverage, (coverage.shape[1], coverage.shape[0]))
        next(islice(solver(tone, n, np.random.default_rng(0)), int(step), None))
        walls.append(time.perf_counter() - began)
        cpus.append(time.process_time() - spent)
    return Taken.of(walls, cpus)


def traces(report: Report, dots: tuple[int, ...]) -> dict[int, dict[str, list[Point]]]:
    """Every solver's way down on the camera of 1 Mpx, by number of dots."""
    dark = darkness(camera())
    traced(SOLVERS[DEFAULT], dark, 1000, scores)  # compiled before the clock runs
    found: dict[int, dict[str, list[Point]]] = {n: {} for n in dots}
    for n, ways in found.items():
        for name, solver in SOLVERS.items():
            ways[name] = timed(solver, dark, n, scores, 1 if report.quick or n == 50_000 else 2)
            first, end = ways[name][0], ways[name][-1]
            said = f"tone error {first['tone']:.4f} to {end['tone']:.4f}, rho {end['rho']:.3f}"
            report.row(f"{name}, {n} dots, {end['step']:.0f} steps", taken(end), said)
    report.figure("solvers", {str(n): ways for n, ways in found.items()})
    return found


def steps_of(k: float) -> str:
    """So many steps, in words."""
    return f"{k:.0f} step{'s' * (k != 1)}"


def taken(point: Point) -> Taken:
    """A point of a trace as a row has it."""
    return Taken(point["seconds"], point["seconds"], 0.0, point["cpu"])


def downhill(report: Report, n: int) -> None:
    """How soon each solver comes to the energy that 50 plain iterations from a random start reach."""
    coverage = shaded(1000)
    plain = timed(SOLVERS[PLAIN], coverage, n, energies)
    wanted = plain[-1]["energy"]
    report.row(f"50 plain iterations from a random start, {n} sites, 1 Mpx", taken(plain[-1]))
    for name, solver in SOLVERS.items():
        if name != PLAIN:
            way = timed(solver, coverage, n, energies, 1 if report.quick else 2)
            there = next((point for point in way if point["energy"] <= wanted), None)
            if there is None:
                report.missing(f"{name}: the energy of 50 plain iterations", f"not reached in {LOOKED_AT[-1]} steps")
            else:
                bar = 1.5 if n == SITES else None
                report.row(f"{name}, {n} sites: to that energy", taken(there), f"after {steps_of(there['step'])}", bar=bar)


def early_and_late(report: Report, n: int) -> None:
    """One exact weighted step from a random start, and one when sites hardly move any more."""
    tone = Tone(shaded(1000), (100, 100))
    early = []
    for seed in range(3):
        states = SOLVERS[PLAIN](tone, n, np.random.default_rng(seed))
        next(states)
        began, spent = time.perf_counter(), time.process_time()
        next(states)
        early.append((time.perf_counter() - began, time.process_time() - spent))
    bars: tuple[Any, Any] = (0.25, 0.12) if n == SITES else (None, None)
    walls, cpus = map(list, zip(*early, strict=True))
    report.row(f"one exact weighted step, {n} sites, 1 Mpx, from a random start", Taken.of(walls, cpus), bar=bars[0])
    states = SOLVERS[DEFAULT](tone, n, np.random.default_rng(0))
    state = next(state for state in states if state.movement < STILL or state.done >= LATEST)
    late = seconds(lambda: next(states), 5)
    report.row("the same late", late, f"after {state.done} steps, movement {state.movement:.4f} spacings", bar=bars[1])
