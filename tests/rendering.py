"""Renderers used as rulers: how much of each pixel of a window they cover with ink, and the dots found there.

Lengths are mm. At 100 pixels to the mm (2540 dpi) A4, A5 and Letter are whole numbers of pixels; at
1200 dpi they are not, and renderers stretch the page by up to 20 um to make them so.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image
from scipy import ndimage
from scipy.spatial import cKDTree

from crowquill.marks import Marks

Array = npt.NDArray[np.float64]
FINE = 100.0  # pixels to the mm; a 0.3 mm dot is 30 pixels wide
COARSE = 10.0  # pixels to the mm, for whole pages
NEAR = 0.5  # mm: a dot found this near a mark may be that mark's; dots of the specimen are over 1 mm apart
POPPLER_GAMMA = 1.5  # splashAAGamma: Poppler lightens edges to coverage ** 1.5
LIMIT = 120  # seconds after which a renderer has hung


class Window(NamedTuple):
    """A part of the page, from its left and top, in mm."""

    x: float
    y: float
    width: float
    height: float

    def holds(self, xy: Array) -> npt.NDArray[np.bool_]:
        return ((xy >= (self.x, self.y)) & (xy <= (self.x + self.width, self.y + self.height))).all(axis=1)


Renderer = Callable[[bytes, Window, float], Array]


def require(tool: str) -> str:
    """The path of a program. Where it is missing the test is reported as not run, and on CI it fails."""
    path = shutil.which(tool)
    if path is None:
        reason = f"NOT RUN: {tool} is not installed"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return path


def run(tool: str, arguments: Sequence[str], files: dict[str, bytes], gives: str | None = None) -> bytes:
    """What a program prints, or the file it makes, in a folder of its own that holds these files."""
    program = require(tool)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:  # browsers may still be leaving it
        for name, data in files.items():
            (Path(folder) / name).write_bytes(data)
        done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, timeout=LIMIT)
        if done.returncode:
            raise AssertionError(f"{tool} ended with {done.returncode}: {done.stderr.decode(errors='replace')[-500:]}")
        return done.stdout if gives is None else (Path(folder) / gives).read_bytes()


def resvg(svg: bytes, window: Window, px: float) -> Array:
    import resvg_py

    png = resvg_py.svg_to_bytes(svg_string=cropped(svg, window), dpi=25.4 * px, background="#ffffff", skip_system_fonts=True)
    return _ink(bytes(png), window, px)


def chromium(svg: bytes, window: Window, px: float) -> Array:
    page = cropped(svg, window, enlarged=px * 25.4 / 96).encode()  # a screen has 96 pixels to the inch
    width, height = (round(side * px) for side in window[2:])
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--user-data-dir=profile"]
    shot = [*flags, f"--window-size={width},{height}", "--screenshot=shot.png", "page.svg"]
    return _ink(run("chromium", shot, {"page.svg": page}, "shot.png"), window, px)


def poppler(pdf: bytes, window: Window, px: float) -> Array:
    x, y, width, height = (str(round(side * px)) for side in window)
    crop = ["-x", x, "-y", y, "-W", width, "-H", height]
    shot = run("pdftoppm", ["-gray", "-r", f"{25.4 * px:g}", *crop, "page.pdf"], {"page.pdf": pdf})
    return np.asarray(_ink(shot, window, px) ** (1 / POPPLER_GAMMA))


def ghostscript(pdf: bytes, window: Window, px: float) -> Array:
    import pikepdf

    buffer = io.BytesIO()
    with pikepdf.open(io.BytesIO(pdf)) as document:
        page = document.pages[0]
        top = float(page.MediaBox[3]) / 72 * 25.4
        x, y, width, height = window
        page.obj["/CropBox"] = pikepdf.Array([round(s * 72 / 25.4, 9) for s in (x, top - y - height, x + width, top - y)])
        document.save(buffer)
    flags = ["-q", "-dBATCH", "-dNOPAUSE", "-sDEVICE=pgmraw", "-dUseCropBox", "-dGraphicsAlphaBits=4", f"-r{25.4 * px:g}"]
    return _ink(run("gs", [*flags, "-sOutputFile=-", "page.pdf"], {"page.pdf": buffer.getvalue()}), window, px)


def pdfium(pdf: bytes, window: Window, px: float) -> Array:
    import pypdfium2
    import pypdfium2.raw as raw

    width, height = (round(side * px) for side in window[2:])
    scale = px * 25.4 / 72
    document = pypdfium2.PdfDocument(pdf)
    page = document[0]
    bitmap = pypdfium2.PdfBitmap.new_native(width, height, raw.FPDFBitmap_Gray)
    bitmap.fill_rect((255, 255, 255, 255), 0, 0, width, height)
    # its own render() stretches the page to whole pixels; a matrix does not
    matrix = raw.FS_MATRIX(scale, 0, 0, scale, -window.x * px, -window.y * px)
    raw.FPDF_RenderPageBitmapWithMatrix(bitmap, page, matrix, raw.FS_RECTF(0, 0, width, height), 0)
    shot = np.array(bitmap.to_numpy()).reshape(height, width)
    for part in (bitmap, page, document):
        part.close()
    return 1 - shot / 255.0


RENDERERS: dict[str, tuple[str, Renderer]] = {
    "resvg": ("svg", resvg),
    "poppler": ("pdf", poppler),
    "ghostscript": ("pdf", ghostscript),
    "pdfium": ("pdf", pdfium),
}


def cropped(svg: bytes, window: Window, *, enlarged: float = 1.0) -> str:
    """The same SVG with a viewport that shows the window alone, by the file's own millimetres to the unit."""
    head, root, rest = re.split(r"(<svg\b[^>]*>)", svg.decode(), maxsplit=1)
    found = {key: re.search(rf'\b{key}="([^"]*)"', root) for key in ("width", "height", "viewBox")}
    text = {key: match[1] for key, match in found.items() if match}
    box = [float(part) for part in text["viewBox"].split()]
    for key, unit, side, span in (("width", box[2], window.width, "x"), ("height", box[3], window.height, "y")):
        if not text[key].endswith("mm"):
            raise AssertionError(f"{key} {text[key]!r} is not in mm")
        mm = float(text[key][:-2]) / unit
        box["xy".index(span)] += window["xy".index(span)] / mm
        box[2 + "xy".index(span)] = side / mm
        root = root.replace(f'{key}="{text[key]}"', f'{key}="{side * enlarged:.9g}mm"')
    view = " ".join(f"{part:.12g}" for part in box)
    return head + root.replace(f'viewBox="{text["viewBox"]}"', f'viewBox="{view}"') + rest


