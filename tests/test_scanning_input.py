"""Pages that are noisy, coloured, negative, empty, huge or no pictures have their answers; grey patches are read back."""

from __future__ import annotations

import base64
import io
import zlib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy import ndimage
from skimage.measure import find_contours
from test_scanning import ABOUT, DPI, PIXEL, UM, areas_and_centroids, clean, differences, dots, ellipse, page

from crowquill import glyphs
from crowquill.glyphs import Library
from crowquill.glyphs.scanning import Scan, library, scan
from crowquill.paths import Array, Paths
from crowquill.picture import encoded, linear


@cache
def noisy() -> Scan:
    """The page's dots under noise of 0.03 of the code values: 0.07 of the paper's light."""
    return scan(page(dots(), noise=0.03, tilt=0), dpi=DPI)


def contours(found: Scan) -> list[shapely.Polygon]:
    """The contour of each dot in mm, found another way: of the patch zoomed by splines, at the level named."""
    made = []
    for patch, corner, level in zip(found.patches, found.corners, found.levels, strict=True):
        fine = ndimage.zoom(patch.astype(float), [(5 * side - 4) / side for side in patch.shape], order=3, mode="mirror")
        ring = max(find_contours(fine, level), key=len)[:, ::-1] / 5 + 0.5
        made.append(shapely.Polygon(ring * PIXEL + corner))
    return made


def test_noise_is_smoothed_as_far_as_it_asks_and_dots_stay_where_and_as_large_as_they_are() -> None:
    found = noisy()
    assert clean()[2].smoothing == 0  # noise of 0.01 needs none
    assert 0.5 <= found.smoothing <= 1
    assert found.warnings == ()
    apart, larger = differences(dots(), found)
    assert apart.max() < 3 * UM
    assert np.abs(larger).max() < 0.02
    assert np.abs(larger.mean()) < 0.005  # smoothing draws edges in by 2 %, and the level makes up for it


def test_outlines_of_a_noisy_page_lie_within_three_micrometres_of_its_contours_with_few_cubics() -> None:
    found = noisy()
    for ring, contour in zip(found.outlines, contours(found), strict=True):
        outline = Paths.of([ring], cubic=True)
        curve = outline.flat(1e-5).polygons()[0]
        assert shapely.hausdorff_distance(curve.exterior, contour.exterior, densify=0.25) < 3.1 * UM  # 0.1: two splines' ends
        assert outline.areas[0] / contour.area == pytest.approx(1, abs=0.002)
    assert np.diff(found.outlines.start).mean() / 3 <= 6.5


