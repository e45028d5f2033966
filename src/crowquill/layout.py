"""From a picture file to a Tone in its place: how light becomes ink, and how large it is drawn on which paper.

The two signatures are all the settings that drawings of every style share.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from crowquill import curves, units
from crowquill.knobs import Choice, Flag, Numbers, Range, Text
from crowquill.light import TONES
from crowquill.picture import MAX_PIXELS, shape, window
from crowquill.sheet import Sheet, check_bar, check_fit, turned
from crowquill.tone import FITS, Tone
from crowquill.tracing import WISHES
from crowquill.tracing import canvas as traced

BAR_MARGIN = 4.0  # mm; a check bar needs that much


def lit(
    picture: Path,
    colour: bool = False,
    toned: bool = False,
    *,
    tone: Annotated[
        str, Choice(TONES, "light to ink; auto suits the pen (--inks: linear), linear is exact, grey goes by code value")
    ] = "auto",
    gamma: Annotated[float, Range(0.01, 10, "", "power of coverage; above 1 opens shadows")] = 1.0,
    black_point: Annotated[float | None, Range(0, 1, "", "code value that is full ink")] = None,
    white_point: Annotated[float | None, Range(0, 1, "", "code value that is white paper")] = None,
    invert: Annotated[bool, Flag("swap light and dark")] = False,
    crop: Annotated[tuple[float, ...] | None, Numbers(0, 1, "", "the part to draw: left,top,width,height, shares of 1", 4)] = None,
    local_contrast: Annotated[float, Range(0, 1, "", "stress on detail")] = 0.0,
    canvas: Annotated[str | None, Text("where to draw: alpha, auto, a mask, or an SVG outline laid over the picture", file=True)] = None,
    importance: Annotated[str | None, Text("a picture laid over it, white where it matters most", file=True)] = None,
    tone_curve: Annotated[str | None, Text("a CSV of coverage asked and measured in print, to be made up for", file=True)] = None,
    max_pixels: Annotated[int, Range(1, 10**12, "", "refuse larger pictures")] = MAX_PIXELS,
) -> Tone:
    """The tone of a picture file, of no particular size yet. Raises what Tone.load, tracing.canvas and curves.inverse raise."""
    for name, path in (("canvas", canvas), ("importance", importance), ("tone-curve", tone_curve)):
        if path is not None and not Path(path).suffix and not (name == "canvas" and path in WISHES):
            raise ValueError(f"no {name} {path!r}; give a file with a suffix{', alpha or auto' if name == 'canvas' else ''}")
    curve = None if tone_curve is None else curves.inverse(tone_curve)
    left, top, width, height = crop or (0.0, 0.0, 1.0, 1.0)
    cut = (left, top, width, height) if crop else None
    found = Tone.load(
        picture,
        tone=tone,
        gamma=gamma,
        black_point=black_point,
        white_point=white_point,
        invert=invert,
        crop=cut,
        local_contrast=local_contrast,
        importance=importance,
        colour=colour,
        toned=toned,
        max_pixels=max_pixels,
    )
    found = found if curve is None else found.mapped(curve)
    if canvas is None:
        return found
    return replace(found, canvas=traced(canvas, picture, found.size, crop=cut, max_pixels=max_pixels))


def placed(
    tone: Tone,
    *,
    paper: Annotated[str, Text("paper: a4, a5, letter, or a size such as 120x80mm")] = "a4",
    orientation: Annotated[str, Choice(("auto", "portrait", "landscape"), "how the paper lies")] = "auto",
    margin: Annotated[float, Range(0, 10_000, "mm", "white kept around the drawing")] = 15.0,
    width: Annotated[float | None, Range(0.001, 100_000, "mm", "width of the drawing; all the room when left out")] = None,
    height: Annotated[float | None, Range(0.001, 100_000, "mm", "height of the drawing")] = None,
    fit: Annotated[str, Choice(FITS, "how to fill a room of which both sides are known")] = "contain",
    check_bar: Annotated[bool, Flag("draw a 10 mm bar in the margin")] = False,
) -> tuple[tuple[float, float], Tone]:
    """The paper's sides in mm, and the tone in its size. Raises ValueError for a drawing or a bar that has no room."""
    units.paper(paper)
    art = (width, height) if width and height and fit != "contain" else tone.size
    size = turned(paper, art, orientation)
    room = (size[0] - 2 * margin, size[1] - 2 * margin)
    if min(room) <= 0:
        raise ValueError(f"a margin of {margin:g} mm leaves no room on a paper of {size[0]:g} x {size[1]:g} mm; make it smaller")
    if check_bar:
        _check_bar(size, margin)
    tone = tone.fitted(width, height, fit) if width is not None or height is not None else tone.fitted(*room, fit)
    check_fit(tone.size, size, margin)
    return size, tone


def frame(
    tone: Tone, picture: Path, crop: tuple[float, ...] | None = None, max_pixels: int = MAX_PIXELS
) -> tuple[float, float, float, float]:
    """The part of a picture that its tone shows, once it was cropped and placed: left, top, width and height as shares of the picture."""
    whole, (h, w) = shape(picture, max_pixels), tone.shape
    rows, columns = window(whole, (crop[0], crop[1], crop[2], crop[3]) if crop else None)
    top = rows.start + (rows.stop - rows.start - h) // 2  # fit cover keeps the middle
    left = columns.start + (columns.stop - columns.start - w) // 2
    return left / whole[1], top / whole[0], w / whole[1], h / whole[0]


def on_paper(sheet: Sheet, size: tuple[float, float], margin: float, bar: bool) -> Sheet:
    """The drawing in the middle of its paper, with a check bar in the margin where one is wanted."""
    sheet = sheet.on(size, margin=margin, orientation="as it is")
    return replace(sheet, layers=(*sheet.layers, check_bar(margin, size[1] - margin / 2))) if bar else sheet


def _check_bar(size: tuple[float, float], margin: float) -> None:
    if margin < BAR_MARGIN or margin + 10 > size[0] - BAR_MARGIN / 2:
        raise ValueError(f"a check bar of 10 mm has no room in a margin of {margin:g} mm; make margin or paper larger")
