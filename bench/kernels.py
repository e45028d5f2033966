"""What single steps cost: cells, moments, an iteration, halftones, objects, routes, measures, and the command line's start."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
import shapely
from common import SITES, Report, process, seconds, shaded
from PIL import Image

import crowquill
from crowquill import cells, halftone, hilbert, judge, moments, relax, route, seen
from crowquill.objects import Objects, Shape
from crowquill.paths import Paths
from crowquill.tone import Tone
from crowquill.units import INCH


def iteration(sites: np.ndarray, canvas: shapely.Geometry, tone: Tone) -> moments.Moments:
    return moments.of_tone(cells.voronoi(sites, canvas), tone)


def exact(report: Report) -> None:
    """The two functions that take the time, and both together, on 1 and 16 Mpx."""
    rng = np.random.default_rng(0)
    sites, canvas = rng.random((SITES, 2)) * 100, shapely.box(0, 0, 100, 100)
    small, large = (Tone(shaded(side), (100, 100)) for side in (1000, 4000))
    assert small.prefix.size and large.prefix.size  # made once for a drawing, outside the loop
    sites = sites[hilbert.of_points(sites)]
    partition = cells.voronoi(sites, canvas)
    report.row("cells.voronoi", seconds(lambda: cells.voronoi(sites, canvas)))
    weights = rng.random(SITES) * 0.1
    report.row("cells.power, weights of a cell's area", seconds(lambda: cells.power(sites, weights, canvas)))
    report.row("moments.of_tone, 1 Mpx", seconds(lambda: moments.of_tone(partition, small)))
    one = seconds(lambda: iteration(sites, canvas, small))
    many = seconds(lambda: iteration(sites, canvas, large))
    report.row(f"one exact weighted iteration, {SITES} sites, 1 Mpx", one, bar=0.35)
    said = f"one exact weighted iteration, {SITES} sites, 16 Mpx"
    report.row(said, many, bar=2.5, got=many.least / one.least, unit="times 1 Mpx")


def started(report: Report) -> None:
    """The command line's first word."""
    program = str(Path(sys.executable).parent / "crowquill")
    bare = seconds(lambda: subprocess.run([sys.executable, "-c", "import numpy"], check=True))
    told = seconds(lambda: subprocess.run([program, "--help"], check=True, stdout=subprocess.DEVNULL))
    report.row("python -c 'import numpy'", bare)
    report.row("crowquill --help", told, bar=2, got=told.least / bare.least, unit="times import numpy")


def halftoned(report: Report) -> None:
    """Black and white of 16 Mpx, and Pillow's own Floyd-Steinberg of the same."""
    levels = np.round(255 * shaded(4000)).astype(np.uint8)
    theirs = seconds(partial(Image.fromarray(255 - levels).convert, "1"), 3)
    report.row("Pillow convert('1'), 16 Mpx", theirs)
    for method in ("floyd-steinberg", "ostromoukhov"):
        ours = seconds(partial(halftone.halftoned, levels, method), 3)
        report.row(f"halftoned, {method}, 16 Mpx", ours, bar=3, got=ours.least / theirs.least, unit="times Pillow")


def settled(report: Report) -> None:
    """A step of 10 000 objects beside one of Lloyd's on as many points as they have samples."""
    rng, tone = np.random.default_rng(0), Tone(shaded(1000), (100, 100))
    line, box = [(0, 0), (0.8, 0)], [(0, 0), (0.6, 0), (0.6, 0.3), (0, 0.3)]
    shapes = (Shape.of(Paths.of([line], closed=False)), Shape.of(Paths.of([box])))
    xy = rng.random((10_000, 2)) * 100
    many = Objects.of(xy[hilbert.of_points(xy)], shapes, angle=6 * rng.random(len(xy)), shape=rng.integers(0, 2, len(xy)))
    states = relax.settle(many, tone)
    k = len(next(states).owner)
    points = rng.random((k, 2)) * 100
    others = relax.lloyd(points[hilbert.of_points(points)], tone)
    theirs = seconds(lambda: next(others))
    ours = seconds(lambda: next(states))
    report.row(f"relax.lloyd, {k} points, a step", theirs)
    said = f"relax.settle, 10 000 objects of {k} samples, a step"
    report.row(said, ours, bar=8, got=ours.least / theirs.least, unit="times Lloyd")


def routed(report: Report, quick: bool) -> None:
    """The order of 100 000 dots for a plotter, and vpype's of the same, the reading of its file taken off; in short, of 20 000."""
    n = 20_000 if quick else SITES
    places = np.random.default_rng(5).random((n, 2)) * 180
    ends = np.repeat(places[:, None], 2, axis=1)
    best = 0.7124 * np.sqrt(n * 180.0**2)
    length = route.travel(ends, route.order(ends))
    ours = seconds(lambda: route.order(ends), 2)
    report.row(f"route.order, {n} dots", ours, bar=1.12, got=length / best, unit="times 0.7124 sqrt(N A)")
    with tempfile.TemporaryDirectory() as folder:
        drawing, sorted_ = f"{folder}/dots.svg", f"{folder}/sorted.svg"
        ticks = Paths(np.stack([places, np.add(places, (0.02, 0))], axis=1).reshape(-1, 2), np.arange(0, 2 * n + 1, 2), closed=False)
        crowquill.save(crowquill.Sheet((181, 181), (crowquill.Layer(crowquill.Ink(pen=0.3), ticks),)), drawing)
        vpype = (sys.executable, "-m", "vpype_cli", "read", drawing)
        try:
            read = process(*vpype, "write", sorted_)
            both = process(*vpype, "linesort", "write", sorted_)
        except ChildProcessError as error:
            report.missing("vpype linesort", str(error))
            return
        found = re.findall(r'<line x1="([\d.]+)" x2="([\d.]+)" y1="([\d.]+)" y2="([\d.]+)"', Path(sorted_).read_text())
        x0, x1, y0, y1 = np.array(found, np.float64).reshape(-1, 4).T * INCH / 96
    theirs = both.seconds - read.seconds
    way = float(np.hypot(x0[1:] - x1[:-1], y0[1:] - y1[:-1]).sum()) / best
    sorting = both.taken._replace(least=theirs, mean=theirs, cpu=both.cpu - read.cpu)
    said = f"{len(x0)} dots, {way:.3f} times 0.7124 sqrt(N A)"
    report.row("vpype linesort, the same", sorting, said, bar=10, got=theirs / ours.least, unit="times route.order", least=True)


def judged(report: Report) -> None:
    """Every measure of a drawing of about 100 000 dots against its picture of 4 Mpx."""
    tone = Tone(shaded(2000), (180, 180))
    sheet = crowquill.draw("stipple", tone, dots=SITES, iterations=10)
    report.row(f"judge, {len(sheet.marks)} dots against 4 Mpx", seconds(partial(judge.of, seen.of_sheet(sheet), tone), 2), bar=20)
