"""What styles of sites share: how many a tone takes and where they settle, and dots of ink on them with no more overlap than asked."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from crowquill import relax
from crowquill.expense import Clock as Clock  # of styles
from crowquill.expense import expected_seconds as expected_seconds
from crowquill.levels import Levels
from crowquill.marks import Glyph, Marks
from crowquill.paths import Array, fixed
from crowquill.sheet import Step
from crowquill.tone import Tone

PEN = 0.3  # mm, the commonest technical pen
REACH = 3.0  # standard deviations that a blur goes to
CAP = 0.97  # coverage that overlapping dots still reach with a fifth more ink than paper

# Coverage that relaxed dots of the shipped libraries really give when their areas sum to this share of
# the paper: below 0.6 they hardly touch. Written by tools/calibrate.py.
NOMINAL = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4])
RENDERED = np.array([0.0, 0.2001, 0.3999, 0.5005, 0.6001, 0.6975, 0.7843, 0.8576, 0.9136, 0.9505, 0.9739, 0.9879, 0.9946])


Moving = TypeVar("Moving", bound=relax.State)


@dataclass(frozen=True)
class Plan:
    """How many dots of what diameter, and where they are wanted.

    demand   where dots go, as a tone: how densely, over the densest there can be
    nominal  the areas of dots on so much paper, overlap not taken off, over NOMINAL's last figure
    white    (h, w) pixels that must stay free of dots
    ink      mm^2 asked for, that on white not counted
    pen      mm, the diameter; of dots that differ, that of their mean area
    largest  mm, the diameter of the largest dots; spans of sizes are shares of it
    shared   whether importance moved dots of one size about: tone is kept on the whole only; `gap` mm of white between dots
    """

    demand: Tone
    nominal: Tone
    white: npt.NDArray[np.bool_]
    ink: float
    pen: float
    largest: float
    dots: int
    shared: bool
    gap: float


def cut_white(tone: Tone, white: float, rule: str = "before") -> tuple[Tone, npt.NDArray[np.bool_]]:
    """The tone that is asked for, and the pixels that must stay free: those below the cutoff.

    By the rule "before" nothing is asked of them; by "after" what is there is drawn, and removed at the end.
    """
    if rule != "before":
        return tone, tone.levels.where(lambda c: c < white)
    return tone.mapped(lambda c: np.where(c < white, 0.0, c)), tone.levels.where(lambda c: (c < white) | (c == 0))


def widest(tone: Tone, pen: float | None, default: float) -> float:
    """The pen, or the default one as fine as the canvas is narrow. Raises ValueError for a pen wider than the canvas."""
    if pen is not None and pen > tone.across:
        raise ValueError(f"a pen of {pen:g} mm is wider than the canvas of {tone.across:.4g} mm; use a finer pen")
    return min(default, tone.across) if pen is None else pen


def planned(
    tone: Tone,
    *,
    pen: float | None,
    dots: int | None,
    white: float,
    white_rule: str,
    min_gap: float,
    max_dots: int,
    span: tuple[float, float] = (1.0, 1.0),
    rendered: Array = RENDERED,
) -> Plan:
    """How many dots of what diameter the tone takes, before any is placed.

    span      diameters of the smallest and the largest dots over the pen's: the mean area of dots rises from the one's
              where it is white to the other's where it is darkest, in proportion to the ink
    rendered  what dots that are not relaxed cover where their areas sum to NOMINAL of the paper
    """
    asked, blank = cut_white(tone, white, white_rule)
    width = widest(tone, pen, PEN)
    for _ in range(2 if dots is not None and pen is None else 0):  # how wide a dot is decides how far around it tone is looked at
        ink = _ink(*_crowded(*_nominal(asked, width, span, min_gap, rendered), span))
        width = min(tone.across, 2 * float(np.sqrt(ink / (np.pi * (dots or 1)))) / span[1]) if ink else PEN
    nominal, top = _nominal(asked, width, span, min_gap, rendered)
    crowd, peak = _crowded(nominal, top, span)
    ink = _ink(crowd, peak)
    wanted = round(ink / (np.pi * (span[1] * width) ** 2 / 4)) if dots is None else dots if ink else 0
    if wanted > max_dots:
        raise ValueError(
            f"the picture takes {wanted} dots of {width:g} mm, over the limit of {max_dots}; "
            "draw it smaller, use a wider pen, or raise max-dots"
        )
    one = span[0] == span[1]
    mean = width if one or not wanted else 2 * float(np.sqrt(_ink(nominal) / (np.pi * wanted)))
    wish = importance(tone) if one and wanted else None
    demand = crowd if wish is None else _shared_out(crowd, wish)
    moved = wish is not None and bool(np.ptp(wish[crowd.coverage > 0]) > 0)
    demand, nominal = (replace(part, importance=None) for part in (demand, nominal))
    drawn = asked.ink if white_rule == "before" else cut_white(tone, white)[0].ink
    return Plan(demand, nominal, blank, drawn, mean, span[1] * width, wanted, moved, min_gap)


def importance(tone: Tone) -> Array | None:
    """How much finer dots are wished for, (h, w): 1/2 to 2, 1 where nothing is said; None without a map of importance."""
    return None if tone.importance is None else np.asarray(2.0 ** (2 * tone.importance - 1))


def _cap(pen: float, gap: float) -> float:
    """The greatest coverage to ask for.

    Dots that must stay apart cover less: of relaxed ones on over 0.46 of the paper many break the gap and would have to go.
    """
    return min(CAP, 0.46 * (pen / (pen + gap)) ** 2) if gap else CAP


def _nominal(asked: Tone, pen: float, span: tuple[float, float], gap: float, rendered: Array) -> tuple[Tone, float]:
    """Coverage before overlap over NOMINAL's last, and its greatest value where it is darkest.

    How much dots overlap follows the tone around a dot, not under one pixel: fine texture
    keeps its mean.
    """
    from scipy.ndimage import gaussian_filter

    cap = _cap(pen * span[1], gap)
    if gap:  # what is out of reach is pressed together, not cut off, so that tone still rises with tone
        asked = asked.mapped(lambda c: c / (1 + c * (1 / cap - 1)))
    around = pen * float(np.sqrt((span[0] ** 2 + span[1] ** 2) / 2))
    sigma = [around / side for side in reversed(asked.pixel)]
    margin = int(REACH * sigma[0] + 0.5)  # rows that the blur looks at

    def rows(top: int, bottom: int) -> Array:
        first = max(0, top - margin)
        c = np.minimum(asked.levels.rows(first, bottom + margin), cap)
        own = slice(top - first, bottom - first)
        near = np.clip(gaussian_filter(c, sigma, mode="nearest", truncate=REACH)[own], 1e-6, cap)
        swell = np.interp(near, rendered, NOMINAL) / near
        found: Array = np.clip(c[own] * swell / NOMINAL[-1], 0, 1)
        return found

    nominal = asked.holding(Levels.filled(asked.shape, rows))
    return nominal, float(np.interp(cap, rendered, NOMINAL)) / NOMINAL[-1]


def _ink(crowd: Tone, peak: float = 1.0) -> float:
    """mm^2 of dots if each were of the largest, overlap not taken off."""
    return crowd.ink * peak * float(NOMINAL[-1])


def _crowded(nominal: Tone, top: float, span: tuple[float, float]) -> tuple[Tone, float]:
    """How densely dots lie, over the densest there may be, and that over as many of the largest as cover NOMINAL's last.

    The mean area of a dot rises with the nominal coverage, up to the largest's at `top`. Where it is important dots
    are finer, but no finer than the smallest.
    """
    if span[0] == span[1]:
        return nominal, 1.0
    least, wish = (span[0] / span[1]) ** 2, importance(nominal)

    def dense(c: Array, finer: Array | float = 1.0) -> Array:
        part: Array = np.clip((least + (1 - least) * c / top) / finer, least, 1)
        return c / part

    density = nominal.levels.mapped(dense) if wish is None else Levels(dense(nominal.coverage, wish**2))
    peak = max(1.0, density.most)
    return nominal.holding(density.mapped(lambda d: d / peak)), peak


def _shared_out(demand: Tone, wish: Array) -> Tone:
    """The same dots in all, more where they are wished for: demand times wish times a number, no more than can be placed."""
    most, scale, shared = demand.ink, 1.0, demand
    for _ in range(50):
        shared = demand.holding(np.minimum(1, demand.coverage * wish * scale))
        if abs(shared.ink - most) <= 1e-6 * most:
            break
        scale *= most / shared.ink
    return shared


def settled(
    demand: Tone,
    dots: int,
    rng: np.random.Generator,
    clock: Clock,
    *,
    start: str,
    iterations: int,
    until: float = 0.0,
    step: float = 1.8,
    exponent: float = 2.0,
    banned: npt.NDArray[np.bool_] | None = None,
) -> Generator[Step, None, relax.State]:
    """Steps of sites being placed by the demand and relaxed; returns the last state, that of no sites where there are none."""
    sites = relax.scatter(demand, dots, rng, start)
    yield Step("place", 1, 1, {"dots": len(sites)})
    clock.lap("place")
    states = relax.lloyd(sites, demand, step=step, exponent=exponent, banned=banned)
    return (yield from watched(states, iterations, clock, until=until))


def watched(states: Iterator[Moving], iterations: int, clock: Clock, *, until: float = 0.0) -> Generator[Step, None, Moving]:
    """Steps of states, so many of them, or until sites move less, or there are none; returns the last state."""
    for state in states:
        if not len(state.sites):
            break
        yield Step("relax", state.done, iterations, {"energy": state.energy, "movement": state.movement})
        if state.done >= iterations or state.movement < until:
            break
    clock.lap("relax")
    return state


def snapped(sites: Array, tone: Tone, white: npt.NDArray[np.bool_]) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Sites in whole micrometres, and which of them may stay: in the canvas and not on white.

    A site whose nearest micrometre is across a border takes one on its own side.
    """
    best = np.round(sites, 3)
    good = allowed(best, tone, white)
    for x in (np.floor, np.ceil):
        for y in (np.floor, np.ceil):
            lost = np.flatnonzero(~good)
            other = np.stack([x(sites[lost, 0] * 1000), y(sites[lost, 1] * 1000)], axis=1) / 1000
            mends = allowed(other, tone, white)
            best[lost[mends]] = other[mends]
            good[lost[mends]] = True
    return best, good


