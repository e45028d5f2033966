"""Printed and scanned: a plate as a 1200 dpi TIFF, degraded as a scanner would, gives its dots back at their places and sizes."""

from __future__ import annotations

import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image
from scipy import ndimage
from scipy.spatial import cKDTree

from crowquill import Tone, draw, formats
from crowquill.glyphs.scanning import Scan, scan
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.picture import encoded
from crowquill.sheet import Sheet
from crowquill.units import INCH

DPI = 1200
PIXEL = INCH / DPI
SIZE = (30.0, 24.0)  # mm
TURN, SCALE = np.radians(0.4), 1.003  # how a page lies on the glass, and how far the glass is out
ROOM = 0.12  # mm of paper around a dot that counts as isolated: the optics' blur reaches half as far
NEAR, LIKE = 0.015, 0.05  # mm, and share of the area


@cache
def plate(style: str) -> Sheet:
    tone = Tone(np.tile(np.linspace(0.02, 0.12, 40), (30, 1)), (SIZE[0] - 6, SIZE[1] - 6))
    return draw(style, tone, seed=2).on(SIZE, margin=3)


def printed(sheet: Sheet, **values: Any) -> Array:
    """The paper's light (h, w) under a plate in black and white, read from its TIFF; ink leaves 0.06."""
    image = Image.open(io.BytesIO(formats.to_bytes(sheet, "tiff", dpi=DPI, bilevel=True, **values)))
    assert image.info["dpi"] == (DPI, DPI) and image.mode == "1"
    return np.where(np.asarray(image), 1.0, 0.06)


def seen(light: Array, *, blur: float = 0.8, noise: float = 0.01, turn: float = TURN, scale: float = SCALE) -> npt.NDArray[np.uint8]:
    """What a scanner makes of it, 8 bits: laid down askew, blurred by the optics, noisy, under an uneven lamp."""
    h, w = light.shape
    cos, sin = np.cos(turn) / scale, np.sin(turn) / scale
    back = np.array([[cos, -sin], [sin, cos]])  # rows and columns of the plate by those of the scan
    middle = (np.array(light.shape) - 1) / 2
    askew = ndimage.affine_transform(light, back, middle - back @ middle, order=1, cval=1.0)
    lamp = np.linspace(0.95, 1.0, w)
    rng = np.random.default_rng(5)
    received = ndimage.gaussian_filter(askew, blur) * lamp + noise * rng.standard_normal((h, w))
    return np.round(255 * encoded(np.clip(received, 0, 1))).astype(np.uint8)


def scanned(codes: npt.NDArray[np.uint8], folder: Path) -> Scan:
    Image.fromarray(codes).save(folder / "scan.png", dpi=(DPI, DPI))
    return scan(folder / "scan.png")


def isolated(marks: Marks) -> Marks:
    """Marks that keep ROOM from all others and from the scan's border."""
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    apart = cKDTree(marks.xy).query(marks.xy, 2)[0][:, 1]
    inside = ((marks.xy > 1.0) & (marks.xy < np.array(SIZE) - 1.0)).all(axis=1)
    return marks.take((apart > reach + reach.max() + ROOM) & inside)


def expected(marks: Marks) -> tuple[Array, Array]:
    """Where dots lie on the scan, by the known turn and scale about its middle, (n, 2) mm, and their areas."""
    middle = np.array([round(side / PIXEL) for side in SIZE]) * PIXEL / 2
    cos, sin = SCALE * np.cos(TURN), SCALE * np.sin(TURN)
    return (marks.xy - middle) @ np.array([[cos, sin], [-sin, cos]]) + middle, (marks.scale * SCALE) ** 2


def found(page: Scan, at: Array) -> tuple[Array, Array]:
    """How far the nearest outline's centroid is from each place, mm, and its area."""
    m = page.outlines.green()
    centroid = page.outlines.xy[page.outlines.start[:-1]] + m[:, 1:3] / m[:, :1]
    far, which = cKDTree(centroid).query(at)
    return far, page.outlines.areas[which]


