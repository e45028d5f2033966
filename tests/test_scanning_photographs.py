"""A photograph of dots with a ruler beside them gets its scale from the ruler's millimetres, and says where it looks aslant."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw
from scipy import ndimage
from test_scanning import ellipse, page

from crowquill.glyphs import ruler
from crowquill.glyphs.scanning import Scan, scan
from crowquill.paths import Array
from crowquill.picture import encoded, linear

SIZE = (48.0, 34.0)  # mm of the scene
BODY = np.array([[-4.0, -0.3], [44, -0.3], [44, 25], [-4, 25]])  # of the ruler, from its first tick, x along it
SEGMENTS = {"0": "abcdef", "1": "bc", "2": "abged", "3": "abgcd", "4": "fgbc"}  # of figures made of seven bars


def bar(x: float, y: float, width: float, height: float) -> Array:
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])


def figure(digit: str, x: float, y: float) -> list[Array]:
    """A digit of 2 mm in strokes of 0.25 mm, as wide as a dot."""
    at = {"a": (0, 0, 1, 0.25), "g": (0, 0.9, 1, 0.25), "d": (0, 1.75, 1, 0.25), "f": (0, 0, 0.25, 1), "b": (0.75, 0, 0.25, 1)}
    at |= {"e": (0, 1, 0.25, 1), "c": (0.75, 1, 0.25, 1)}
    return [bar(x + at[part][0], y + at[part][1], *at[part][2:]) for part in SEGMENTS[digit]]


def millimetres(k: int) -> float:
    return 6 if k % 10 == 0 else 4.5 if k % 5 == 0 else 3


def half_millimetres(k: int) -> float:
    return millimetres(k // 2) if k % 2 == 0 else 2


def sixteenths(k: int) -> float:
    return 6 if k % 16 == 0 else 5 if k % 8 == 0 else 4 if k % 4 == 0 else 3 if k % 2 == 0 else 2


def ticks(n: int = 41, length: Callable[[int], float] = millimetres, *, pitch: float = 1.0, comb: bool = False) -> list[Array]:
    """Marks of a ruler from (0, 0) along x, figures, and a full stop like a dot."""
    made = [bar(k * pitch - 0.075, 0, 0.15, length(k)) for k in range(n)]
    made += [stroke for k in range(0, n, 10) for stroke in figure(str(k // 10 % 5), k * pitch - 0.5, 7)]
    return [*made, ellipse(16, 10, 0.3, 0.3), *([bar(-3, -0.1, n * pitch + 5, 0.2)] if comb else [])]


def laid() -> list[Array]:
    """The ruler's marks where photograph() lays them."""
    return [mark + np.array([4, 12]) for mark in ticks()]


