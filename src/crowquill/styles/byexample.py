"""Stippling by example: marks and their places as in a scanned drawing, tone by tone; white on black in the darks.

A tile of marks with the example's texture at each of its tones is laid over the picture without end, and each mark is drawn where
the picture is darker than the mark's own threshold: what is there in a light tone is there in a darker one, where dots that keep apart
have slid by up to half their width to make room.
Source: S. Kim, R. Maciejewski, T. Isenberg, W. M. Andrews, W. Chen, M. C. Sousa, D. S. Ebert, Stippling by Example, NPAR 2009.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import shapely

from crowquill import exemplar, measure
from crowquill.exemplar import darks, kept, learning, stylefile
from crowquill.exemplar.style import Hand, Style, Tile
from crowquill.knobs import Range, Text
from crowquill.marks import Marks, together
from crowquill.paths import Array
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, cut_white, snapped
from crowquill.styles import Work
from crowquill.tone import Tone

INKS = False  # marks lie in the groups of the example, and its darks are reversed as it has them
EXAMPLE = "hand"
LEARNING = 40.0  # seconds, about, that a page of a few thousand dots takes
SPEED = 40_000  # marks a second that are laid and measured
PASSES = 3  # of looking up the tone where a mark lies, which says where it lies
INK = 0.02  # marks are as wide as in the example, and lie in groups if they do there: a drawing has a few too many or too few


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    example: Annotated[str | None, Text("scan of a drawing to follow: hand, even, or a picture file (hand)", file=True)] = None,
    example_dpi: Annotated[float | None, Range(300, 25_400, "", "dpi of the scan, which gives marks their size (the file's tag)")] = None,
    style_file: Annotated[str | None, Text("a style learned before, in place of an example", file=True)] = None,
    white: Annotated[float, Range(0, 1, "", "no marks where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size: a layer of black areas out of which white marks are cut, and one of black marks.

    example     its tones should lie in patches of some 24 dots' width or more; examples that come along are simulated. What it
                taught is kept in the user's cache folder: a second drawing by it starts at once
    size        marks are as large as in the example: the size of the drawing decides how many there are
    shapes      are dealt out at random, none again before all others were, each turned at random
    seed        moves, turns and mirrors the tile
    importance  is not heeded: tone and example leave nothing to choose
    no ink      an empty sheet and a warning. Raises ValueError for an example of which nothing can be learned, for more than
                max_dots, and for an example with a style_file
    """
    clock = Clock()
    if style_file is not None and (example is not None or example_dpi is not None):
        raise ValueError(f"style_file {style_file!r} holds all of its example; leave out example and example_dpi")
    style = yield from _style(example or EXAMPLE, example_dpi, style_file)
    clock.lap("learn")
    asked, blank = cut_white(tone, white)
    count = _expected(style, asked)
    if count > max_dots:
        raise ValueError(
            f"the picture takes {count} marks like the example's, over the limit of {max_dots}; draw it smaller, or raise max-dots"
        )
    yield Step("plan", 0, 1, {"dots": count, "seconds": 1 + count / SPEED})
    chance = rng.spawn(3)
    black = _laid(style.black, asked, chance[0])
    black = black.take(~blank[tone.under(black.xy)])
    yield Step("place", 1, 2, {"dots": len(black)})
    areas, black, holes = _darks(style, asked, black, chance[1], chance[2])
    clock.lap("place")
    yield Step("measure", 0, 1)
    ink = measure.ink(black) + float(shapely.area(areas)) - darks.overlap(areas, black)
    clock.lap("measure")
    report: dict[str, Any] = {
        "marks": len(black) + holes,
        "white_marks": holes,
        "example": style.name,
        "example_levels": len(style.black.levels) + (len(style.white.levels) if style.white else 0),
        "turnover": list(style.turnover),
        "ink_asked_mm2": asked.ink,
        "ink_placed_mm2": ink,
        "coverage_missing": max(0.0, 1 - ink / asked.ink) if asked.ink else 0.0,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(style, tone, report)
    every = Layer(Ink(), darks.rings(areas), "areas"), Layer(Ink(), black, "marks")
    return Sheet(tone.size, tuple(layer for layer in every if len(layer.art)) or every[1:], report=report)


def _style(example: str, dpi: float | None, style_file: str | None) -> Generator[Step, None, Style]:
    """Steps of learning, and then the style: one that was learned before, or comes along, takes no step."""
    if style_file is not None:
        return stylefile.load(style_file)
    if not exemplar.suffixed(example):
        if dpi is not None:
            raise ValueError(f"example_dpi {dpi:g} is for scans; leave it out for the example {example!r}, which knows its own")
        return exemplar.load(example)
    file = kept.place(Path(example), dpi)
    style = kept.recalled(file)
    if style is None:
        yield Step("learn", 0, 1, {"seconds": LEARNING})
        style = kept.kept((yield from exemplar.learning_steps(learning.learn(example, dpi))), file)
    return style


def _expected(style: Style, asked: Tone) -> int:
    """About how many marks a tone takes, white ones among them."""
    dark = asked.coverage > (sum(style.turnover) / 2 if style.white else 1)
    density = np.where(dark, 0.0, _density(style.black.tile, asked.coverage))
    if style.white:
        density = np.where(dark, _density(style.white.tile, 1 - asked.coverage), density)
    return round(float((density * asked.inside).sum() * asked.pixel[0] * asked.pixel[1]))


def _density(tile: Tile | None, coverage: Array) -> Array:
    """Marks to a mm^2 at each coverage."""
    assert tile is not None
    return np.asarray(np.searchsorted(tile.threshold, coverage) / tile.side**2)


def _darks(
    style: Style, asked: Tone, black: Marks, rng: np.random.Generator, chance: np.random.Generator
) -> tuple[shapely.Geometry, Marks, int]:
    """The areas of black out of which white marks are cut, the black marks that are left, and how many are cut out."""
    if style.white is None:
        return shapely.MultiPolygon(), black, 0
    diameter = 2 * float(np.sqrt(style.black.area / np.pi))
    ground = darks.ground(asked, style.turnover, diameter, rng)
    if ground.whole.is_empty:
        return ground.whole, black, 0
    beads = _shaped(style.black, darks.beads(ground.core, asked.canvas, diameter, rng), rng)
    near = shapely.buffer(ground.whole, darks.NEAR * diameter)
    for part in (ground.whole, near):
        shapely.prepare(part)
    black = black.take(~shapely.intersects_xy(ground.whole, *black.xy.T))
    joins = shapely.intersects_xy(near, *black.xy.T)
    white = _laid(style.white, asked.mapped(lambda c: 1 - c), chance)
    white = white.take(shapely.intersects_xy(ground.whole, *white.xy.T))
    areas = darks.cut(ground.core, together([black.take(joins), beads]), white, style.black.area)
    return areas, black.take(~joins), len(white)


def _laid(hand: Hand, asked: Tone, rng: np.random.Generator) -> Marks:
    """The marks of a hand where a tone is darker than their thresholds, in the canvas, in whole micrometres."""
    assert hand.tile is not None
    place, deal = rng.spawn(2)
    mirrored, turned = place.random(2) < 0.5
    tile = hand.tile.laid(bool(mirrored), bool(turned), place.random(2))
    drawn, stray = np.arange(np.searchsorted(tile.threshold, asked.coverage.max())), tile.stray
    found = [np.empty((0, 2))]
    for top in np.arange(-tile.side, asked.size[1], tile.side):
        for left in np.arange(-tile.side, asked.size[0], tile.side):
            corner = np.array([left, top])
            home = tile.xy[-1, drawn] + corner
            near = ((home >= -stray) & (home <= np.add(asked.size, stray))).all(axis=1)
            which, xy = drawn[near], home[near]
            for _ in range(PASSES):
                xy = tile.at(which, asked.at(xy)) + corner
            found.append(xy[(tile.threshold[which] < asked.at(xy)) & ((xy >= 0) & (xy <= asked.size)).all(axis=1)])
    sites, kept = snapped(np.concatenate(found), asked, np.zeros(asked.coverage.shape, bool))
    return _shaped(hand, sites[kept], deal)


def _shaped(hand: Hand, sites: Array, rng: np.random.Generator) -> Marks:
    """Marks of a hand at sites (n, 2) mm, each turned by chance."""
    kind = _dealt(len(sites), len(hand.glyphs), rng)
    scale = np.array([glyph.size for glyph in hand.glyphs])[kind] * np.sqrt(np.pi) / 2
    return Marks.of(sites, hand.glyphs, scale=scale, angle=rng.uniform(0, 2 * np.pi, len(sites)), glyph=kind)


def _dealt(count: int, shapes: int, rng: np.random.Generator) -> Array:
    """So many of the numbers of the shapes, by chance, none again before all others were."""
    packs = [rng.permutation(shapes) for _ in range(-(-count // shapes))]
    return np.concatenate([np.zeros(0, np.int64), *packs])[:count]


def _warnings(style: Style, tone: Tone, report: dict[str, Any]) -> list[str]:
    """What is to be said of the example and the ink."""
    said = list(style.notes)
    if not report["ink_asked_mm2"]:
        return [*said, "no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on"]
    if not report["marks"] and not report["ink_placed_mm2"]:
        said.append("no marks: all the ink is less than a mark of the example; draw the picture larger")
    elif report["coverage_missing"] > 2 * INK:
        said.append(f"{report['coverage_missing']:.1%} of the ink asked for is not reached; a larger drawing or lighter tones would help")
    if style.white is None and tone.coverage.max() > exemplar.DARKEST:
        said.append("the example has no white marks on black, and its darks are drawn with black ones; give one with dark tones for more")
    if tone.importance is not None:
        said.append("importance is not heeded: what the example shows leaves nothing to choose")
    return said
