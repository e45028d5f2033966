"""Take gallery/editor.png and gallery/editor_objects.png: the editor's page at work on the specimen, in a real browser."""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from browser import Editor, browsing, serving

GALLERY = Path(__file__).resolve().parents[1] / "gallery"
SIZE = (1240, 780)  # px
COLOURS = 64


def shot(editor: Editor, name: str) -> None:
    editor.page.evaluate("document.getElementById('messages').replaceChildren()")
    with Image.open(io.BytesIO(editor.page.screenshot())) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(GALLERY / f"{name}.png", optimize=True)


def look(editor: Editor, theme: str, opacity: float, box: tuple[float, float, float, float]) -> None:
    """Sets the page's colours and what is seen: mm of the left, upper, right and lower side."""
    editor.page.evaluate(
        """([theme, opacity, [left, top, right, bottom]]) => {
          const { appearance, viewport } = crowquill.desk;
          appearance.theme.value = theme;
          appearance.opacity.value = opacity;
          viewport.fit({ left, top, right, bottom });
        }""",
        [theme, opacity, list(box)],
    )
    editor.page.wait_for_timeout(500)


def dots(editor: Editor) -> None:
    """Dots of a pen, some of them selected, a part relaxed again, its energy plotted."""
    editor.apply("redraw stipple", pen=0.35)
    editor.apply("jitter", on="all", amount=0.12)
    look(editor, "light", 0.3, (38, 62, 112, 122))
    editor.take("l")
    editor.stroke((43, 70), (43, 92), (58, 96), (63, 82), (57, 69), (45, 68))
    editor.tab("Relax")
    panel = editor.page.get_by_role("tabpanel", name="Relax")
    panel.get_by_label("Number of steps").fill("25")
    panel.get_by_role("button", name="steps", exact=True).click()
    editor.rest()
    editor.page.mouse.move(*editor.screen(90, 80))
    shot(editor, "editor")


def objects(editor: Editor) -> None:
    """Objects with handles while they are turned."""
    editor.apply("redraw objects", objects="leaves")
    look(editor, "dark", 0.25, (50, 75, 104, 119))
    editor.take("l")
    editor.stroke((70, 88), (70, 102), (84, 104), (88, 93), (82, 86), (71, 87))
    editor.tab("Layers")
    editor.page.get_by_role("radio").nth(1).click()
    editor.page.mouse.move(*editor.screen(100, 80))
    shot(editor, "editor_objects")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "specimen.png"
        shutil.copy(GALLERY / "specimen.png", file)
        with serving(file, "--paper", "a5") as address, browsing() as browser:
            editor = Editor(browser, address, *SIZE)
            dots(editor)
            objects(editor)
