"""The editor's page, in a browser, on the real server: brushes, relaxation, undo, export, and what it says when things go wrong."""

from __future__ import annotations

import io
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from browser import PATIENCE, Array, Editor, browsing, log_of, serving
from PIL import Image
from playwright.sync_api import Browser, Error, Locator
from rendering import Window, dots, pdfium
from scipy.spatial import cKDTree

from crowquill import Ink, Layer, Sheet, glyphs, save
from crowquill.marks import Marks
from crowquill.sheet import Bitmap

PAPER = "60x60mm"
FREE = Window(4, 2, 38, 12)  # mm: white paper above the picture, which lies from 15 to 45 both ways
PX = 20.0  # to the mm of the screen, where dots are found
NEAR = 0.05  # mm: a pixel of that

Columns = dict[str, npt.NDArray[np.int64]]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsing() as found:
        yield found


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A grey disc of 64 x 64 pixels, darker to the right."""
    path = tmp_path_factory.mktemp("edited") / "disc.png"
    y, x = np.mgrid[:64, :64]
    grey = np.where(np.hypot(x - 31.5, y - 31.5) < 30, 220 - 2 * x, 255)
    Image.fromarray(grey.astype(np.uint8)).save(path)
    return path


@pytest.fixture(scope="module")
def address(picture: Path) -> Iterator[str]:
    with serving(picture, "--paper", PAPER, "--width", "30mm") as found:
        yield found


@pytest.fixture(scope="module")
def shared(browser: Browser, address: str) -> Editor:
    """The page, with the disc stippled."""
    made = Editor(browser, address, has_touch=True)
    made.apply("redraw stipple", pen=0.5)
    return made


@pytest.fixture
def editor(shared: Editor) -> Iterator[Editor]:
    """The page with the whole paper shown and nothing selected; without faults at the end."""
    shared.page.evaluate("crowquill.desk.viewport.all()")
    yield shared
    assert shared.faults == []


def places(found: Columns) -> Array:
    """Where items lie, (n, 2) mm."""
    return np.stack([found["x"], found["y"]], axis=1) / 1000.0


def off(xy: Array, a: tuple[float, float], b: tuple[float, float]) -> Array:
    """How far places are from the way between two, mm."""
    from_, way = xy - a, np.subtract(b, a)
    part = np.clip(from_ @ way / max(way @ way, 1e-12), 0, 1)
    return np.asarray(np.hypot(*(from_ - part[:, None] * way).T))


def changed(before: Columns, after: Columns) -> npt.NDArray[np.bool_]:
    """Which of the items there were before are gone or differ in any column."""
    where = {int(id): k for k, id in enumerate(after["id"])}
    rows = np.array([where.get(int(id), -1) for id in before["id"]])
    same = rows >= 0
    for name in before:
        same &= before[name] == after[name][rows]
    return ~same


def added(before: Columns, after: Columns) -> Columns:
    """The items that were not there before."""
    new = ~np.isin(after["id"], before["id"])
    return {name: column[new] for name, column in after.items()}


def test_two_hundred_dots_of_the_insert_brush_are_found_on_the_screen(editor: Editor) -> None:
    before = editor.columns()
    editor.take("b", size=5.0, rate=4.0, gap=0.2, diameter=0.4, glyph="nib-03")
    ways = [((7, 6), (39, 6)), ((39, 10), (7, 10))]
    for way in ways:
        editor.stroke(*way, steps=12)
    after = editor.columns()
    new = added(before, after)
    xy = places(new)
    assert len(xy) >= 200
    assert not changed(before, after).any()
    assert (np.min([off(xy, *way) for way in ways], axis=0) <= 2.5 + 0.001).all()  # the brush's radius, and a micrometre of rounding
    apart = cKDTree(xy).query(xy, 2)[0][:, 1]
    assert apart.min() >= 0.2 + 0.3  # the gap, and a dot that is narrower than its mean diameter by a quarter at most
    seen, _ = dots(editor.ink(FREE, PX), FREE, PX)
    far, nearest = cKDTree(seen).query(xy)
    assert len(seen) == len(xy) == len(set(nearest))
    assert far.max() <= NEAR


@pytest.mark.parametrize("scale", [3.0, 11.0, 30.0])
def test_a_screen_is_as_dark_as_the_dots_are_large_at_any_zoom(editor: Editor, scale: float) -> None:
    window = Window(47, 20, 9, 20)
    if not len(within(editor, window)):
        editor.take("b", size=8.0, rate=30.0, gap=0.1, diameter=0.5, glyph="disc")
        editor.stroke((51.5, 25), (51.5, 35))
    area = np.pi * 0.25**2 * len(within(editor, window))
    assert editor.ink(window, scale).sum() / scale**2 == pytest.approx(area, rel=0.02)  # sprites are of steps of 1/16 px


def within(editor: Editor, window: Window) -> Array:
    """Where marks lie in a window, mm."""
    xy = places(editor.columns())
    return xy[window.holds(xy)]


def test_erasing_takes_what_is_under_the_brush_and_leaves_the_rest_to_a_bit(editor: Editor) -> None:
    before = editor.columns()
    editor.take("e", size=4.0, strength=1.0, falloff="flat")
    way = ((20.0, 25.0), (40.0, 25.0))
    editor.stroke(*way)
    after = editor.columns()
    far = off(places(before), *way)
    gone = changed(before, after)
    assert gone[far < 1.9].all() and gone.any()  # mm: between pieces of the stroke notches of .02 mm may stay
    assert not gone[far > 2.001].any()
    assert len(after["id"]) == len(before["id"]) - gone.sum()


def test_pushing_drags_marks_along_and_no_others(editor: Editor) -> None:
    before = editor.columns()
    editor.take("p", size=6.0, strength=1.0, falloff="smooth")
    way = ((26.0, 32.0), (32.0, 32.0))
    editor.stroke(*way, steps=12)
    after = editor.columns()
    moved = changed(before, after)
    assert (off(places(before), *way)[moved] <= 3.001).all()
    step = (places(after) - places(before))[moved]
    assert len(after["id"]) == len(before["id"]) and moved.sum() > 20
    assert step[:, 0].max() > 2 and (np.abs(step[:, 1]) < 0.1).all()  # mm: the way is level, but for the pixels it is drawn in


def test_relaxing_under_the_brush_moves_no_mark_outside_by_a_bit(editor: Editor) -> None:
    before = editor.columns()
    editor.take("r", size=8.0, strength=1.0, variant="weighted")
    editor.stroke((30, 36), (33, 36))
    after = editor.columns()
    moved = changed(before, after)
    assert (off(places(before), (30, 36), (33, 36))[moved] <= 4.001).all()
    assert moved.sum() > 20


def relaxing(editor: Editor) -> Locator:
    """The choice of a variant, on the panel of relaxation, which is shown."""
    editor.tab("Relax")
    return editor.page.get_by_role("tabpanel", name="Relax").get_by_label("Variant")


def test_steps_of_every_variant_do_what_they_are_called(editor: Editor) -> None:
    editor.apply("layer add", name="ticks")
    ticks = max(layer["id"] for layer in editor.state()["layers"])
    editor.apply("insert", layer=ticks, path=[30, 30, 1], size=24, rate=60, glyph="ticks", diameter=1.2, gap=0.1)
    editor.apply("tile", side=3.0, gap=0.3)
    choice = relaxing(editor)
    variants = choice.locator("option").all_inner_texts()
    assert {"uniform", "weighted", "move", "turn", "objects", "mosaic"} <= set(variants)
    for variant in variants:
        before, count = editor.columns(), len(editor.state()["undo"])
        choice.select_option(variant)
        editor.page.get_by_label("Number of steps").fill("3")
        editor.page.get_by_role("button", name="steps", exact=True).click()
        editor.rest()
        after, state = editor.columns(), editor.state()
        assert state["undo"][0] == "relax" and len(state["undo"]) == min(50, count + 1)
        assert changed(before, after).any(), variant
        if variant in ("move", "turn") and len(after["id"]) == len(before["id"]):
            still = "turn" if variant == "move" else "x"
            assert (after[still] == before[still]).all(), variant
    assert editor.page.locator(".plot-now").first.inner_text() != ""


def test_play_goes_on_until_it_is_stopped_and_can_be_undone_whole(editor: Editor) -> None:
    before = editor.columns()
    relaxing(editor).select_option("uniform")
    panel = editor.page.get_by_role("tabpanel", name="Relax")
    panel.get_by_role("button", name="Play").click()
    editor.until("crowquill.desk.drawing.state.value.busy !== null")
    panel.get_by_role("button", name="Pause").click()
    editor.until("crowquill.desk.drawing.state.value.busy?.paused === true")
    panel.get_by_role("button", name="Go on").click()
    editor.until("crowquill.desk.drawing.state.value.busy?.paused === false")
    panel.get_by_role("button", name="Stop", exact=True).click()
    editor.rest()
    assert changed(before, editor.columns()).any()
    editor.press("Control+z")
    assert not changed(before, editor.columns()).any()


def test_long_work_is_shown_and_paused_and_cancelled_while_the_drawing_is_looked_at_and_written(editor: Editor, picture: Path) -> None:
    before, count = editor.columns(), len(log_of(picture))
    bar = editor.page.locator("#work")
    editor.page.evaluate("void crowquill.desk.apply('redraw stipple', { dots: 20000, iterations: 100000 })")
    bar.wait_for(state="visible")
    editor.until("/^Stipple: relax [0-9]+ of 100000$/.test(document.querySelector('#work span').textContent)")
    assert bar.get_by_role("progressbar").get_attribute("value") is not None
    bar.get_by_role("button", name="Pause").click()
    bar.get_by_role("button", name="Go on").wait_for()
    assert violations(editor) == []
    assert exported(editor, picture, "meanwhile")["svg"]  # and nothing of it is waited for
    bar.get_by_role("button", name="Cancel").click()
    bar.wait_for(state="hidden")
    editor.rest()
    assert not changed(before, editor.columns()).any() and len(log_of(picture)) == count


def test_fifty_undone_and_done_again_give_the_same_bytes(editor: Editor, picture: Path) -> None:
    for k in range(50):
        editor.page.evaluate("(k) => { crowquill.desk.apply('jitter', { path: [20 + k / 2, 30, 1], size: 4, amount: 0.1 }) }", k)
    editor.rest()
    assert editor.state()["undo"][:50] == ["jitter"] * 50
    first = exported(editor, picture, "first")
    middle = editor.columns()
    for _ in range(50):
        editor.page.keyboard.press("Control+z")
    editor.rest()
    assert changed(middle, editor.columns()).any()
    for _ in range(50):
        editor.page.keyboard.press("Control+Shift+z")
    editor.rest()
    assert exported(editor, picture, "second") == first


def exported(editor: Editor, picture: Path, name: str) -> dict[str, bytes]:
    """The files that the page's own dialog writes, by suffix."""
    editor.page.get_by_role("button", name="Export").click()
    dialog = editor.page.get_by_role("dialog")
    dialog.get_by_label("Name").fill(name)
    dialog.get_by_role("button", name="Export").click()
    dialog.get_by_text("is written").nth(1).wait_for()
    editor.page.keyboard.press("Escape")
    return {suffix: picture.with_name(f"{name}.{suffix}").read_bytes() for suffix in ("svg", "pdf")}


