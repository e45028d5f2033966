"""Pictures become coverage: what each kind of file means, at what size, and what is refused and how."""

from __future__ import annotations

import io
import os
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from crowquill.light import REACH, TONES
from crowquill.tone import Tone

Array = npt.NDArray[np.float64]
GREYS = np.array([[0, 51, 102], [153, 204, 255]], np.uint8)  # fifths of 255: 0, .2, .4 / .6, .8, 1
EXACT = 1e-12  # of a coverage of 1: some roundings of a double


def saved(folder: Path, pixels: npt.NDArray[Any] | Image.Image, name: str = "a.png", **save: Any) -> Path:
    """A picture file; PNG and TIFF keep every value."""
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
    image.save(folder / name, **save)
    return folder / name


def coverage(path: Path, tone: str = "grey", **options: Any) -> Array:
    return Tone.load(path, tone=tone, **options).coverage


def encoded(format: str, pixels: npt.NDArray[Any]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format)
    return buffer.getvalue()


def light(code: npt.ArrayLike) -> Array:
    """Light of sRGB code values 0 to 1, by the standard's own words."""
    code = np.asarray(code, np.float64)
    return np.where(code <= 0.04045, code / 12.92, np.power((code + 0.055) / 1.055, 2.4))


def test_grey_coverage_is_one_less_the_code_value(tmp_path: Path) -> None:
    np.testing.assert_allclose(coverage(saved(tmp_path, GREYS)), 1 - GREYS / 255, atol=EXACT)


def test_linear_coverage_is_one_less_the_light(tmp_path: Path) -> None:
    every = np.arange(256, dtype=np.uint8)[None]
    np.testing.assert_allclose(coverage(saved(tmp_path, every), "linear"), 1 - light(every / 255), atol=EXACT)


@pytest.mark.parametrize(("name", "order"), [("a.png", "<u2"), ("a.tif", "<u2"), ("a.tif", ">u2")])
def test_sixteen_bits_are_not_cut_to_eight(tmp_path: Path, name: str, order: str) -> None:
    codes = np.array([[0, 1, 257, 32768, 65534, 65535]])
    np.testing.assert_allclose(coverage(saved(tmp_path, codes.astype(order), name)), 1 - codes / 65535, atol=EXACT)


def test_colours_weigh_by_their_luminance_and_greys_are_greys(tmp_path: Path) -> None:
    path = saved(tmp_path, np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255]]], np.uint8))
    np.testing.assert_allclose(coverage(path, "linear"), [[1 - 0.2126, 1 - 0.7152, 1 - 0.0722]], atol=1e-9)
    for tone in TONES:
        grey, colour = saved(tmp_path, GREYS), saved(tmp_path, np.repeat(GREYS[..., None], 3, axis=2), "c.png")
        np.testing.assert_allclose(coverage(colour, tone), coverage(grey, tone), atol=1e-9)  # to light and back


def test_palette_and_one_bit_pictures_are_their_colours(tmp_path: Path) -> None:
    image = Image.fromarray(np.array([[0, 1, 2]], np.uint8), "P")
    image.putpalette([255, 255, 255, 0, 0, 0, 255, 0, 0])
    np.testing.assert_allclose(coverage(saved(tmp_path, image), "linear"), [[0, 1, 1 - 0.2126]], atol=1e-9)
    assert coverage(saved(tmp_path, np.array([[False, True]]), "bits.png")).tolist() == [[1, 0]]


def test_rubbish_under_transparent_pixels_is_white(tmp_path: Path) -> None:
    pixels = np.array([[[0, 0, 0, 0], [255, 0, 255, 0], [0, 0, 0, 255], [0, 0, 0, 51]]], np.uint8)
    np.testing.assert_allclose(coverage(saved(tmp_path, pixels), "linear"), [[0, 0, 1, 0.2]], atol=1e-9)


@pytest.mark.parametrize(("dtype", "palette"), [(np.uint8, False), (np.uint8, True), (np.uint16, False)])
def test_a_colour_named_as_transparent_is_white(tmp_path: Path, dtype: type, palette: bool) -> None:
    image = Image.fromarray(np.array([[7, 0]], dtype))
    if palette:
        image.putpalette([0, 0, 0] * 8)
    np.testing.assert_allclose(coverage(saved(tmp_path, image, transparency=7), "linear"), [[0, 1]], atol=1e-9)