def test_without_smoothing_the_noise_would_show(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("crowquill.glyphs.page.SMOOTHER", (0.0,))
    shaken, astray = scan(page(dots(), noise=0.03, tilt=0), dpi=DPI).warnings
    assert "noise moves edges" in shaken
    assert "off their contours" in astray


def test_a_scan_holds_what_a_contact_sheet_draws() -> None:
    code = page([*dots(3), ellipse(0, 1.5, 0.3, 0.3), ellipse(1.35, 1.35, 0.1, 0.1)], (3.4, 4.0))
    found = scan(code, dpi=DPI)
    assert found.size == pytest.approx((code.shape[1] * PIXEL, code.shape[0] * PIXEL))
    assert (found.scale, found.counts) == ("given", {"cut by the border": 1, "dust": 1})
    for _, (left, top, right, bottom) in found.rejected:
        assert 0 <= left < right <= found.size[0]
        assert 0 <= top < bottom <= found.size[1]


def test_a_page_of_yellow_paper_and_blue_ink_works(tmp_path: Path) -> None:
    rings = dots()
    cover = 1 - linear(page(rings, noise=0, tilt=0, ink=0)) / 0.85
    light = np.array([0.95, 0.85, 0.55]) * (1 - cover[..., None]) + np.array([0.03, 0.05, 0.35]) * cover[..., None]
    Image.fromarray(np.uint8(encoded(np.clip(light, 0, 1)) * 255 + 0.5)).save(tmp_path / "page.png", dpi=(DPI, DPI))
    found = scan(tmp_path / "page.png")
    apart, larger = differences(rings, found)
    assert (apart.max() < 3 * UM, np.abs(larger).max() < 0.02, found.warnings) == (True, True, ())


def test_a_colour_cast_changes_nothing_but_the_light(tmp_path: Path) -> None:
    rings, code, _ = clean()
    cast = encoded(linear(code)[..., None] * (0.95, 0.8, 0.5))
    Image.fromarray(np.uint8(cast * 255 + 0.5)).save(tmp_path / "page.png", dpi=(DPI, DPI))
    apart, larger = differences(rings, scan(tmp_path / "page.png"))
    assert (apart.max() < 3 * UM, np.abs(larger).max() < 0.02) == (True, True)


def test_a_negative_is_refused_until_it_is_said_to_be_one() -> None:
    _, code, found = clean()
    with pytest.raises(ValueError, match="use invert"):
        scan(1 - code, dpi=DPI)
    with pytest.raises(ValueError, match="leave out invert"):
        scan(code, dpi=DPI, invert=True)
    np.testing.assert_allclose(scan(1 - code, dpi=DPI, invert=True).outlines.xy, found.outlines.xy, atol=1e-9)


@pytest.mark.parametrize(
    ("code", "dpi", "remedy"),
    [
        (page([]), DPI, "no dots; scan dark ink on light paper"),
        (page([], noise=0, tilt=0), DPI, "no dots; scan dark ink"),
        (np.ones((0, 0)), DPI, "no dots; scan dark ink"),
        (page([ellipse(4, 4, 4, 4)], (8, 8)), DPI, "1 giant.*scan single dots"),
        (page([ellipse(0, 2, 0.3, 0.3)]), DPI, "1 cut by the border.*scan single dots"),
        (page(dots(2)), None, "dpi is not known; give it, such as --dpi 1200, or lay a ruler"),
        (np.ones((99, 99)), 72, "too coarse.*scan at 1200"),
        (np.ones((99, 99)), float("nan"), "too coarse.*scan at 1200"),
        (np.full((99, 99), 255.0), DPI, "it takes grey code values 0 to 1"),
        (np.ones((9, 9, 3)), DPI, "it takes n by n"),
    ],
)
def test_a_bad_scan_is_refused_in_one_line_with_a_remedy(code: Array, dpi: float | None, remedy: str) -> None:
    with pytest.raises(ValueError, match=remedy) as refused:
        scan(code, dpi=dpi)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("how", "said"),
    [({"tilt": 0.5}, "uneven light"), ({"noise": 0.08, "tilt": 0}, "even when smoothed"), ({"dpi": 300, "tilt": 0}, "scan with more dpi")],
)
def test_what_makes_outlines_doubtful_is_said(how: dict[str, Any], said: str) -> None:
    assert scan(page(dots(3), tilt=0), dpi=DPI).warnings == ()
    (warning,) = scan(page(dots(3), **how), dpi=how.get("dpi", DPI)).warnings
    assert said in warning


def picture(code: Array, **how: Any) -> bytes:
    file = io.BytesIO()
    Image.fromarray(np.uint8(code * 255 + 0.5)).save(file, how.pop("format", "PNG"), **how)
    return file.getvalue()


@pytest.mark.parametrize(
    ("data", "remedy"),
    [
        (lambda: b"", "not a picture that can be read|the file is empty; give a picture file"),
        (lambda: b"no picture at all", "not a picture that can be read; give one of PNG"),
        (lambda: picture(page(dots(2)), dpi=(DPI, DPI))[:900], "the picture is broken"),
        (lambda: picture(page(dots(2))), "its dpi is not known; give it, such as --dpi 1200, or lay a ruler beside"),
        (lambda: picture(page(dots(2)), dpi=(72, 72)), "its tag says 72 dpi, a camera's stopgap; give the true --dpi, or lay a ruler"),
        (lambda: picture(page(dots(2)), dpi=(200, 200)), "its tag says 200 dpi, too coarse for ink dots; scan at 1200, give --dpi"),
        (lambda: picture(page(dots(2)), dpi=(1200, 600)), "1200 by 599.999 dpi; scan with square pixels"),
        (lambda: picture(1 - page(dots(2)), dpi=(DPI, DPI)), "use invert for white on black"),
        (lambda: b"P5 100000 100000 255\n", "pixels are over the limit of 200 million"),
    ],
)
def test_a_bad_file_is_refused_in_one_line_with_a_remedy(tmp_path: Path, data: Any, remedy: str) -> None:
    path = tmp_path / "page.bin"
    path.write_bytes(data())
    for source in (path, io.BytesIO(path.read_bytes())):
        with pytest.raises(ValueError, match=remedy) as refused:
            scan(source)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("tag", [(0, 0), (1e-9, 1e-9)])
