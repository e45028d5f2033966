"""Hedcut: lines along a picture's features and dots in rows beside them, larger where it is darker, as portraits are engraved.

Lines are found by a difference of Gaussians across the picture's flow; dots relax to evenness and, by turns, to rows that go along
with the lines. In the darks dots are white on black.
Source: D. Kim, M. Son, Y. Lee, H. Kang, S. Lee, Feature-Guided Image Stippling, Computer Graphics Forum 27(4), 2008; H. Kang, S. Lee,
C. K. Chui, Coherent Line Drawing, NPAR 2007.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
import shapely

from crowquill import aligned, field, measure, raster, trimming
from crowquill.aligned import Laid, Mask
from crowquill.exemplar import darks
from crowquill.field import Rows, Sight
from crowquill.knobs import Range, Text
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock, widest
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots")  # of which one is enough: who types one means to do without what a recipe has of the other
SPAN = aligned.SPAN
LINE = 0.8  # of the pen
GAP = 1 / 3  # of a line
SOFT = 0.25  # of coverage; where a lighter place than that is beside black, dots keep off the black
AROUND = 5  # squares that are beside
RIM = 0.1  # of the way from a white dot's middle to the border of black that stays black
BRIDGE = 0.03  # mm of black between white dots: what a press still prints
ARCS = 32  # pieces to a quarter of a circle around ends and corners of strokes
FLAT = 5e-4  # mm that outlines of white dots stray from their curves
WORK = 70  # iterations of stippling that a drawing takes as long as


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "dot diameter, on average; decides the number of dots (0.3mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of dots, white ones too; decides their diameter")] = None,
    line: Annotated[float | None, Range(0, 50, "mm", "width of lines; 0 draws none (four fifths of the pen)")] = None,
    detail: Annotated[float, Range(0, 1, "", "how faint lines may be: 0 the strongest alone, 1 all")] = 0.5,
    gap: Annotated[float | None, Range(0, 100, "mm", "white between lines and dots where it is lightest (a third of a line)")] = None,
    reach: Annotated[float | None, Range(0, 10_000, "mm", "how far from lines dots lie in rows (20 rows)")] = None,
    black: Annotated[float, Range(0.3, 1, "", "coverage from which on dots are white on black; 1 for none")] = 0.7,
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the pen)", file=True)] = None,
    white: Annotated[float, Range(0, 1, "", "no dots where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size with a layer of black dots, one of black areas with white dots left open in them, and one of lines.

    pen and dots  either gives the other by the tone's ink; both fix both and let the tone give; neither is 0.3 mm, or one
                  as fine as the canvas is narrow. Dots are 0.4 to 1.4 times the pen
    line          strokes of one width, smooth, clear of the canvas's outline; on black there are none, and white dots keep off them
    gap           less of it the darker it is; 0 lets dots touch lines, none lies on one
    rows          are as far apart as dots are on the median, and fade out over the reach; the report has `rows_off`, how far
                  dots are from them on the median, in rows: 0.25 were they anywhere
    ink           of lines counts: dots nearby make up for it, as they do for the white beside lines. Where lines alone are
                  darker than what is asked around them, more is placed than asked, and the report says so
    no lines      dots lie evenly, as stippled ones, and a warning says so; a reach of 0 has them so without one
    no ink        an empty sheet and a warning. Raises ValueError for more than max_dots, for a pen or line wider than the canvas, and
                  for a gap to lines of no width
    """
    clock = Clock()
    if line == 0 and gap:
        raise ValueError(f"gap {gap:g} mm is of no use to lines of no width; leave one out")
    begun = aligned.Setting.of(tone, pen=pen, dots=dots, glyphs=glyphs, white=white, most=max_dots)
    width = LINE * begun.pen if line is None else line
    widest(tone, line, width)
    yield begun.foretold(WORK)
    chance = rng.spawn(3)
    ground = Ground.of(begun, width, GAP * width if gap is None else gap, detail, black, chance[2])
    yield Step("lines", 1, 1, {"lines": len(ground.lines)})
    clock.lap("lines")
    demands = [ground.black] + ([] if ground.region.is_empty else [ground.white])
    counts = _shared_out(begun, demands, dots)
    clock.lap("demand")
    along = aligned.REACH * begun.pitch if reach is None else reach
    parts: list[Laid] = []
    for k, (demand, count) in enumerate(zip(demands, counts, strict=True)):
        plan, room, lost = begun.planned(demand, count), ground.rooms[k], (ground.hidden, _none)[k]
        parts.append((yield from aligned.laid(plan, ground.rows, begun.glyphs, chance[k], clock, reach=along, room=room, lost=lost)))
    marks, pale = parts[0].marks.snapped(), parts[-1].marks if len(parts) > 1 else None
    areas = Paths.of([]) if pale is None else _pierced(ground.region, pale)
    ink = measure.ink(marks) - ground.hidden(marks) + float(areas.areas.sum()) + ground.stroked
    clock.lap("measure")
    report = aligned.told(parts, begun.asked.ink, ink, ground.rows, clock)
    report |= {"white_marks": len(pale or ()), "lines": len(ground.strokes), "line_mm": width, "lines_mm2": ground.stroked}
    report["warnings"] += _warnings(report, ground)
    every = Layer(Ink(), marks), Layer(Ink(), areas, "areas"), Layer(Ink(pen=width or None), ground.strokes, "lines")
    return Sheet(tone.size, tuple(layer for layer in every if len(layer.art)) or every[:1], report=report)


