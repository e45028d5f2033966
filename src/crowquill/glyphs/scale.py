"""How many pixels a millimetre of a page is: said, in the file's tag, or by a ruler on it; and whether it is so everywhere."""

from __future__ import annotations

import numpy as np

from crowquill.glyphs.page import Grey
from crowquill.glyphs.ruler import SURE, Ruler, found
from crowquill.paths import Array, Paths
from crowquill.units import INCH

FINEST = 25_400.0  # dpi: a pixel is a micrometre
COARSEST = 300.0  # dpi: a 0.3 mm dot is 3.5 pixels across
PLACEHOLDERS = (72.0, 96.0)  # dpi that cameras and programs write when they know none
AGREED = 0.02  # a tag and a ruler that differ by less say the same
ASLANT = 0.01  # of a millimetre, by which millimetres may differ unsaid
UNLIKE = 0.03  # of dots' sizes across the page, or of their widths two ways


def of_page(light: Grey, name: str, dpi: float | None, tag: float | None) -> tuple[float, str, Ruler | None, tuple[str, ...]]:
    """The page's dpi; who said it, "given", "tag" or "ruler"; the ruler on it, if any; and warnings.

    What is given counts first, then a tag of 300 dpi or more, then a ruler. ValueError where none says, or it is too coarse.
    """
    sound = tag if tag and tag >= COARSEST else None
    ruler = found(light, dpi or sound)
    shown = ruler.pitch * INCH if ruler else None
    if dpi or sound:
        chosen, origin = (dpi, "given") if dpi else (sound, "tag")
    elif shown:
        chosen, origin = shown, "ruler"
    elif tag in PLACEHOLDERS:
        raise ValueError(f"{name}: its tag says {tag:g} dpi, a camera's stopgap; give the true --dpi, or lay a ruler beside the dots")
    elif tag:
        raise ValueError(f"{name}: its tag says {tag:g} dpi, too coarse for ink dots; scan at 1200, give --dpi, or lay a ruler beside")
    else:
        raise ValueError(f"{name}: its dpi is not known; give it, such as --dpi 1200, or lay a ruler beside the dots")
    assert chosen is not None
    fine(chosen, name, "its ruler shows " if origin == "ruler" else "")
    said = []
    if ruler and shown and origin != "ruler" and abs(shown / chosen - 1) > AGREED:
        by = "what is given" if origin == "given" else "the file's tag"
        said.append(f"the ruler shows {shown:.0f} dpi, {by} says {chosen:g}: sizes are by the latter; give the ruler's dpi if it is right")
    return float(chosen), origin, ruler, tuple(said)


def fine(dpi: float, name: str, origin: str = "") -> None:
    """ValueError for a dpi that is no number from 300 to 25 400."""
    if dpi > FINEST:
        raise ValueError(f"{name}: {origin}{dpi:.5g} dpi, finer than any scanner; give the true dpi, such as 1200")
    if not COARSEST <= dpi < np.inf:
        remedy = "go nearer" if origin else "scan at 1200, or give the true dpi"
        raise ValueError(f"{name}: {origin}{dpi:.5g} dpi, too coarse for ink dots; {remedy}, {COARSEST:g} or more")


def aslant(ruler: Ruler, outlines: Paths, mm: float) -> tuple[str, ...]:
    """What a ruler and dots (closed outlines, mm) on a page of pixels of so many mm tell of a camera that looked at it aslant.

    Millimetres then grow along the ruler, or its ticks are not parallel, as millimetres grow away from it. Dots of one pen
    are as wide one way as the other, and on one side of a page as on the other, on average: a mean that is not, by UNLIKE
    and beyond chance, is named, but the hand may have done it.
    """
    said = []
    m = outlines.green()
    area, x, y = m[:, 0], m[:, 1] / m[:, 0], m[:, 2] / m[:, 0]
    place = outlines.xy[outlines.start[:-1]] + m[:, 1:3] / m[:, :1]
    away = 1.5 * ruler.fan * float(np.median(np.abs((place / mm - ruler.origin) @ ruler.inward))) / ruler.pitch  # 1.5: of both sides
    straight = "the photograph was not taken straight from above; sizes may be off by as much"
    if ruler.drift > ASLANT:
        said.append(f"the ruler's millimetres grow by {ruler.drift:.1%} along it: {straight}")
    if away > ASLANT:
        said.append(f"the ruler's ticks are not parallel, and millimetres differ by {away:.1%} from it to the dots: {straight}")
    if len(outlines) < 10:
        return tuple(said)
    xx, xy, yy = m[:, 3] / area - x * x, m[:, 4] / area - x * y, m[:, 5] / area - y * y
    stretch = ((xx - yy) + 2j * xy) / (xx + yy)  # of an ellipse of nearly even axes: ln of their ratio, turned
    longer, chance = float(abs(stretch.mean())), float(stretch.std() / np.sqrt(len(outlines)))
    if longer > max(UNLIKE, SURE * chance):
        said.append(f"the dots are {longer:.0%} longer one way than across it, on average: drawn so, or photographed aslant")
    grow, chance = _growth(place, np.log(area) / 2)
    if grow > max(UNLIKE, SURE * chance):
        said.append(f"the dots grow by {grow:.0%} across the page: drawn so, or photographed aslant")
    return tuple(said)


def _growth(place: Array, size: Array) -> tuple[float, float]:
    """By how much a plane through sizes at places rises across them, and its standard error."""
    middle = place - place.mean(0)
    plane, *_ = np.linalg.lstsq(middle, size - size.mean(), rcond=None)
    steep = float(np.hypot(*plane))
    if not steep:
        return 0.0, 0.0
    along = middle @ plane / steep
    rest = size - size.mean() - middle @ plane
    return steep * float(np.ptp(along)), float(rest.std() / max(np.sqrt((along**2).sum()), 1e-12)) * float(np.ptp(along))