def test_an_exported_pdf_has_its_dots_where_the_page_shows_them(editor: Editor, picture: Path) -> None:
    editor.take("b", size=3.0, rate=4.0, gap=0.3, diameter=0.5, glyph="nib-03")
    editor.stroke((8, 50), (36, 53))
    window = Window(4, 46, 38, 12)
    seen, wide = dots(editor.ink(window, PX), window, PX)
    printed, true = dots(pdfium(exported(editor, picture, "places")["pdf"], window, PX), window, PX)
    far, nearest = cKDTree(printed).query(seen)
    assert len(seen) == len(printed) == len(set(nearest)) > 20
    assert far.max() <= NEAR
    assert np.abs(wide - true[nearest]).max() <= NEAR


def test_preflight_says_in_the_dialog_what_it_finds(editor: Editor, picture: Path) -> None:
    editor.page.keyboard.press("Control+s")
    dialog = editor.page.get_by_role("dialog")
    dialog.get_by_label("Name").fill("checked")
    dialog.get_by_role("button", name="Export").click()
    dialog.get_by_role("button", name="Preflight").first.click()
    dialog.locator(".findings li, p:text('press')").first.wait_for()
    dialog.get_by_role("button", name="Export").click()
    dialog.locator("p.error").wait_for()  # it is there already
    dialog.get_by_label("Replace files that are there").check()
    dialog.get_by_role("button", name="Export").click()
    dialog.get_by_text("is written").nth(1).wait_for()
    dialog.get_by_label("Name").fill("../outside")
    dialog.get_by_role("button", name="Export").click()
    dialog.locator("p.error").wait_for()
    editor.page.keyboard.press("Escape")
    assert picture.with_name("checked.pdf").exists() and not (picture.parent.parent / "outside.pdf").exists()


