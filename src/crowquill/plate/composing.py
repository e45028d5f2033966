"""The page of a plate: where pictures, letters, bars and captions go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from crowquill import lettering, scale, units
from crowquill.plate import places, wording
from crowquill.plate.journals import JOURNALS, Journal
from crowquill.plate.parts import Content, Size, content
from crowquill.plate.places import Box, Want
from crowquill.plate.platefile import Panel, Plate, named
from crowquill.plate.sources import Folder
from crowquill.plate.wording import Faces, caption
from crowquill.sheet import Layer, turned

Around = tuple[float, float, float, float]  # left, top, right, bottom, mm
MARGIN, RIM = 15.0, 0.5  # mm, on paper, and around a figure, that dots on its border are whole
TEXT = 8 * units.POINT  # where no journal says another size
MORE = units.POINT  # that letters of panels are larger than other text
APART = 1.5  # mm between a picture and its words, and from letters and bars to the picture's border
MOST = 5  # letters that are named of those that a font lacks
BOXES = "; empty boxes stand there, and no PDF can be written: choose other words, or another font"


@dataclass(frozen=True)
class Placed:
    """A panel in its place: its box with its words and that of its picture, scale in mm drawn to a mm, and words as layers.

    label   its letter, or its number where it has none: what its layers are called
    free    boxes (left, top, right, bottom) mm of the page that its drawing leaves free
    """

    name: str
    label: str
    panel: Panel
    content: Content
    art: Box
    box: Box
    ratio: float | None
    words: tuple[Layer, ...]
    free: tuple[Around, ...]


@dataclass(frozen=True)
class Composition:
    """A plate with all in its place: `size` of its page in mm, panels, words of the page, and what is to be said of it.

    lacking  which words have letters that their font has no shape for, a line each
    """

    plate: Plate
    size: Size
    panels: tuple[Placed, ...]
    words: tuple[Layer, ...]
    lacking: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Hand:
    """How the page is lettered: fonts by face, sizes in mm, and the inks of letters and bars."""

    faces: Faces
    text: float
    letter: float
    letters: str
    letter_font: str
    bar: float


def composed(plate: Plate, folder: Folder) -> Composition:
    """The plate with its files found and all in its place. Raises ValueError for what cannot be, before anything is drawn."""
    page, journal = plate.page, JOURNALS.get(plate.page.journal or "")
    hand = _hand(plate, journal, folder)
    labels = _labels(plate, hand.letters)
    names = [f"panel {k + 1}" for k in range(len(plate.panel))]
    wants = []
    for rank, (panel, name) in enumerate(zip(plate.panel, names, strict=True)):
        with named(name):
            wants.append(_want(panel, content(plate, rank, folder), plate, hand, letter=bool(labels[rank])))
    size, most = _size(plate, journal)
    margin = page.margin if page.margin is not None else RIM if page.width or journal else MARGIN
    room = size[0] - 2 * margin
    if min(room, most - 2 * margin) < places.LEAST:
        raise ValueError(f"page: a margin of {margin:g} mm leaves no room; make it smaller")
    with named("page"):
        foot = caption(page.caption, room, hand.text, hand.faces)
    under = foot.height + 2 * APART if foot.lines else 0.0
    if most - 2 * margin - under < places.LEAST:
        raise ValueError(f"page: its caption is {foot.height:.4g} mm high and leaves no room for panels; make the page higher")
    spots = places.spots(wants, names, plate.grid, margin, (room, most - 2 * margin - under))
    boxes = [box for _, box in spots]
    bottom = max(box.bottom for box in boxes)
    size = (size[0], size[1] or round(min(bottom + under + margin, most), 3))
    places.check(boxes, names, size)
    if foot.lines and bottom + under > size[1] + units.UM:
        raise ValueError(f"page: its caption is {foot.height:.4g} mm high and does not fit below the panels; make the page higher")
    panels = []
    for k, want in enumerate(wants):
        with named(names[k]):
            panels.append(_lettered(want, spots[k], names[k], labels[k], k, plate, hand))
    words = tuple(foot.layers(margin, bottom + 2 * APART, "caption", plate.ink("black")))
    lost = tuple(_lacking(panels, words))
    return Composition(plate, size, tuple(panels), words, lost, (*_notes(plate, journal, hand), *(f"{line}{BOXES}" for line in lost)))


def _size(plate: Plate, journal: Journal | None) -> tuple[Size, float]:
    """The page's sides, its height 0 where the panels give it, and the most it may be."""
    page = plate.page
    if page.width or journal:
        width = page.width or (journal.widths[(page.columns or len(journal.widths)) - 1] if journal else 0.0)
        most = page.height or (journal.height if journal and journal.height else 10 * units.paper("a4")[1])
        return (width, page.height or 0.0), most
    size = turned(page.paper or "a4", (1, 1), page.orientation)
    return size, size[1]


