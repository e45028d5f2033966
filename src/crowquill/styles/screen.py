"""Line screens: families of parallel lines that swell with the tone, alone, one over the other, or what two leave of each other.

Each side of a line is as wide as the ink of its half of the strip between lines, so that coverage is the tone.
Source: G. Meisenbach, patent DE 22244, 1882; R. Ulichney, Digital Halftoning, MIT Press 1987, for waves as thresholds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.kernel import shared_out
from crowquill.knobs import Choice, Numbers, Range
from crowquill.paths import Array, Paths
from crowquill.printable import FAINTEST, GOLDEN, clipped, cut, cut_strokes, dashes, opened, polygons, simplified
from crowquill.screening import Ground, Lattice, Wave, contoured, held, inked, joined, phases, ruling, squares, strips, triangle
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, widest
from crowquill.styles import Work
from crowquill.tone import Tone
from crowquill.units import INCH

EITHER = ("lpi", "pitch")  # of which one is enough: who types one means to do without what a recipe has of the other
RULES: dict[str, Callable[[Array, Array], Array]] = {
    "mean": lambda u, v: (triangle(u) + triangle(v)) / 2,
    "max": lambda u, v: np.maximum(triangle(u), triangle(v)),
    "product": lambda u, v: triangle(u) * triangle(v),
}
DASHED = -1  # in place of a number of passes
BLOCK = 32  # lines worked out together
LAP = 0.005  # mm that lines overlap where the gap between them is closed: where they only met, a device may show a hair of white
SAMPLES = 1 << 18  # of three families of lines or more: three cover what is asked within 0.002, four within 0.004
SHAPED = 300_000  # squares of two families that are rid of necks and slits: half a minute on a machine of 2024
ANGLES = {True: (45.0,), False: (45.0, -45.0)}  # degrees, of one family, and of rules of two
APART = 30.0  # degrees: lines that cross at less beat visibly


def turned(knobs: Mapping[str, Any], by: float) -> dict[str, Any]:
    """The knobs of the same lines turned by so many degrees: for one ink of several."""
    angles = knobs.get("angles") or ANGLES[knobs.get("combine", "union") == "union"]
    return {**knobs, "angles": tuple((angle + by + 90) % 180 - 90 for angle in angles)}


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    lpi: Annotated[float | None, Range(0.25, 1270, "", "lines to the inch (50)")] = None,
    pitch: Annotated[float | None, Range(0.02, 101.6, "mm", "from line to line, in place of lpi")] = None,
    angles: Annotated[
        tuple[float, ...] | None,
        Numbers(-180, 180, "", "degrees in which lines run, clockwise from level (45, and -45 too for rules of two)"),
    ] = None,
    phase: Annotated[tuple[float, ...] | None, Numbers(0, 1, "", "where lines lie, in pitches: one, or one a family (by seed)")] = None,
    combine: Annotated[
        str,
        Choice(("union", *RULES), "of several: all lines; or of two the round dots of a cross screen, crossings alone, light through both"),
    ] = "union",
    min_line: Annotated[
        float, Range(0, 10, "mm", "least width that prints; thinner lines, and necks of up to 300 000 dots, are left out")
    ] = 0.03,
    min_gap: Annotated[float, Range(0, 10, "mm", "least white that prints; narrower gaps are closed, between dots too")] = 0.03,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "strokes of a pen side by side in place of outlines")] = None,
) -> Work:
    """A sheet the tone's size with one layer of outlines in black, cut at the canvas, or of strokes where there is a pen.

    union    every family is drawn, each so much lighter that together they cover the tone
    mean, max, product    where the mean, the greater, or the product of two families' waves is below the level of the tone
    min_line, min_gap     of two families dots and holes are as large as a square of that side at the least, and without necks,
                          slits and slivers where there are SHAPED squares or fewer; a warning says where not. Ink is kept but
                          for them: the report has what is left out and what is closed, mm^2 and share; 0 keeps all
    pen      lines as wide as one pass or more are as many passes as they take; thinner ones are dashes of the same ink, or
             none below a quarter of the pen. Pens wider than the pitch overlap: the report has the excess
    white    stays white, but for half a pixel beside ink; the coverage of 1 is solid. A canvas narrower than the pitch may
             lie between lines
    no ink   an empty sheet and a warning. Raises ValueError for lpi and pitch together, angles that repeat, rules of two for
             other numbers of families, and a ruling too fine for the canvas or for min_line and min_gap
    """
    clock = Clock()
    angles = angles or ANGLES[combine == "union"]
    p = ruling(lpi, pitch, tone, len(angles))
    _check(angles, combine, p, min_line, min_gap, pen)
    nib = None if pen is None else widest(tone, pen, pen)
    shift = phases(phase, len(angles), rng)
    count = len(angles) * float(shapely.area(tone.canvas)) / p**2
    shaped = combine != "union" and count / 2 <= SHAPED and max(min_line, min_gap) > 0
    yield Step("plan", 0, 1, {"pitch_mm": p, "seconds": round(1 + count * (6e-5 if shaped else 6e-6), 1)})
    ground = Ground.of(tone, p / 8)
    least = max(min_line, FAINTEST * min(nib or 0, p))
    if combine == "union":
        levels = _levels(angles, p, shift)
        family = Family(ground, tone, p, levels, len(angles), least, min_gap, nib)
        found: list[tuple[Paths, float, float]] = []
        for rank, (angle, at) in enumerate(zip(angles, shift, strict=True)):
            found.append(family.drawn(np.radians(angle), float(at)))
            yield Step("lines", rank + 1, len(angles))
        art = joined([paths for paths, _, _ in found], closed=nib is None)
        lost, closed = sum(part[1] for part in found), sum(part[2] for part in found)
    else:
        art, lost, closed = _crossed(ground, tone, p, angles, shift, combine, min_line, min_gap, shaped)
        yield Step("dots", 1, 1)
    clock.lap("draw")
    ink = inked(art, angles, p, nib)
    clock.lap("measure")
    report: dict[str, Any] = {
        "marks": len(art),
        "pitch_mm": p,
        "lpi": INCH / p,
        "phase": shift.tolist(),
        "ink_asked_mm2": tone.ink,
        "ink_placed_mm2": ink,
        "coverage_missing": max(0.0, 1 - ink / tone.ink) if tone.ink else 0.0,
        "excess": max(0.0, ink / tone.ink - 1) if tone.ink else 0.0,
        "left_out_mm2": lost,
        "left_out": lost / tone.ink if tone.ink else 0.0,
        "closed_mm2": closed,
        "closed": closed / tone.ink if tone.ink else 0.0,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(report, tone, angles, least, min_gap)
    if combine != "union" and not shaped and max(min_line, min_gap) > 0:
        report["warnings"].append(
            f"necks and gaps between more than {SHAPED} dots are not looked at: some may not print; a coarser ruling would help"
        )
    return Sheet(tone.size, (Layer(Ink(pen=nib), art, "screen"),), report=report)


@dataclass(frozen=True)
class Family:
    """What families of lines of one screen share: what they follow, how wide they are, how many they are, what prints, and the pen."""

    ground: Ground
    tone: Tone
    pitch: float
    levels: Callable[[Array], Array]
    families: int
    min_line: float
    min_gap: float
    pen: float | None

    def drawn(self, angle: float, phase: float) -> tuple[Paths, float, float]:
        """The family that runs at an angle, on the canvas, and the ink in mm^2 that was left out of it, and closed."""
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        reach = shapely.get_coordinates(shapely.envelope(self.tone.canvas)) @ across / self.pitch - phase
        first, last = int(np.floor(reach.min() - 0.5)), int(np.ceil(reach.max() + 0.5))
        blocks = list(range(first, last + 1, BLOCK))
        found: list[Any] = [None] * len(blocks)

        def work(lo: int, hi: int) -> None:
            for b in range(lo, hi):
                lines = np.arange(blocks[b], min(blocks[b] + BLOCK, last + 1))
                found[b] = self._block(np.asarray((lines + phase) * self.pitch, np.float64), along, across)

        shared_out(work, len(blocks), 1)
        return joined([part[0] for part in found], self.pen is None), sum(part[1] for part in found), sum(part[2] for part in found)

    def _block(self, centre: Array, along: Array, across: Array) -> tuple[Paths, float, float]:
        """Some neighbouring lines whose centres lie at these places across, mm."""
        none = Paths.of([], closed=self.pen is None)
        p, far = self.pitch, float(np.hypot(*self.tone.size))
        low, high = (across * place for place in (centre[0] - p / 2, centre[-1] + p / 2))
        band = shapely.intersection(
            self.tone.canvas, shapely.polygons([low - far * along, low + far * along, high + far * along, high - far * along])
        )
        reach = shapely.get_coordinates(band) @ along
        if not len(reach):
            return none, 0.0, 0.0
        step = float(np.clip(min(self.ground.pixel) / 4, p / 16, p / 4))
        first, count = int(np.floor(reach.min() / step)) - 1, int(np.ceil(np.ptp(reach) / step)) + 4
        place = np.asarray((first + np.arange(count)) * step, np.float64)
        centre = np.concatenate([[centre[0] - p], centre, [centre[-1] + p]])  # a line's gaps depend on its neighbours
        start = centre[:, None] * across + place[0] * along
        before, after = (self.levels(strips(self.ground, start, step * along, count, side * p / 2 * across)) * p / 2 for side in (-1, 1))
        gap = np.maximum(0, p - after[:-1] - before[1:])
        width = (before + after)[1:-1]
        drawn = (width >= self.min_line) & (width > 0)
        close = gap < max(self.min_gap, p * 1e-6)
        lap = min(LAP, p / 50)
        before, after = np.where(close[:-1], p / 2 + lap, before[1:-1]), np.where(close[1:], p / 2 + lap, after[1:-1])
        on = held(self.ground, centre[1:-1, None] * across[0] + place * along[0], centre[1:-1, None] * across[1] + place * along[1])
        # of what one family leaves out or closes, the others cover their share
        lost = step * float((width * (1 - width / p) ** (self.families - 1))[on & ~drawn].sum())
        closed = step * float((gap * (gap / p) ** (self.families - 1))[:-1][on & close[:-1]].sum())
        pieces = [(k, piece) for k in range(len(drawn)) for piece in self._pieces(place, centre[k + 1], before[k], after[k], drawn[k])]
        if not pieces:
            return none, lost, closed
        sizes = np.array([len(piece) for _, piece in pieces])
        s, t = np.concatenate([piece for _, piece in pieces]).T
        t = t + np.repeat(centre[1:-1][[k for k, _ in pieces]], sizes)
        xy = s[:, None] * along + t[:, None] * across
        paths = simplified(Paths(xy, np.concatenate([[0], np.cumsum(sizes)]), self.pen is None))
        return (clipped(paths, self.tone.canvas) if self.pen is None else cut_strokes(paths, self.tone.canvas)), lost, closed

    def _pieces(self, place: Array, centre: float, before: Array, after: Array, drawn: npt.NDArray[np.bool_]) -> list[Array]:
        """A line's rings, or its strokes, each (m, 2): places along it, and how far to the side of its centre."""
        if self.pen is None:
            passes = drawn.astype(np.int64)
        else:
            passes = np.where(drawn, np.ceil((before + after) / self.pen - 1e-6), 0).astype(np.int64)
            passes[drawn & (before + after < min(self.pen, self.pitch) * (1 - 1e-6))] = DASHED
        found, step = [], place[1] - place[0]
        for lo, hi in pairwise([0, *(np.flatnonzero(np.diff(passes)) + 1).tolist(), len(passes)]):
            if not passes[lo]:
                continue
            s = np.concatenate([[place[lo] - step / 2], place[lo:hi], [place[hi - 1] + step / 2]])
            b, a = np.pad(before[lo:hi], 1, "edge"), np.pad(after[lo:hi], 1, "edge")
            if self.pen is None:
                found.append(np.stack([np.concatenate([s, s[::-1]]), np.concatenate([-b, a[::-1]])], axis=1))
                continue
            if passes[lo] == DASHED:
                share = (before + after)[lo:hi] / min(self.pen, self.pitch)
                for begin, end in dashes(place[lo:hi], step, share, self.pen, centre / self.pitch * GOLDEN % 1):
                    t = np.concatenate([[begin], s[(s > begin) & (s < end)], [end]])
                    found.append(np.stack([t, np.interp(t, s, (a - b) / 2)], axis=1))
                continue
            inner = np.maximum(0, a + b - self.pen) / 2  # the outer passes run half a pen inside the edges
            for side in np.linspace(-1, 1, passes[lo]) if passes[lo] > 1 else (0.0,):
                found.append(np.stack([s, (a - b) / 2 + side * inner], axis=1))
        return found