def test_a_killed_page_loses_nothing(editor: Editor, browser: Browser, address: str) -> None:
    other = Editor(browser, address)
    other.until("crowquill.desk.drawing.tabs.value === 2")
    assert "2 tabs" in editor.page.locator("#tab-count").inner_text()
    other.take("j", size=6.0)
    other.stroke((28, 28), (34, 30))
    kept = other.columns()
    with suppress(Error):
        other.page.goto("chrome://crash", timeout=5000)
    again = Editor(browser, address)
    assert not changed(kept, again.columns()).any()
    editor.until("crowquill.desk.drawing.tabs.value === 2")
    assert not changed(kept, editor.columns()).any()
    again.page.close()


def test_a_broken_line_is_said_and_mended(editor: Editor) -> None:
    before = editor.columns()
    editor.page.evaluate("crowquill.desk.link.socket.close(4000)")
    editor.until("!document.getElementById('banner').hidden")
    assert "connecting again" in editor.page.locator("#banner").inner_text()
    editor.rest()
    assert editor.page.locator("#banner").is_hidden()
    assert not changed(before, editor.columns()).any()
    editor.press("Control+a")
    assert editor.state()["selected"] == len(before["id"])
    editor.press("Control+z")


def test_what_the_server_refuses_is_said_on_the_page(editor: Editor) -> None:
    before = editor.state()["revision"]
    for op, params in (("insert", {"path": [1, 2]}), ("no such thing", {}), ("erase", {"path": [1, 2, 1], "size": -1})):
        editor.page.evaluate("([op, params]) => crowquill.desk.apply(op, params)", [op, params])
        line = editor.page.locator("#messages p.error").last
        line.wait_for()
        assert len(line.inner_text()) > 10
        line.click()
    assert editor.state()["revision"] == before


