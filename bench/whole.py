"""What whole drawings cost, in every style and to every kind of file."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from common import HERE, Report, painted, process, seconds, shaded

import crowquill
from crowquill import exemplar, field
from crowquill.tone import Tone

PROGRAM = str(Path(sys.executable).parent / "crowquill")


def stippled(report: Report) -> None:
    """Whole drawings of 20 000 dots on 1 Mpx, in the three styles of even dots."""
    tone = Tone(shaded(1000), (100, 100))
    pen = crowquill.draw("stipple", tone, dots=20_000, iterations=0).report["pen_mm"]
    for style, bar in (("stipple", None), ("adaptive", 10), ("bluenoise", 60)):
        work = partial(crowquill.draw, style, tone, pen=pen)
        report.row(f"{style}, {len(work().marks)} dots, 1 Mpx", seconds(work, 1 if report.quick else 2, bool), bar=bar)


def mosaics(report: Report) -> None:
    """Mosaics of 20 000 stones around a disc."""
    y, x = np.mgrid[0:1000, 0:1000] / 1000
    tone = Tone(np.where(np.hypot(x - 0.5, y - 0.5) < 0.3, 0.7, 0.3), (180, 180))
    for mode in ("hausner", "rows", "lloyd", "cells"):
        work, few = (partial(crowquill.draw, "mosaic", tone, mode=mode, tiles=tiles) for tiles in (20_000, 200))
        report.row(f"mosaic {mode}, 20 000 stones", seconds(work, 1, few), bar=120)


def aligned(report: Report) -> None:
    """Dots along rows, and the lines found: 20 000 of a picture of 1 Mpx with edges and darks."""
    y, x = np.mgrid[0:1000, 0:1000] / 1000
    tone = Tone(np.clip(shaded(1000) + 0.2 * (np.hypot(x - 0.5, y - 0.5) < 0.3), 0, 1), (180, 180))
    for style in ("hedcut", "isophote"):
        report.row(f"{style}, 20 000 dots, 1 Mpx", seconds(partial(crowquill.draw, style, tone, dots=20_000), 2), bar=30)
    report.row("field.lines, strokes of 0.25 mm, 1 Mpx", seconds(partial(field.lines, tone, 0.25), 2))


def structured(report: Report) -> None:
    """About 20 000 dots of styles that heed structure on 1 Mpx: for a pen, which takes one pass or two, and by their number."""
    tone = Tone(shaded(1000), (100, 100))
    for style, knobs, bar in (("contrast", {"pen": 0.5}, 12), ("contrast", {"dots": 20_000}, 60), ("frontier", {"dots": 20_000}, 20)):
        sheet = crowquill.draw(style, tone, **knobs)
        said = ", ".join(f"{key} {value}" for key, value in knobs.items())
        passes = f"{sheet.report['iterations']} {'levels' if style == 'frontier' else 'passes'}"
        report.row(f"{style}, {said}: {len(sheet.marks)} dots", seconds(partial(crowquill.draw, style, tone, **knobs), 2), passes, bar=bar)


def exampled(report: Report) -> None:
    """Ten tones learned from a page and made into tiles; drawings of 120 x 160 mm by what was kept of them, and in grey dots."""
    page = exemplar.FOLDER / "hand.png"
    tone = Tone(shaded(1000), (120, 160))
    report.row("ten tones of an example learned, and tiles of them made", seconds(partial(exemplar.learned, page), 1), bar=200)
    report.row("byexample, 120 x 160 mm, its style kept", seconds(partial(crowquill.draw, "byexample", tone, example="hand"), 2))
    sheet = crowquill.draw("inkdots", tone)
    report.row(f"inkdots, {len(sheet.marks)} dots", seconds(partial(crowquill.draw, "inkdots", tone), 2))
    report.row("and their grey at 600 dpi, as a TIFF", seconds(partial(crowquill.to_bytes, sheet, "tiff"), 2))


def plates(report: Report) -> None:
    """Two whole drawings from picture to PDF and SVG: a warm one of 300 000 dots, and the first ever on a machine."""
    with tempfile.TemporaryDirectory() as folder:
        picture, out = f"{folder}/shaded.png", [f"{folder}/plate.pdf", f"{folder}/plate.svg"]
        painted(1600, Path(picture))
        a4 = ("--fit", "stretch", "--margin", "10mm", "--tone", "grey", "--quiet", "--report", f"{folder}/report.json")
        run = process(PROGRAM, "stipple", picture, *out, *a4)
        marks = int(Path(f"{folder}/report.json").read_text().split('"marks": ')[1].split(",")[0])
        report.row(f"A4 plate, 0.3 mm pen, {marks} dots, PDF and SVG, warm", run.taken, bar=60)
        report.row("the same plate's memory", run.taken, bar=1500, got=run.memory, unit="MB")
        written(report, f"{folder}/plate.svg", folder)
        run = process(PROGRAM, "stipple", str(HERE.parent / "gallery" / "specimen.png"), *out, "--quiet", cache=f"{folder}/cache")
        report.row("first drawing ever: the specimen's plate, compiling all", run.taken, bar=60)


BITMAP = "import sys, crowquill; crowquill.save(crowquill.load(sys.argv[1]), sys.argv[2], dpi=1200, bilevel=True)"


def written(report: Report, drawing: str, folder: str) -> None:
    """The same plate as outlines, as characters of a font, and as a bitmap; and what Poppler takes to show it."""
    sheet = crowquill.load(drawing)
    dots = len(sheet.marks)
    for name, more in (("outlines", {}), ("compact", {"compact": True})):
        path = Path(folder, f"{name}.pdf")
        taken = seconds(partial(crowquill.save, sheet, path, **more), 2)
        report.row(f"PDF, {name}", taken, f"{path.stat().st_size / dots:.1f} bytes a dot")
        if shutil.which("pdftoppm"):
            shown = ("pdftoppm", "-r", "600", "-gray", "-singlefile", str(path), f"{folder}/shown")
            report.row(f"Poppler at 600 dpi, {name}", seconds(partial(subprocess.run, shown, check=True), 3))
        else:
            report.missing(f"Poppler at 600 dpi, {name}", "pdftoppm is not installed")
    run = process(sys.executable, "-c", BITMAP, drawing, f"{folder}/plate.tiff")
    report.row("1-bit TIFF at 1200 dpi, reading the SVG included", run.taken, f"{run.memory:.0f} MB")
