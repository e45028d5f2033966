"""What comes over a drawing and how it prints: lines and a scale bar with white around them, ink gain, and the ink itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from dataclasses import field as made
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import field, inks, measure, trimming, vector
from crowquill.knobs import Range, Text
from crowquill.marks import Marks, together
from crowquill.paths import Paths
from crowquill.scale import Bar, bar, of_pixel, parsed
from crowquill.sheet import Bitmap, Ink, Layer, Sheet
from crowquill.tone import Tone

EDGES = "edges"  # in place of a file: lines are found in the picture
DETAIL = 0.5
LINE = 0.25  # mm, where nothing is said of a width
STEP = 0.01  # mm, to which widths are rounded: each has a layer
FINE = 2e-4  # of a mark, that its flattened outline may
ARCS = 32  # pieces to a quarter of a circle around ends and corners: within 0.0003 of its radius
SLACK = 1e-3  # mm: what ARCS and whole micrometres may take of a gap
INSET = 2.0  # mm from the drawing's edges to its scale bar
SURROUND = 0.8  # mm of white around it
SQUARE = 0.02  # by which the sides of a pixel may differ: small pictures are cut to whole ones
FRAME = (0.0, 0.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Finish:
    """What is drawn over a drawing, and how it is printed.

    lines  lines by their width in mm, shapely (Multi)LineStrings in whole micrometres on the drawing
    gap    mm of white to either side of them
    gain   mm by which every printed edge grows
    ink    the drawing's own
    """

    lines: Mapping[float, shapely.Geometry] = made(default_factory=dict)
    bar: Bar | None = None
    gap: float = 0.0
    gain: float = 0.0
    ink: Ink = made(default_factory=Ink)

    def freed(self, tone: Tone, pen: float = 0.0) -> Tone:
        """The tone without what must stay white for lines and bar by dots or strokes of this width in mm, on their middles.

        Raises ValueError where nothing is left, and for a pen that the gain makes nothing of.
        """
        if pen:
            trimming.left(pen, self.gain)
        if self._white(0.0).is_empty:
            return tone
        rest = shapely.difference(tone.canvas, self._white(pen / 2 + SLACK))
        if not shapely.area(rest) > 0:
            raise ValueError("lines, their gap and the scale bar leave no room to draw in; draw larger, or make them smaller")
        parts = [part for part in shapely.get_parts(rest) if part.geom_type == "Polygon"]
        return replace(tone, canvas=shapely.multipolygons(parts))

    def drawn(self, sheet: Sheet) -> Sheet:
        """The sheet in its ink without what reaches into the white, with lines and bar over it, and reduced by the gain.

        The report's "finish" has what was left out and cut off, and the smallest mark. Raises ValueError for marks and strokes
        that the gain makes nothing of, and for pixels, which cannot be cut or made finer.
        """
        told: dict[str, Any] = {}
        said: list[str] = []
        layers = [replace(layer, ink=_inked(layer.ink, self.ink)) for layer in sheet.layers]
        own = [layer.fill is not None or layer.ink == old.ink for layer, old in zip(layers, sheet.layers, strict=True)]
        if self.ink != Ink() and all(own):
            said.append(f"ink {self.ink.name} is not used: the drawing has inks of its own")
        if not self._white(0.0).is_empty:
            layers, told, more = self._freed(layers, sheet.report)
            said += more
        layers += self._over()
        if self.gain:
            least = [size for layer in layers for size in trimming.sizes(layer)]
            finer = [trimming.finer(layer, self.gain) for layer in layers]
            layers, gone = [layer for layer, _ in finer], sum(lost for _, lost in finer)
            facts = {
                "ink_gain_mm": self.gain,
                "smallest_mm": trimming.left(min(least), self.gain) if least else None,
                "areas_left_out": gone,
            }
            told["finish"] = told.get("finish", {}) | facts
            said += [f"{gone} areas are finer than twice the ink gain and are left out"] if gone else []
        if self.bar:
            told["finish"] = told.get("finish", {}) | {"scale_bar": self.bar.label}
        if not told and not said and self.ink == Ink():
            return sheet
        report = {**sheet.report, **told, "warnings": [*sheet.report.get("warnings", []), *said]}
        return replace(sheet, layers=tuple(layers), report=report)

    def _white(self, more: float) -> shapely.Geometry:
        """Where nothing may lie that reaches `more` mm from its middle."""
        areas = [shapely.buffer(lines, width / 2 + self.gap + more, quad_segs=ARCS) for width, lines in self.lines.items()]
        if self.bar:
            areas.append(shapely.buffer(shapely.box(*self.bar.box), SURROUND + more, quad_segs=ARCS))
        return shapely.union_all(areas)

    def _freed(self, layers: list[Layer], report: Mapping[str, Any]) -> tuple[list[Layer], dict[str, Any], list[str]]:
        """The layers with white around lines and bar, what changes in the report, and what is to be said."""
        out, length, area = 0, 0.0, 0.0
        freed = []
        for layer in layers:
            art, pen = layer.art, layer.ink.pen
            if isinstance(art, Bitmap):
                raise ValueError("pixels of a device keep no white around lines; leave out outline and scale-bar")
            if isinstance(art, Marks):
                stay = ~self._reached(art, pen or 0.0)
                out += int((~stay).sum())
                freed.append(replace(layer, art=art if stay.all() else art.take(stay)))
            elif isinstance(art, Paths):
                layer, long, wide = trimming.cut(layer, self._white((pen or 0.0) / 2 + SLACK))
                length, area = length + long, area + wide
                freed.append(layer)
            else:
                freed.append(layer)
        told: dict[str, Any] = {"finish": {"marks_left_out": out, "cut_mm": length, "cut_mm2": area}}
        if "marks" in report:
            told["marks"] = report["marks"] + sum(len(new.art) - len(old.art) for new, old in zip(freed, layers, strict=True))
        dots = [layer.art for layer in freed if isinstance(layer.art, Marks)]
        if "ink_placed_mm2" in report and (out or area):
            ink = measure.ink(together(dots)) if out and len(dots) == len(freed) else max(0.0, report["ink_placed_mm2"] - area)
            asked = report.get("ink_asked_mm2", 0.0)
            told |= {"ink_placed_mm2": ink, "coverage_missing": max(0.0, 1 - ink / asked) if asked else 0.0}
        said = [f"{out} marks that reached into the white around lines are left out"] if out else []
        return freed, told, said

    def _reached(self, marks: Marks, pen: float) -> npt.NDArray[np.bool_]:
        """Which marks come nearer to lines or bar than they may, by their outlines."""
        near = np.zeros(len(marks), bool)
        reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale if len(marks) else np.empty(0)
        for tree, clear in self._trees:
            far = clear + pen / 2
            close = np.unique(tree.query(shapely.points(marks.xy), "dwithin", far + reach)[0]) if len(marks) else np.empty(0, np.int64)
            close = close[~near[close]]
            if len(close):
                shapes = marks.take(close).outlines().flat(FINE * float(marks.scale.max())).polygons()
                near[close[np.unique(tree.query(shapes, "dwithin", far)[0])]] = True
        return near

    @cached_property
    def _trees(self) -> list[tuple[shapely.STRtree, float]]:
        """The pieces of lines, and the bar's box, with the distance in mm that edges keep from each."""
        found = []
        for width, lines in self.lines.items():
            xy, line = shapely.get_coordinates(shapely.get_parts(lines), return_index=True)
            on = np.flatnonzero(line[1:] == line[:-1])
            found.append((shapely.STRtree(shapely.linestrings(np.stack([xy[on], xy[on + 1]], axis=1))), width / 2 + self.gap))
        if self.bar:
            found.append((shapely.STRtree([shapely.box(*self.bar.box)]), SURROUND))
        return found

    def _over(self) -> list[Layer]:
        """The layers of lines, the finest first, and of the bar."""
        found = []
        for width, lines in sorted(self.lines.items()):
            name = "outline" if len(self.lines) == 1 else f"outline {width:g} mm"
            paths = Paths.of([shapely.get_coordinates(line) for line in shapely.get_parts(lines)], closed=False)
            found.append(Layer(Ink("outline", pen=width), paths, name))
        return [*found, *(self.bar.layers if self.bar else ())]