@pytest.mark.parametrize("turn", range(1, 9))
def test_exif_turns_the_picture_upright(tmp_path: Path, turn: int) -> None:
    upright = GREYS[:, :, None] * np.ones(3, np.uint8)
    lying = upright.swapaxes(0, 1)
    # how a camera held that way stores it, by the table of EXIF: where the file's first row and column are in the scene
    stored = [
        upright, upright[:, ::-1], upright[::-1, ::-1], upright[::-1], lying, lying[::-1], lying[::-1, ::-1], lying[:, ::-1]
    ][turn - 1]  # fmt: skip
    exif = Image.Exif()
    exif[0x0112] = turn
    path = saved(tmp_path, np.ascontiguousarray(stored), exif=exif)
    np.testing.assert_allclose(coverage(path), 1 - GREYS / 255, atol=1e-9)
    assert Tone.load(path, width=30).size == (30, 20)


def test_a_float_picture_is_scaled_by_its_finite_range_and_nan_is_no_ink(tmp_path: Path) -> None:
    values = np.array([[-2, 0, 2, np.nan, np.inf, -np.inf]], np.float32)
    np.testing.assert_allclose(coverage(saved(tmp_path, values, "f.tif")), [[1, 0.5, 0, 0, 0, 1]], atol=EXACT)
    nothing = saved(tmp_path, np.full((2, 2), np.nan, np.float32), "n.tif")
    assert [Tone.load(nothing, tone=tone).ink for tone in TONES] == [0, 0, 0]


@pytest.mark.parametrize("mode", ["1", "L", "RGB", "RGBA", "P", "I;16"])
@pytest.mark.parametrize("tone", TONES)
def test_a_white_picture_asks_for_no_ink_at_all(tmp_path: Path, mode: str, tone: str) -> None:
    white = Image.new("L", (3, 3), 255).convert(mode) if mode != "I;16" else np.full((3, 3), 65535, np.uint16)
    assert Tone.load(saved(tmp_path, white), tone=tone).ink == 0


def test_auto_reaches_from_white_to_the_darkest_it_asks_for(tmp_path: Path) -> None:
    ramp = np.tile(np.arange(60, 200, dtype=np.uint8), (10, 1))  # a flat photograph
    got = coverage(saved(tmp_path, ramp), "auto")
    assert (got.min(), got.max()) == (0, REACH) and (np.diff(got[0]) <= 0).all()


@pytest.mark.parametrize("grey", [0, 30, 118, 200, 254])
def test_auto_leaves_a_flat_grey_its_lightness(tmp_path: Path, grey: int) -> None:
    y = light(grey / 255)  # CIE 1976: L* = 116 Y^(1/3) - 16, and 903.3 Y in the dark
    lightness = 116 * y ** (1 / 3) - 16 if y > 0.008856 else 903.3 * y
    got = coverage(saved(tmp_path, np.full((4, 4), grey, np.uint8)), "auto")
    # 1e-5: 903.3 and 0.008856 are rounded as of old
    np.testing.assert_allclose(got, REACH * (1 - lightness / 100), atol=1e-5)


def test_auto_keeps_a_tiny_black_dot_on_white(tmp_path: Path) -> None:
    page = np.full((40, 40), 255, np.uint8)
    page[7, 9] = 0  # one of 1600: fewer than the share of extremes that is taken for noise
    assert coverage(saved(tmp_path, page), "auto").ravel()[[7 * 40 + 9, 0]].tolist() == [REACH, 0]


@given(hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2)))
def test_a_darker_pixel_never_gets_less_ink(pixels: npt.NDArray[np.uint8]) -> None:
    for tone in TONES:
        got = Tone.load(io.BytesIO(encoded("PNG", pixels)), tone=tone).coverage.ravel()
        assert (np.diff(got[np.argsort(pixels, axis=None, kind="stable")]) <= 0).all()


def test_black_and_white_points_are_full_ink_and_none(tmp_path: Path) -> None:
    path = saved(tmp_path, GREYS)
    np.testing.assert_allclose(coverage(path, black_point=0.2, white_point=0.8), [[1, 1, 2 / 3], [1 / 3, 0, 0]], atol=EXACT)
    linear = coverage(path, "linear", white_point=0.8)
    np.testing.assert_allclose(linear, np.clip(1 - light(GREYS / 255) / light(0.8), 0, 1), atol=EXACT)