def _check(angles: tuple[float, ...], combine: str, pitch: float, min_line: float, min_gap: float, pen: float | None) -> None:
    """Raises ValueError for knobs that do not go together."""
    for one, other in combinations(angles, 2):
        if abs((one - other + 90) % 180 - 90) < 1:
            raise ValueError(f"angles {one:g} and {other:g} repeat: their lines run the same way; take angles 30 degrees apart or more")
    if combine != "union" and len(angles) != 2:
        many = f"are {len(angles)} angles" if len(angles) > 1 else "is one angle"
        raise ValueError(f"combine {combine!r} is of two families, and there {many}; give two, or take union")
    if combine != "union" and pen is not None:
        raise ValueError(f"pen {pen:g} mm draws lines, and combine {combine!r} has none; take union, or --for plotter to hatch the dots")
    if min_line + min_gap > pitch / 2:
        raise ValueError(
            f"min-line {min_line:g} mm and min-gap {min_gap:g} mm are over half the pitch of {pitch:.4g} mm; "
            "take a coarser ruling, or less of them"
        )


def _levels(angles: tuple[float, ...], pitch: float, phase: Array) -> Callable[[Array], Array]:
    """The share of its pitch that a line of each family takes for a coverage, so that all families together cover that.

    Of one and of two families it is known. Three or more may be tied to one another (at 0, 60 and 120 degrees every crossing
    of two lies alike to the third), and are measured.
    """
    k = len(angles)
    if k < 3:
        return lambda d: np.asarray(1 - (1 - d) ** (1 / k))
    turn = np.radians(angles)
    golden = np.array([0.7548776662466927, 0.5698402909980532])  # of the plastic number: places as even as a lattice, tied to none
    x, y = 1000 * pitch * ((np.arange(SAMPLES)[:, None] * golden) % 1).T
    waves = [triangle((y * np.cos(t) - x * np.sin(t)) / pitch - at) for t, at in zip(turn, phase, strict=True)]
    wave = np.sort(np.min(waves, axis=0))
    return lambda d: np.asarray(np.where(d >= 1, 1.0, np.interp(d, np.linspace(0, 1, SAMPLES + 1), np.concatenate([[0], wave]))))


