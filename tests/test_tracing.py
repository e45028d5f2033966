"""Canvases from pictures: areas to half a percent, holes and islands counted, whatever lies behind; and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from PIL import Image

from crowquill import tracing
from crowquill.tone import Tone

H, W = 240, 320
CLOSE = 5e-3  # of an area: a tenth of a pixel on a disc 100 pixels wide, whose edge pixels hold some of each side
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"><path d="M20 0H40V30H20Z"/></svg>'
Y, X = np.mgrid[:H, :W] + 0.5


def disc(x: float, y: float, radius: float, hole: float = 0.0) -> Any:
    """The share of each pixel in a disc or ring, (H, W), good to some hundredths of a pixel."""
    far = np.hypot(X - x, Y - y)
    return np.clip(radius + 0.5 - far, 0, 1) * np.clip(far - hole + 0.5, 0, 1)


def saved(folder: Path, values: npt.ArrayLike, name: str = "shell.png", **save: Any) -> Path:
    """A picture of values of 0 to 255."""
    Image.fromarray(np.clip(np.round(values), 0, 255).astype(np.uint8)).save(folder / name, **save)
    return folder / name


def over(share: Any, specimen: npt.ArrayLike, backdrop: Any) -> Any:
    """A specimen of one colour before a backdrop, (H, W, 3)."""
    return share[..., None] * np.asarray(specimen, float) + (1 - share[..., None]) * np.asarray(backdrop, float)


def parts(shape: shapely.Geometry) -> list[Any]:
    return list(shapely.get_parts(shape))


VIGNETTE = np.cos(np.arctan(np.hypot(X - W / 2, Y - H / 2) / 400))[..., None] ** 4  # the law of a simple lens
BACKDROPS = {
    "white": np.full((H, W, 3), 255.0),
    "black": np.zeros((H, W, 3)),
    "vignetted grey": VIGNETTE * [150, 160, 170],
    "a blue gradient": (X / W * 40 + Y / H * 30)[..., None] + [90.0, 100, 140],
}
SPECIMENS = {"dark": (40, 40, 40), "brown": (120, 80, 50), "yellow": (230, 180, 90)}


@pytest.mark.parametrize("backdrop", BACKDROPS)
@pytest.mark.parametrize("specimen", SPECIMENS)
@pytest.mark.parametrize("noise", [0, 3])
def test_a_disc_comes_off_its_backdrop_to_half_a_percent(tmp_path: Path, backdrop: str, specimen: str, noise: float) -> None:
    grain = np.random.default_rng(1).normal(0, noise, (H, W, 3))
    path = saved(tmp_path, over(disc(170.3, 110.7, 50), SPECIMENS[specimen], BACKDROPS[backdrop]) + grain)
    found = tracing.canvas("auto", path, (W, H))
    assert found.area == pytest.approx(np.pi * 50**2, rel=CLOSE)
    assert found.geom_type == "Polygon" and not found.interiors and found.is_valid
    assert (found.centroid.x, found.centroid.y) == pytest.approx((170.3, 110.7), abs=0.1)
    assert len(found.exterior.coords) < 300  # of some 400 edge pixels


def test_a_grey_picture_and_one_of_sixteen_bits_come_off_too(tmp_path: Path) -> None:
    share = disc(160, 120, 50)
    deep = tmp_path / "deep.png"
    Image.fromarray((65535 * (1 - 0.6 * share)).astype(np.uint16)).save(deep)
    for path in (saved(tmp_path, 255 * (1 - 0.6 * share)), deep):
        assert tracing.canvas("auto", path, (W, H)).area == pytest.approx(np.pi * 50**2, rel=CLOSE)


def test_what_the_specimen_encloses_is_inside_and_islands_are_counted(tmp_path: Path) -> None:
    ring = tracing.canvas("auto", saved(tmp_path, 250 - 190 * disc(160, 120, 80, 30)), (W, H))
    assert ring.area == pytest.approx(np.pi * 80**2, rel=CLOSE)
    six = np.sum([disc(x, y, 20) for x in (60, 160, 260) for y in (60, 180)], axis=0)
    islands = parts(tracing.canvas("auto", saved(tmp_path, 250 - 160 * six), (W, H)))
    assert [round(island.area / (np.pi * 20**2), 2) for island in islands] == [1] * 6


def test_dust_a_frame_and_a_touched_border_do_not_matter(tmp_path: Path) -> None:
    page = 250 - 190 * disc(160, 120, 60)
    page[np.random.default_rng(2).integers(0, H, 40), np.random.default_rng(3).integers(0, W, 40)] = 0
    framed = page.copy()
    framed[:3] = framed[-3:] = framed[:, :3] = framed[:, -3:] = 0
    for values in (page, framed):
        assert tracing.canvas("auto", saved(tmp_path, values), (W, H)).area == pytest.approx(np.pi * 60**2, rel=CLOSE)
    half = tracing.canvas("auto", saved(tmp_path, 250 - 190 * disc(160, H, 90)), (W, H))
    assert half.area == pytest.approx(np.pi * 90**2 / 2, rel=CLOSE) and half.bounds[3] == H


@pytest.mark.parametrize("hole", [0, 20])
def test_alpha_and_masks_keep_areas_and_holes(tmp_path: Path, hole: float) -> None:
    share, true = disc(150.2, 119.6, 50, hole), np.pi * (50**2 - hole**2)
    rubbish = np.where(share[..., None] > 0, 60, np.random.default_rng(1).integers(0, 256, (H, W, 3)))
    cut = saved(tmp_path, np.dstack([rubbish, 255 * share]))
    mask = saved(tmp_path, 255 * share, "mask.png")
    hard = saved(tmp_path, 255.0 * (share > 0.5), "hard.png")
    clear = saved(tmp_path, np.dstack([np.full((H, W, 3), 255), 255.0 * (share > 0.5)]), "clear.png")  # white on nothing
    for wish in ("alpha", mask, hard, clear):
        found = tracing.canvas(wish, cut, (W, H))
        assert found.area == pytest.approx(true, rel=CLOSE) and len(found.interiors) == bool(hole)


def test_an_island_in_a_lake_on_an_island_is_one(tmp_path: Path) -> None:
    mask = saved(tmp_path, 255 * (disc(160, 120, 100, 70) + disc(160, 120, 40, 10)))
    found = parts(tracing.canvas(mask, mask, (W, H)))
    assert [len(part.interiors) for part in found] == [1, 1]
    assert sorted(part.area for part in found) == pytest.approx([np.pi * 1500, np.pi * 5100], rel=CLOSE)


def test_a_mask_is_laid_over_the_picture_whatever_its_size(tmp_path: Path) -> None:
    picture = saved(tmp_path, np.zeros((30, 40)))
    mask = saved(tmp_path, 255.0 * (X > W / 2), "mask.png")
    svg = tmp_path / "half.svg"
    svg.write_text(SVG)
    for wish in (mask, svg):
        for crop, left in ((None, 50), ((0.25, 0, 0.5, 1), 50), ((0.4, 0.5, 0.4, 0.5), 25), ((0.5, 0, 0.5, 1), 0)):
            found = tracing.canvas(wish, picture, (100, 60), crop=crop)
            assert shapely.symmetric_difference(found, shapely.box(left, 0, 100, 60)).area < 1e-6 * 6000  # binary fractions of a share


def test_a_canvas_takes_the_crop_and_the_turn_of_its_picture(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # lies on its side
    share = disc(100, 120, 50)
    lying = np.rot90(np.dstack([np.full((H, W, 3), 50), 255 * share]))
    crop = (0.2, 0.1, 0.3, 0.6)
    path = saved(tmp_path, lying, exif=exif)
    tone = Tone.load(path, crop=crop, tone="grey")
    placed = replace(tone, canvas=tracing.canvas("alpha", path, tone.size, crop=crop))
    assert tone.coverage.shape == (144, 96)
    # all the ink there is lies in the canvas, but for the outer halves of edge pixels
    assert placed.ink == pytest.approx(tone.ink, rel=2e-2) and placed.canvas.area < 0.6 * np.prod(tone.size)
    cut = placed.fitted(50, 50, "cover")
    assert cut.ink == pytest.approx(Tone(cut.coverage, cut.size).ink, rel=2e-2)


def test_all_light_is_the_whole_rectangle(tmp_path: Path) -> None:
    white = saved(tmp_path, np.full((5, 7), 255))
    assert Tone(np.zeros((5, 7)), (70, 50), tracing.canvas(white, white, (70, 50))).is_rectangle


def test_an_outline_of_blocks_lies_where_that_of_the_pixels_does(monkeypatch: pytest.MonkeyPatch) -> None:
    share = disc(170.3, 110.7, 90)[:-1, :-1]  # sides that three does not divide
    fine = tracing.traced(share)
    monkeypatch.setattr(tracing, "FINEST", share.size // 9 + 1)
    coarse = tracing.traced(share)
    assert shapely.symmetric_difference(fine, coarse).area < CLOSE * fine.area


def test_specks_and_pinholes_under_four_pixels_are_dropped() -> None:
    values = np.ones((30, 30))
    values[5, 5], values[20:23, 20:23], values[12:, :12] = 0, 0, 0
    values[20, 5], values[24:27, 3:6] = 1, 1
    found = parts(tracing.traced(values))
    assert len(found) == 2 and sum(len(part.interiors) for part in found) == 1


NOISE = np.random.default_rng(1).uniform(0, 255, (H, W))
REFUSED = {
    "alpha of none": ("alpha", np.zeros((9, 9)), "has no transparency .*; ask for auto"),
    "alpha all clear": ("alpha", np.zeros((9, 9, 4)), "is transparent all over; "),
    "auto on noise": ("auto", NOISE, "its border shows no plain backdrop; give a mask"),
    "auto on coloured noise": (
        "auto",
        np.random.default_rng(1).uniform(0, 255, (H, W, 3)),
        "its border shows no plain backdrop; give a mask",
    ),
    "auto on one grey": ("auto", np.full((H, W), 90), "nothing of it stands off its backdrop; give"),
    "auto on a ramp": ("auto", X / W * 255, "nothing of it stands off its backdrop; give"),
    "auto on a few pixels": ("auto", np.array([[0, 255], [255, 0]]), "its border shows no plain backdrop; give a mask"),
    "auto on one": ("auto", np.zeros((1, 1)), "its border shows no plain backdrop; give a mask"),
    "a dark mask": ("shell.png", np.zeros((9, 9)), "has no light place .*; make the canvas white"),
    "a mask of specks": ("shell.png", 255.0 * ((X % 8 < 1) & (Y % 8 < 1)), "has no light place .*; make the canvas white"),
    "a mask of crumbs": ("shell.png", 255.0 * ((X % 5 < 3) & (Y % 5 < 3)), "would be a canvas of 3072 islands and holes .*; smooth it"),
}


@pytest.mark.parametrize("story", REFUSED)
def test_a_picture_without_a_canvas_is_refused_in_a_line(tmp_path: Path, story: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wish, values, says = REFUSED[story]
    monkeypatch.setattr(tracing, "MOST", 3000)
    path = saved(tmp_path, values)
    with pytest.raises(ValueError, match=rf"^[^\n]*shell\.png: {says}[^\n]*$") as refusal:
        tracing.canvas(wish if wish in tracing.WISHES else tmp_path / wish, path)
    assert len(str(refusal.value).replace(str(tmp_path), "")) < 140


def test_a_mask_that_is_none_is_refused(tmp_path: Path) -> None:
    picture = saved(tmp_path, NOISE)
    (tmp_path / "words.png").write_text("white, please")
    for wish, says in (("words.png", r"words\.png: not a picture"), ("", "is a folder"), ("words.svg", "words.svg")):
        with pytest.raises((ValueError, FileNotFoundError), match=says):
            tracing.canvas(tmp_path / wish, picture)
    mask = saved(tmp_path, 255.0 * (X > W / 2), "mask.png")
    with pytest.raises(ValueError, match=r"mask\.png: its canvas has no area on the picture that the crop leaves; "):
        tracing.canvas(mask, picture, crop=(0, 0, 0.4, 1))
    with pytest.raises(ValueError, match="over the limit of 100; "):
        tracing.canvas("auto", picture, max_pixels=100)