def finish(
    tone: Tone,
    frame: tuple[float, float, float, float] = FRAME,
    *,
    outline: Annotated[str | None, Text("lines to draw over it: edges, found in it, or an SVG laid over the picture", file=True)] = None,
    outline_width: Annotated[float | None, Range(STEP, 50, "mm", "width of its lines (their own, or 0.25mm)")] = None,
    outline_detail: Annotated[float | None, Range(0, 1, "", "how faint edges may be: 0 the strongest alone, 1 all (0.5)")] = None,
    outline_gap: Annotated[float, Range(0, 100, "mm", "white to either side of its lines")] = 0.15,
    scale_bar: Annotated[str | None, Text("a scale bar: a length of the specimen such as 500um, or auto for a round one")] = None,
    scale: Annotated[str | None, Text("how large it is drawn: 1 mm = 250 um, the drawing's length first, or 1:50")] = None,
    pixel_size: Annotated[str | None, Text("the same, as the length of a pixel of the picture on the specimen: 1.3um")] = None,
    ink_gain: Annotated[float, Range(0, 1, "mm", "how far every printed edge grows; sizes are reduced by it")] = 0.0,
    ink: Annotated[str, Text("black, cyan, magenta, yellow, a mix as NAME=c,m,y,k of 0 to 1 or NAME=#rrggbb; or spot:NAME=...")] = "black",
) -> Finish:
    """What is to be drawn over a drawing of this tone, and how it is to print.

    frame          the part of the picture that the tone shows: left, top, width, height as shares
    outline        strokes keep their own width, in proportion; shapes that are filled only are drawn as their outline. All is
                   black. What lies outside the frame is cut off, and so is what crosses the scale bar. "edges" are the lines that
                   `field.lines` finds on the tone's canvas for a pen of the width
    scale_bar      lies in the lower right corner, 2 mm from the edges and 0.8 mm clear of all else
    ink            takes the place of plain black; inks that a style chose by itself stay

    Raises ValueError for a file or a picture without lines, and for what cannot be drawn or means nothing.
    """
    _check(outline, outline_width, outline_detail, scale_bar, scale, pixel_size)
    bars = None
    if scale_bar is not None:
        across, down = tone.pixel
        if abs(across / down - 1) > SQUARE:
            raise ValueError("a drawing stretched one way has no one scale; leave out scale-bar, or fit stretch")
        ratio = parsed(scale) if scale is not None else of_pixel(str(pixel_size), across)
        corner = tone.size[0] - INSET, tone.size[1] - INSET
        bars = bar(ratio, max(tone.size[0] - 2 * INSET, 1e-9), scale_bar, at=corner, ink=Ink("scale bar"))
        if bars.box[1] < INSET:
            high = tone.size[1] - bars.box[1] + INSET
            raise ValueError(f"a scale bar takes {high:.3g} mm of height, and the drawing has {tone.size[1]:.3g}; draw larger")
    if outline == EDGES:
        lines = _found(tone, outline_width or LINE, DETAIL if outline_detail is None else outline_detail)
    else:
        lines = {} if outline is None else _laid(vector.contents(Path(outline)), outline, tone.size, frame, outline_width)
    if bars:
        box = shapely.box(*bars.box)
        cut = {width: shapely.difference(part, shapely.buffer(box, SURROUND + width / 2)) for width, part in lines.items()}
        lines = {width: trimming.snapped(part) for width, part in cut.items() if not trimming.snapped(part).is_empty}
    return Finish(lines, bars, outline_gap, ink_gain, inks.one(ink))


