"""What matters most in a picture: a map over it, that goes where the picture goes; and what is refused."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from crowquill.tone import Tone

GREYS = np.array([[0, 51, 102], [153, 204, 255]], np.uint8)
EXACT = 1e-12  # of an importance of 1: some roundings of a double


def saved(folder: Path, pixels: npt.NDArray[Any], name: str = "a.png") -> Path:
    Image.fromarray(pixels).save(folder / name)
    return folder / name


def test_importance_is_laid_over_the_whole_picture_and_goes_with_it(tmp_path: Path) -> None:
    path = saved(tmp_path, np.tile(np.arange(8, dtype=np.uint8) * 30, (4, 1)))
    ramp = np.tile(np.arange(8) * 36, (4, 1)).astype(np.uint8)
    whole = Tone.load(path, importance=saved(tmp_path, ramp, "map.png"))
    np.testing.assert_allclose(whole.importance, ramp / 255, atol=EXACT)
    cut = Tone.load(path, importance=tmp_path / "map.png", crop=(0.25, 0.5, 0.5, 0.5))
    np.testing.assert_allclose(cut.importance, ramp[2:, 2:6] / 255, atol=EXACT)
    square = whole.mapped(np.sqrt).fitted(30, 30, "cover")
    np.testing.assert_allclose(square.importance, ramp[:, 2:6] / 255, atol=EXACT)
    assert not square.importance.flags.writeable and Tone.load(path).importance is None


@pytest.mark.parametrize("times", [1, 2, 5])
def test_importance_of_another_size_is_averaged_or_drawn_out(times: int) -> None:
    ramp = np.tile((np.arange(40) + 0.5) / 40, (30, 1))
    finer = np.tile((np.arange(40 * times) + 0.5) / (40 * times), (30 * times, 1))
    for tone in (Tone.load(ramp, importance=finer), Tone.load(finer, importance=ramp)):
        wish, true = tone.importance, tone.coverage  # both are ramps, but for the end that a filter cannot see beyond
        np.testing.assert_allclose(wish[:, times:-times], true[:, times:-times], atol=1e-6)  # 32 bits
        np.testing.assert_allclose(wish, true, atol=1 / 40)
    half = Tone.load(ramp, importance=finer, crop=(0.5, 0, 0.5, 1))
    np.testing.assert_allclose(half.importance[:, 1:-1], half.coverage[:, 1:-1], atol=1e-6)


def test_clear_pixels_of_an_importance_map_wish_nothing(tmp_path: Path) -> None:
    pixels = np.array([[[9, 9, 9, 0], [255, 255, 255, 255], [0, 0, 0, 255]]], np.uint8)
    tone = Tone.load(saved(tmp_path, GREYS[:1]), importance=saved(tmp_path, pixels, "map.png"))
    np.testing.assert_allclose(tone.importance, [[0.5, 1, 0]], atol=1e-9)


def test_a_bad_importance_map_is_refused(tmp_path: Path) -> None:
    path = saved(tmp_path, GREYS)
    (tmp_path / "words.png").write_text("the head, please")
    size = struct.pack(">II", 60000, 60000) + b"\x08\0\0\0\0"
    head = struct.pack(">I", 13) + b"IHDR" + size + struct.pack(">I", zlib.crc32(b"IHDR" + size))
    (tmp_path / "huge.png").write_bytes(b"\x89PNG\r\n\x1a\n" + head + struct.pack(">I", 9) + b"IDAT")
    maps = [("words.png", r"words\.png: not a picture .*; "), ("huge.png", r"huge\.png: 60000 x 60000 pixels"), ("", "is a folder; ")]
    for name, says in maps:
        with pytest.raises(ValueError, match=says):
            Tone.load(path, importance=tmp_path / name)
    for values in ([[1.5]], [[np.nan]], [0.5], [[]]):
        with pytest.raises(ValueError, match="importance"):
            Tone.load(path, importance=np.array(values))
    with pytest.raises(ValueError, match="importance has shape"):
        Tone(np.zeros((2, 2)), (1, 1), importance=np.zeros((2, 3)))
    with pytest.raises(ValueError, match="importance runs from -1"):
        Tone(np.zeros((1, 1)), (1, 1), importance=np.array([[-1.0]]))
