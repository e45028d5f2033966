"""Dots of several inks moved so that all together lie as evenly as those of one: few of different inks come near each other.

Each dot goes part of the way to the middle of its cell in the diagram of all dots, and part of the way back to where it lies in the
diagram of its own ink as the style laid it: own patterns stay, whatever they are, and own tones with them.
Source: C. Schulz, K. C. Kwan, M. Becher, D. Baumgartner, G. Reina, O. Deussen, D. Weiskopf, Multi-Class Inverted
Stippling, ACM Transactions on Graphics 40(6), 2021, where chance chooses between both middles, by the ink under the dot.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import cells, measure, moments
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.relax import GOLDEN
from crowquill.sheet import Step
from crowquill.stippling import snapped
from crowquill.tone import Tone

HALVED = 3  # times that a way too near to another dot is halved before it is given up
ROUNDS = 20
STRIDE = 1.8  # of the way, as relax.lloyd goes
JOINT = 0.8  # of the way to the middle among all dots; with .5 six times as many of two inks stay near, with 1 own patterns grow uneven
DENSE = 0.5  # of own coverage, from which on that fades to nothing at 1: there is no way round dots that cover all
REACH = 0.7  # of the spacing in its own ink that a dot may end up from where the style laid it
TWINS = 1e-4  # mm: dots in one place are looked at so far apart, or they would have one cell
LEVEL = 2e-4  # of an ink's area: as near as it is brought to what it was


@dataclass(frozen=True, eq=False)
class Ground:
    """Where the dots of one ink may go.

    weight    its tone squared, as relaxing dots see it; lightest, the lightest coverage on which the style laid one
    first     (n, 2) mm where it laid them, and `own` from there to the middles of their cells; most (n,) mm that each may move
    joint     (n, 1) of the way to the middle among all dots
    reach     (n,) mm of each, and `gap` the least white between two, None where there is none
    """

    tone: Tone
    weight: Tone
    first: Array
    own: Array
    most: Array
    joint: Array
    lightest: float
    reach: Array
    gap: float | None

    @classmethod
    def of(cls, marks: Marks, tone: Tone, gap: float) -> Ground:
        """The ground of dots as a style laid them, with so much white between them where they did not touch."""
        weight, cover = tone.mapped(np.square), tone.at(marks.xy)
        reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
        spacing = marks.scale / np.sqrt(np.maximum(cover, 1e-3))
        joint = JOINT * np.clip((1 - cover) / (1 - DENSE), 0, 1)[:, None]
        least = _least_gap(marks.xy, reach)
        return cls(
            tone, weight, marks.xy, _middles(marks.xy, weight) - marks.xy, REACH * spacing, joint,
            float(cover.min(initial=1.0)), reach, min(gap, least) if least > 0 else None,
        )  # fmt: skip

    def allowed(self, sites: Array) -> npt.NDArray[np.bool_]:
        """Which places lie in the canvas and on no lighter tone than the style laid dots on."""
        return np.asarray(self.tone.holds(sites) & (self.tone.at(sites) >= self.lightest))

    def moved(self, sites: Array, middles: Array) -> Array:
        """Where dots go from these sites, with these middles among all dots: less far where they may not go so far, or not at all."""
        back = _middles(sites, self.weight) - self.own
        way = STRIDE * (self.joint * (middles - sites) + (1 - self.joint) * (back - sites))
        found, lost = sites.copy(), np.ones(len(sites), bool)
        for share in (1, 0.5, 0.25):
            off = sites + share * way - self.first
            off *= np.minimum(1, self.most / np.maximum(np.hypot(*off.T), 1e-12))[:, None]
            good = lost & self.allowed(self.first + off)
            found[good], lost = (self.first + off)[good], lost & ~good
        return self.kept_apart(found, sites)

    def kept_apart(self, sites: Array, before: Array, halvings: int = HALVED) -> Array:
        """The sites, those taken back, by so many halves, then to where they were, that came too near to others of this ink."""
        if self.gap is None:
            return sites
        back = np.zeros(len(sites), np.int64)
        while len(near := _too_near(sites, self.reach, self.gap)):
            back[near] += 1
            half = (sites + before)[near] / 2
            sites[near] = np.where((back[near] <= halvings)[:, None] & self.allowed(half)[:, None], half, before[near])
        return sites


def mingled(
    parts: Sequence[Marks], tones: Sequence[Tone], canvas: shapely.Geometry, gap: float = 0.0
) -> Generator[Step, None, list[Marks]]:
    """Steps of dots that make room for those of other inks; returns the marks of each ink, as many, in their order.

    tones  what is asked of each ink, on parts of the canvas. No dot leaves its part, moves by more than REACH of its ink's
           spacing there, or goes where it is lighter than where the style had any. Each ink covers as much as before: dots that
           now meet more, or less, are made larger or smaller for it, all alike
    gap    mm of white that stays between any two of one ink, taken as circles of their reach; where none touched none will

    Of one ink, or of none, nothing moves.
    """
    grounds = [Ground.of(marks, tone, gap) for marks, tone in zip(parts, tones, strict=True)]
    sites = [marks.xy for marks in parts]
    if sum(len(part) > 0 for part in sites) < 2:
        return list(parts)
    every = np.sum([tone.coverage * tone.inside for tone in tones], axis=0)
    weight = replace(tones[0], values=(every / every.max()) ** 2, canvas=canvas, importance=None)
    cuts = np.cumsum([len(part) for part in sites])[:-1]
    turn = GOLDEN * np.arange(sum(map(len, sites)))
    twins = TWINS * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for done in range(ROUNDS):
        yield Step("mingle", done, ROUNDS)
        middles = np.split(_middles(np.concatenate(sites) + twins, weight), cuts)
        sites = [ground.moved(*both) if len(both[0]) else both[0] for ground, *both in zip(grounds, sites, middles, strict=True)]
    yield Step("mingle", ROUNDS, ROUNDS)
    return [_settled(*one) for one in zip(parts, grounds, sites, strict=True)]


def _settled(marks: Marks, ground: Ground, sites: Array) -> Marks:
    """The marks at these sites in whole micrometres, covering as much as they did; where no whole one will do they stay."""
    if not len(marks):
        return marks
    whole, good = snapped(sites, ground.tone, ground.tone.coverage < ground.lightest)
    found = replace(marks, xy=ground.kept_apart(np.where(good[:, None], whole, marks.xy), marks.xy, 0))
    wanted, grown, steep = np.log(measure.ink(marks)), 0.0, 1.0
    before: tuple[float, float] | None = None
    for _ in range(6):  # of a secant: of dots that overlap what they cover grows less than they do
        now = float(np.log(measure.ink(found)))
        if abs(now - wanted) <= LEVEL:
            break
        steep = steep if before is None else float(np.clip((now - before[1]) / (grown - before[0]), 0.1, 1))
        before, grown = (grown, now), grown + float(wanted - now) / steep
        # whole micrometres, each dot's rounded at a place of its own: all at once would be steps of .7 % of ink
        found = replace(found, scale=np.floor(1000 * marks.scale * np.exp(grown / 2) + GOLDEN * np.arange(len(marks)) % 1) / 1000)
    return found


def _middles(sites: Array, weight: Tone) -> Array:
    """The middle of each site's cell, weighed (n, 2) mm."""
    return moments.of_tone(cells.voronoi(sites, weight.canvas), weight).centroid


def _least_gap(sites: Array, reach: Array) -> float:
    """The least white between two dots, as circles of their reach, mm; 0 and less where two may touch, or there are no two."""
    from scipy.spatial import cKDTree

    if len(sites) < 2:
        return 0.0
    nearest = float(np.asarray(cKDTree(sites).query(sites, 2)[0])[:, 1].min())
    i, j = _pairs(sites, nearest + 2 * (reach.max() - reach.min()) + 1e-9)
    return float((np.hypot(*(sites[i] - sites[j]).T) - reach[i] - reach[j]).min())


def _too_near(sites: Array, reach: Array, gap: float) -> npt.NDArray[np.int64]:
    """The dots that leave less white than the gap to another."""
    i, j = _pairs(sites, 2 * reach.max() + gap)
    near = np.hypot(*(sites[i] - sites[j]).T) - reach[i] - reach[j] < gap - 1e-9
    return np.unique(np.concatenate([i[near], j[near]]))


def _pairs(sites: Array, distance: float) -> npt.NDArray[np.int64]:
    """Pairs (2, m) of sites no further apart."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(sites).query_pairs(distance, output_type="ndarray").T)
