"""Ink dots: scanned dots on the black pixels of a halftone, moved about by chance, the same at any resolution.

As grey they merge where they meet, as ink does; as outlines, or cut at a level, they are black.
Source: D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and Example-based Stippling, NPAR 2010, and
Computers & Graphics 35(1), 2011.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import field, halftone, measure, raster, tracing
from crowquill.greydots import Greys
from crowquill.grid import Grid
from crowquill.inkdots import JITTER, PITCH, Dots, Reached, measured, rows_along
from crowquill.knobs import Choice, Numbers, Range, Text
from crowquill.marks import Marks, together
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, Shown, Step
from crowquill.stippling import Clock, snapped
from crowquill.styles import Work
from crowquill.tone import Tone

FORMS = ("black", "grey")  # of dots, that may keep the tone
CURVES = ("measured", *(f"measured-{form}" for form in FORMS), "none")
# candidates 0.25 mm apart, all of them dots, cover 0.8 of the paper, and a ramp to 0.9 asks for more; in the darks tone is kept half
# way between outlines and cut scans, which a twentieth of the paper parts; chance moves 1 %
INK = 0.04
WHITE = Ink("white", (0.0, 0.0, 0.0, 0.0))
UNEVEN = 0.25  # of the jitter: how far chance moves the dots of a row along an edge
SEEN = 0.04  # mm: a pixel in which ink is measured where white lies on black
DARK = 0.97  # coverage: for more, dots of which chance lets some meet would have to lie without end
RATE = 7e4  # dots a second, about, of a machine of 2024
Bits = npt.NDArray[np.bool_]


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pitch: Annotated[float | None, Range(0.02, 25, "mm", "from candidate to candidate (3 pixels of 300 dpi, 0.254mm)")] = None,
    jitter: Annotated[float, Range(0, 25, "mm", "how far chance moves a dot, each way")] = JITTER,
    sizes: Annotated[tuple[float, ...] | None, Numbers(0.03, 25, "mm", "mean diameters of the size classes (0.25,0.3,0.35)")] = None,
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nibs nearest to the sizes)", file=True)] = None,
    curve: Annotated[
        str, Choice(CURVES, "how tone is kept: of dots as the first file shows them, of black or grey ones, or as published")
    ] = "measured",
    edges: Annotated[float | None, Range(0.05, 50, "mm", "draw edges too, as rows of dots, seen through so much blur")] = None,
    invert_mask: Annotated[str | None, Text("picture or SVG laid over this one: white on black where it is light", file=True)] = None,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 5_000_000,
) -> Work:
    """A sheet the tone's size with one layer of black dots, true to size, each near the middle of a candidate that is black.

    candidates   squares of one pitch, the mean of the picture under each made black or white by Ostromoukhov's error diffusion
    dots         a size class, one of its scans, a turn and a shift, each by chance; one that would leave the canvas stays unmoved
    curve        dots overlap: flat patches are drawn and measured, and each tone is asked for so that black dots ("measured-black"),
                 or grey ones, which are lighter ("measured-grey"), give it. "measured" is of black dots but where grey ones are to
                 be written: see suited(). Darker tones than all candidates give are out of reach: the report has `darkest`, and
                 `out_of_reach`, the share of the ink that it cost. "none" asks for the tone itself
    scans        PNG and TIFF show them in grey, or cut at a level, and PDF on demand; SVG keeps outlines alone
    files        a drawing is the same dots at the same places in all, and as dark as the picture where they show the form kept
    edges        dots that just touch along lines where tone changes most, over all others; their ink is not made up for
    invert_mask  there black is filled in, and white dots drawn on it: two layers more. Tone is kept

    No ink gives an empty sheet and a warning. Raises ValueError for a pitch wider than the canvas, a mask without a light
    place, and more dots than max_dots.
    """
    clock = Clock()
    grid, dots, chance = _candidates(tone, pitch), Dots.of(glyphs, sizes), rng.spawn(3)
    inverted = None if invert_mask is None else _region(invert_mask, tone)
    count = round(tone.ink / grid.cell**2)
    if count > max_dots:
        raise ValueError(f"the picture takes {count} dots, over the limit of {max_dots}; use a wider pitch, or raise max-dots")
    facts = {"dots": count, "candidates": grid.columns * grid.rows, "pitch_mm": grid.cell, "seconds": round(2 + count / RATE, 1)}
    yield Step("plan", 0, 1, facts)
    reached = measured(dots, grid.cell, jitter)
    clock.lap("curve")
    yield Step("halftone", 0, 1, {"darkest": float(reached.black[-1])})
    form = "" if curve == "none" else "grey" if curve == "measured-grey" and reached.grey is not None else "black"
    black, lost = _black(grid, inverted, reached, form, chance[0])
    clock.lap("halftone")
    yield Step("draw", 0, 1)
    centres = grid.centres(*np.nonzero(black))
    marks = _kept(dots.at(centres, jitter, chance[1]), centres, tone)
    rows = _rows(tone, dots, edges, max(grid.cell, dots.mean), jitter, chance[2])
    layers = _layers(together([marks, rows]), inverted)
    clock.lap("draw")
    yield Step("measure", 0, 1)
    placed = measure.ink(together([marks, rows])) if inverted is None and form != "grey" else _shown(layers, tone, form == "grey")
    clock.lap("measure")
    report: dict[str, Any] = {
        "marks": len(marks) + len(rows),
        "edge_dots": len(rows),
        "candidates": grid.columns * grid.rows,
        "black": int(black.sum()),
        "pitch_mm": grid.cell,
        "jitter_mm": jitter,
        "diameter_mm": dots.mean,
        "curve": curve,
        "tone_of": form,
        "darkest": {own: float(reached.of(own)[-1]) for own in (FORMS if reached.grey is not None else FORMS[:1])},
        "ink_asked_mm2": tone.ink,
        "ink_placed_mm2": placed,
        "coverage_missing": max(0.0, 1 - placed / tone.ink) if tone.ink else 0.0,
        "out_of_reach": lost,
        "seconds": clock.laps,
    }
    report["warnings"] = _warnings(report, tone, curve)
    return Sheet(tone.size, layers, report=report)


def suited(values: Mapping[str, Any], files: Sequence[Shown]) -> dict[str, Any]:
    """The knobs for these files: a curve left to them is that of dots as the first file shows them, grey or black."""
    form = FORMS[files[0].grey]
    return {**values, "curve": f"measured-{form}"} if values.get("curve") == CURVES[0] else dict(values)


def remarks(report: Mapping[str, Any], files: Sequence[Shown]) -> list[str]:
    """What is to be said of files that show dots of another form than tone was kept of."""
    form = report["tone_of"]
    other = ", ".join(file.name for file in files if file.grey != (form == "grey"))
    if not form or not other or "grey" not in report["darkest"]:
        return []
    there, than, wish = ("black", "darker", FORMS[0]) if form == "grey" else ("grey", "lighter", FORMS[1])
    return [
        f"{other}: dots are {there} there, and all is {than} than the picture, whose tone is kept of {form} ones; "
        f"draw it by itself, or with --curve measured-{wish}"
    ]


def _candidates(tone: Tone, pitch: float | None) -> Grid:
    """The grid of candidates, in the picture's middle; of the usual pitch, or as fine as the canvas is narrow."""
    least = tone.across
    side = min(PITCH, least) if pitch is None else pitch
    if side > least:
        raise ValueError(f"a pitch of {side:.4g} mm is wider than the canvas of {least:.4g} mm; use a finer one")
    return Grid.of(tone, side)