def test_a_selection_is_moved_and_turned_by_its_handles(editor: Editor) -> None:
    editor.take("m")
    editor.stroke((24, 24), (36, 36), steps=3)
    before, count = editor.columns(), editor.state()["selected"]
    chosen = (before["flags"] & 1) == 1
    assert count == chosen.sum() > 20
    xy = places(before)[chosen]
    middle = (xy.min(axis=0) + xy.max(axis=0)) / 2
    editor.stroke(tuple(middle), (middle[0] + 4, middle[1] - 2))
    dragged = places(editor.columns())[chosen]
    assert np.abs(dragged - xy - (4, -2)).max() < 0.1  # mm: half a pixel
    box = editor.page.evaluate("crowquill.desk.drawing.selection()")
    x, y = editor.screen((box["left"] + box["right"]) / 2, box["top"])
    editor.page.mouse.move(x, y - 26)
    editor.page.mouse.down()
    centre = (dragged.min(axis=0) + dragged.max(axis=0)) / 2
    cx, cy = editor.screen(*centre)
    editor.page.mouse.move(cx + (cy - y + 26), cy + (x - cx), steps=4)  # a quarter of a turn about the middle
    editor.page.mouse.up()
    editor.rest()
    turned = places(editor.columns())[chosen] - centre
    quarter = np.stack([-(dragged - centre)[:, 1], (dragged - centre)[:, 0]], axis=1)
    assert np.abs(turned - quarter).max() < 0.05  # mm: whole pixels far from the middle
    editor.press("Escape")
    assert editor.state()["selected"] == 0


def test_a_pen_presses_as_hard_as_it_does(editor: Editor, picture: Path) -> None:
    editor.take("j", size=4.0)
    x, y = editor.screen(30, 30)
    pen: dict[str, Any] = {"x": x, "y": y, "button": "left", "pointerType": "pen", "force": 0.25, "clickCount": 1}
    session = editor.page.context.new_cdp_session(editor.page)
    session.send("Input.dispatchMouseEvent", {"type": "mousePressed", **pen})
    session.send("Input.dispatchMouseEvent", {"type": "mouseReleased", **pen})
    editor.rest()
    editor.until("crowquill.desk.drawing.state.value.undo[0] === 'jitter'")
    assert '"path": [' in str(log_of(picture)[-1]).replace("'", '"')
    assert 0.25 in [round(value, 3) for value in log_of(picture)[-1]["params"]["path"][2::3]]


