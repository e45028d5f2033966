"""Isophote: dots in rows along lines of equal lightness and edges, larger where it is darker, so that they model what is round.

Light is cut into levels; their borders, the picture's edges and, where there is a map of depth, its contours lead dots that relax to
evenness and, by turns, to rows at even distances from them.
Source: S. Kim, I. Woo, R. Maciejewski, D. S. Ebert, Automated Hedcut Illustration Using Isophotes, Smart Graphics 2010.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np

from crowquill import aligned, field, light, measure
from crowquill.field import Rows, Sight
from crowquill.knobs import Range, Text
from crowquill.paths import Paths
from crowquill.picture import MAX_PIXELS, shape
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import Clock
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots")  # of which one is enough: who types one means to do without what a recipe has of the other
SPAN = aligned.SPAN
LINE = 0.8  # of the pen: the width of a stroke that edges are found for
SMOOTH = 1.0  # of a pitch: the blur through which isophotes are seen
SHORT = 8.0  # pitches; shorter lines lead no row
SQUARE = 0.02  # by which a map's shape may differ from the drawing's
WORK = 45  # iterations of stippling that a drawing takes as long as


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "dot diameter, on average; decides the number of dots (0.3mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of dots; decides their diameter")] = None,
    levels: Annotated[int, Range(1, 64, "", "steps that light is cut into; their borders lead the dots, 1 has none")] = 6,
    weight: Annotated[float, Range(0.01, 1, "", "how far isophotes lead dots, over edges")] = 0.5,
    detail: Annotated[float, Range(0, 1, "", "how faint edges may be: 0 the strongest alone, 1 all")] = 0.5,
    depth: Annotated[str | None, Text("a picture of depth laid over it, white for near; its contours lead dots too", file=True)] = None,
    reach: Annotated[float | None, Range(0, 10_000, "mm", "how far from lines dots lie in rows (20 rows)")] = None,
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the pen)", file=True)] = None,
    white: Annotated[float, Range(0, 1, "", "no dots where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size with one layer of black dots, 0.4 to 1.4 times the pen.

    pen and dots  either gives the other by the tone's ink; both fix both and let the tone give; neither is 0.3 mm, or one
                  as fine as the canvas is narrow
    levels        of light, evenly from black to white: so many less one isophotes, seen through a blur of a row
    weight        a place follows the line whose distance over its weight is least, an edge's being 1. Rows are the lines
                  themselves and all that lie any number of rows from the one that a place follows; the report has `rows_off`, how
                  far dots are from them on the median, in rows: 0.25 were they anywhere
    depth         contours of so many levels and edges of the map count as those of the picture do. It has the drawing's shape: a
                  picture that is cropped takes a map that is cropped alike
    ink           the union of the dots covers what is asked up to 0.97
    no lines      dots lie evenly, as stippled ones, and a warning says so; a reach of 0 has them so without one
    no ink        an empty sheet and a warning. Raises ValueError for more than max_dots, for a pen wider than the canvas, and for a map
                  of another shape
    """
    clock = Clock()
    near = None if depth is None else _depth(depth, tone)
    begun = aligned.Setting.of(tone, pen=pen, dots=dots, glyphs=glyphs, white=white, most=max_dots)
    yield begun.foretold(WORK)
    sight, pitch = Sight.of(begun.asked, LINE * begun.pen), begun.pitch
    seen = begun.evened(sight)
    edges, isophotes = Paths.of([], closed=False), Paths.of([], closed=False)
    for picture in (sight.smoothed(), near):
        if picture is not None:
            low, high = field.contrast(detail)
            edges = _together(edges, field.edges(picture, sight.sigma, low=low, high=high, least=SHORT * pitch))
            isophotes = _together(isophotes, *field.isophotes(picture, levels, SMOOTH * pitch, least=SHORT * pitch))
    sources = [(lines, part) for lines, part in ((edges, 1.0), (isophotes, weight)) if len(lines)] or [(edges, 1.0)]
    rows = Rows(field.weighed([(field.distances(lines, seen.size, seen.coverage.shape), part) for lines, part in sources]), pitch)
    yield Step("lines", 1, 1, {"edges": len(edges), "isophotes": len(isophotes)})
    clock.lap("lines")
    along = aligned.REACH * pitch if reach is None else reach
    part = yield from aligned.laid(begun.planned(seen, dots), rows, begun.glyphs, rng, clock, reach=along)
    marks = part.marks.snapped()
    ink = measure.ink(marks)
    clock.lap("measure")
    report = {**aligned.told([part], begun.asked.ink, ink, rows, clock), "edges": len(edges), "isophotes": len(isophotes)}
    if begun.asked.ink and not len(edges) + len(isophotes):
        report["warnings"].append("no edges or isophotes were found: dots lie evenly, as stippled ones; more detail or levels would help")
    return Sheet(tone.size, (Layer(Ink(), marks),), report=report)


def _depth(file: str, tone: Tone) -> Tone:
    """The map of depth in a file as a tone on the pixels of the drawing's, white for 1."""
    if not Path(file).suffix:
        raise ValueError(f"no depth {file!r}; give a picture file with a suffix")
    (h, w), (width, height), grid = shape(file, MAX_PIXELS), tone.size, tone.coverage.shape
    if abs(w / h / (width / height) - 1) > SQUARE:
        raise ValueError(f"{file}: is {w} x {h} pixels, and the drawing {width:.4g} x {height:.4g} mm; give a map of its shape")
    values, _ = light.wished(file, grid, (slice(0, grid[0]), slice(0, grid[1])), MAX_PIXELS)
    return Tone(values, tone.size)


def _together(*several: Paths) -> Paths:
    """All lines of several."""
    return Paths.of([line for paths in several for line in paths], closed=False)