@cache
def dots() -> tuple[Array, ...]:
    """Forty ellipses in rows above the ruler."""
    rng = np.random.default_rng(2)
    place = [(5 + 4 * (k % 10), 2.5 + 2 * (k // 10)) for k in range(40)]
    return tuple(ellipse(x, y, rng.uniform(0.3, 0.36), rng.uniform(0.26, 0.3), rng.uniform(0, np.pi)) for x, y in place)


def photograph(
    marks: list[Array],
    *,
    angle: float = 0.0,
    at: tuple[float, float] = (4, 12),
    size: tuple[float, float] = SIZE,
    dpi: float = 600,
    along: float = 0.0,
    down: float = 0.0,
    body: float = 0.75,
    tag: float | None = 72,
    noise: float = 0.01,
) -> io.BytesIO:
    """A JPEG of the dots and a ruler laid at an angle (degrees) with its first tick at a place.

    It is warped so that what is w times as far is 1 / w as large, w rising by `along` and `down` across the scene, its
    corners have 0.75 of the light, and the ruler's body takes what it does not give back. dpi is that of the middle.
    """
    a, mm, middle = np.radians(angle), 25.4 / dpi, np.array(size) / 2
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])

    def seen(points: Array) -> Array:
        away = points - middle
        return away / (1 + away @ (along / size[0], down / size[1]))[:, None] + middle

    rings = [seen(ring) for ring in [*dots(), *(mark @ turn + at for mark in marks)]]
    rings = [ring for ring in rings if (ring > 0.1).all() and (ring < np.array(size) - 0.1).all()]
    light = linear(page(rings, size, dpi=dpi, noise=0, tilt=0))
    high, wide = light.shape
    mask = Image.new("L", (wide, high), 0)
    if marks:
        ImageDraw.Draw(mask).polygon([tuple(place) for place in (seen(BODY @ turn + at) / mm).tolist()], fill=255)
    light *= 1 - (1 - body) * ndimage.gaussian_filter(np.asarray(mask) / 255, 1.0)
    y, x = np.mgrid[0:high, 0:wide]
    light *= 1 - 0.5 * ((x / wide - 0.5) ** 2 + (y / high - 0.5) ** 2)
    code = np.clip(encoded(light) + np.random.default_rng(4).normal(0, noise, light.shape), 0, 1)
    file = io.BytesIO()
    Image.fromarray(np.uint8(code * 255 + 0.5)).save(file, "JPEG", quality=92, **({"dpi": (tag, tag)} if tag else {}))
    file.seek(0)
    return file


def aslant(found: Scan) -> list[str]:
    return [warning for warning in found.warnings if "straight from above" in warning]


@cache
def straight() -> Scan:
    return scan(photograph(ticks()))


LAID: dict[str, dict[str, Any]] = {
    "a comb": {"comb": True},
    "a little turned": {"angle": 4},
    "aslope": {"angle": -35, "at": (8, 44), "size": (48.0, 50.0)},
    "upright, a comb": {"angle": 90, "at": (46, 12), "size": (48.0, 54.0), "comb": True},
    "upside down": {"angle": 180, "at": (44, 40), "size": (48.0, 46.0)},
    "white": {"body": 1.0},
    "grey and noisy": {"body": 0.55, "noise": 0.02},
}


@pytest.mark.parametrize("lying", list(LAID))
def test_a_ruler_gives_the_scale_however_it_lies(lying: str) -> None:
    how = dict(LAID[lying])
    found = scan(photograph(ticks(comb=how.pop("comb", False)), **how))
    assert found.scale == "ruler"
    assert found.dpi == pytest.approx(600, rel=3e-4)  # a fiftieth of a pixel a millimetre... over forty ticks, 0.1 mm in 300
    assert not aslant(found)


def test_dots_are_found_at_their_size_and_nothing_of_the_ruler_is_one() -> None:
    found = straight()
    assert len(found.outlines) == 40  # the full stop on the ruler is not among them
    assert found.counts == {"ruler": 41 + 5 + 1}  # ticks, figures, full stop
    drawn = 2 * np.sqrt(np.mean([ring_area(ring) for ring in dots()]) / np.pi)
    assert np.sqrt((found.diameters**2).mean()) == pytest.approx(drawn, rel=0.01)  # 2 % of area, at 600 dpi


def ring_area(ring: Array) -> float:
    x, y = ring.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


@pytest.mark.parametrize("tag", [None, 96, 180])
def test_a_missing_or_coarse_tag_gives_way_to_the_ruler(tag: float | None) -> None:
    assert scan(photograph(ticks(), tag=tag)).dpi == pytest.approx(straight().dpi, rel=1e-9)


def test_a_tag_or_a_dpi_given_counts_first_and_a_ruler_that_disagrees_is_named() -> None:
    assert scan(photograph(ticks(), tag=600)).warnings == straight().warnings
    (by_tag,) = set(scan(photograph(ticks(), tag=630)).warnings) - set(straight().warnings)
    (given,) = set(scan(photograph(ticks()), dpi=570).warnings) - set(straight().warnings)
    assert "the ruler shows 600 dpi, the file's tag says 630" in by_tag
    assert "the ruler shows 600 dpi, what is given says 570" in given
    wide = scan(photograph(ticks()), dpi=570)
    assert (wide.scale, wide.dpi, len(wide.outlines)) == ("given", 570, 40)
    np.testing.assert_allclose(np.median(wide.diameters) / np.median(straight().diameters), 600 / 570, rtol=2e-3)


def test_a_dpi_given_that_agrees_within_two_per_cent_is_not_doubted() -> None:
    assert scan(photograph(ticks()), dpi=609).warnings == straight().warnings


def test_millimetres_that_grow_along_the_ruler_are_measured_and_named() -> None:
    found = scan(photograph(ticks(), along=0.04))
    (warning,) = aslant(found)
    said = float(re.findall(r"grow by ([\d.]+)%", warning)[0]) / 100
    far, near = (1 + 0.04 * (x - 24) / 48 for x in (44, 4))
    assert said == pytest.approx((far / near) ** 2 - 1, abs=0.005)  # the warp's derivative along the ruler goes by 1 / w^2
    assert found.dpi == pytest.approx(600 / far / near, rel=0.001)  # 40 mm there by 40 mm seen: the mean, not that of an end


def test_ticks_that_fan_out_tell_of_a_slant_away_from_the_ruler() -> None:
    found = scan(photograph(ticks(), down=0.12))
    (warning,) = aslant(found)
    said = float(re.findall(r"differ by ([\d.]+)%", warning)[0]) / 100
    # 1.5 times: sizes go by 1 / w one way and 1 / w^2 the other; dots lie 6.5 mm off the edge on average
    assert said == pytest.approx(1.5 * 0.12 / 34 * 6.5, rel=0.2)


def test_dots_all_stretched_one_way_are_named() -> None:
    rings = [ellipse(5 + 4 * (k % 10), 2.5 + 2 * (k // 10), 0.33, 0.27) for k in range(40)]
    found = scan(page([*rings, *laid()], SIZE, dpi=600, tilt=0), dpi=600)
    assert [w for w in found.warnings if re.search("1[789]% longer one way", w)]  # ln of 0.33 by 0.27 is 0.20; blur makes rounder


def test_dots_that_grow_across_the_page_are_named() -> None:
    rings = [ellipse(5 + 4 * (k % 10), 2.5 + 2 * (k // 10), *(0.3 + 0.006 * (k % 10),) * 2) for k in range(40)]
    found = scan(page([*rings, *laid()], SIZE, dpi=600, tilt=0), dpi=600)
    assert [w for w in found.warnings if re.search("dots grow by 1[678]% across", w)]  # 0.354 by 0.3 mm: ln is 0.166


@pytest.mark.parametrize(
    ("marks", "why"),
    [
        ([], "no ruler"),
        (ticks(length=lambda _: 3.0), "hatching"),
        (ticks(26, sixteenths, pitch=25.4 / 16), "inches"),
        (ticks(81, half_millimetres, pitch=0.5), "half millimetres"),
        (ticks(15), "too short"),
    ],
)
def test_what_is_no_millimetre_ruler_gives_no_scale(marks: list[Array], why: str) -> None:
    with pytest.raises(ValueError, match=r"its tag says 72 dpi.*give the true --dpi, or lay a ruler beside") as refused:
        scan(photograph(marks))
    assert "\n" not in str(refused.value), why


def test_a_photograph_from_too_far_is_refused_by_its_ruler() -> None:
    with pytest.raises(ValueError, match=r"its ruler shows 2[45]\d(\.\d+)? dpi, too coarse.*go nearer"):
        scan(photograph(ticks(comb=True), dpi=250))


def test_three_hundred_dpi_by_a_ruler_is_enough() -> None:
    found = scan(photograph(ticks(), dpi=310))
    assert (found.scale, len(found.outlines)) == ("ruler", 40)


def test_a_page_of_dots_without_a_ruler_has_none() -> None:
    light = linear(page(list(dots()), SIZE, dpi=600)).astype(np.float32)
    assert ruler.found(light, 600) is None
    assert ruler.found(light) is None


def test_a_ruler_covers_its_ticks_and_not_the_dots() -> None:
    light = linear(page(laid(), SIZE, dpi=600, tilt=0)).astype(np.float32)
    found = ruler.found(light)
    assert found is not None
    assert (found.ticks, found.drift, found.fan) == (41, 0, 0)
    middles = np.array([mark.mean(0) for mark in laid()]) * found.pitch
    assert found.covers(middles).all()
    assert not found.covers(np.array([ring.mean(0) for ring in dots()]) * found.pitch).any()
    assert found.shades(middles + np.array([0, 40 * found.pitch])).any()