def test_two_fingers_pan_and_zoom_and_draw_nothing(editor: Editor) -> None:
    editor.take("e", size=5.0)
    before, scale = editor.columns(), editor.page.evaluate("crowquill.desk.viewport.scale")
    x, y = editor.screen(30, 30)
    session = editor.page.context.new_cdp_session(editor.page)
    for spread in (40, 60, 80):
        kind = "touchStart" if spread == 40 else "touchMove"
        session.send(
            "Input.dispatchTouchEvent",
            {"type": kind, "touchPoints": [{"x": x - spread, "y": y, "id": 0}, {"x": x + spread, "y": y, "id": 1}]},
        )
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    editor.rest()
    assert editor.page.evaluate("crowquill.desk.viewport.scale") == pytest.approx(2 * scale, rel=0.02)  # 40 to 80 px
    assert not changed(before, editor.columns()).any()


def test_the_keyboard_alone_draws(editor: Editor) -> None:
    before = editor.columns()
    editor.take("b", size=4.0, rate=20.0, glyph="disc", diameter=0.4, gap=0.1)
    for key in ["Shift+ArrowRight", "Shift+ArrowDown", "Shift+ArrowDown", "ArrowRight", "Enter"]:
        editor.page.keyboard.press(key)
    editor.rest()
    xy = places(added(before, editor.columns()))
    assert len(xy), editor.said()
    assert np.hypot(*(xy.mean(axis=0) - (41, 50))).max() < 2  # mm: 11 right of the middle and 20 below


def test_a_layer_gets_a_spot_ink_and_the_drawing_another_paper(editor: Editor) -> None:
    before, page = editor.columns(), editor.page
    editor.tab("Layers")
    panel = page.get_by_role("tabpanel", name="Layers")
    panel.get_by_role("radio").last.check()
    panel.get_by_label("Ink", exact=True).select_option("spot")
    panel.get_by_label("Spot name").fill("Gold")
    panel.get_by_label("Spot name").press("Enter")
    panel.get_by_role("button", name="Sepia").click()
    editor.rest()  # what the server answers fills the fields
    panel.get_by_label("Cyan, per cent").fill("50")
    panel.get_by_label("Magenta, per cent").fill("20")
    panel.get_by_label("Magenta, per cent").press("Enter")
    editor.rest()
    layer = editor.state()["layers"][0]
    assert (layer["ink"], layer["spot"], layer["cmyk"]) == ("Gold", True, [0.5, 0.2, 0.75, 0.45])
    panel.get_by_text("Another paper", exact=True).click()
    panel.get_by_role("combobox", name="Paper").fill("90x80mm")
    panel.get_by_role("button", name="Put it on this paper").click()
    editor.until("crowquill.desk.drawing.hello.value.size[0] === 90")
    editor.rest()
    assert "90 × 80 mm" in panel.inner_text()
    assert np.abs(places(editor.columns()) - places(before) - (15, 10)).max() < 1e-9
    editor.page.evaluate("crowquill.desk.ask({ do: 'undo', count: 5 })")
    editor.until("crowquill.desk.drawing.hello.value.size[0] === 60")
    editor.rest()
    assert not changed(before, editor.columns()).any() and not editor.state()["layers"][0]["spot"]


def colour(editor: Editor, x: float, y: float) -> tuple[int, ...]:
    """The colour on the screen at a place of the paper, mm."""
    left, top = editor.screen(x, y)
    shot = editor.page.screenshot(clip={"x": left, "y": top, "width": 1, "height": 1})
    with Image.open(io.BytesIO(shot)) as image:
        return image.convert("RGB").getpixel((0, 0))  # type: ignore[return-value]