def test_a_tag_that_says_nothing_counts_as_none(tmp_path: Path, tag: tuple[float, float]) -> None:
    (tmp_path / "page.jpg").write_bytes(picture(page(dots(2)), format="JPEG", dpi=tag))
    with pytest.raises(ValueError, match="lay a ruler beside"):
        scan(tmp_path / "page.jpg")


@cache
def kept() -> Library:
    return glyphs.parsed(library(clean()[2], name="scan-03", pen_mm=0.3, about=ABOUT), "scan-03")


def test_grey_patches_are_read_back_as_they_were_scanned() -> None:
    found = clean()[2]
    read = glyphs.patches(kept())
    _, centre = areas_and_centroids(found.outlines)
    assert len(read) == len(found.patches) == 25
    for patch, grey, corner, place in zip(read, found.patches, found.corners, centre, strict=True):
        np.testing.assert_allclose(patch.grey, grey, atol=0.5 / 255 + 1e-6)  # kept in 8 bits
        np.testing.assert_allclose(patch.centre_mm + corner, place, atol=1e-5)  # five decimals
        assert patch.pixel_mm == pytest.approx(PIXEL)
        assert not patch.grey.flags.writeable


def test_a_library_without_patches_gives_none() -> None:
    assert glyphs.patches(glyphs.load("disc")) == ()


def packed(n: int) -> str:
    return base64.b64encode(zlib.compress(bytes(n))).decode()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"grey": "%%%"}, "broken or not of their stated shapes"),
        ({"grey": base64.b64encode(b"not packed").decode()}, "broken or not of their stated shapes"),
        ({"grey": packed(10)}, "broken or not of their stated shapes"),
        ({"grey": packed(50_000_000)}, "broken or not of their stated shapes"),
        ({"grey": "é"}, "lack a sound pixel_mm, shape, centre_mm or grey"),
        ({"shape": [[24, 24]]}, "are 1 with 25 centres for 25 dots"),
        ({"shape": [[24, 24.5]] * 25}, "lack a sound"),
        ({"shape": [[24, -24]] * 25}, "lack a sound"),
        ({"shape": [[True, 24]] * 25}, "lack a sound"),
        ({"shape": 3}, "lack a sound"),
        ({"shape": [[5000, 1]] * 25}, "takes 4096 a side"),
        ({"shape": [[4000, 4000]] * 25}, "100 million at most"),
        ({"centre_mm": [[0, 0]]}, "are 25 with 1 centres"),
        ({"centre_mm": [[0, float("nan")]] * 25}, "centres that are no numbers"),
        ({"centre_mm": "here"}, "lack a sound"),
        ({"pixel_mm": 0}, "have pixels of 0 mm"),
        ({"pixel_mm": None}, "lack a sound"),
    ],
)
def test_patches_that_are_not_what_they_say_are_refused_in_one_line(changed: dict[str, Any], said: str) -> None:
    about = {**kept().about, "patches": {**kept().about["patches"], **changed}}
    with pytest.raises(ValueError, match=f"^scan-03: its grey patches.*{said}") as refused:
        glyphs.patches(replace(kept(), about=about))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("patches", [[], "grey", 7, {}])
def test_patches_of_another_kind_are_refused(patches: object) -> None:
    with pytest.raises(ValueError, match="lack a sound"):
        glyphs.patches(replace(kept(), about={"patches": patches}))


def test_patches_that_unpack_to_more_than_they_state_are_never_unpacked_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    real = zlib.decompressobj

    class Watched:
        def __init__(self) -> None:
            self.inner = real()

        def decompress(self, data: bytes, most: int = 0) -> bytes:
            asked.append(most)
            return self.inner.decompress(data, most)

        @property
        def eof(self) -> bool:
            return self.inner.eof

    monkeypatch.setattr(zlib, "decompressobj", Watched)
    about = {**kept().about, "patches": {**kept().about["patches"], "grey": packed(50_000_000)}}
    with pytest.raises(ValueError, match="stated shapes"):
        glyphs.patches(replace(kept(), about=about))
    assert asked == [sum(h * w for h, w in about["patches"]["shape"]) + 1]