def _region(mask: str, tone: Tone) -> shapely.Geometry:
    """Where a mask is light, in mm, on what is drawn of the picture."""
    light = shapely.intersection(tracing.canvas(mask, mask, tone.size), tone.canvas)
    return shapely.multipolygons([part for part in shapely.get_parts(light) if part.geom_type == "Polygon"])


def _black(grid: Grid, inverted: shapely.Geometry | None, reached: Reached, form: str, rng: np.random.Generator) -> tuple[Bits, float]:
    """Candidates that become dots, where the picture is inverted white ones, and the share of what they are to cover that is too much."""
    coverage, held = grid.asked(0, grid.rows)
    if inverted is not None:
        x, y = grid.centres(*np.indices(held.shape).reshape(2, -1)).T
        coverage = np.where(shapely.contains_xy(inverted, x, y).reshape(held.shape), 1 - coverage, coverage)
    coverage = np.where(held, coverage, 0.0)
    lost = np.maximum(0, coverage - reached.of(form)[-1]).sum() / max(coverage.sum(), 1e-9) if form else 0.0
    black = halftone.halftoned(reached.asked(coverage, form) if form else coverage, rng=rng) & held
    return black, float(lost)


def _kept(marks: Marks, centres: Array, tone: Tone) -> Marks:
    """The marks, those that chance would move out of the canvas back at their centres."""
    xy = np.where(tone.holds(marks.xy)[:, None], marks.xy, centres)
    xy, kept = snapped(xy, tone, np.zeros(tone.coverage.shape, bool))
    return replace(marks, xy=xy).take(kept)


