"""Colour profiles are followed to sRGB and opacity is left alone; what cannot be followed is said, and nothing stops the drawing."""

from __future__ import annotations

import io
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image, ImageCms
from PIL.PngImagePlugin import PngInfo

from crowquill.picture import BROKEN, DEEP, FOREIGN, INKS, TAGS, colours, read, shape, window
from crowquill.tone import Tone

Array = npt.NDArray[np.float64]
D50 = (0.9642, 1.0, 0.8249)
SRGB = ((0.4360, 0.2225, 0.0139), (0.3851, 0.7169, 0.0971), (0.1431, 0.0606, 0.7141))  # its primaries, adapted to D50
STEP = 1.5 / 255  # results are whole code values of 8 bits, and the profile's own numbers are rounded


def fixed(*numbers: float) -> bytes:
    return b"".join(struct.pack(">i", round(number * 65536)) for number in numbers)


def curve(gamma: float) -> bytes:
    return b"curv" + bytes(4) + struct.pack(">IHxx", 1, round(gamma * 256))


def profile(space: bytes, kind: bytes, tags: dict[bytes, bytes], pcs: bytes = b"XYZ ") -> bytes:
    """An ICC profile of version 2 with these tags, and a white point of D50 (ICC.1:2001-04)."""
    described = b"desc" + bytes(4) + struct.pack(">I", 2) + b"t\0" + bytes(78)
    tags = {b"desc": described, b"cprt": b"text" + bytes(4) + b"-\0", b"wtpt": b"XYZ " + bytes(4) + fixed(*D50)} | tags
    table, body, at = struct.pack(">I", len(tags)), b"", 132 + 12 * len(tags)
    for name, data in tags.items():
        table += name + struct.pack(">II", at + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    head = bytes(8) + struct.pack(">I", 0x02400000) + kind + space + pcs + bytes(12) + b"acsp" + bytes(28) + fixed(*D50) + bytes(48)
    whole = head + table + body
    return struct.pack(">I", len(whole)) + whole[4:]


def rgb_profile(gamma: float, primaries: Any = SRGB) -> bytes:
    columns = {name + b"XYZ": b"XYZ " + bytes(4) + fixed(*xyz) for name, xyz in zip((b"r", b"g", b"b"), primaries, strict=True)}
    return profile(b"RGB ", b"mntr", columns | {name + b"TRC": curve(gamma) for name in (b"r", b"g", b"b")})


def cmyk_profile() -> bytes:
    """A press whose lightness is 100 (1 - K), whatever the other inks: a table of two points along each of four axes."""
    levels = np.array([[100 * (1 - k), 0, 0] for k in (0, 1)])  # K is the axis that runs fastest
    lab = np.tile(levels, (8, 1)) * [65280 / 100, 1, 1] + [0, 0x8000, 0x8000]  # Lab of version 2
    ends = struct.pack(">HH", 0, 65535)
    table = b"mft2" + bytes(4) + struct.pack(">BBBx", 4, 3, 2) + fixed(1, 0, 0, 0, 1, 0, 0, 0, 1) + struct.pack(">HH", 2, 2)
    return profile(b"CMYK", b"prtr", {b"A2B0": table + ends * 4 + lab.round().astype(">u2").tobytes() + ends * 3}, b"Lab ")


def grey_profile(gamma: float) -> bytes:
    return profile(b"GRAY", b"mntr", {b"kTRC": curve(gamma)})


def code(light: npt.ArrayLike) -> Array:
    """sRGB code values of light, by the standard's own words."""
    light = np.asarray(light, np.float64)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)


def saved(folder: Path, image: Any, name: str = "a.png", **save: Any) -> Path:
    (image if isinstance(image, Image.Image) else Image.fromarray(image)).save(folder / name, **save)
    return folder / name


RAMP = np.arange(256, dtype=np.uint8)[None]
COLOURS = np.random.default_rng(1).integers(0, 256, (20, 30, 3), np.uint8)
BUILT_IN = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


