"""Contrast-aware stippling: dots where error diffusion that heeds structure sets black pixels, as large as the tone there needs.

Errors of dots count more and those of white less, so that few dots are left, on pixels so fine that they draw lines and edges.
Source: H. Li, D. Mould, Contrast-aware Halftoning, Computer Graphics Forum 29(2), 2010; Structure-preserving Stippling by
Priority-based Error Diffusion, Graphics Interface 2011.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import shapely

from crowquill import glyphs as libraries
from crowquill import measure, picture
from crowquill.contrast import JITTER, Found, Set, Texture, Wanted, by_pitch, diffused, flat
from crowquill.halftone.contrast import ORDERS, Diffusing
from crowquill.knobs import Choice, Numbers, Range, Text
from crowquill.marks import Glyph, Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import PEN, Clock, dotted, snapped, widest
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots")  # of which one is enough
GROUNDS = ("white", "black", "grey", "toned")
SPAN = (0.5, 1.7)  # smallest and largest dots over the mean one, about: what lines laid over them reckon with
G = 5.0  # as published; the radii that keep the tone are then near the published ones too
OFF = 0.03  # of the pen, by which the mean dot may differ from it
TRIES = 4  # of pitches for a pen
SCALED = (0.4, 1.25)  # times the size that flat tones ask for: less where edges have many dots, hardly more where lights have none
MISSED = 0.02  # of the number of dots asked for: what is further off is said
RATE = 6e5  # pixels a second and pass, about, of a machine of 2024
WHITE = Ink("white", (0.0, 0.0, 0.0, 0.0))


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "mean dot diameter; decides the number of dots (0.3mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of dots; decides their diameter")] = None,
    g_plus: Annotated[float | None, Range(0, 12, "", "errors of dots count as their radius to this power: more, fewer dots (5)")] = None,
    g_minus: Annotated[float | None, Range(0, 12, "", "errors of white count less by this power (as g-plus)")] = None,
    order: Annotated[str, Choice(ORDERS, "which pixel is next: the nearest to black or white, or row by row")] = "priority",
    mask: Annotated[int, Range(3, 31, "", "pixels, the diameter of the disc that takes an error")] = 7,
    exponent: Annotated[float | None, Range(0, 10, "", "how errors fall with distance (2 by priority, 2.6 by raster)")] = None,
    k: Annotated[float, Range(0, 255, "", "levels that count as a dot's error for each pixel of its area beyond the first")] = 0.1,
    radii: Annotated[tuple[float, ...] | None, Numbers(0.5, 10, "", "radius of a dot in white and in black, pixels (1,2)", 2)] = None,
    size_by: Annotated[str, Choice(("tone", "published"), "dots as large as tones need, or of the radii")] = "tone",
    jitter: Annotated[float, Range(0, 0.5, "", "of a pixel: how far chance moves a dot, each way")] = JITTER,
    texture: Annotated[str | None, Text("picture or pattern that shows in the tones", file=True)] = None,
    texture_width: Annotated[float | None, Range(0.1, 10_000, "mm", "width of a tile of it (the whole drawing)")] = None,
    texture_strength: Annotated[float, Range(0, 1, "", "how much of it shows")] = 0.7,
    ground: Annotated[
        str, Choice(GROUNDS, "black dots on white; white on black; both on grey, or on paper that is toned itself")
    ] = "white",
    grey: Annotated[float, Range(0.05, 0.95, "", "how dark a grey ground or toned paper is")] = 0.5,
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the pen)", file=True)] = None,
    white: Annotated[float, Range(0, 1, "", "no dots where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 1_000_000,
) -> Work:
    """A sheet the tone's size with a layer of black dots, each near the middle of a pixel that the diffusion made black.

    pen, dots  with a pen, pixels are as fine as dots of that mean diameter ask for, within 3 %. With a number, pixels are searched
               on which G leaves so many, within 2 %, and dots are as large as the ink asks for; with both the tone gives. The
               search is not over G, as published: a larger one takes all dots from the lights first and reaches few numbers,
               finer or coarser pixels leave the drawing its character. What cannot be met is reported
    g_plus, g_minus  at 0 there are as many dots as in a halftone, hardly differing in size. In lights of which G leaves too few
               dots tone is lost: by raster from 3 on, by priority from 7 on
    size_by    "tone": dots of flat tones cover what is asked, up to 0.97; all together, by one factor from 0.4 to 1.25, what the
               picture asks. "published": of radii by tone, in pixels, and the tone gives
    texture    moves each pixel towards black or white by its rank: the mean over it is the tone
    ground     "black" is filled, and its dots are white; "grey" is a tint, "toned" paper that has it, with black dots where the
               picture is darker and white ones where it is lighter
    no ink     an empty sheet and a warning. Raises ValueError for a texture_width without texture, a pen wider than the canvas,
               more than max_dots, and more pixels than 12 million
    """
    clock = Clock()
    if texture is None and texture_width is not None:
        raise ValueError(f"texture_width {texture_width:g} mm is of no use without a texture; give one, or leave it out")
    given = [power for power in (g_plus, g_minus) if power is not None] or [G]
    rule = Diffusing(order, mask, exponent, given[0], given[-1], k, (1.0, 2.0) if radii is None else (radii[0], radii[1]))
    weave = None if texture is None else Texture(1 - picture.decoded(texture), texture_width, texture_strength)
    tints = _tints(ground, grey)
    wanted = tuple(Wanted(tone.mapped(tint.curve), white, weave, int(rng.integers(2**62))) for tint in tints)
    width = widest(tone, pen, PEN)
    pitch, facts = _planned(wanted, rule, pen, width, dots)
    if facts["dots"] > max_dots:
        raise ValueError(f"the picture takes {facts['dots']:.0f} dots, over the limit of {max_dots}; use a wider pen, or raise max-dots")
    yield Step("plan", 0, 1, facts)
    clock.lap("plan")
    library = libraries.load(glyphs or libraries.nearest(facts["pen_mm"]))
    brush = Brush(library.glyphs, size_by == "tone", jitter, int(rng.integers(2**62)))
    if dots is None or not facts["dots"]:
        found, drawn = yield from _by_pen(wanted, width, pitch, rule, brush)
    else:
        found = yield from by_pitch(wanted, dots, pitch, rule)
        drawn = brush.drawn(found, wanted, pen)
    clock.lap("draw")
    report = _report(tone, tints, wanted, drawn, ground, grey)
    report |= {"dots_asked": dots, "pitch_mm": found.pitch, "g": [rule.more, rule.less], "glyphs": library.name}
    report |= {"iterations": found.rounds, "seconds": clock.laps}
    tone_gives = (pen is not None and dots is not None) or size_by == "published"
    report["warnings"] = _warnings(report, tone, width, tone_gives)
    layers = tuple(Layer(tint.ink, part.marks, tint.label) for tint, part in zip(tints, drawn, strict=True))
    return Sheet(tone.size, (*_ground(ground, grey, tone), *layers), report=report)


@dataclass(frozen=True)
class Tint:
    """One ink of a drawing: its layer's name, the coverage it is to give for each of the picture's, and how much darker it makes paper."""

    label: str
    ink: Ink
    curve: Callable[[Array], Array]
    darkens: float


@dataclass(frozen=True, eq=False)
class Drawn:
    """The dots of one ink, and the paper in mm^2 that they cover together."""

    marks: Marks
    covered: float


@dataclass(frozen=True, eq=False)
class Brush:
    """How pixels become dots: of what glyphs, as large as the tone asks for or of the rule's radii, how far off, by what chance."""

    glyphs: tuple[Glyph, ...]
    by_tone: bool
    jitter: float
    seed: int

    def drawn(self, found: Found, wanted: tuple[Wanted, ...], pen: float | None = None) -> list[Drawn]:
        """The dots of each ink; with a pen their mean diameter is that in mm, without, where tone decides, they cover what is asked."""
        rng = np.random.default_rng(self.seed)
        every = [self._marks(part, found, rng) for part in found.sets]
        if pen is not None:
            factor = pen / (_mean([Drawn(marks, 0.0) for marks in every]) or pen)
            every = [replace(marks, scale=factor * marks.scale) for marks in every]
        if pen is not None or not self.by_tone:
            return [Drawn(marks, measure.ink(marks)) for marks in every]
        return [Drawn(*measure.covering(marks, part.ink, SCALED)) for marks, part in zip(every, wanted, strict=True)]

    def _marks(self, part: Set, found: Found, rng: np.random.Generator) -> Marks:
        """The dots of one ink: at the middles of pixels but for the jitter, and there too where that would take one off the canvas."""
        centre, coverage = part.at
        moved = centre + part.grid.cell * rng.uniform(-self.jitter, self.jitter, centre.shape)
        tone, (low, high) = part.grid.tone, found.rule.radii
        xy, kept = snapped(np.where(tone.holds(moved)[:, None], moved, centre), tone, np.zeros(tone.coverage.shape, bool))
        area = flat(found.rule).areas(coverage) if self.by_tone else np.pi * (low + (high - low) * coverage) ** 2
        return dotted(xy, self.glyphs, 2 * part.grid.cell * np.sqrt(area / np.pi), rng).take(kept)