def _rows(tone: Tone, dots: Dots, edges: float | None, apart: float, jitter: float, rng: np.random.Generator) -> Marks:
    """Rows of dots, so many mm apart, along the edges of a tone; none where no edges are wanted."""
    lines = Paths.of([], closed=False) if edges is None else field.edges(tone, edges, least=2 * edges)
    at = rows_along(lines, apart)
    at = at[tone.holds(at)]
    return _kept(dots.at(at, UNEVEN * jitter, rng), at, tone)


def _layers(marks: Marks, inverted: shapely.Geometry | None) -> tuple[Layer, ...]:
    """Black dots; where the picture is inverted, black, and white dots on it."""
    if inverted is None:
        return (Layer(Ink(), marks, "dots"),)
    inside = shapely.contains_xy(inverted, *marks.xy.T)
    ground = Layer(Ink(), Paths.of_polygons(inverted)[0], "ground")
    return ground, Layer(Ink(), marks.take(~inside), "dots"), Layer(WHITE, marks.take(inside), "white dots")


def _shown(layers: tuple[Layer, ...], tone: Tone, grey: bool) -> float:
    """mm^2 of the tone's rectangle that layers of black and white leave black, or would at the light they take, as grey dots."""
    width, height = (max(1, round(side / SEEN)) for side in tone.size)
    pixel = tone.size[0] / width, tone.size[1] / height
    total, band = 0.0, max(1, raster.PIXELS // width)
    arts: list[tuple[Any, float]] = []
    for layer in layers:
        if grey and isinstance(layer.art, Marks):
            arts.append((Greys.of(layer.art, pixel=pixel, width=width), layer.ink.cmyk[3]))
        else:
            arts.append((raster.ready(layer.art, pixel=pixel, width=width, lines=4), layer.ink.cmyk[3]))
    for top in range(0, height, band):
        ink = np.zeros((min(height, top + band) - top, width))
        for art, black in arts:
            cover = art.rows(top, top + len(ink))
            ink += cover * (black - ink)
        total += float(ink.sum())
    return total * pixel[0] * pixel[1]


def _warnings(report: dict[str, Any], tone: Tone, curve: str) -> list[str]:
    """What is to be said of the ink, and of importance."""
    asked, said = report["ink_asked_mm2"], []
    if not asked:
        said.append("no ink: the picture is white where it may be drawn on")
    elif not report["marks"]:
        said.append(f"no dots: there is too little ink for one of {report['diameter_mm']:.4g} mm; smaller sizes would draw it")
    elif report["out_of_reach"] > 0.02:
        reach = report["darkest"][report["tone_of"]]
        finer = report["pitch_mm"] * np.sqrt(np.log1p(-min(reach, 0.999)) / np.log1p(-min(tone.coverage.max(), DARK)))
        said.append(
            f"{report['out_of_reach']:.1%} of the ink asked for is out of reach: all candidates together take {reach:.2f} of the paper's "
            f"light; a finer pitch would help, such as {finer:.2g}mm"
        )
    if curve == "measured-grey" and report["tone_of"] == "black":
        said.append("this library has no scans: tone is kept of black dots")
    if tone.importance is not None:
        said.append("importance is not heeded: dots are as large everywhere; stippling heeds it")
    return said