def _crossed(
    ground: Ground,
    tone: Tone,
    pitch: float,
    angles: tuple[float, ...],
    phase: Array,
    combine: str,
    min_line: float,
    min_gap: float,
    shaped: bool,
) -> tuple[Paths, float, float]:
    """The shapes of two families by a rule, and the ink in mm^2 that is left out, and closed; shaped are without necks and slits."""
    lattice, wave = Lattice.of((angles[0], angles[1]), pitch, phase), Wave.of(RULES[combine], pitch, square=combine == "max")
    least = (min_line / pitch) ** 2
    most = (1 - min_gap / pitch) ** 2 if combine == "max" else 1 - (min_gap / pitch) ** 2  # the white of max is lines
    d = ground.coverage
    lost, closed = ground.sum(np.where(d < least, d, 0)), ground.sum(np.where(d >= most, 1 - d, 0))
    if not shaped:
        return joined(list(contoured(ground, tone, lattice, wave, least, most))), lost, closed
    art, lap = [], float(np.abs(lattice.steps).sum()) / len(wave.nodes)
    for square, paths in squares(ground, tone, lattice, wave, least, most, beyond=1):
        asked = cut(polygons(paths), tone.canvas)
        kept, filled = opened(asked, min_line, min_gap)
        asked, kept, filled = (cut(part, shapely.intersection(tone.canvas, square)) for part in (asked, kept, filled))
        before, thick, after = (float(shapely.area(part).sum()) for part in (asked, kept, filled))
        lost, closed = lost + max(0.0, before - thick), closed + max(0.0, after - thick)
        own = shapely.buffer(square, -0.99 * lap)  # of what lies in the lap alone another square has the whole
        art.append(simplified(Paths.of_polygons(filled[shapely.intersects(own, filled)])[0]))
    return joined(art), lost, closed