def _mean(drawn: list[Drawn]) -> float:
    """The mean diameter of all dots, mm; 0 where there are none."""
    scale = np.concatenate([part.marks.scale for part in drawn])
    return float(2 * scale.mean() / np.sqrt(np.pi)) if len(scale) else 0.0


def _tints(ground: str, grey: float) -> list[Tint]:
    """The inks on a ground."""
    if ground == "white":
        return [Tint("", Ink(), lambda c: c, 1.0)]
    if ground == "black":
        return [Tint("white dots", WHITE, lambda c: 1 - c, -1.0)]
    dark = Tint("dots", Ink(), lambda c: np.maximum(0, (c - grey) / (1 - grey)), 1 - grey)
    return [dark, Tint("white dots", WHITE, lambda c: np.maximum(0, (grey - c) / grey), -grey)]


def _ground(ground: str, grey: float, tone: Tone) -> tuple[Layer, ...]:
    """What is filled below the dots."""
    inks = {"black": Ink(), "grey": Ink("paper", (0.0, 0.0, 0.0, grey))}
    assert tone.canvas is not None
    return (Layer(inks[ground], Paths.of_polygons(tone.canvas)[0], "ground"),) if ground in inks else ()


def _planned(
    wanted: tuple[Wanted, ...], rule: Diffusing, pen: float | None, width: float, dots: int | None
) -> tuple[float, dict[str, float]]:
    """The pitch in mm from which the search begins, for dots of a width or their number, and the facts of the plan."""
    tone = wanted[0].tone
    per, area = (sum(parts) for parts in zip(*(part.expected(rule) for part in wanted), strict=True))
    ratio = 2 * float(np.sqrt(area / per / np.pi)) if per else 2.0  # of a mean dot's diameter to the pitch
    pitch = float(np.sqrt(per / dots)) if dots and per else width / ratio
    count = dots if dots and per else round(per / pitch**2)
    seconds = round(1 + 3 * tone.size[0] * tone.size[1] / pitch**2 / RATE, 1)
    return pitch, {"dots": count, "pen_mm": pen or ratio * pitch, "pitch_mm": pitch, "seconds": seconds}


