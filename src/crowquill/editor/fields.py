"""Directions in the picture beneath, which items are turned by."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from crowquill import field
from crowquill.editor.drawing import Drawing
from crowquill.field import Field
from crowquill.paths import Array
from crowquill.tone import Tone

REACH = 1.5  # mm over which the way of the picture is taken


def flow(drawing: Drawing, xy: Array) -> Array:
    """The direction in which the tone changes least at places (n, 2) mm on the sheet, rad."""
    return along(drawing.toned()).at(xy - drawing.picture.corner)[0] if len(xy) else np.zeros(0)


@lru_cache(2)
def along(tone: Tone) -> Field:
    """The field of directions in which a tone changes least."""
    return field.along(tone, REACH).eased(REACH)