def test_gamma_invert_and_crop_do_what_they_say(tmp_path: Path) -> None:
    path, plain = saved(tmp_path, GREYS), 1 - GREYS / 255
    np.testing.assert_allclose(coverage(path, gamma=2), plain**2, atol=EXACT)
    np.testing.assert_allclose(coverage(path, invert=True, gamma=2), (1 - plain) ** 2, atol=EXACT)
    np.testing.assert_allclose(coverage(path, crop=(1 / 3, 0.5, 2 / 3, 0.5)), plain[1:, 1:], atol=EXACT)
    assert coverage(path, crop=(0.99, 0.99, 0.01, 0.01)).shape == (1, 1)
    with pytest.raises(ValueError, match="has 3 numbers"):
        coverage(path, crop=(0, 0, 1))


@given(st.integers(1, 300), st.data())
def test_a_crop_of_whole_pixels_takes_these_pixels(w: int, data: st.DataObject) -> None:
    left = data.draw(st.integers(0, w - 1))
    span = data.draw(st.integers(1, w - left))
    got = Tone.load(np.arange(w)[None] / w, crop=(left / w, 0, span / w, 1)).coverage
    assert (got * w).round().astype(int).tolist() == [list(range(left, left + span))]


def test_local_contrast_leaves_white_white_and_flat_flat() -> None:
    edge = np.repeat([[0.0, 0.5]], 50, axis=1)
    got = Tone.load(edge, local_contrast=1).coverage
    assert (got[:, :50] == 0).all() and got[:, 50].min() > 0.5
    np.testing.assert_allclose(Tone.load(np.full((9, 9), 0.3), local_contrast=1).coverage, 0.3, atol=EXACT)


@pytest.mark.parametrize(
    ("asked", "size", "shape"),
    [
        ({}, (180, 90), (4, 8)), ({"width": 60}, (60, 30), (4, 8)), ({"height": 60}, (120, 60), (4, 8)),
        ({"width": 60, "height": 60}, (60, 30), (4, 8)), ({"width": 600, "height": 60}, (120, 60), (4, 8)),
        ({"width": 60, "height": 60, "fit": "stretch"}, (60, 60), (4, 8)),
        ({"width": 60, "height": 60, "fit": "cover"}, (60, 60), (4, 4)),
        ({"width": 80, "height": 20, "fit": "cover"}, (80, 20), (2, 8)),
    ],
)  # fmt: skip
def test_the_size_in_mm_is_as_asked(asked: dict[str, Any], size: tuple[float, float], shape: tuple[int, int]) -> None:
    columns = np.tile(np.arange(8) / 8, (4, 1))
    tone = Tone.load(columns, **asked)
    assert tone.size == pytest.approx(size, rel=1e-12)  # a side is the other times a ratio
    first = (8 - shape[1]) // 2  # cover keeps the middle
    np.testing.assert_array_equal(tone.coverage, columns[: shape[0], first : first + shape[1]])


def test_an_array_is_coverage_itself_and_is_copied() -> None:
    tone = Tone.load(values := np.array([[0.25, 1.0]]), width=2)
    values[:] = 0
    assert tone.coverage.tolist() == [[0.25, 1]] and not tone.coverage.flags.writeable
    assert tone.ink == 1.25  # mm^2 of two pixels of 1 mm


@given(hnp.arrays(np.float64, hnp.array_shapes(min_dims=2, max_dims=2), elements=st.floats(0, 1)), st.floats(1e-6, 1e6))
def test_ink_is_the_integral_of_coverage_at_any_size(values: Array, width: float) -> None:
    tone, white = Tone.load(values, width=width), Tone.load(values, width=width, invert=True)
    area = tone.size[0] * tone.size[1]
    assert tone.ink == pytest.approx(values.mean() * area, rel=1e-12, abs=1e-300)  # roundings of up to 81 terms
    assert tone.ink + white.ink == pytest.approx(area, rel=1e-12)
    assert Tone.load(values[::-1, ::-1], width=width).ink == pytest.approx(tone.ink, rel=1e-12)
    middles = (np.indices(values.shape)[::-1].reshape(2, -1).T + 0.5) * tone.pixel
    np.testing.assert_array_equal(tone.at(middles), values.ravel())
    assert tone.holds(middles).all() and not tone.holds(middles - tone.size).any()


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 1e3))
def test_ink_in_a_canvas_with_holes_is_exact(seed: int, width: float) -> None:
    rng = np.random.default_rng(seed)
    values = rng.uniform(0, 1, rng.integers(1, 9, 2))
    whole = Tone.load(values, width=width)
    discs = shapely.buffer(shapely.points(rng.uniform(-0.1, 1.1, (6, 2)) * whole.size), rng.uniform(0.02, 0.4, 6) * width)
    canvas = shapely.difference(shapely.union_all(discs[:3]), shapely.union_all(discs[3:]))
    assume(shapely.intersection(canvas, shapely.box(0, 0, *whole.size)).area > 1e-3 * width**2)
    tone = Tone.load(values, width=width, canvas=canvas)
    (rows, columns), (dx, dy) = np.indices(values.shape), tone.pixel
    boxes = shapely.box(columns * dx, rows * dy, (columns + 1) * dx, (rows + 1) * dy)
    true = shapely.area(shapely.intersection(canvas, boxes))  # whose corners are good to 1e-12 or so
    np.testing.assert_allclose(tone.inside, true / (dx * dy), atol=1e-9)
    assert tone.ink == pytest.approx((values * true).sum(), rel=1e-9)