def _by_pen(
    wanted: tuple[Wanted, ...], pen: float, pitch: float, rule: Diffusing, brush: Brush
) -> Generator[Step, None, tuple[Found, list[Drawn]]]:
    """Steps of a search over the pitch for dots of a mean diameter; they go nearly in proportion."""
    for turn in range(TRIES):
        found = diffused(wanted, pitch, rule)
        drawn = brush.drawn(found, wanted)
        yield Step("diffuse", turn + 1, TRIES, {"dots": found.count})
        mean = _mean(drawn)
        if not mean or abs(mean / pen - 1) < OFF:
            break
        pitch = min(pitch * pen / mean, wanted[0].tone.across)
    return replace(found, rounds=turn + 1), drawn


def _report(tone: Tone, tints: list[Tint], wanted: tuple[Wanted, ...], drawn: list[Drawn], ground: str, grey: float) -> dict[str, Any]:
    """What is reported of dots and ink: of each ink the paper that it covers, and of all together how dark the drawing is."""
    every = list(zip(tints, wanted, drawn, strict=True))
    paper = {"white": 0.0, "black": 1.0}.get(ground, grey) * float(shapely.area(tone.canvas))
    asked = paper + sum(tint.darkens * want.ink for tint, want, _ in every)
    placed = paper + sum(tint.darkens * part.covered for tint, _, part in every)
    return {
        "marks": sum(len(part.marks) for part in drawn),
        "pen_mm": _mean(drawn),
        "inks": [
            {"ink": tint.ink.name, "marks": len(part.marks), "asked_mm2": want.ink, "covered_mm2": part.covered}
            for tint, want, part in every
        ],
        "ink_asked_mm2": asked,
        "ink_placed_mm2": placed,
        "coverage_missing": max(0.0, 1 - placed / asked) if asked else 0.0,
    }


def _warnings(report: dict[str, Any], tone: Tone, width: float, tone_gives: bool) -> list[str]:
    """What is to be said of the ink, of the number of dots, and of importance."""
    asked, marks, dots, said = report["ink_asked_mm2"], report["marks"], report["dots_asked"], []
    if not any(part["asked_mm2"] for part in report["inks"]):
        said.append("no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on")
    elif not marks:
        said.append(f"no dots: there is too little ink for one of {width:.4g} mm, or G leaves none; a finer pen or a lower G may draw some")
    elif dots is not None and abs(marks - dots) > MISSED * dots:
        said.append(f"{marks} dots in place of {dots}: the nearest that pixels of {report['pitch_mm']:.3g} mm give; another G may help")
    share = report["ink_placed_mm2"] / asked if asked and marks else 1.0
    if abs(share - 1) > 0.02:
        wish = "a pen or a number alone, sized by tone, keeps the tone" if tone_gives else "a lower G keeps more of the lights"
        said.append(f"{share:.1%} of the ink asked for is placed; {wish}")
    if tone.importance is not None:
        said.append("importance is not heeded: pixels are as fine everywhere; stippling heeds it")
    return said
