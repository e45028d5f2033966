"""What a press needs beside the drawing: the plates of its inks, and the furniture around its trim.

Furniture is outside the trim and its bleed, in mm by the sheet's own corner, so that it lies at negative places too.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from crowquill.lettering import Words, width
from crowquill.marks import whole
from crowquill.paths import Array, Paths
from crowquill.sheet import Ink, Layer, Sheet, shifted

PLATES = ("Cyan", "Magenta", "Yellow", "Black")
PAPER = Ink("paper", (0.0, 0.0, 0.0, 0.0))
REGISTRATION = Ink("registration", (1.0, 1.0, 1.0, 1.0))  # on every plate there is
OFFSET = 3.0  # mm at least between the trim and a mark; the bleed where that is wider
LONG = 6.0  # mm: a crop mark, and a registration mark across
THIN = 0.1  # mm: the finest line that printers ask for
EDGE = 2.0  # mm of paper left around all
PATCH = 5.0  # mm: a patch of the colour bar
STEPS = (1.0, 0.75, 0.5, 0.25)  # shares of ink in it
LETTERS = 2.5  # mm: the size that inks are named in
SLIGHT = 4 * LONG  # mm: sides under this have no registration mark, which would come near the crop marks


@dataclass(frozen=True)
class Tint(Ink):
    """A share of a spot ink, 0 to 1, in patches that measure it."""

    share: float = 1.0


@dataclass(frozen=True, eq=False)
class Forme:
    """A sheet with what stands around it: layers of furniture, and mm from the trim to the end of the bleed and of the paper.

    plate  the ink it is the plate of, where it is one
    """

    sheet: Sheet
    around: tuple[Layer, ...] = ()
    bleed: float = 0.0
    slug: float = 0.0
    plate: str = ""

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in mm of the paper with all that is on it."""
        return self.sheet.size[0] + 2 * self.slug, self.sheet.size[1] + 2 * self.slug

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The layers of the sheet, and those around it."""
        return (*self.sheet.layers, *self.around)

    def flat(self) -> Sheet:
        """All of it as one sheet of the paper's size; paper covers what hangs out of the bleed."""
        offset = np.array([self.slug, self.slug])
        cover = (Layer(PAPER, self._surround(), "slug"),) if self.slug > self.bleed else ()
        layers = (*self.sheet.layers, *cover, *self.around)
        moved = tuple(replace(layer, art=shifted(layer.art, offset)) for layer in layers)
        return Sheet(self.size, moved, self.sheet.recipe, self.sheet.report)

    def _surround(self) -> Paths:
        """All of the paper that is beyond the bleed, as a ring."""
        (width, height), out, bleed = self.sheet.size, self.slug, self.bleed
        hole = _box(-bleed, -bleed, width + 2 * bleed, height + 2 * bleed)[::-1]
        return Paths.of([_box(-out, -out, width + 2 * out, height + 2 * out), hole])


def locked(sheet: Sheet, *, bleed: float = 0.0, marks: bool = False, colour_bar: bool = False) -> Forme:
    """The sheet with its furniture; where none is asked for, just the sheet.

    marks       crop marks at the corners, registration marks in the middle of sides of SLIGHT and more, the names of
                the inks, each in its own
    colour_bar  patches of each ink in STEPS, below all else, in as many rows as the sheet's width makes of them

    Raises what inks() raises.
    """
    bleed = round(float(bleed), 3)
    found = inks(sheet.layers)
    off = max(bleed, OFFSET)
    slug, around = bleed, list[Layer]()
    if marks:
        around = [*_marks(sheet.size, off), *_names(sheet.size[0], off, found.values())]
        slug = off + LONG + EDGE
    if colour_bar and found:
        top = off + (LONG + EDGE if marks else 0)
        patches, deep = _bar(sheet.size, top, found.values())
        around += patches
        slug = top + deep + EDGE
    return Forme(sheet, tuple(around), bleed, slug)


def shares(ink: Ink) -> dict[str, float]:
    """The plates that an ink prints on, and how much of each, over 0. None for paper; REGISTRATION counts as the four of them."""
    if ink.spot:
        return {ink.name: ink.share if isinstance(ink, Tint) else 1.0}
    return {plate: share for plate, share in zip(PLATES, ink.cmyk, strict=True) if share > 0}


def registers(ink: Ink) -> bool:
    """Whether an ink is that of marks on every plate."""
    return replace(ink, pen=None) == REGISTRATION


def inks(layers: Iterable[Layer]) -> dict[str, Ink]:
    """The solid ink of each plate that the layers use: process plates first, then spot inks from the bottom up.

    Raises ValueError for a spot ink of two looks, and for paper that is to overprint, which would print nothing.
    """
    process, spots = set(), dict[str, Ink]()
    for layer in layers:
        ink = layer.ink
        if not len(layer.art) or registers(ink):
            continue
        used = shares(ink) if layer.fill is None else _filled(layer.fill)
        if ink.overprint and not used:
            raise ValueError(f"ink {ink.name!r} is paper and would overprint, which shows nothing; leave overprint off")
        if not ink.spot or layer.fill is not None:
            process |= set(used)
        elif spots.setdefault(ink.name, Ink(ink.name, ink.cmyk, spot=True)).cmyk != ink.cmyk:
            raise ValueError(f"spot ink {ink.name!r} is cmyk {spots[ink.name].cmyk} and {ink.cmyk}; give it one look")
    solid = {plate: Ink(plate, tuple(float(k == n) for k in range(4))) for n, plate in enumerate(PLATES)}  # type: ignore[arg-type]
    return {**{plate: ink for plate, ink in solid.items() if plate in process}, **spots}