def allowed(sites: Array, tone: Tone, white: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Which places lie in the canvas and not on white."""
    return np.asarray(tone.holds(sites) & ~white[tone.under(sites)])


def dotted(sites: Array, glyphs: tuple[Glyph, ...], diameter: float | Array, rng: np.random.Generator) -> Marks:
    """A glyph at each site, turned at random.

    diameter  one for all, about which true diameters keep their spread; or (n,) mm, which are kept to
    """
    glyph = fixed(rng.permutation(np.arange(len(sites)) % len(glyphs)))  # each as often as any other
    spread: Array | float = 1.0
    if isinstance(diameter, float) and len(sites):
        sizes = np.array([glyph.size for glyph in glyphs])[glyph]
        spread = sizes / np.sqrt((sizes**2).mean())
    scale = np.asarray(diameter * np.sqrt(np.pi) / 2 * spread)
    return Marks.of(sites, glyphs, scale=fixed(scale), angle=fixed(rng.uniform(0, 2 * np.pi, len(sites))), glyph=glyph)


def apart(marks: Marks, gap: float) -> npt.NDArray[np.bool_]:
    """Which marks stay so that no two outlines are nearer than the gap, taking each mark as its circle of reach.

    Of two that are too near, the one with more such neighbours goes, or else the later.
    """
    from scipy.spatial import cKDTree

    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    stay = np.ones(len(marks), bool)
    if len(marks) < 2 or not gap:
        return stay
    pairs = cKDTree(marks.xy).query_pairs(2 * reach.max() + gap, output_type="ndarray")
    near = np.hypot(*(marks.xy[pairs[:, 0]] - marks.xy[pairs[:, 1]]).T) < reach[pairs].sum(axis=1) + gap
    pairs = pairs[near]
    crowd = np.bincount(pairs.ravel(), minlength=len(marks))
    pairs = np.sort(pairs, axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], -crowd[pairs].max(axis=1)))
    for i, j in pairs[order].tolist():
        if stay[i] and stay[j]:
            stay[j if crowd[j] >= crowd[i] else i] = False
    return stay


def found(plan: Plan, marks: int, ink: float) -> dict[str, Any]:
    """What is reported of dots and ink, and what is to be said of it."""
    asked, warnings = plan.ink, []
    missing = max(0.0, 1 - ink / asked) if asked else 0.0
    if not asked:
        warnings.append("no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on")
    elif not plan.dots:
        warnings.append(f"no dots: all the ink is less than half a dot of {plan.pen:.4g} mm; a finer pen would draw it")
    elif missing > 0.02:
        wish = "a smaller gap" if plan.gap else "a wider pen, more dots or lighter tones"
        warnings.append(f"{missing:.1%} of the ink asked for is not reached; {wish} would help")
    if plan.shared:
        warnings.append("importance moved dots of one size about, so that tone is kept on the whole only; several sizes would keep it")
    return {
        "marks": marks,
        "pen_mm": plan.pen,
        "ink_asked_mm2": asked,
        "ink_placed_mm2": ink,
        "coverage_missing": missing,
        "warnings": warnings,
    }