def _check(outline: str | None, width: float | None, detail: float | None, bars: str | None, scale: str | None, pixel: str | None) -> None:
    """Raises ValueError for settings that say nothing by themselves, or one thing twice."""
    if outline not in (None, EDGES) and Path(outline).suffix.lower() != ".svg":
        raise ValueError(f"no outline {outline!r}; give an SVG file, or {EDGES}")
    if detail is not None and outline != EDGES:
        raise ValueError(f"outline-detail is for edges that are found; add outline {EDGES}, or leave it out")
    if width is not None and outline is None:
        raise ValueError("outline-width is given for no outline; add outline, or leave it out")
    if bars is None and (scale is not None or pixel is not None):
        raise ValueError(f"{'scale' if pixel is None else 'pixel-size'} is given for no scale bar; add scale-bar auto, or leave it out")
    if bars is not None and (scale is None) == (pixel is None):
        raise ValueError(f"a scale bar takes one of scale and pixel-size, and {'both are' if scale else 'none is'} given; give one")


def _found(tone: Tone, width: float, detail: float) -> dict[float, shapely.Geometry]:
    """The lines of a tone by their width in mm, those on its canvas."""
    width = max(STEP, round(round(width / STEP) * STEP, 3))
    lines = shapely.MultiLineString([shapely.LineString(line) for line in field.lines(tone, width, detail=detail)])
    kept = trimming.snapped(shapely.intersection(lines, shapely.buffer(tone.canvas, -width / 2)))
    if kept.is_empty:
        raise ValueError("no edges are found in the picture; give more outline-detail, a finer outline-width, or an SVG file of lines")
    return {width: kept}