def check_dots(page: Scan, marks: Marks, *, refused: float = 0.0) -> None:
    """Raises AssertionError where an isolated dot lies further off than NEAR, or has another area by more than LIKE.

    refused  the share of dots that the scan may say to be two, for their size or shape; it must say so of each that is missing
    """
    at, area = expected(isolated(marks))
    boxes = np.array([box for _, box in page.rejected]).reshape(-1, 1, 4)
    lost = ((at > boxes[:, :, :2]) & (at < boxes[:, :, 2:])).all(axis=2).any(axis=0)
    assert lost.mean() <= refused, f"{lost.mean():.1%} of the dots are refused"
    at, area = at[~lost], area[~lost]
    far, own = found(page, at)
    assert far.max() <= NEAR, f"a dot is {1000 * far.max():.1f} um out of place"
    off = np.abs(own / area - 1)
    assert off.max() <= LIKE, f"a dot's area is {off.max():.1%} off"


@pytest.mark.parametrize(("style", "refused"), [("stipple", 0.0), ("inkdots", 0.015)])
def test_dots_of_a_plate_come_back_from_a_scan(style: str, refused: float, tmp_path: Path) -> None:
    marks = plate(style).marks
    assert len(isolated(marks)) > 200
    # of dots of three nibs a few of the largest and longest pass for two that lie half over one another
    check_dots(scanned(seen(printed(plate(style), grey_dots=False)), tmp_path), marks, refused=refused)


def fitted(at: Array, to: Array) -> tuple[float, float, Array]:
    """The turn, the scale and the places (n, 2) after it of the similarity that takes some places nearest to others."""
    one, other = ((part - part.mean(axis=0)) @ (1, 1j) for part in (at, to))
    by = np.vdot(one, other) / np.vdot(one, one)
    moved = one * by
    return float(np.angle(by)), float(abs(by)), np.stack([moved.real, moved.imag], axis=1) + to.mean(axis=0)


def test_a_similarity_fitted_to_the_dots_is_how_the_page_lay(tmp_path: Path) -> None:
    marks = isolated(plate("stipple").marks)
    page = scanned(seen(printed(plate("stipple"))), tmp_path)
    m = page.outlines.green()
    centroid = page.outlines.xy[page.outlines.start[:-1]] + m[:, 1:3] / m[:, :1]
    at = centroid[cKDTree(centroid).query(expected(marks)[0])[1]]
    turn, scale, moved = fitted(marks.xy, at)
    assert turn == pytest.approx(TURN, abs=1e-4) and scale == pytest.approx(SCALE, abs=1e-4)
    assert np.hypot(*(moved - at).T).max() <= NEAR


def test_a_plate_of_grey_dots_cut_at_their_rims_is_as_true_on_the_whole(tmp_path: Path) -> None:
    at, area = expected(isolated(plate("inkdots").marks))
    far, own = found(scanned(seen(printed(plate("inkdots"))), tmp_path), at)
    back = far < 0.1  # mm: those that are not refused
    assert back.mean() > 0.97 and far[back].max() <= NEAR
    assert (own / area)[back].mean() == pytest.approx(1, abs=0.02) and (own / area)[back].std() < LIKE  # one level for all dots


def test_the_check_sees_a_page_that_lay_otherwise(tmp_path: Path) -> None:
    light = printed(plate("stipple"))
    with pytest.raises(AssertionError, match=r"^a dot is .* um out of place"):
        check_dots(scanned(seen(light, turn=TURN + 0.002), tmp_path), plate("stipple").marks)


def test_the_check_sees_dots_that_grew(tmp_path: Path) -> None:
    grown = ndimage.minimum_filter(printed(plate("stipple")), 3)  # a pixel of ink all around
    with pytest.raises(AssertionError, match=r"^a dot's area is .* off"):
        check_dots(scanned(seen(grown), tmp_path), plate("stipple").marks)