def _hand(plate: Plate, journal: Journal | None, folder: Folder) -> Hand:
    said = plate.text
    own = {"regular": said.font, "italic": said.italic, "bold": said.bold}
    plain = said.font if said.font != "regular" else ""
    with named("text"):
        faces = {face: _font(font or plain or face, folder) for face, font in own.items()}
    text = said.size or (journal.text if journal and journal.text else TEXT)
    style = plate.letters.style or (journal.letters if journal and journal.letters else "A")
    with named("letters"):
        font = _font(plate.letters.font, folder) if plate.letters.font else faces["bold"]
    letter = round(plate.letters.size or text + MORE, 3)
    return Hand(faces, round(text, 3), letter, style, font, round(plate.bars.size or text, 3))


def _font(font: str, folder: Folder) -> str:
    """A face by its name, or the path of a file of the plate's folder."""
    found = str(folder.file(font)) if Path(font).suffix else font
    lettering.lacking("", found)  # one that cannot be read is refused here
    return found


def _labels(plate: Plate, style: str) -> list[str]:
    """The letters of the panels: their own, or the next."""
    found, rank = [], 0
    for panel in plate.panel:
        if panel.letter is not None or style == "none":
            found.append(panel.letter or "")
            continue
        word, k = "", rank + 1
        while k:
            k, digit = divmod(k - 1, 26)
            word = chr(ord(style) + digit) + word
        found.append(word)
        rank += 1
    return found


def _want(panel: Panel, shown: Content, plate: Plate, hand: Hand, *, letter: bool) -> Want:
    """The panel with the room that its words take."""
    above = hand.letter * wording.CAPITALS + APART if letter and plate.letters.position == "above" else 0.0
    bar = _bar_height(plate, hand) if panel.barred and plate.bars.position == "below" else 0.0

    def below(width: float) -> float:
        words = caption(panel.caption, width, hand.text, hand.faces)
        return bar + (words.height + APART if words.lines else 0.0)

    return Want(panel, shown, above, below)


def _lettered(want: Want, spot: tuple[Box, Box], name: str, letter: str, rank: int, plate: Plate, hand: Hand) -> Placed:
    """The panel with its letter, its bar and its caption where they go."""
    (art, box), panel = spot, want.panel
    label = letter or str(rank + 1)
    words: list[Layer] = []
    free = []
    if letter:
        line, around = _letter(letter, art, box, plate, hand)
        words.append(Layer(plate.ink(plate.letters.ink), line, f"{label} letter"))
        free += [around] if plate.letters.position == "inside" else []
    ratio, down = want.content.ratio_at((art.width, art.height)), art.bottom + APART
    if ratio is not None and panel.barred:
        bar = _bar(panel, ratio, art, plate, hand)
        words += [replace(layer, name=f"{label} {layer.label}") for layer in bar.layers]
        if plate.bars.position == "inside":
            free.append(bar.box)
        else:
            down = bar.box[3] + APART
    text = caption(panel.caption, box.width, hand.text, hand.faces)
    words += text.layers(max(box.left, min(art.left, box.right - text.width)), down, f"{label} caption", plate.ink("black"))
    return Placed(name, label, panel, want.content, art, box, ratio, tuple(words), tuple(free))