@dataclass(frozen=True, eq=False)
class Ground:
    """What dots are laid on.

    tone        the picture evened out, on squares fine enough for rows
    lines       its features; width of their strokes, 0 where none are drawn, and gap of white beside them where it is lightest, mm
    pen, pitch  of dots, and from row to row, mm
    region      where dots are white on black, shapely; there coverage is `least` or more
    """

    tone: Tone
    lines: Paths
    width: float
    gap: float
    pen: float
    pitch: float
    region: shapely.Geometry
    least: float

    @classmethod
    def of(cls, begun: aligned.Setting, width: float, gap: float, detail: float, black: float, rng: np.random.Generator) -> Ground:
        """The ground for a setting."""
        sight = Sight.of(begun.asked, width or LINE * begun.pen)
        seen = begun.evened(sight)
        region = darks.ground(seen, (black, black), 2 * begun.pen, rng).whole if black < 1 else shapely.MultiPolygon()
        return cls(seen, sight.lines(detail), width, gap, begun.pen, begun.pitch, region, black)

    @cached_property
    def rows(self) -> Rows:
        """Rows beside the lines, the first where a dot has room."""
        far = field.distances(self.lines, self.tone.size, self.tone.coverage.shape)
        return Rows(far, self.pitch, self.width / 2 + self.gap + self.pitch / 2)

    @cached_property
    def within(self) -> Mask:
        """Which squares lie in the region."""
        return raster.covered(darks.rings(self.region), self.tone.coverage.shape, pixel=self.tone.pixel, lines=4) > 0.5

    @cached_property
    def rim(self) -> Array:
        """How far squares are from the region's border, mm."""
        return field.distances(darks.rings(self.region), self.tone.size, self.tone.coverage.shape).mm

    @cached_property
    def strokes(self) -> Paths:
        """The lines as they are drawn: on the canvas, and not on black."""
        if not self.width or not len(self.lines):
            return Paths.of([], closed=False)
        room = shapely.difference(shapely.buffer(self.tone.canvas, -self.width / 2), shapely.buffer(self.region, self.width / 2))
        lines = shapely.multilinestrings([shapely.LineString(line) for line in self.lines])
        parts = shapely.get_parts(trimming.snapped(shapely.intersection(lines, room)))
        return Paths.of([shapely.get_coordinates(part) for part in parts if part.length > self.width], closed=False)

    @cached_property
    def stroked(self) -> float:
        """The area that strokes cover, mm^2."""
        if not len(self.strokes):
            return 0.0
        return float(
            shapely.area(
                shapely.union_all(shapely.buffer([shapely.LineString(line) for line in self.strokes], self.width / 2, quad_segs=ARCS))
            )
        )

    @cached_property
    def rooms(self) -> tuple[Array, Array]:
        """What black dots, and white ones, may reach from each square, mm: black ones into black too where tone rises to it softly."""
        from scipy.ndimage import minimum_filter

        tone, off = self.tone.coverage, self.rows.far.mm - self.width / 2
        soft = np.clip(1 - (self.least - minimum_filter(tone, AROUND)) / SOFT, 0, 1)
        into = np.where(self.within, 0, self.rim) + soft * aligned.radius(tone, self.pen)
        return np.minimum(off - self.gap * (1 - tone), into), np.minimum(off, (1 - RIM) * self.rim)

    @cached_property
    def black(self) -> Tone:
        """What is asked of black dots: nothing in slivers between a line and the white that lies beyond it."""
        from scipy.ndimage import binary_dilation

        tone, room, need = self.tone, self.rooms[0], aligned.radius(self.tone.coverage, self.pen)
        sliver = binary_dilation(tone.coverage == 0, iterations=2) & (room < need + 3 * max(tone.pixel))
        spent = raster.covered(self.strokes, tone.coverage.shape, pixel=tone.pixel, pen=self.width or None) * ~self.within
        outside = tone.holding(np.where(self.within, 0.0, tone.coverage))
        free = ~self.within & ~sliver & (room >= need) & (tone.coverage > 0)
        return aligned.handed_on(outside, spent, free, aligned.NEAR * self.pitch)

    @cached_property
    def white(self) -> Tone:
        """What is asked of white ones."""
        pale = self.tone.holding(np.where(self.within, 1 - self.tone.coverage, 0.0))
        free = self.within & (self.rooms[1] >= aligned.radius(pale.coverage, self.pen))
        return aligned.handed_on(pale, np.zeros_like(pale.coverage), free, aligned.NEAR * self.pitch)

    def hidden(self, marks: Marks) -> float:
        """How many mm^2 of dots lie on black."""
        if self.region.is_empty or not len(marks):
            return 0.0
        near = field.between(self.rim, self.tone.size, marks.xy) < 2 * SPAN[1] * self.pen
        return darks.overlap(self.region, marks.take(near))