def png_header(width: int, height: int) -> bytes:
    """A PNG that says how large it is and holds two bytes of its pixels."""
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)), (b"IDAT", b"x\x9c"), (b"IEND", b"")]
    parts = [struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


NOISE = np.random.default_rng(1).integers(0, 256, (60, 60), np.uint8)
BAD = {
    "empty": (b"", "the file is empty"),
    "text": (b"a shell, seen from above\n" * 9, "not a picture"),
    "PNG, cut": (encoded("PNG", NOISE)[:2000], "broken"),
    "PNG, cut in its header": (encoded("PNG", NOISE)[:20], "broken|not a picture"),
    "JPEG, cut": (encoded("JPEG", NOISE)[:1500], "broken"),
    "a picture that is a program": (encoded("EPS", NOISE), "not a picture"),
    "bomb": (png_header(60000, 60000), "60000 x 60000 pixels"),
    "just over the limit": (png_header(20000, 10001), "20000 x 10001 pixels"),
    "just under it": (png_header(20000, 9999), "broken"),
}  # read from the header: the bombs hold no pixels that could be found broken


@pytest.mark.parametrize("story", BAD)
def test_a_bad_file_is_refused_with_its_name_and_a_remedy(tmp_path: Path, story: str) -> None:
    data, says = BAD[story]
    path = tmp_path / "shell.png"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=rf"shell\.png: .*({says}).*; \w+"):
        Tone.load(path)


def test_what_is_no_regular_file_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, says in ((tmp_path, "is a folder; "), (tmp_path / "pipe", "not a regular file; ")):
        with pytest.raises(ValueError, match=f"{path.name}: .*{says}"):
            Tone.load(path)
    with pytest.raises(FileNotFoundError, match="gone"):
        Tone.load(tmp_path / "gone.png")


def test_the_limit_of_pixels_can_be_moved(tmp_path: Path) -> None:
    assert Tone.load(saved(tmp_path, GREYS), max_pixels=6).coverage.size == 6
    with pytest.raises(ValueError, match=r"a\.png: 3 x 2 pixels are over the limit .*; .*--max-pixels 6"):
        Tone.load(tmp_path / "a.png", max_pixels=5)


@pytest.mark.parametrize(
    ("says", "options"),
    [
        ("no tone 'sepia'", {"tone": "sepia"}), ("no fit 'tile'", {"fit": "tile"}), ("gamma is 0", {"gamma": 0}),
        ("gamma is nan", {"gamma": np.nan}), ("local contrast is 2", {"local_contrast": 2}), ("width is 0 mm", {"width": 0}),
        ("height is -1 mm", {"height": -1}), ("crop .* not inside", {"crop": (0.5, 0, 0.6, 1)}), ("crop", {"crop": (0, 0, 0, 1)}),
        ("black point 0.8 and white point 0.2", {"black_point": 0.8, "white_point": 0.2}), ("black", {"black_point": np.nan}),
        ("not a sound polygon", {"canvas": shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])}),
        ("no area on the picture", {"canvas": shapely.box(500, 0, 501, 1)}), ("no area", {"canvas": shapely.Point(1, 1)}),
    ],
)  # fmt: skip
def test_a_wrong_option_is_refused(tmp_path: Path, says: str, options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=says):
        Tone.load(saved(tmp_path, GREYS), **options)


@pytest.mark.parametrize("values", [[[1.1]], [[-0.1]], [[np.nan]], [0.5], [[]], [[[0.5]]]])
def test_an_array_that_is_no_coverage_is_refused(values: Any) -> None:
    with pytest.raises(ValueError, match="coverage"):
        Tone.load(np.array(values))
