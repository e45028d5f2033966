"""A picture of a report's first and last plots for README: python bench/picture.py ROWS.json PICTURE.png. Takes Chromium."""

from __future__ import annotations

import io
import json
import sys
import tempfile
from pathlib import Path

from page import STYLE, opening, solving, versus
from PIL import Image

COLOURS = 64
WIDE = 1180  # px


def taken(rows: Path, picture: Path) -> None:
    """Renders the plots with the machine named above them."""
    from playwright.sync_api import sync_playwright

    data = json.loads(rows.read_text(encoding="utf-8"))
    parts = opening(data).replace("<h1>What drawing costs</h1>", ""), f"<div class=plots>{versus(data)}</div>", solving(data)
    words = f'<meta charset="utf-8"><style>{STYLE}</style>' + "".join(parts)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as run:
        file = Path(folder, "plots.html")
        file.write_text(words, encoding="utf-8")
        browser = run.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDE, "height": 800})
        page.goto(file.as_uri())
        shot = page.screenshot(full_page=True)
        browser.close()
    with Image.open(io.BytesIO(shot)) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)


if __name__ == "__main__":
    taken(*map(Path, sys.argv[1:]))