def _laid(
    data: bytes, name: str, size: tuple[float, float], frame: tuple[float, float, float, float], fixed: float | None
) -> dict[float, shapely.Geometry]:
    """The lines of an SVG file by their width in mm, its page laid over the whole picture, of which a drawing shows the frame."""
    page, found = vector.shapes(data, name)
    if min(page) <= 0:
        raise ValueError(f"{name}: its page has no size; give it the shape of the picture")
    stretch = np.array(size) / (np.array(frame[2:]) * page)
    corner = np.array(frame[:2]) * page
    lines: dict[float, list[shapely.Geometry]] = {}
    for paths, shape in found:
        stroked = shape.stroke is not None and shape.stroke.value is not None and float(shape.stroke_width or 0) > 0
        if not stroked and (shape.fill is None or shape.fill.value is None):
            continue  # nobody sees it
        own = float(shape.stroke_width) * vector.PX * float(np.sqrt(stretch.prod())) if stroked else LINE
        width = max(STEP, round((fixed or own) / STEP) * STEP)
        flat = replace(paths, xy=(paths.xy - corner) * stretch).flat(trimming.FLAT)
        rings = [np.concatenate([line, line[:1]]) if paths.closed else line for line in flat]
        lines.setdefault(round(width, 3), []).extend(shapely.linestrings(ring) for ring in rings if len(ring) > 1)
    room = shapely.box(0, 0, *size)
    kept = {width: trimming.snapped(shapely.union_all(shapely.intersection(several, room))) for width, several in lines.items()}
    kept = {width: several for width, several in kept.items() if not several.is_empty}
    if not kept:
        raise ValueError(f"{name}: has no line on the picture{'' if frame == FRAME else ' that the crop leaves'}; draw strokes or outlines")
    return kept


def _inked(own: Ink, ink: Ink) -> Ink:
    """The ink for what is plain black; others stay."""
    return replace(ink, pen=own.pen, overprint=own.overprint) if replace(own, pen=None, overprint=False) == Ink() else own
