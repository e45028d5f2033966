"""A scanned page of dots gives their outlines within micrometres, rejects what is no dot, and makes a glyph library."""

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

from crowquill import glyphs
from crowquill.glyphs.scanning import Scan, library, scan
from crowquill.glyphs.sorting import _largest
from crowquill.paths import Array, Paths
from crowquill.picture import encoded

DPI = 1200
PIXEL = 25.4 / DPI  # mm
UM = 1e-3
PITCH = 0.7  # mm between dots
ABOUT = {"simulated": True, "source": "rendered by the test", "licence": "MIT"}


def ellipse(x: float, y: float, wide: float, high: float, angle: float = 0.0) -> Array:
    """Points of an ellipse of these diameters, mm."""
    t = np.arange(400) * 2 * np.pi / 400
    place = x + 1j * y + (wide * np.cos(t) + 1j * high * np.sin(t)) / 2 * np.exp(1j * angle)
    return np.stack([place.real, place.imag], axis=1)


@cache
def dots(side: int = 5) -> list[Array]:
    """Outlines in mm of dots in rows from (1, 1) mm, a little out of line: of the ink model and ellipses by turns."""
    rng, made, nib = np.random.default_rng(1), [], glyphs.load("nib-03").glyphs
    for k in range(side * side):
        x, y = 1 + PITCH * np.array([k % side, k // side]) + rng.uniform(-0.05, 0.05, 2)
        a, glyph = rng.uniform(0, 2 * np.pi), nib[k]
        turn = glyph.size * np.sqrt(np.pi) / 2 * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
        flat = glyph.paths.flat(1e-4).moved(turn, (x, y)).xy
        made.append(flat if k % 2 else ellipse(x, y, rng.uniform(0.28, 0.36), rng.uniform(0.24, 0.3), a))
    return made


def page(rings: list[Array], size: tuple[float, float] = (4.8, 4.8), *, dpi: float = DPI, **how: float) -> Array:
    """Code values of a scan: ink's share of 8 x 8 places in a pixel, in light; blurred optics, a tilt of the lamp, noise, 8 bits."""
    blur, noise, tilt, ink = ({"blur": 0.7, "noise": 0.01, "tilt": 0.3, "ink": 0.06} | how).values()
    mm = 25.4 / dpi
    width, height = (round(side / mm) for side in size)
    cover = np.zeros((height, width))
    for ring in rings:
        shape = shapely.Polygon(ring / mm)
        shapely.prepare(shape)
        (x0, y0), (x1, y1) = np.floor(ring.min(0) / mm).astype(int), np.ceil(ring.max(0) / mm).astype(int)
        x, y = np.meshgrid(x0 + (np.arange(8 * (x1 - x0)) + 0.5) / 8, y0 + (np.arange(8 * (y1 - y0)) + 0.5) / 8)
        part = shapely.contains_xy(shape, x, y).reshape(y1 - y0, 8, x1 - x0, 8).mean((1, 3))
        a, b, c, d = max(y0, 0), min(y1, height), max(x0, 0), min(x1, width)
        cover[a:b, c:d] = np.maximum(cover[a:b, c:d], part[a - y0 : b - y0, c - x0 : d - x0])
    light = ndimage.gaussian_filter(1 - (1 - ink) * cover, blur, mode="nearest")
    light *= 0.85 * (1 - tilt * np.linspace(0, 1, width)) * (1 - tilt / 2 * np.linspace(0, 1, height)[:, None])
    code = encoded(light) + np.random.default_rng(7).normal(0, noise, light.shape)
    return np.round(np.clip(code, 0, 1) * 255) / 255


@cache
def clean() -> tuple[list[Array], Array, Scan]:
    """Twenty-five single dots, their page, and what was found on it."""
    code = page(dots())
    return dots(), code, scan(code, dpi=DPI)


def areas_and_centroids(paths: Paths) -> tuple[Array, Array]:
    m = paths.green()
    return m[:, 0], paths.xy[paths.start[:-1]] + m[:, 1:3] / m[:, :1]


def differences(rings: list[Array], found: Scan) -> tuple[Array, Array]:
    """Of each dot drawn: how far the nearest found is from it, mm, and the found one's area less 1, by its own."""
    area, centre = areas_and_centroids(Paths.of(rings))
    have, at = areas_and_centroids(found.outlines)
    apart = np.hypot(*(centre[:, None] - at).transpose(2, 0, 1))
    return apart.min(1), have[apart.argmin(1)] / np.abs(area) - 1


def test_every_dot_is_found_where_it_is_and_as_large_as_it_is() -> None:
    rings, _, found = clean()
    assert len(found.outlines) == len(rings)
    assert found.rejected == ()
    apart, larger = differences(rings, found)
    assert apart.max() < 3 * UM  # a seventh of a pixel: noise of 0.01 leaves 1 um
    assert np.abs(larger).max() < 0.02  # an edge 1.5 um out
    assert np.abs(larger.mean()) < 0.004  # one dot's noise is a half per cent; what is common to all is a fault of the method


@pytest.mark.parametrize("how", [{"blur": 0.4}, {"blur": 1.1}, {"ink": 0.5}], ids=str)
def test_areas_hardly_depend_on_the_optics_or_the_ink(how: dict[str, float]) -> None:
    _, larger = differences(dots(), scan(page(dots(), **how), dpi=DPI))
    assert np.abs(larger.mean()) < 0.01  # uncorrected, a blur of 1.1 pixels draws in 3 %


@pytest.mark.parametrize(("dpi", "apart", "larger"), [(600, 5 * UM, 0.03), (2400, 1.5 * UM, 0.01)])
def test_other_resolutions_find_the_same_dots(dpi: int, apart: float, larger: float) -> None:
    found = scan(page(dots(), dpi=dpi), dpi=dpi)
    off, bigger = differences(dots(), found)
    assert len(found.outlines) == 25
    assert off.max() < apart  # an eighth of a pixel, or a sixth
    assert np.abs(bigger).max() < larger  # an edge out by a 20th of a pixel, or a 13th


def test_outlines_lie_within_three_micrometres_of_contours_found_another_way() -> None:
    _, _, found = clean()
    for ring, patch, corner, level in zip(found.outlines, found.patches, found.corners, found.levels, strict=True):
        fine = ndimage.zoom(patch.astype(float), [(5 * side - 4) / side for side in patch.shape], order=3, mode="mirror")
        contour = max(find_contours(fine, level), key=len)[:, ::-1] / 5 + 0.5  # of (row, column), a fifth of a pixel apart
        contour = shapely.Polygon(contour * PIXEL + corner)
        outline = Paths.of([ring], cubic=True)
        curve = outline.flat(1e-5).polygons()[0]
        # 3 um asked for; 0.1 um more for two splines of other ends and other straight pieces
        assert shapely.hausdorff_distance(curve.exterior, contour.exterior, densify=0.25) < 3.1 * UM
        assert outline.areas[0] / contour.area == pytest.approx(1, abs=0.002)


def test_outlines_are_smooth_closed_cubics_of_five_to_eight_pieces() -> None:
    _, _, found = clean()
    outlines = found.outlines
    assert (outlines.closed, outlines.cubic, (outlines.areas > 0).all()) == (True, True, True)
    assert set(np.diff(outlines.start) // 3) <= {5, 6, 7, 8}
    assert shapely.is_valid(outlines.flat(1e-5).polygons()).all()
    for ring in outlines:
        after, before = ring[1::3] - ring[0::3], ring[0::3] - np.roll(ring[2::3], 1, axis=0)
        turn = np.cross(np.pad(before, ((0, 0), (0, 1))), np.pad(after, ((0, 0), (0, 1))))[:, 2]
        assert np.abs(turn / np.hypot(*after.T) / np.hypot(*before.T)).max() < 1e-6  # handles are in line but for rounding
    np.testing.assert_allclose(found.diameters, 2 * np.sqrt(outlines.areas / np.pi))


def pairs() -> list[Array]:
    """Six dots that are two: discs that touch, overlap, touch at their flat sides, are small, all but touch, overlap end to end."""
    shapes = [(0.3, 0.3, 0.3), (0.2, 0.3, 0.3), (0.22, 0.22, 0.32), (0.25, 0.25, 0.25), (0.31, 0.3, 0.3), (0.26, 0.32, 0.22)]
    middle = [(1 + PITCH * k, 1 + PITCH * 5.3) for k in range(6)]
    return [ellipse(x + s * d / 2, y, w, h) for (x, y), (d, w, h) in zip(middle, shapes, strict=True) for s in (-1, 1)]


@cache
def dirty() -> tuple[Array, Scan]:
    """The dots with touching pairs below, dust between, and dots that the border cuts."""
    rng = np.random.default_rng(3)
    dust = [ellipse(*(1.35 + PITCH * rng.integers(0, 4, 2)), *rng.uniform(0.04, 0.1, 2)) for _ in range(30)]
    cut = [ellipse(x, y, 0.3, 0.3) for x, y in [(0, 1.5), (0.1, 2.5), (2.0, 0.05), (5.6, 3.0), (3.0, 6.15), (0.0, 0.0)]]
    code = page([*dots(), *pairs(), *dust, *cut], (5.7, 6.2))
    return code, scan(code, dpi=DPI)


def test_no_touching_pair_speck_or_cut_dot_is_taken_for_a_dot() -> None:
    _, found = dirty()
    apart, larger = differences(dots(), found)
    assert (len(found.outlines), found.counts["merged"], found.counts["cut by the border"]) == (25, 6, 6)
    assert 10 < found.counts["dust"] <= 16  # thirty specks on sixteen places
    assert apart.max() < 3 * UM  # as on the clean page
    assert np.abs(larger).max() < 0.02


def test_the_largest_dots_of_a_page_of_several_pens_are_no_pairs_and_those_of_one_pen_are() -> None:
    rng = np.random.default_rng(4)
    for spread, largest in ((0.05, 1.6), (0.13, 2.2)):  # of diameters: log-normal, half of what areas have
        areas = np.round(300 * np.exp(2 * spread * rng.standard_normal(2000))).astype(int)
        assert _largest(areas, float(np.median(areas))) / np.median(areas) == pytest.approx(largest, abs=0.1)
    few = np.array([100, 200, 300, 400, 500])
    assert _largest(few, 300.0) == _largest(np.zeros(0, int), 300.0) == 1.6 * 300  # these tell nothing
    places = [(1 + PITCH * (k % 8), 1 + PITCH * (k // 8)) for k in range(64)]
    sizes = np.linspace(0.2, 0.38, 64)  # mm: the largest have 1.7 times the area of the median
    mixed = [ellipse(x, y, size, 0.9 * size) for (x, y), size in zip(places, rng.permutation(sizes), strict=True)]
    assert len(scan(page(mixed, (7, 7)), dpi=DPI).outlines) == 64


def test_boxes_of_the_rejected_hold_what_was_rejected() -> None:
    _, found = dirty()
    merged = [shapely.box(*box) for reason, box in found.rejected if reason == "merged"]
    for a, b in zip(pairs()[::2], pairs()[1::2], strict=True):
        pair = shapely.union(shapely.Polygon(a), shapely.Polygon(b))
        assert shapely.intersection(pair, shapely.union_all(merged)).area / pair.area > 0.97  # whole pixels lose some of a rim


def test_dots_that_nearly_touch_are_two() -> None:
    rings = [ellipse(1 + x, 1, 0.3, 0.3) for x in (0, 0.37, 1.2, 1.9, 2.6)]  # 0.07 mm of paper: three pixels
    found = scan(page(rings, (4.6, 2)), dpi=DPI)
    apart, larger = differences(rings, found)
    assert (len(found.outlines), apart.max() < 3 * UM) == (5, True)
    assert np.abs(larger).max() < 0.03  # the neighbour's blur is cut off half way, not taken out


def test_turning_the_page_over_turns_the_outlines_over() -> None:
    _, code, found = clean()
    flipped = scan(code.T[:, ::-1], dpi=DPI)
    back = flipped.outlines.moved([[0, 1], [-1, 0]], (0, code.shape[0] * PIXEL))
    apart, larger = differences(list(found.outlines.flat(1e-5)), replace(flipped, outlines=back))
    assert apart.max() < 1 * UM  # knots begin elsewhere: two fits of one contour
    assert np.abs(larger).max() < 0.002


def test_patches_are_dark_dots_on_white_paper() -> None:
    _, _, found = clean()
    for patch in found.patches:
        rim = np.concatenate([patch[0], patch[-1], patch[:, 0], patch[:, -1]])
        assert rim.mean() < 0.02  # noise of 0.01 in code values is 0.02 in light, and only its dark half is kept
        assert patch.max() > 0.9  # ink of 0.06


@pytest.mark.parametrize("format", ["PNG", "TIFF", "JPEG"])
def test_a_file_says_its_own_dpi(tmp_path: Path, format: str) -> None:
    _, code, found = clean()
    path = tmp_path / f"page.{format.lower()}"
    Image.fromarray(np.uint8(code * 255 + 0.5)).save(path, dpi=(DPI, DPI), **({"quality": 98} if format == "JPEG" else {}))
    for source in (path, io.BytesIO(path.read_bytes())):
        read = scan(source)
        assert read.dpi == DPI
        # exact but for JPEG's losses
        np.testing.assert_allclose(read.diameters, found.diameters, rtol=0.005 if format == "JPEG" else 1e-9)


def test_a_library_is_read_back_with_its_sizes_and_its_grey() -> None:
    _, _, found = clean()
    data = library(found, name="scan-03", pen_mm=0.3, about=ABOUT)
    read = glyphs.parsed(data, "scan-03.svg")
    assert (read.name, read.about["pen_mm"], read.about["count"], read.about["simulated"]) == ("scan-03", 0.3, 25, True)
    assert read.about.keys() >= {"made", "source", "licence"}
    np.testing.assert_allclose([glyph.size for glyph in read.glyphs], found.diameters, atol=2e-5)  # five decimals are kept
    kept: dict[str, Any] = read.about["patches"]
    grey = np.frombuffer(zlib.decompress(base64.b64decode(kept["grey"])), np.uint8)
    ends = np.cumsum([h * w for h, w in kept["shape"]])
    assert ends[-1] == len(grey)
    for k, part in enumerate(np.split(grey, ends[:-1])):
        np.testing.assert_allclose(part.reshape(kept["shape"][k]) / 255, found.patches[k], atol=0.5 / 255 + 1e-6)
    _, centre = areas_and_centroids(found.outlines)
    np.testing.assert_allclose(np.array(kept["centre_mm"]) + found.corners, centre, atol=1e-5)
    assert kept["pixel_mm"] == pytest.approx(PIXEL)


@pytest.mark.parametrize(
    ("changed", "remedy"),
    [
        ({"name": "no good"}, "give one such as"),
        ({"pen_mm": 0.0}, "it takes over 0"),
        ({"about": {"simulated": True}}, "about lacks licence, source"),
        ({"about": {**ABOUT, "simulated": "no"}}, "it takes True or False"),
        ({"about": {**ABOUT, "made": object()}}, "give texts, numbers"),
    ],
)
def test_a_library_that_cannot_be_is_refused_with_a_remedy(changed: dict[str, Any], remedy: str) -> None:
    with pytest.raises(ValueError, match=remedy):
        library(clean()[2], **{"name": "scan-03", "pen_mm": 0.3, "about": ABOUT, **changed})


def test_the_same_scan_gives_the_same_bytes() -> None:
    code, found = dirty()
    again = scan(code.copy(), dpi=DPI)
    assert again.rejected == found.rejected
    assert library(again, name="a", pen_mm=0.3, about=ABOUT) == library(found, name="a", pen_mm=0.3, about=ABOUT)
