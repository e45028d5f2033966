"""Rules for what is drawn, whatever file it is in: dots, lines, gaps, words, ink, bitmaps, the page's edges."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crowquill.paths import Array
from crowquill.preflight.drawing import EVERY, Colour, Drawing, same_paper
from crowquill.preflight.marks import measured
from crowquill.preflight.rules import ERROR, INFORMATION, WARNING, Hit, Limits, rule
from crowquill.units import PAPERS

SMALL = 12 * 25.4 / 72  # mm: text that is kept to one ink; a plate a tenth of a millimetre off shows in it
THIN = 0.5  # mm: lines that are
ON_EDGE = 0.05  # mm: art so near to the trim touches it
SAFE = 5.0  # mm inside the trim of a paper, which a knife may miss
SLACK = 1e-6  # mm, of sums of floats: a dot of 0.1 mm passes at 0.1 mm
READ = 0.002  # mm: outlines are measured so finely; a dot of a hair less than the limit is no fault


def _smaller(sizes: Array, at: Array, least: float, what: str, drawing: Drawing) -> Iterator[Hit]:
    """An error for what is below half the limit, a warning for what is below it, each with how many and the smallest."""
    half, whole = (max(limit - READ, SLACK) for limit in (least / 2, least))  # a hairline of 0 is below any limit
    for below, high, severity in ((sizes < half, least / 2, ERROR), ((sizes >= half) & (sizes < whole), least, WARNING)):
        found = np.flatnonzero(below)
        if len(found):
            worst = found[np.argmin(sizes[found])]
            place = f"{drawing.where}, {at[worst, 0]:.2f} {at[worst, 1]:.2f} mm"
            many = f"{len(found)} of {len(sizes)} {what}"
            yield Hit(place, f"{many} below {high:.3g} mm, the smallest {sizes[worst]:.4f} mm", round(float(sizes[worst]), 4), severity)


@rule("min-dot", WARNING, "drawing")
def dots(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """No dot is smaller than --min-dot; below half of it, it is an error."""
    found = measured(drawing.printed, 2 * limits.min_gap)
    yield from _smaller(found.dots, found.dots_at, limits.min_dot, "dots", drawing)


@rule("min-line", WARNING, "drawing")
def lines(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """No line, drawn or filled, is thinner than --min-line; below half of it, or as thin as a device can, it is an error."""
    found = measured(drawing.printed, 2 * limits.min_gap)
    yield from _smaller(found.lines, found.lines_at, limits.min_line, "lines", drawing)


@rule("min-gap", WARNING, "drawing")
def gaps(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """No white between marks is narrower than --min-gap, where ink runs together."""
    found = measured(drawing.printed, 2 * limits.min_gap)
    narrow = np.flatnonzero(found.gaps < limits.min_gap - READ)
    if found.share < 1:
        yield Hit(drawing.where, f"gaps were measured about a sample of {found.share:.0%} of the marks", round(found.share, 4), INFORMATION)
    if len(narrow):
        half = int((found.gaps < limits.min_gap / 2).sum())
        worst = narrow[np.argmin(found.gaps[narrow])]
        x, y = found.gaps_at[worst]
        yield Hit(
            f"{drawing.where}, {x:.2f} {y:.2f} mm",
            f"{len(narrow)} gaps below {limits.min_gap:g} mm, {half} of them below half of it, the narrowest {found.gaps[worst]:.4f} mm",
            round(float(found.gaps[worst]), 4),
        )


@rule("half-size", WARNING, "drawing")
def half_size(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """Printed at half its size, the drawing keeps its dots, lines and gaps above the limits."""
    found = measured(drawing.printed, 2 * limits.min_gap)
    sorts = (("dots", found.dots, limits.min_dot), ("lines", found.lines, limits.min_line), ("gaps", found.gaps, limits.min_gap))
    lost = {name: int(((sizes >= least - READ) & (sizes / 2 < least - READ)).sum()) for name, sizes, least in sorts}
    if any(lost.values()):
        said = ", ".join(f"{count} {name}" for name, count in lost.items() if count)
        yield Hit(drawing.where, f"at half size {said} more fall below the limits", lost)


@rule("min-text", WARNING, "drawing")
def text(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """No text is set smaller than --min-text."""
    small = [words for words in drawing.words if words.size < limits.min_text - SLACK]
    if small:
        least = min(small, key=lambda words: words.size)
        count = sum(words.count for words in small)
        message = f"{count} letters below {limits.min_text:.3g} mm, the smallest {least.size:.3g} mm in {least.font}"
        yield Hit(drawing.where, message, round(least.size, 3))


def used(drawing: Drawing) -> list[Colour]:
    """The colours that art and words are in, each once, in the order of the art."""
    art = drawing.art
    shown = np.unique(art.thing)
    which = np.unique(np.concatenate([art.fill[shown], art.stroke[shown]]))
    found = [art.colours[k] for k in which if k >= 0] + [words.colour for words in drawing.words]
    return list(dict.fromkeys(found))


@rule("inks", INFORMATION, "drawing")
def inks(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """The inks that are really used."""
    found = used(drawing)
    names = dict.fromkeys(name for one in found for name, _ in one.shares if one.space != EVERY)
    lights = dict.fromkeys(one.space for one in found if one.light is not None and not one.white)
    said = [*names, *(f"whatever {space} is turned into" for space in lights)]
    if said:
        yield Hit(drawing.where, f"inks used: {', '.join(said)}", list(names))


@rule("rgb-black", WARNING, "drawing")
def rgb_black(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """Black is given as ink, and not as the absence of red, green and blue, of which printers make four inks."""
    found = sorted({one.space for one in used(drawing) if one.light is not None and one.black})
    if found and not drawing.screen:
        yield Hit(drawing.where, f"black in {', '.join(found)} becomes four inks; give it as DeviceGray 0", found)


def _rich(colour: Colour) -> bool:
    """Whether a colour is black of several inks; that of crop marks is meant to be."""
    return colour.black and colour.light is None and colour.plates > 1 and colour.space != EVERY


@rule("black-lines", WARNING, "drawing")
def black_lines(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """Small text and thin lines in black are of one ink."""
    art, rich = drawing.art, np.array([_rich(one) for one in drawing.art.colours] + [False])
    if rich.any():
        length, area = art.lengths, np.abs(art.area)
        width = np.where(
            rich[art.stroke[art.thing]], art.pen[art.thing], 2 * np.divide(area, length, out=np.zeros(len(art)), where=length > 0)
        )
        thin = (rich[art.stroke[art.thing]] | rich[art.fill[art.thing]]) & (width < THIN)
        if thin.any():
            yield Hit(drawing.where, f"{int(thin.sum())} lines or marks below {THIN:g} mm are black of several inks", int(thin.sum()))
    count = sum(words.count for words in drawing.words if words.size < SMALL and _rich(words.colour))
    if count:
        yield Hit(drawing.where, f"{count} letters below 12 pt are black of several inks", count)


@rule("white-overprint", ERROR, "drawing")
def white_overprint(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """Nothing white overprints: it prints nothing, and what should be white is not."""
    art, white = drawing.art, np.array([one.white for one in drawing.art.colours] + [False])
    over = (white[art.fill] & art.over[:, 0]) | (white[art.stroke] & art.over[:, 1])
    count = int(np.asarray(over)[np.unique(art.thing)].sum())
    if count:
        yield Hit(drawing.where, f"{count} things are white and overprint", count)


@rule("total-ink", ERROR, "drawing")
def total_ink(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """No colour has more ink than --max-ink; of colours that overprint, the sum with the strongest below."""
    art, found = drawing.art, [one for one in used(drawing) if one.light is None and one.space != EVERY]
    shown = np.unique(art.thing)
    sums = {one: sum(share for _, share in one.shares) for one in found}
    most = max([*sums.values(), drawing.ink], default=0.0)
    message = "a colour"
    lying = np.concatenate([art.fill[shown][art.over[shown, 0]], art.stroke[shown][art.over[shown, 1]]])
    for own in [art.colours[k] for k in np.unique(lying) if k >= 0 and art.colours[k] in sums]:
        names = {name for name, _ in own.shares}
        under = max((sum(share for name, share in one.shares if name not in names) for one in found if one != own), default=0.0)
        if sums[own] + under > most + SLACK:
            most, message = sums[own] + under, "a colour with what it overprints at worst"
    if most * 100 > limits.max_ink + 0.5:
        yield Hit(drawing.where, f"{message} has {most:.0%} of ink, over {limits.max_ink:g} %", round(100 * most, 1))


def _sides(drawing: Drawing) -> Array:
    """Left, top, right, bottom in mm of everything drawn with ink: outlines with their pens, words and bitmaps, (n, 4)."""
    art, inked = drawing.art, np.array([not one.white for one in drawing.art.colours] + [False])
    pen = np.where(inked[art.stroke], art.pen / 2, 0)[art.thing][:, None]
    shown = (inked[art.stroke] | inked[art.fill])[art.thing]
    return np.concatenate([(art.boxes + pen * (-1, -1, 1, 1))[shown], np.array(drawing.extents).reshape(-1, 4)])


@rule("safe-zone", WARNING, "drawing")
def safe_zone(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """Art that does not bleed stays --safe inside the trim, which a knife may miss; a figure is put on a page, and not cut."""
    sides, (left, top, right, bottom) = _sides(drawing), drawing.trim
    bleeds = max(abs(a - b) for a, b in zip(drawing.bleed, drawing.trim, strict=True)) > ON_EDGE
    cut = bleeds or any(same_paper((right - left, bottom - top), paper) for paper in PAPERS.values())
    safe = limits.safe if limits.safe is not None else SAFE * cut
    inner = np.array([left, top, -right, -bottom]) + safe
    beyond = inner - sides * (1, 1, -1, -1) > SLACK
    outside = (sides[:, 2] <= left) | (sides[:, 0] >= right) | (sides[:, 3] <= top) | (sides[:, 1] >= bottom)
    bleeding = np.asarray(np.array([left, top, -right, -bottom]) - sides * (1, 1, -1, -1) >= -ON_EDGE).any(axis=1)
    count = int((beyond.any(axis=1) & ~outside & ~bleeding).sum())
    if count:
        yield Hit(drawing.where, f"{count} marks lie within {safe:g} mm of the trim", count)


@rule("bleed", WARNING, "drawing")
def bleed(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """Art that touches the trim goes on as far as the bleed, and a page that is touched has one."""
    sides, trim, wide = _sides(drawing), np.array(drawing.trim), np.array(drawing.bleed)
    turn = np.array([1, 1, -1, -1])
    touches = (trim - sides) * turn >= -ON_EDGE
    across = np.asarray((sides[:, :2] < trim[2:] - ON_EDGE) & (sides[:, 2:] > trim[:2] + ON_EDGE)).all(axis=1)
    short = touches & across.reshape(-1, 1) & (((sides - wide) * turn > ON_EDGE) | ((wide - trim) * turn >= 0))
    count = int(short.any(axis=1).sum())
    if count:
        yield Hit(drawing.where, f"{count} marks touch the trim and do not reach the bleed", count)


@rule("outside", WARNING, "drawing")
def outside(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """Art lies on the page; crop marks lie in the slug, and are not meant."""
    if drawing.page is None:
        return
    sides, (left, top, right, bottom) = _sides(drawing), drawing.page
    off = (sides[:, 0] < left - SLACK) | (sides[:, 1] < top - SLACK) | (sides[:, 2] > right + SLACK) | (sides[:, 3] > bottom + SLACK)
    if off.any():
        yield Hit(drawing.where, f"{int(off.sum())} marks lie outside the page, wholly or in part", int(off.sum()))


@rule("resolution", WARNING, "drawing")
def resolution(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """Bitmaps have --min-ppi pixels to the inch as they are placed; those of one bit 1200, and at the very least --min-ppi-line."""
    for one in drawing.bitmaps:
        least = limits.min_ppi_line if one.bits == 1 else limits.min_ppi
        best = 1200.0 if one.bits == 1 else least
        if one.ppi < max(best, least) - 0.5:
            wish = f"{least:g}, better {best:g}" if best > least else f"{least:g}"
            severity = WARNING if one.ppi < least - 0.5 else INFORMATION
            message = f"{one.name} of {one.pixels[0]} x {one.pixels[1]} pixels has {one.ppi:.0f} ppi, where {wish} are wanted"
            yield Hit(drawing.where, message, round(one.ppi, 1), severity)


@rule("elements", WARNING, "drawing")
def elements(drawing: Drawing, limits: Limits) -> Iterator[Hit]:
    """A page has no more operators, or elements, than --max-elements."""
    if drawing.elements > limits.max_elements:
        yield Hit(drawing.where, f"{drawing.elements} {drawing.parts}, over {limits.max_elements}", drawing.elements)


@rule("unread", INFORMATION, "drawing")
def unread(drawing: Drawing, _: Limits) -> Iterator[Hit]:
    """What the rules for dots, lines, gaps and ink do not see into."""
    if drawing.unread:
        said = ", ".join(f"{count} {name}" for name, count in drawing.unread.items())
        yield Hit(drawing.where, f"not measured: {said}", dict(drawing.unread))