@pytest.mark.parametrize("gamma", [1.0, 1.8, 2.6])
@pytest.mark.parametrize("mode", ["L", "RGB", "P", "L in colour"])
def test_a_gamma_is_followed_to_srgb(tmp_path: Path, gamma: float, mode: str) -> None:
    embedded = grey_profile(gamma) if mode == "L" else rgb_profile(gamma)
    image = Image.fromarray(RAMP).convert(mode[:3].strip() if mode[0] != "L" else "L")
    got, notes = read(saved(tmp_path, image, icc_profile=embedded))
    np.testing.assert_allclose(got[0], code((np.arange(256) / 255) ** gamma), atol=STEP)
    assert notes == ()


def test_primaries_are_followed_to_srgb(tmp_path: Path) -> None:
    turned = rgb_profile(1.0, SRGB[1:] + SRGB[:1])  # what it calls red is sRGB's green, and so on round
    got, _ = read(saved(tmp_path, np.eye(3, dtype=np.uint8)[None] * 255, icc_profile=turned))
    np.testing.assert_allclose(got[0], code([0.7152, 0.0722, 0.2126]), atol=STEP)


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.webp"])
def test_profiles_are_found_in_every_format_that_has_them(tmp_path: Path, name: str) -> None:
    flat = np.full((16, 16, 3), 128, np.uint8)
    exact = {"lossless": True} if name == "a.webp" else {}
    got, _ = read(saved(tmp_path, flat, name, icc_profile=rgb_profile(1.0), **exact))
    np.testing.assert_allclose(got, code(128 / 255), atol=STEP)


@pytest.mark.parametrize("values", [RAMP, COLOURS, np.dstack([COLOURS, COLOURS[..., 0]])], ids=["grey", "colour", "clear"])
def test_a_profile_of_srgb_changes_no_bit(tmp_path: Path, values: Any) -> None:
    with_it, notes = read(saved(tmp_path, values, icc_profile=BUILT_IN))
    np.testing.assert_array_equal(with_it, read(saved(tmp_path, values, "b.png"))[0])
    assert notes == () and np.ptp(read(saved(tmp_path, values, icc_profile=rgb_profile(1.8)))[0] - with_it) > 0.02


@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_a_profile_leaves_opacity_and_its_white_ground_alone(tmp_path: Path, mode: str) -> None:
    alpha = np.array([[0, 51, 255]], np.uint8)
    values = np.dstack([np.full((1, 3), 128, np.uint8)] * (len(mode) - 1) + [alpha])
    embedded = grey_profile(1.0) if mode == "LA" else rgb_profile(1.0)
    path = saved(tmp_path, Image.fromarray(values, mode), icc_profile=embedded)
    share = alpha / 255
    np.testing.assert_allclose(read(path)[0], code(share * 128 / 255 + 1 - share), atol=STEP)
    np.testing.assert_allclose(read(path, under=0.0)[0], code(share * 128 / 255), atol=STEP)
    rgba, clear = colours(path)
    assert clear and (rgba[..., 3] == alpha).all() and abs(int(rgba[0, 2, 0]) - 188) <= 1  # code(128 / 255) * 255


def test_a_grey_with_a_clear_value_keeps_it_clear(tmp_path: Path) -> None:
    path = saved(tmp_path, np.array([[7, 128]], np.uint8), transparency=7, icc_profile=grey_profile(1.0))
    np.testing.assert_allclose(read(path)[0], [[1, code(128 / 255)]], atol=STEP)


@pytest.mark.parametrize("name", ["a.jpg", "a.tif"])
def test_inks_go_by_their_profile(tmp_path: Path, name: str) -> None:
    inks = Image.merge("CMYK", [Image.new("L", (16, 16), v) for v in (200, 0, 30, 102)])  # 102: K of 40 %, and L* of 60
    exact = {"quality": 100, "subsampling": 0} if name == "a.jpg" else {}
    got, notes = read(saved(tmp_path, inks, name, icc_profile=cmyk_profile(), **exact))
    np.testing.assert_allclose(got, code(((60 + 16) / 116) ** 3), atol=2 * STEP)  # two tables of whole numbers
    assert notes == ()


