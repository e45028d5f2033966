"""What a press or a printer makes of tones: a curve measured on its paper, from a CSV file, and its inverse."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from crowquill.paths import Array
from crowquill.vector import contents

SHARE = re.compile(r"(\d+(?:\.\d*)?|\.\d+)\s*(%?)")


def inverse(file: str | os.PathLike[str]) -> Callable[[Array], Array]:
    """The coverage to ask for so that the coverage wanted is what prints, as a function of arrays, by a CSV file of two columns.

    Rows are coverage asked and coverage measured, both rising, as shares of 1, or as percents where any is over 1 or has the sign; a
    first row of words is a heading, and empty rows and those after # say nothing. Straight lines run between rows, from
    bare paper before the first and to full ink after the last. What no ink asked for can reach is asked for as nearly as can be.
    Raises ValueError, with the number of the line, for what is no such table.
    """
    asked, measured = _table(contents(Path(file)), os.fspath(file))
    return lambda coverage: np.asarray(np.interp(coverage, measured, asked))


def _table(data: bytes, name: str) -> tuple[Array, Array]:
    """Both columns as shares, from bare paper to full ink."""
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{name}: is no text; give a CSV file of coverage asked and measured") from None
    rows: list[tuple[int, float, float]] = []
    percents, first = False, True
    for number, line in enumerate(lines, 1):
        parts = [part.strip().strip('"') for part in re.split("[,;\t]", line)]
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        found = [SHARE.fullmatch(part) for part in parts]
        heading, first = first and all(re.match(r"[^\W\d]", part) for part in parts), False
        if heading and len(parts) == 2:
            continue
        if len(parts) != 2 or not all(found):
            raise ValueError(f"{name}: line {number} is {line.strip()[:40]!r}; a row is coverage asked and measured, such as 0.5,0.62")
        asked, measured = (float(match[1]) for match in found if match)
        percents = percents or max(asked, measured) > 1 or any(match[2] for match in found if match)
        rows.append((number, asked, measured))
    if len(rows) < 2:
        raise ValueError(f"{name}: has {len(rows)} rows of numbers; a curve takes two or more")
    top = 100.0 if percents else 1.0
    for (_, *before), (number, *row) in zip([(0, -math.inf, -math.inf), *rows], rows, strict=False):
        if max(row) > top:
            raise ValueError(f"{name}: line {number} has a coverage of {max(row):g} %; it takes 0 to 100")
        if not (row[0] > before[0] and row[1] > before[1]):
            raise ValueError(f"{name}: line {number} does not rise over the one before, in both columns; mend it, or leave it out")
    table = np.array([row for _, *row in rows]) / top
    low = [(0.0, 0.0)] if table[0].min() > 0 else []
    high = [(1.0, 1.0)] if table[-1].max() < 1 else []
    whole = np.concatenate([np.reshape(low, (-1, 2)), table, np.reshape(high, (-1, 2))])
    return whole[:, 0], whole[:, 1]