def _none(_: Marks) -> float:
    """White dots lie on black and nowhere else: all of them count."""
    return 0.0


def _shared_out(begun: aligned.Setting, demands: Sequence[Tone], dots: int | None) -> list[int | None]:
    """How many dots go to each demand; None leaves it to the pen."""
    if dots is None:
        return [None] * len(demands)
    wanted = [begun.planned(aligned.squared(demand, begun.pen), None).dots for demand in demands]
    first = round(dots * wanted[0] / sum(wanted)) if len(demands) > 1 and any(wanted) else dots
    return [first or None, dots - first or None][: len(demands)]


def _pierced(region: shapely.Geometry, marks: Marks) -> Paths:
    """An area as rings with dots left open in it, those that come too near another so much smaller that black stays between."""
    from scipy.spatial import cKDTree

    outer = darks.rings(region)
    if not len(marks):
        return outer
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    pairs = cKDTree(marks.xy).query_pairs(2 * float(reach.max()) + BRIDGE, output_type="ndarray")
    far = np.hypot(*(marks.xy[pairs[:, 0]] - marks.xy[pairs[:, 1]]).T)
    fit = np.ones(len(marks))
    for side in (0, 1):
        np.minimum.at(fit, pairs[:, side], np.maximum(far - BRIDGE, 0) / reach[pairs].sum(axis=1))
    holes = replace(marks, scale=marks.scale * fit).take(fit > 0).snapped().outlines().flat(FLAT)
    return Paths.of([*outer, *(hole[::-1] for hole in holes)])


def _warnings(report: dict[str, Any], ground: Ground) -> list[str]:
    """What is to be said of lines."""
    asked, placed = report["ink_asked_mm2"], report["ink_placed_mm2"]
    if not asked:
        return []
    if not len(ground.lines):
        return ["no lines were found: dots lie evenly, as stippled ones; more detail or another style would suit the picture better"]
    if placed > 1.02 * asked:
        return [f"lines make the drawing {placed / asked - 1:.1%} darker than asked; finer lines or less detail would help"]
    return []