def _ink(picture: bytes, window: Window, px: float) -> Array:
    """The ink on each pixel of a rendered picture, 0 to 1; it must have the window's size to the pixel."""
    with Image.open(io.BytesIO(picture)) as image:
        pixels = np.asarray(image.convert("L"))
    assert pixels.shape == (round(window.height * px), round(window.width * px))
    return 1 - pixels / 255.0


def dots(ink: Array, window: Window, px: float) -> tuple[Array, Array]:
    """Centroids (n, 2) on the page and diameters of equal area (n,) of the islands of ink. No threshold: edges count by share."""
    island, n = ndimage.label(ink > 0, np.ones((3, 3)))
    row, column = np.nonzero(island)
    which, share = island[row, column], ink[row, column]
    area, x, y = (np.bincount(which, share * place, n + 1)[1:] for place in (1.0, column + 0.5, row + 0.5))
    return np.stack([x, y], axis=1) / area[:, None] / px + window[:2], np.sqrt(4 / np.pi * area) / px


def deviations(render: Renderer, data: bytes, marks: Marks, windows: Sequence[Window], px: float) -> tuple[float, float]:
    """The greatest error of position and of diameter, mm, over all marks in the windows.

    Raises AssertionError where a mark has no dot or a dot no mark.
    """
    found = [dots(render(data, window, px), window, px) for window in windows]
    xy, diameter = np.concatenate([part[0] for part in found]), np.concatenate([part[1] for part in found])
    seen = marks.take(np.any([window.holds(marks.xy) for window in windows], axis=0))
    far, nearest = cKDTree(xy).query(seen.xy, distance_upper_bound=NEAR) if len(xy) else (np.full(len(seen), np.inf), [])
    missing = int((far == np.inf).sum())
    stray = len(xy) - len(np.unique(nearest[far < np.inf])) if len(xy) else 0
    if missing or stray:
        raise AssertionError(f"{missing} dots missing, {stray} stray, of {len(seen)}")
    true = 2 * seen.scale / np.sqrt(np.pi)  # a mark's own area is scale**2
    return float(far.max()), float(np.abs(diameter[nearest] - true).max())


def check_true_size(
    render: Renderer, data: bytes, marks: Marks, windows: Sequence[Window], px: float, position: float, diameter: float
) -> None:
    """Raises AssertionError where a dot is missing, stray, out of place or of the wrong size by more than these mm."""
    far, wide = deviations(render, data, marks, windows, px)
    assert far <= position, f"a dot is {far * 1000:.2f} um out of place"
    assert wide <= diameter, f"a dot is {wide * 1000:.2f} um off in diameter"