def separated(sheet: Sheet, *, bleed: float = 0.0, colour_bar: bool = False) -> dict[str, Forme]:
    """The plate of each ink in use, by its name: what it prints as black, with registration marks and its name around.

    What lies above on other plates alone leaves paper here, unless it overprints. Shares of ink stay shares of black:
    who writes pixels screens them first. A sheet without ink has no plates. Raises what inks() raises.
    """
    every = locked(sheet, bleed=bleed, marks=True, colour_bar=colour_bar)
    plates = {}
    for plate in inks(sheet.layers):
        art: list[Layer] = []
        for layer in sheet.layers:
            if printed := _printed(layer, plate):
                art.append(printed)
            elif art and not layer.ink.overprint:
                art.append(replace(layer, ink=replace(PAPER, pen=layer.ink.pen), fill=None))
        around = [printed for layer in every.around if (printed := _printed(layer, plate))]
        alone = replace(sheet, layers=tuple(art), attached={})
        plates[plate] = replace(every, sheet=alone, around=tuple(around), plate=plate)
    return plates


def _filled(fill: Array) -> dict[str, float]:
    """The plates that rings coloured by themselves print on, and the most of each."""
    return {plate: float(most) for plate, most in zip(PLATES, fill.max(axis=0, initial=0.0), strict=True) if most > 0}


def _printed(layer: Layer, plate: str) -> Layer | None:
    """What a layer prints on a plate, as black; None for nothing."""
    ink = layer.ink
    if layer.fill is None:
        share = 1.0 if registers(ink) else shares(ink).get(plate, 0.0)
        return replace(layer, ink=Ink(plate, (0.0, 0.0, 0.0, share), ink.pen)) if share else None
    if plate not in _filled(layer.fill):
        return None
    assert isinstance(layer.art, Paths)  # Layer has seen to it
    fill = np.zeros_like(layer.fill)
    fill[:, 3] = layer.fill[:, PLATES.index(plate)]
    kept = np.flatnonzero(fill[:, 3] > 0) if ink.overprint else np.arange(len(fill))  # other rings leave paper
    return replace(layer, ink=Ink(plate), art=layer.art.take(kept), fill=fill[kept])


def _marks(size: tuple[float, float], off: float) -> list[Layer]:
    """Crop marks, as rectangles that end where they say, and registration marks."""
    (width, height), half = size, THIN / 2
    starts = (-off - LONG, off)
    crops = [_box(x - half, y + start, THIN, LONG) for x in (0, width) for y, start in zip((0, height), starts, strict=True)]
    crops += [_box(x + start, y - half, LONG, THIN) for y in (0, height) for x, start in zip((0, width), starts, strict=True)]
    out = off + LONG / 2
    middles = [(width / 2, -out), (width / 2, height + out)] if width >= SLIGHT else []
    middles += [(-out, height / 2), (width + out, height / 2)] if height >= SLIGHT else []
    targets = [ring for x, y in middles for ring in _target(x, y)]
    named = [Layer(REGISTRATION, Paths.of(crops), "crop marks")]
    return [*named, Layer(REGISTRATION, Paths.of(targets), "registration marks")] if targets else named


def _target(x: float, y: float) -> list[Array]:
    """A circle and a cross through it."""
    around = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    circle = np.stack([np.cos(around), np.sin(around)], axis=1)
    rings = [radius * circle[::turn] + (x, y) for radius, turn in ((LONG / 4, 1), (LONG / 4 - THIN, -1))]
    return [*rings, _box(x - LONG / 2, y - THIN / 2, LONG, THIN), _box(x - THIN / 2, y - LONG / 2, THIN, LONG)]


def _names(side: float, off: float, found: Iterable[Ink]) -> list[Layer]:
    """Each ink's name in itself, one after another above the left half of the sheet; smaller where they would not fit."""
    named = list(found)
    wide = [width(ink.name, LETTERS) + LETTERS for ink in named]
    scale = min(1.0, max(side / 2 - LONG - EDGE, LONG) / sum(wide)) if wide else 1.0
    lefts = EDGE + scale * np.cumsum([0.0, *wide])
    size = max(1e-3, float(whole(np.array(scale * LETTERS))))
    return [Layer(ink, Words.of([(ink.name, left, -off - EDGE)], size=size), "ink") for ink, left in zip(named, lefts, strict=False)]


def _bar(size: tuple[float, float], top: float, found: Iterable[Ink]) -> tuple[list[Layer], float]:
    """The colour bar's layers, `top` mm below the trim, and how deep it is in mm."""
    patches = [(ink, step) for ink in found for step in STEPS]
    across = max(1, int(size[0] / PATCH))
    layers = []
    for k, (ink, step) in enumerate(patches):
        row, column = divmod(k, across)
        box = _box(column * PATCH, size[1] + top + row * PATCH, PATCH, PATCH)
        layers.append(Layer(_tint(ink, step), Paths.of([box]), f"{ink.name} {100 * step:g} %"))
    return layers, PATCH * -(-len(patches) // across)


def _tint(ink: Ink, share: float) -> Ink:
    if ink.spot:
        return Tint(ink.name, ink.cmyk, spot=True, share=share)
    cyan, magenta, yellow, black = (share * part for part in ink.cmyk)
    return Ink(ink.name, (cyan, magenta, yellow, black))


def _box(x: float, y: float, width: float, height: float) -> Array:
    return np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])
