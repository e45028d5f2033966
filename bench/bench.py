"""What drawing costs, in D: the time of scipy.spatial.Delaunay on 100 000 uniform random sites in the same run.

Machines differ and so do their hours; the ratio travels. Everything is seeded, what is timed is named, nothing is
asserted. `python bench/bench.py quick` leaves out the two whole plates.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from scipy.spatial import Delaunay

import crowquill
from crowquill import cells, exemplar, field, halftone, hilbert, judge, moments, relax, route, seen
from crowquill.objects import Objects, Shape
from crowquill.paths import Paths
from crowquill.tone import Tone

SITES = 100_000


def seconds(work: Callable[[], Any], times: int = 5) -> tuple[float, float, float]:
    """Least, mean and spread of the time of a call, warmed by one."""
    work()
    taken = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        taken.append(time.perf_counter() - began)
    return min(taken), float(np.mean(taken)), float(np.std(taken))


def row(what: str, taken: tuple[float, float, float], unit: float, bar: str = "") -> None:
    least, mean, spread = taken
    print(f"{what:<66} {least:8.3f} s  {mean:8.3f} +- {spread:.3f}  {least / unit:7.2f} D  {bar}", flush=True)


def shaded(side: int) -> np.ndarray:
    """A picture of side x side pixels with every tone from .05 to .75 and no two rows alike."""
    y, x = np.mgrid[0:side, 0:side] / side
    return 0.4 + 0.35 * np.sin(9 * x + 4 * y * y) * np.cos(7 * y)


def iteration(sites: np.ndarray, canvas: shapely.Geometry, tone: Tone) -> moments.Moments:
    return moments.of_tone(cells.voronoi(sites, canvas), tone)


# a small program between: Linux would count what the bench itself holds to its child, and all children together
CHILD = """
import resource, subprocess, sys, time
began = time.perf_counter()
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
print(time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)
"""


def process(*command: str, folder: str, fresh: bool) -> tuple[float, float]:
    """Seconds and the greatest memory in MB of a command; fresh: with an empty cache of compiled code."""
    cache = {"NUMBA_CACHE_DIR": folder} if fresh else {}
    done = subprocess.run([sys.executable, "-c", CHILD, *command], check=True, capture_output=True, text=True, env={**os.environ, **cache})
    took, most = map(float, done.stdout.split())
    return took, most


def main(quick: bool) -> None:
    rng = np.random.default_rng(0)
    sites = rng.random((SITES, 2)) * 100
    unit = seconds(lambda: Delaunay(sites), 3)
    row(f"D: scipy Delaunay, {SITES} uniform sites", unit, unit[0])
    d = unit[0]
    canvas = shapely.box(0, 0, 100, 100)
    small, large = (Tone(shaded(side), (100, 100)) for side in (1000, 4000))
    assert small.prefix.size and large.prefix.size  # made once for a drawing, outside the loop
    sites = sites[hilbert.of_points(sites)]
    partition = cells.voronoi(sites, canvas)
    row("cells.voronoi", seconds(lambda: cells.voronoi(sites, canvas)), d)
    weights = rng.random(SITES) * 0.1
    row("cells.power, weights of a cell's area", seconds(lambda: cells.power(sites, weights, canvas)), d)
    row("moments.of_tone, 1 Mpx", seconds(lambda: moments.of_tone(partition, small)), d)
    one = seconds(lambda: iteration(sites, canvas, small))
    many = seconds(lambda: iteration(sites, canvas, large))
    row(f"one exact weighted iteration, {SITES} sites, 1 Mpx", one, d, "bar 0.35 D")
    row(f"one exact weighted iteration, {SITES} sites, 16 Mpx", many, d, f"{many[0] / one[0]:.2f} times 1 Mpx; bar 2.5")
    program = str(Path(sys.executable).parent / "crowquill")
    bare = seconds(lambda: subprocess.run([sys.executable, "-c", "import numpy"], check=True))
    told = seconds(lambda: subprocess.run([program, "--help"], check=True, stdout=subprocess.DEVNULL))
    row("python -c 'import numpy'", bare, d)
    row("crowquill --help", told, d, f"{told[0] / bare[0]:.2f} times import numpy; bar 2")
    halftoned(d)
    stippled(small, d)
    settled(small, d)
    mosaics(d)
    aligned(d)
    structured(small, d)
    judged(d)
    routed(d)
    exampled(d)
    if not quick:
        plates(d, program)


def plates(d: float, program: str) -> None:
    """Two whole drawings from picture to PDF and SVG: a warm one of 300 000 dots, and the first ever on a machine."""
    from PIL import Image

    with tempfile.TemporaryDirectory() as folder:
        picture, out = f"{folder}/shaded.png", [f"{folder}/plate.pdf", f"{folder}/plate.svg"]
        Image.fromarray((255 * (1 - shaded(1600))).astype(np.uint8)).save(picture)
        a4 = ("--fit", "stretch", "--margin", "10mm", "--tone", "grey", "--quiet", "--report", f"{folder}/report.json")
        taken, memory = process(program, "stipple", picture, *out, *a4, folder=folder, fresh=False)
        marks = int(Path(f"{folder}/report.json").read_text().split('"marks": ')[1].split(",")[0])
        row(f"A4 plate, 0.3 mm pen, {marks} dots, PDF and SVG, warm", (taken, taken, 0.0), d, "bar 60 D")
        print(f"{'':<66} {memory:8.0f} MB, bar 1500")
        written(d, f"{folder}/plate.svg", folder)
        specimen = str(Path(__file__).parent.parent / "gallery" / "specimen.png")
        taken, _ = process(program, "stipple", specimen, *out, "--quiet", folder=f"{folder}/cache", fresh=True)
        row("first drawing ever: the specimen's plate, compiling all", (taken, taken, 0.0), d, "bar 60 D")


def halftoned(d: float) -> None:
    """Black and white of 16 Mpx, and Pillow's own Floyd-Steinberg of the same."""
    from PIL import Image

    levels = np.round(255 * shaded(4000)).astype(np.uint8)
    theirs = seconds(partial(Image.fromarray(255 - levels).convert, "1"), 3)
    row("Pillow convert('1'), 16 Mpx", theirs, d)
    for method in ("floyd-steinberg", "ostromoukhov"):
        ours = seconds(partial(halftone.halftoned, levels, method), 3)
        row(f"halftoned, {method}, 16 Mpx", ours, d, f"{ours[0] / theirs[0]:.2f} times Pillow; bar 3")


