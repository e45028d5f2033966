"""A drawing is read for its dots whoever made it: our SVG, another's, a bitmap; each dot where it lies and as large as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drawings import marks
from PIL import Image
from scipy.spatial import cKDTree

from crowquill import Ink, Layer, Paths, Sheet, Tone, draw, save, seen

SPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
PLACES = np.array([(10.0, 20.0), (30.0, 20.0), (10.0, 40.0), (33.0, 44.0)])
WIDE = 0.8  # mm
ROUND = 5e-4  # mm: a sheet has whole micrometres, and circles become cubics


def page(body: str) -> str:
    return f'<svg {SPACES} width="50mm" height="60mm" viewBox="0 0 50 60">{body}</svg>'


def dots(form: str) -> str:
    return "".join(form.format(x=x, y=y, r=WIDE / 2, w=WIDE, left=x - WIDE / 2) for x, y in PLACES)


ROUND_PATH = '<path d="M{left} {y}a{r} {r} 0 1 0 {w} 0a{r} {r} 0 1 0 -{w} 0z"/>'
OTHERS = {
    "circles": dots('<circle cx="{x}" cy="{y}" r="{r}"/>'),
    "ellipses": dots('<ellipse cx="{x}" cy="{y}" rx="{r}" ry="{r}"/>'),
    "paths": dots(ROUND_PATH),
    "uses": f'<defs><circle id="d" r="{WIDE / 2}"/></defs>' + dots('<use xlink:href="#d" x="{x}" y="{y}"/>'),
    "round caps": f'<path fill="none" stroke="black" stroke-linecap="round" stroke-width="{WIDE}" d="' + dots("M{x} {y}h0") + '"/>',
    "a group moved": '<g transform="translate(1 2)">' + dots('<circle cx="{x}" cy="{y}" r="{r}"/>') + "</g>",
}


@pytest.mark.parametrize("story", OTHERS)
def test_dots_of_others_are_found_where_they_are_and_as_large(story: str, tmp_path: Path):
    path = tmp_path / "other.svg"
    path.write_text(page(OTHERS[story]), encoding="utf-8")
    found = seen.load(path)
    off = (1, 2) if story == "a group moved" else (0, 0)
    assert found.size == pytest.approx((50, 60), abs=ROUND) and found.sites == pytest.approx(PLACES + off, abs=ROUND)
    assert found.diameters == pytest.approx(WIDE, abs=ROUND)


def test_lines_are_no_dots_and_count_as_ink(tmp_path: Path):
    path = tmp_path / "other.svg"
    path.write_text(page(OTHERS["circles"] + '<path d="M5 5H45" fill="none" stroke="black" stroke-width="1"/>'), encoding="utf-8")
    found = seen.load(path)
    assert len(found.sites) == len(PLACES)
    dark, pixel = found.coverage(0.1)
    assert dark.sum() * pixel[0] * pixel[1] == pytest.approx(40 + np.pi / 4 * (4 * WIDE**2), rel=0.02)  # butt ends are drawn round


def test_our_own_drawing_gives_back_its_marks_and_recipe(tmp_path: Path):
    sheet = draw("stipple", Tone(np.full((4, 5), 0.3), (20, 16)), pen=0.5).on((40, 30), margin=5)
    save(sheet, tmp_path / "a.svg")
    found = seen.load(tmp_path / "a.svg")
    assert found.marks is not None and (found.sites == sheet.marks.xy).all()
    assert found.areas == pytest.approx(sheet.marks.scale**2) and found.recipe["art_mm"] == [20, 16]


@pytest.mark.parametrize("kind", ["png", "tiff"])
def test_a_bitmap_shows_the_same_dots_within_a_twentieth_of_a_pixel(kind: str, tmp_path: Path):
    art = marks(60, width=30, height=20)
    sheet = Sheet((60, 50), (Layer(Ink(), art),))
    save(sheet, tmp_path / f"a.{kind}", dpi=600)
    found = seen.load(tmp_path / f"a.{kind}")
    pixel = 25.4 / 600
    assert found.size == pytest.approx((60, 50), abs=pixel) and len(found.sites) == len(art)
    away, which = cKDTree(found.sites).query(art.xy)
    assert away.max() < pixel / 20 and len(set(which.tolist())) == len(art)
    assert found.areas.sum() == pytest.approx((art.scale**2).sum(), rel=0.01)
    assert found.notes == ()


def test_dots_that_touch_in_a_bitmap_are_one_and_a_note_says_so(tmp_path: Path):
    place = np.array([(10, 10), (10.28, 10), (20, 10), (30, 10)])
    disc = marks(60, width=30, height=20).take(np.arange(4))
    near = type(disc)(place, disc.angle, np.full(4, 0.27), disc.glyph, disc.glyphs)
    save(Sheet((40, 20), (Layer(Ink(), near),)), tmp_path / "a.png", dpi=1200)
    found = seen.load(tmp_path / "a.png")
    assert len(found.sites) == 3 and "1 of 3 dark places" in found.notes[0]


def test_coverage_of_a_part_is_that_part_of_the_page(tmp_path: Path):
    box = Paths.of([[(10, 10), (20, 10), (20, 20), (10, 20)]])
    sheet = Sheet((40, 30), (Layer(Ink(), box), Layer(Ink("half", (0, 0, 0, 0.5)), box.moved(np.eye(2), (15, 0)))))
    save(sheet, tmp_path / "a.png", dpi=254)
    for found in (seen.of_sheet(sheet), seen.load(tmp_path / "a.png")):
        dark, pixel = found.coverage(0.5, (5.0, 5.0, 20.0, 20.0))
        assert pixel == pytest.approx((0.5, 0.5)) and dark.shape == (40, 40)
        assert dark[10:30, 10:30] == pytest.approx(1, abs=0.01) and dark[:9].max() < 0.01
        assert dark[15, 36] == pytest.approx(0 if 5 + 36.5 * 0.5 < 25 else 0.5, abs=0.01)


def test_a_bitmap_of_no_known_size_is_refused_and_dpi_gives_it_one(tmp_path: Path):
    Image.fromarray(np.full((30, 40), 255, np.uint8)).save(tmp_path / "a.png")
    with pytest.raises(ValueError, match=r"a\.png: its dpi is not known.*; give --dpi"):
        seen.load(tmp_path / "a.png")
    assert seen.load(tmp_path / "a.png", dpi=254).size == pytest.approx((4, 3))
    assert len(seen.load(tmp_path / "a.png", dpi=254).sites) == 0


def test_a_page_of_no_size_is_refused(tmp_path: Path):
    (tmp_path / "a.svg").write_text(f'<svg {SPACES} width="0" height="0"><circle r="1"/></svg>', encoding="utf-8")
    with pytest.raises(ValueError, match="its page has no size"):
        seen.load(tmp_path / "a.svg")
