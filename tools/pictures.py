"""Render gallery/<name>.png from every script of the gallery; the plate is cropped, and 20 mm of it shown close up."""

from io import BytesIO
from pathlib import Path
from runpy import run_path

import numpy as np
from PIL import Image, ImageOps
from pypdfium2 import PdfDocument

from crowquill import Sheet, to_bytes
from crowquill.picture import encoded, linear

GALLERY = Path(__file__).resolve().parents[1] / "gallery"
OVER = 4  # pixels are rendered this many times finer each way, then averaged
STEP = 17  # between the 16 greys kept: dots are black or white, and only their edges are grey
COLOURED = {"measures", "plotter", "figure_3_12"}  # two drawings, strokes, ways told apart; all else is black ink
INKED = {"duotone", "four_inks", "two_inks"}  # inks that overprint, which PDF's viewers do not show
DETAIL = np.array([84, 181, 106, 96])  # mm cut off the plate's paper: left, bottom, right, top


def rendered(pdf: bytes, dpi: float, cut: tuple[float, ...] = (0, 0, 0, 0), grey: bool = True) -> Image.Image:
    page = PdfDocument(pdf)[0].render(scale=OVER * dpi / 72, crop=cut, grayscale=grey)
    return page.to_pil().reduce(OVER)


def printed(sheet: Sheet, dpi: float) -> Image.Image:
    """The page as its inks look together from where dots run together: it is light that eyes average, not code values."""
    with Image.open(BytesIO(to_bytes(sheet, "png", dpi=OVER * dpi))) as image:
        width, height = image.width // OVER, image.height // OVER
        light = linear(np.asarray(image.convert("RGB").crop((0, 0, OVER * width, OVER * height))) / 255)
    means = light.reshape(height, OVER, width, OVER, 3).mean(axis=(1, 3))
    return Image.fromarray(np.round(255 * encoded(means)).astype(np.uint8))


def save(picture: Image.Image, name: str, dpi: float) -> None:
    greys = Image.fromarray(np.round(np.asarray(picture) / STEP).astype(np.uint8))
    greys.putpalette(np.repeat(np.arange(0, 256, STEP), 3).tolist())
    greys.save(GALLERY / f"{name}.png", optimize=True, dpi=(dpi, dpi))


if __name__ == "__main__":
    for script in sorted(path for path in GALLERY.glob("*.py") if path.stem != "plate"):
        sheet = run_path(str(script))["make"]()
        page = to_bytes(sheet, "pdf")
        if script.stem in COLOURED | INKED:
            seen = printed(sheet, 110) if script.stem in INKED else rendered(page, 110, grey=False).convert("RGB")
            shown = seen.quantize(256 if script.stem in INKED else 32, dither=Image.Dither.NONE)
            shown.save(GALLERY / f"{script.stem}.png", optimize=True, dpi=(110, 110))
        else:
            save(rendered(page, 110), script.stem, 110)
    pdf = to_bytes(run_path(str(GALLERY / "plate.py"))["make"](), "pdf")
    plate = rendered(pdf, 130)
    ink = ImageOps.invert(plate).getbbox()
    save(ImageOps.expand(plate.crop(ink), 20, 255), "plate", 130)  # 20 pixels are 4 mm
    save(rendered(pdf, 600, tuple(DETAIL / 25.4 * 72)), "plate_detail", 600)