def stippled(tone: Tone, d: float) -> None:
    """Whole drawings of 20 000 dots on 1 Mpx, in the three styles of even dots."""
    pen = crowquill.draw("stipple", tone, dots=20_000, iterations=0).report["pen_mm"]
    for style, bar in (("stipple", ""), ("adaptive", "bar 10 D"), ("bluenoise", "bar 60 D")):
        work = partial(crowquill.draw, style, tone, pen=pen)
        row(f"{style}, {len(work().marks)} dots, 1 Mpx", seconds(work, 2), d, bar)


def settled(tone: Tone, d: float) -> None:
    """A step of 10 000 objects beside one of Lloyd's on as many points as they have samples."""
    rng = np.random.default_rng(0)
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
    row(f"relax.lloyd, {k} points, a step", theirs, d)
    row(f"relax.settle, 10 000 objects of {k} samples, a step", ours, d, f"{ours[0] / theirs[0]:.2f} times Lloyd; bar 8")


def mosaics(d: float) -> None:
    """Mosaics of 20 000 stones around a disc."""
    y, x = np.mgrid[0:1000, 0:1000] / 1000
    tone = Tone(np.where(np.hypot(x - 0.5, y - 0.5) < 0.3, 0.7, 0.3), (180, 180))
    for mode in ("hausner", "rows", "lloyd", "cells"):
        row(f"mosaic {mode}, 20 000 stones", seconds(partial(crowquill.draw, "mosaic", tone, mode=mode, tiles=20_000), 1), d, "bar 120 D")


def aligned(d: float) -> None:
    """Dots along rows, and the lines found: 20 000 of a picture of 1 Mpx with edges and darks."""
    y, x = np.mgrid[0:1000, 0:1000] / 1000
    tone = Tone(np.clip(shaded(1000) + 0.2 * (np.hypot(x - 0.5, y - 0.5) < 0.3), 0, 1), (180, 180))
    for style in ("hedcut", "isophote"):
        row(f"{style}, 20 000 dots, 1 Mpx", seconds(partial(crowquill.draw, style, tone, dots=20_000), 2), d, "bar 30 D")
    row("field.lines, strokes of 0.25 mm, 1 Mpx", seconds(partial(field.lines, tone, 0.25), 2), d)