def test_layers_that_are_not_edited_are_seen_in_their_true_order(browser: Browser, tmp_path: Path) -> None:
    disc = Marks.of([[30.0, 30.0], [5.0, 5.0]], glyphs.load("disc").glyphs, scale=8.0)
    red, green = Ink("red", (0.0, 1.0, 1.0, 0.0)), Ink("green", (1.0, 0.0, 1.0, 0.0))
    below, above = (Bitmap.of(np.ones((n, n)), 254, (30 - n / 20, 30 - n / 20)) for n in (140, 20))  # 14 and 2 mm, about the disc of 9
    save(Sheet((60, 60), (Layer(green, below), Layer(Ink(), disc), Layer(red, above))), tmp_path / "still.svg")
    with serving(tmp_path / "still.svg") as address:
        editor = Editor(browser, address)
        assert [layer["kind"] for layer in editor.state()["layers"]] == ["still", "marks", "still"]
        end = time.monotonic() + PATIENCE
        while colour(editor, 30, 30) != (255, 0, 0) and time.monotonic() < end:
            editor.page.wait_for_timeout(100)  # images come beside the drawing's state
        places = ((30, 30), (33, 30), (36.5, 30), (50, 50))
        assert [colour(editor, *place) for place in places] == [(255, 0, 0), (0, 0, 0), (0, 255, 0), (255, 255, 255)]
        editor.apply("layer order", layer=2, to=2)
        assert [colour(editor, *place) for place in places] == [(0, 0, 0), (0, 0, 0), (0, 255, 0), (255, 255, 255)]
        editor.apply("layer edit", layer=1, hidden=True)
        assert colour(editor, 36.5, 30) == (255, 255, 255)
        editor.page.close()


AXE = Path(__file__).resolve().parents[1] / "web" / "node_modules" / "axe-core" / "axe.min.js"
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
REACHED = """() => [...document.querySelectorAll('#app button, #app input, #app select, #app summary, #surface')]
  .filter((e) => e.checkVisibility() && !e.disabled && e.tabIndex >= 0).length"""
FOCUSED = """() => { const e = document.activeElement, style = getComputedStyle(e);
  e.dataset.reached = '1';
  return [e === document.body, style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2]; }"""


def violations(editor: Editor) -> list[str]:
    """What axe finds wrong with the page as it is now."""
    if not AXE.exists():
        reason = "NOT RUN: web/node_modules is missing; make page installs it"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    if not editor.page.evaluate("typeof axe === 'object'"):
        editor.page.evaluate(AXE.read_text(encoding="utf-8"))
    found = editor.page.evaluate("(tags) => axe.run(document, { runOnly: tags, resultTypes: ['violations'] })", RULES)
    return [f"{one['id']}: {node['html'][:120]}" for one in found["violations"] for node in one["nodes"]]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_panel_and_dialog_is_accessible(editor: Editor, theme: str) -> None:
    editor.page.evaluate("(theme) => { crowquill.desk.appearance.theme.value = theme; }", theme)
    for tab in ("Tool", "Layers", "Relax", "Style", "History", "View"):
        editor.tab(tab)
        assert violations(editor) == [], tab
    for name in ("Keys", "Export"):
        editor.page.get_by_role("button", name=name).click()
        assert violations(editor) == [], name
        editor.page.keyboard.press("Escape")


def test_what_is_not_accessible_is_found(editor: Editor) -> None:
    editor.page.evaluate("document.getElementById('inspector').insertAdjacentHTML('beforeend', '<button id=nameless></button>')")
    assert any("nameless" in line for line in violations(editor))
    editor.page.evaluate("document.getElementById('nameless').remove()")


def test_the_tab_key_reaches_every_control_and_shows_where_it_is(editor: Editor) -> None:
    editor.tab("Layers")
    count = editor.page.evaluate(REACHED)
    editor.page.evaluate("document.activeElement.blur()")
    for _ in range(count + 1):
        editor.page.keyboard.press("Tab")
        body, seen = editor.page.evaluate(FOCUSED)
        assert body or seen
    missed = "[...document.querySelectorAll('#app button, #app input, #app select')].filter((e) => e.checkVisibility() && !e.disabled"
    missed += " && e.tabIndex >= 0 && !e.dataset.reached && e.type !== 'radio').map((e) => e.outerHTML)"
    assert count > 12 and editor.page.evaluate(missed) == []


def test_shortcuts_of_one_character_can_be_turned_off(editor: Editor) -> None:
    editor.take("b")
    editor.tab("View")
    box = editor.page.get_by_label("Shortcuts of one character")
    for wanted, tool in ((False, "insert"), (True, "erase")):
        box.set_checked(wanted)
        editor.page.locator("#surface").focus()
        editor.page.keyboard.press("e")
        assert editor.page.evaluate("crowquill.desk.tool.value.name") == tool
        editor.tab("View")
