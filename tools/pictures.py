"""Render gallery/<name>.png from every script of the gallery; the plate is cropped, and 20 mm of it shown close up."""

from pathlib import Path
from runpy import run_path

import numpy as np
from PIL import Image, ImageOps
from pypdfium2 import PdfDocument

from crowquill import to_bytes

GALLERY = Path(__file__).resolve().parents[1] / "gallery"
OVER = 4  # pixels are rendered this many times finer each way, then averaged
STEP = 17  # between the 16 greys kept: dots are black or white, and only their edges are grey
COLOURED = {"measures", "plotter", "duotone", "figure_3_12"}  # two drawings, strokes, ways and inks told apart; all else is black ink
DETAIL = np.array([84, 181, 106, 96])  # mm cut off the plate's paper: left, bottom, right, top


def rendered(pdf: bytes, dpi: float, cut: tuple[float, ...] = (0, 0, 0, 0), grey: bool = True) -> Image.Image:
    page = PdfDocument(pdf)[0].render(scale=OVER * dpi / 72, crop=cut, grayscale=grey)
    return page.to_pil().reduce(OVER)


def save(picture: Image.Image, name: str, dpi: float) -> None:
    greys = Image.fromarray(np.round(np.asarray(picture) / STEP).astype(np.uint8))
    greys.putpalette(np.repeat(np.arange(0, 256, STEP), 3).tolist())
    greys.save(GALLERY / f"{name}.png", optimize=True, dpi=(dpi, dpi))


if __name__ == "__main__":
    for script in sorted(path for path in GALLERY.glob("*.py") if path.stem != "plate"):
        page = to_bytes(run_path(str(script))["make"](), "pdf")
        if script.stem in COLOURED:
            shown = rendered(page, 110, grey=False).convert("RGB").quantize(32, dither=Image.Dither.NONE)
            shown.save(GALLERY / f"{script.stem}.png", optimize=True, dpi=(110, 110))
        else:
            save(rendered(page, 110), script.stem, 110)
    pdf = to_bytes(run_path(str(GALLERY / "plate.py"))["make"](), "pdf")
    plate = rendered(pdf, 130)
    ink = ImageOps.invert(plate).getbbox()
    save(ImageOps.expand(plate.crop(ink), 20, 255), "plate", 130)  # 20 pixels are 4 mm
    save(rendered(pdf, 600, tuple(DETAIL / 25.4 * 72)), "plate_detail", 600)