def structured(tone: Tone, d: float) -> None:
    """About 20 000 dots of styles that heed structure on 1 Mpx: for a pen, which takes one pass or two, and by their number."""
    for style, knobs, bar in (("contrast", {"pen": 0.5}, 12), ("contrast", {"dots": 20_000}, 60), ("frontier", {"dots": 20_000}, 20)):
        sheet = crowquill.draw(style, tone, **knobs)
        said = ", ".join(f"{key} {value}" for key, value in knobs.items())
        passes = f"{sheet.report['iterations']} {'levels' if style == 'frontier' else 'passes'}; bar {bar} D"
        row(f"{style}, {said}: {len(sheet.marks)} dots", seconds(partial(crowquill.draw, style, tone, **knobs), 2), d, passes)


def routed(d: float) -> None:
    """The order of 100 000 dots for a plotter, and vpype's of the same, the reading of its file taken off."""
    places = np.random.default_rng(5).random((SITES, 2)) * 180
    ends = np.repeat(places[:, None], 2, axis=1)
    best = 0.7124 * np.sqrt(SITES * 180.0**2)
    length = route.travel(ends, route.order(ends))
    ours = seconds(lambda: route.order(ends), 2)
    row(f"route.order, {SITES} dots", ours, d, f"{length / best:.3f} times 0.7124 sqrt(N A); bar 1.12")
    with tempfile.TemporaryDirectory() as folder:
        drawing = f"{folder}/dots.svg"
        ticks = Paths(np.stack([places, np.add(places, (0.02, 0))], axis=1).reshape(-1, 2), np.arange(0, 2 * SITES + 1, 2), closed=False)
        crowquill.save(crowquill.Sheet((181, 181), (crowquill.Layer(crowquill.Ink(pen=0.3), ticks),)), drawing)
        read, _ = process(sys.executable, "-m", "vpype_cli", "read", drawing, folder=folder, fresh=False)
        both, _ = process(sys.executable, "-m", "vpype_cli", "read", drawing, "linesort", folder=folder, fresh=False)
    row("vpype linesort, the same dots", (both - read, both - read, 0.0), d, f"{(both - read) / ours[0]:.1f} times route.order; bar 10")


def judged(d: float) -> None:
    """Every measure of a drawing of about 100 000 dots against its picture of 4 Mpx."""
    tone = Tone(shaded(2000), (180, 180))
    sheet = crowquill.draw("stipple", tone, dots=SITES, iterations=10)
    row(f"judge, {len(sheet.marks)} dots against 4 Mpx", seconds(partial(judge.of, seen.of_sheet(sheet), tone), 2), d, "bar 20 D")


def exampled(d: float) -> None:
    """Ten tones learned from a page and made into tiles; drawings of 120 x 160 mm by what was kept of them, and in grey dots."""
    page = exemplar.FOLDER / "hand.png"
    tone = Tone(shaded(1000), (120, 160))
    row("ten tones of an example learned, and tiles of them made", seconds(partial(exemplar.learned, page), 1), d, "bar 200 D")
    row("byexample, 120 x 160 mm, its style kept", seconds(partial(crowquill.draw, "byexample", tone, example="hand"), 2), d)
    sheet = crowquill.draw("inkdots", tone)
    row(f"inkdots, {len(sheet.marks)} dots", seconds(partial(crowquill.draw, "inkdots", tone), 2), d)
    row("and their grey at 600 dpi, as a TIFF", seconds(partial(crowquill.to_bytes, sheet, "tiff"), 2), d)


BITMAP = "import sys, crowquill; crowquill.save(crowquill.load(sys.argv[1]), sys.argv[2], dpi=1200, bilevel=True)"


def written(d: float, drawing: str, folder: str) -> None:
    """The same plate as outlines, as characters of a font, and as a bitmap; and what Poppler takes to show it."""
    sheet = crowquill.load(drawing)
    dots = len(sheet.marks)
    for name, more in (("outlines", {}), ("compact", {"compact": True})):
        path = Path(folder, f"{name}.pdf")
        row(f"PDF, {name}", seconds(partial(crowquill.save, sheet, path, **more), 2), d, f"{path.stat().st_size / dots:.1f} bytes a dot")
        if shutil.which("pdftoppm"):
            shown = ("pdftoppm", "-r", "600", "-gray", "-singlefile", str(path), f"{folder}/shown")
            row(f"Poppler at 600 dpi, {name}", seconds(partial(subprocess.run, shown, check=True), 3), d)
    taken, memory = process(sys.executable, "-c", BITMAP, drawing, f"{folder}/plate.tiff", folder=folder, fresh=False)
    row("1-bit TIFF at 1200 dpi, reading the SVG included", (taken, taken, 0.0), d)
    print(f"{'':<66} {memory:8.0f} MB at most, of all processes so far")


if __name__ == "__main__":
    main("quick" in sys.argv[1:])
