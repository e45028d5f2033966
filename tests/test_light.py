"""The colours that a tone keeps of its picture."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from crowquill.tone import Tone


def test_colours_are_kept_where_they_are_asked_for(tmp_path):
    rgba = np.zeros((4, 6, 4), np.uint8)
    rgba[..., :3], rgba[..., 3] = (200, 30, 10), 255
    rgba[0, 0, 3] = 0  # lies on white
    rgba[1, 1] = (0, 0, 0, 128)
    file = tmp_path / "red.png"
    Image.fromarray(rgba).save(file)
    assert Tone.load(file).rgb is None
    tone = Tone.load(file, colour=True)
    assert tone.rgb is not None
    assert tone.rgb[0, 0].tolist() == [255, 255, 255]
    assert tone.rgb[2, 2].tolist() == [200, 30, 10]
    assert abs(int(tone.rgb[1, 1, 0]) - 188) <= 1  # half of the light of white
    cut = Tone.load(file, colour=True, crop=(0.5, 0.5, 0.5, 0.5), invert=True)
    assert cut.rgb is not None
    assert cut.rgb.tolist() == [[[55, 225, 245]] * 3] * 2
    assert tone.mapped(lambda c: c / 2).rgb is not None
    with pytest.raises(ValueError, match="rgb has shape"):
        Tone(np.zeros((2, 2)), (1, 1), rgb=np.zeros((2, 3, 3), np.uint8))