def _warnings(report: dict[str, Any], tone: Tone, angles: tuple[float, ...], min_line: float, min_gap: float) -> list[str]:
    """What is to be said of the ink, of angles, and of importance."""
    out, closed = report["left_out"], report["closed"]
    said = []
    if not report["ink_asked_mm2"]:
        said.append("no ink: the picture is white where it may be drawn on")
    elif not report["marks"]:
        said.append(f"no lines: they would be thinner than {min_line:g} mm, or none crosses the canvas; a coarser ruling would help")
    else:
        if out > 0.02:
            said.append(f"{out:.1%} of the ink is thinner than {min_line:g} mm, left out; a coarser ruling would help")
        if closed > 0.02:
            said.append(f"{closed:.1%} of the ink is gaps narrower than {min_gap:g} mm, closed: what is nearly black is solid")
        if report["excess"] - closed > 0.02:
            said.append(f"{1 + report['excess']:.2f} times the ink asked for is placed; a finer pen or a coarser ruling would help")
        if report["coverage_missing"] - out > 0.02:
            said.append(f"{report['coverage_missing']:.1%} of the ink asked for is not reached; a finer pen or a coarser ruling would help")
    for one, other in combinations(angles, 2):
        turn = abs((one - other + 90) % 180 - 90)
        if turn < APART - 1e-9:
            beat = report["pitch_mm"] / 2 / np.sin(np.radians(turn / 2))
            said.append(f"angles {one:g} and {other:g} beat every {beat:.2g} mm, a moire; {APART:g} degrees apart or more would help")
    if tone.importance is not None:
        said.append("importance is not heeded: a screen is as fine everywhere; stippling heeds it")
    return said