def _letter(letter: str, art: Box, box: Box, plate: Plate, hand: Hand) -> tuple[lettering.Words, Around]:
    """A panel's letter inside the top left corner of its picture, or above it, and the box of its ink."""
    inside = plate.letters.position == "inside"
    high, wide = hand.letter * wording.CAPITALS, lettering.width(letter, hand.letter, hand.letter_font)
    if wide > (art.width - 2 * APART if inside else box.right - art.left) or (inside and high > art.height - 2 * APART):
        raise ValueError(f"its letter {letter!r} is {wide:.3g} x {high:.3g} mm and has no room; make letters smaller")
    left, base = (art.left + APART, art.top + APART + high) if inside else (art.left, art.top - APART)
    line = lettering.Words.of([(letter, left, base)], size=hand.letter, font=hand.letter_font)
    return line, (left, base - high, left + wide, base)


def _bar(panel: Panel, ratio: float, art: Box, plate: Plate, hand: Hand) -> scale.Bar:
    """The scale bar in a corner of the picture, or below that corner."""
    bars = plate.bars
    inside = bars.position == "inside"
    edge = APART if inside else 0.0
    x = art.right - edge if bars.corner == "right" else art.left + edge
    y = art.bottom - edge if inside else art.bottom + _bar_height(plate, hand)
    bar = scale.bar(
        ratio, art.width - 2 * edge, panel.scale_bar, at=(x, y), anchor=bars.corner,
        thickness=bars.thickness, ticks=bars.ticks, size=hand.bar, ink=plate.ink(bars.ink), font=hand.faces["regular"],
    )  # fmt: skip
    if inside and bar.box[1] < art.top + APART:
        high = bar.box[3] - bar.box[1]
        raise ValueError(f"its scale bar is {high:.3g} mm high and has no room; put bars below, or make them smaller")
    return bar


def _bar_height(plate: Plate, hand: Hand) -> float:
    """What a scale bar below a picture takes, mm."""
    thick = max(plate.bars.thickness, scale.TICK) if plate.bars.ticks else plate.bars.thickness
    return APART + hand.bar * wording.CAPITALS + scale.APART + thick


def _lacking(panels: list[Placed], words: tuple[Layer, ...]) -> Iterator[str]:
    """Of all words whose font lacks letters of theirs: which they are, the font, and the letters."""
    places = [("page", "", words), *((placed.name, f"{placed.label} ", placed.words) for placed in panels)]
    for place, label, layers in places:
        for layer in layers:
            if isinstance(layer.art, lettering.Words) and (lost := lettering.lacking("".join(layer.art.text), layer.art.font)):
                told = ", ".join(f"{letter} (U+{ord(letter):04X})" for letter in lost[:MOST])
                more = f" and {len(lost) - MOST} more" if len(lost) > MOST else ""
                yield f"{place}: {layer.label.removeprefix(label)}: font {Path(layer.art.font).name} has no {told}{more}"


def _notes(plate: Plate, journal: Journal | None, hand: Hand) -> tuple[str, ...]:
    """What is to be said of the lettering: too small for the journal, faces that are not there."""
    found = []
    if journal and journal.least:
        sizes = {"text": hand.text, "letters": hand.letter, "bars": hand.bar}
        found += [
            f"{name} of {size / units.POINT:.3g} pt is smaller than {plate.page.journal} takes, {journal.least / units.POINT:.3g} pt"
            for name, size in sizes.items()
            if size < journal.least - units.UM
        ]
    text = plate.page.caption + "".join(panel.caption for panel in plate.panel)
    if len(set(hand.faces.values())) < 3 and "*" in text:
        found.append("a font of your own is given without its italic or bold, and words in stars are set like the rest")
    return tuple(found)
