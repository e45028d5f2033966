"""Stippling by example: a hand's marks, and how it lays them in each tone, learned from a scan and laid on without end.

Reading order: style, learning, correlation, synthesis, arranging, darks, stylefile, kept.
"""

from __future__ import annotations

import os
from collections.abc import Generator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from crowquill.exemplar import learning, stylefile, synthesis
from crowquill.exemplar.style import Hand, Level, Style, Tile
from crowquill.glyphs.page import Source
from crowquill.sheet import Step

__all__ = ["Hand", "Level", "Style", "Tile", "learned", "learning_steps", "load", "names", "suffixed"]

FOLDER = Path(__file__).parent.parent / "examples"
SEED = 2009  # of tiles: they are a part of what is learned, and the same for all drawings
BLACK, WHITE = 20_000, 8_000  # marks of a tile: 45 mm of dots of a 0.35 mm pen
DARKEST = 0.97  # coverage that black marks alone are taken to


def names() -> list[str]:
    """The examples that come with the package, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.png"))


@lru_cache(4)
def load(name: str) -> Style:
    """The style of an example that comes with the package, learned when the package was made. Raises ValueError for an unknown name."""
    if name not in names():
        raise ValueError(f"no example {name!r}; there are {', '.join(names())}, or the path of a scan")
    return stylefile.load(FOLDER / f"{name}.style")


def learned(source: Source, dpi: float | None = None) -> Style:
    """The style of a scanned drawing, tiles and all: ten to thirty seconds. See learning.learn for what it takes and refuses."""
    work = learning_steps(learning.learn(source, dpi))
    while True:
        try:
            next(work)
        except StopIteration as stop:
            style: Style = stop.value
            return style


def learning_steps(style: Style) -> Generator[Step, None, Style]:
    """Steps of tiles being made, tone by tone; returns the style with tiles for its hands."""
    chance = np.random.default_rng(SEED).spawn(2)
    black = yield from synthesis.tiled(style.black, style.turnover[1] if style.white else DARKEST, BLACK, chance[0], "black")
    if style.white is None:
        return replace(style, black=black)
    white = yield from synthesis.tiled(style.white, 1 - style.turnover[0], WHITE, chance[1], "white")
    return replace(style, black=black, white=white)


def suffixed(name: str | os.PathLike[str]) -> bool:
    """Whether a name is that of a file."""
    return bool(Path(name).suffix)
