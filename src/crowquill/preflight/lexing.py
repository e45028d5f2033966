"""Where the words of page content end, for compiled code."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled


@compiled
def skipped(code: npt.NDArray[np.uint8], at: int) -> int:
    """Where the string, name, array or dictionary that begins here ends; an array's or dictionary's bracket counts by itself."""
    first, size = code[at], len(code)
    if first == 40:  # (
        depth = 0
        while at < size:
            if code[at] == 92:  # backslash
                at += 1
            elif code[at] == 40:
                depth += 1
            elif code[at] == 41:
                depth -= 1
                if depth == 0:
                    return at + 1
            at += 1
        return size
    if first == 60 and at + 1 < size and code[at + 1] != 60:  # <, of a string in hexadecimal
        while at < size and code[at] != 62:
            at += 1
        return min(at + 1, size)
    if first == 37:  # %
        while at < size and code[at] not in (10, 13):
            at += 1
        return at
    if first == 47:  # /
        at += 1
        while at < size and not parts(code[at]):
            at += 1
        return at
    return at + 1


@compiled
def parts(letter: int) -> bool:
    """Whether the character ends a word."""
    return letter in (0, 9, 10, 12, 13, 32, 40, 41, 60, 62, 91, 93, 123, 125, 47, 37)


@compiled
def number(code: npt.NDArray[np.uint8], at: int) -> tuple[float, int]:
    """The number that begins here, and where it ends; signs and points in odd places are passed over, as readers do."""
    value, scale, sign = 0.0, 0.0, 1.0
    while at < len(code):
        letter = code[at]
        if 48 <= letter <= 57:
            if scale > 0:
                value += (letter - 48) * scale
                scale /= 10
            else:
                value = value * 10 + (letter - 48)
        elif letter == 46 and scale == 0:
            scale = 0.1
        elif letter == 45:
            sign = -1.0
        elif letter != 43:
            break
        at += 1
    return sign * value, at