def test_inks_without_a_profile_are_a_guess_and_that_is_said(tmp_path: Path) -> None:
    inks = Image.merge("CMYK", [Image.new("L", (4, 4), v) for v in (0, 0, 0, 102)])
    got, notes = read(saved(tmp_path, inks, "a.tif"))
    np.testing.assert_allclose(got, 0.6, atol=STEP)
    assert notes == (INKS,)
    assert read(saved(tmp_path, inks, "b.tif", icc_profile=rgb_profile(1.0)))[1] == (FOREIGN, INKS)
    assert read(saved(tmp_path, inks, "c.tif", icc_profile=b"ink"))[1] == (BROKEN, INKS)


WRONG = {
    "rubbish": (b"not a profile at all" * 20, BROKEN),
    "one byte": (b"\0", BROKEN),
    "cut": (rgb_profile(1.0)[:200], BROKEN),
    "no curves": (profile(b"RGB ", b"mntr", {}), FOREIGN),
    "for inks": (cmyk_profile(), FOREIGN),
    "for greys": (grey_profile(1.0), FOREIGN),
    "a link": (profile(b"RGB ", b"link", {}), FOREIGN),
}


@pytest.mark.parametrize("story", WRONG)
def test_a_bad_profile_is_read_as_srgb_and_said(tmp_path: Path, story: str) -> None:
    embedded, says = WRONG[story]
    got, notes = read(saved(tmp_path, COLOURS, icc_profile=embedded))
    np.testing.assert_array_equal(got, read(saved(tmp_path, COLOURS, "b.png"))[0])
    assert len(notes) == 1 and (notes[0] == says or story == "cut")  # where a cut one fails is littleCMS's affair
    assert Tone.load(tmp_path / "a.png").mapped(np.sqrt).fitted(10, 90, "cover").notes == notes


def test_sixteen_bits_keep_their_values_whatever_the_profile(tmp_path: Path) -> None:
    deep = np.array([[0, 257, 30000, 65535]], np.uint16)
    for embedded, says in ((grey_profile(1.0), (DEEP,)), (BUILT_IN, ()), (b"rubbish", (BROKEN,))):
        got, notes = read(saved(tmp_path, deep, icc_profile=embedded))
        np.testing.assert_array_equal(got, deep / 65535)
        assert notes == says


def test_damaged_tags_are_said_once_by_us(tmp_path: Path) -> None:
    turned = saved(tmp_path, COLOURS, "a.jpg", exif=b"Exif\0\0MM\0*\0\0\0\x08\0\x05" + bytes(7))
    nothing = saved(tmp_path, COLOURS, "b.png", exif=b"Exif\0\0rubbish")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read(turned)[1] == read(nothing)[1] == (TAGS,)
        assert read(saved(tmp_path, COLOURS, "c.png", pnginfo=PngInfo()))[1] == ()


def test_a_lab_picture_is_its_lightness(tmp_path: Path) -> None:
    lab = Image.merge("LAB", [Image.new("L", (4, 4), v) for v in (153, 128, 128)])  # L* of 60
    np.testing.assert_allclose(read(saved(tmp_path, lab, "a.tif"))[0], code(((60 + 16) / 116) ** 3), atol=STEP)


def test_the_shape_is_that_of_the_upright_picture_and_windows_have_a_pixel(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6
    assert shape(saved(tmp_path, COLOURS, exif=exif)) == (30, 20)
    assert window((30, 20), None) == (slice(0, 30), slice(0, 20))
    assert window((30, 20, 4), (0.999, 0.999, 0.001, 0.001)) == (slice(29, 30), slice(19, 20))
    with pytest.raises(ValueError, match=r"crop .* is not inside"):
        window((30, 20), (0.5, 0.5, 0.6, 0.5))


def test_the_same_file_is_read_from_a_stream(tmp_path: Path) -> None:
    path = saved(tmp_path, COLOURS, icc_profile=rgb_profile(1.8))
    np.testing.assert_array_equal(read(io.BytesIO(path.read_bytes()))[0], read(path)[0])
