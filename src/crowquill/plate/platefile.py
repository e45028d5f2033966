"""Plate files: a page and its panels as TOML says them, checked, with what a journal asks for in place of what is left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from crowquill import recipe, scale, units
from crowquill.knobs import checked, unknown
from crowquill.plate.journals import JOURNALS
from crowquill.sheet import Ink

SCHEMA = 1  # a reader refuses a newer one
MOST = 200  # panels
LONGEST = 20_000  # letters of a caption
WIDEST = 2000.0  # mm
SHOWN = 60  # letters of a value in an error


def length(value: Any) -> float:
    """Millimetres of a length as plate files have it: a text with its unit, or a number of mm."""
    if isinstance(value, str):
        return units.length(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= units.LARGEST:
        raise ValueError(f"{short(value)} is no length; write a number of mm, or a text such as 12 mm")
    return float(value)


def _side(value: Any) -> float:
    """A length over 0, in whole micrometres."""
    found = round(length(value), 3)
    if not 0 < found <= WIDEST:
        raise ValueError(f"{short(value)} is no length that can be drawn; give one over 0, up to {WIDEST:g} mm")
    return found


def _place(value: Any) -> float:
    """A length of 0 or more, in whole micrometres."""
    found = round(length(value), 3)
    if not 0 <= found <= WIDEST:
        raise ValueError(f"{short(value)} is outside every page; give a length from 0 to {WIDEST:g} mm")
    return found


Side = Annotated[float, BeforeValidator(_side)]
Place = Annotated[float, BeforeValidator(_place)]
Count = Annotated[int, Field(ge=1, le=50)]
Pair = Annotated[tuple[Count, Count], Field(strict=False)]
Words = Annotated[str, Field(max_length=LONGEST)]


class Table(BaseModel):
    """A table that takes no key it does not know."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Page(Table):
    """The page: a paper, or the column of a journal, whose height is that of its panels where none is given."""

    paper: str | None = None
    journal: str | None = None
    columns: Count | None = None  # of the journal, that the figure is wide; all of them when left out
    width: Side | None = None
    height: Side | None = None
    orientation: Literal["portrait", "landscape"] = "portrait"
    margin: Place | None = None  # 15 mm on paper; .5 mm around a figure, that dots on its border are whole
    caption: Words = ""

    @field_validator("journal")
    @classmethod
    def _known(cls, name: str | None) -> str | None:
        if name is not None and name not in JOURNALS:
            raise ValueError(f"no {unknown('journal', name, JOURNALS)}")
        return name

    @field_validator("paper")
    @classmethod
    def _sized(cls, name: str | None) -> str | None:
        if name is not None:
            units.paper(name)
        return name

    @model_validator(mode="after")
    def _one(self) -> Page:
        if self.paper and (self.journal or self.width or self.height):
            raise ValueError("paper has a width and a height of its own; leave out paper, or journal, width and height")
        if self.columns and not self.journal:
            raise ValueError("columns are a journal's; name one with journal, or leave them out")
        if self.columns and self.columns > len(JOURNALS[self.journal or ""].widths):
            raise ValueError(f"journal {self.journal} has a width for {len(JOURNALS[self.journal or ''].widths)} columns; give fewer")
        if self.height and not (self.width or self.journal):
            raise ValueError("height is given without a width; give both, a paper or a journal")
        return self


class Grid(Table):
    """Rows and columns; widths and heights that are left out are shared out, or found from the pictures."""

    columns: Count = 1
    rows: Count | None = None
    gutter: Place = 4.0
    widths: Annotated[list[Side], Field(max_length=50)] = []
    heights: Annotated[list[Side], Field(max_length=50)] = []

    @model_validator(mode="after")
    def _counted(self) -> Grid:
        for name, lengths, count in (("widths", self.widths, self.columns), ("heights", self.heights, self.rows)):
            if lengths and count != len(lengths):
                side = "columns" if name == "widths" else "rows"
                raise ValueError(f"{name} has {len(lengths)} lengths for {count or 'an unknown number of'} {side}; give one for each")
        return self


class Letters(Table):
    """Letters of the panels; size is the font's, whose capitals are .73 of it high."""

    style: Literal["A", "a", "none"] | None = None
    size: Side | None = None
    position: Literal["inside", "above"] = "inside"
    font: str | None = None
    ink: str = "black"


class Text(Table):
    """Captions: one font for the page, its italic for names of species, its bold for letters."""

    size: Side | None = None
    font: str = "regular"
    italic: str | None = None
    bold: str | None = None


class Bars(Table):
    """Scale bars."""

    position: Literal["inside", "below"] = "below"
    corner: Literal["right", "left"] = "right"
    size: Side | None = None
    thickness: Side = scale.THICK
    ticks: bool = False
    ink: str = "black"


class Colour(Table):
    """An ink by its shares of cyan, magenta, yellow and black."""

    cmyk: Annotated[tuple[float, float, float, float], Field(strict=False)]
    spot: bool = False
    overprint: bool = False


class Drawn(Table):
    """One drawing: a picture in a style, a recipe, or a drawing made before."""

    picture: str | None = None
    style: str | None = None
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = None
    tone: dict[str, Any] | None = None
    knobs: dict[str, Any] | None = None
    finish: dict[str, Any] | None = None
    recipe: str | None = None
    drawing: str | None = None
    ink: str | None = None

    @model_validator(mode="after")
    def _one(self) -> Drawn:
        own = [key for key in ("picture", "style", "seed", "tone", "knobs", "finish") if getattr(self, key) is not None]
        if self.drawing and (self.recipe or own):
            raise ValueError(f"a drawing is there already and has no {'recipe' if self.recipe else own[0]}; leave one of them out")
        if self.recipe and (said := [key for key in own if key not in ("picture", "seed")]):
            raise ValueError(f"its recipe says its {said[0]} already; leave one of them out")
        return self


def _given(one: Drawn) -> dict[str, Any]:
    """What it says of what is drawn, by key."""
    return {key: value for key in Drawn.model_fields if (value := getattr(one, key)) is not None}


class Panel(Drawn):
    """A place on the page, what is drawn there, and its words. What a layer does not say is the panel's."""

    layer: Annotated[list[Drawn], Field(max_length=20)] = []
    cell: Pair | None = None  # row and column, from 1
    span: Pair = (1, 1)
    at: Annotated[tuple[Place, Place], Field(strict=False)] | None = None
    size: Annotated[tuple[Side, Side], Field(strict=False)] | None = None
    width: Side | None = None
    fit: Literal["contain", "cover", "stretch"] = "contain"
    letter: Annotated[str, Field(max_length=20)] | None = None
    caption: Words = ""
    scale: str | None = None
    pixel: str | None = None
    scale_bar: str = "auto"  # none leaves it out

    @property
    def drawn(self) -> list[Drawn]:
        """What lies in it, from the bottom up."""
        if not self.layer:
            return [self]
        found = []
        for layer in self.layer:
            own, ours = _given(layer), _given(self)
            if own.keys() & {"drawing", "recipe"}:
                ours = {"ink": self.ink} if self.ink else {}
            if own.keys() - {"ink"}:
                ours.pop("drawing", None)
            if own.keys() & {"style", "tone", "knobs", "finish"}:
                ours.pop("recipe", None)
            found.append(Drawn(**{**ours, **own}))
        return found

    @property
    def barred(self) -> bool:
        """Whether it gets a scale bar."""
        return bool(self.scale or self.pixel) and self.scale_bar != "none"

    @model_validator(mode="after")
    def _placed(self) -> Panel:
        for one in self.drawn:
            if not (one.picture or one.recipe or one.drawing):
                raise ValueError("there is nothing to draw; give a picture, a recipe or a drawing")
        if self.at and (self.cell or self.span != (1, 1)):
            raise ValueError("it is placed by at and by cell or span; leave out one of them")
        if self.size and not self.at:
            raise ValueError("a size goes with at; in a grid give cell and span, or width")
        if self.size and self.width:
            raise ValueError("size has a width already; leave one of them out")
        if self.scale:
            scale.parsed(self.scale)
        if self.pixel:
            scale.of_pixel(self.pixel, 1.0)
            if self.drawn[0].drawing or self.fit == "stretch":
                raise ValueError("pixel is for pictures that are not stretched; say scale")
        if self.scale and self.pixel and (self.width or self.size):
            raise ValueError("scale and pixel together say how large it is drawn; leave out width and size, or one of the two")
        if self.scale_bar not in ("auto", "none") and not (self.scale or self.pixel):
            raise ValueError("a scale bar of an unknown scale; give scale = '1 mm = 250 um', or pixel = '1.3 um'")
        return self


class Plate(Table):
    """A page of panels. style and schema tell its file from a drawing's recipe; sources are files by name with their SHA-256."""

    style: Literal["plate"] = "plate"
    schema_: Annotated[int, Field(alias="schema", ge=1)] = SCHEMA
    version: str = ""
    seed: Annotated[int, Field(ge=0, lt=2**62)] = 0
    page: Page = Page()
    grid: Grid = Grid()
    letters: Letters = Letters()
    text: Text = Text()
    bars: Bars = Bars()
    inks: dict[str, Colour] = {}
    panel: Annotated[list[Panel], Field(min_length=1, max_length=MOST)]
    files: dict[str, Any] = {}
    sources: dict[str, Annotated[str, Field(pattern="^([0-9a-f]{64})?$")]] = {}

    @model_validator(mode="after")
    def _whole(self) -> Plate:
        for name in self.inks:
            with named(f"inks: {name}"):
                self.ink(name)
        for where, name in [("letters", self.letters.ink), ("bars", self.bars.ink)]:
            _known(where, name, self.inks)
        for k, panel in enumerate(self.panel, 1):
            for one in panel.drawn:
                _known(f"panel {k}", one.ink or "black", self.inks)
        checked(recipe.takes_of("files", ""), self.files, "table files")
        return self

    def ink(self, name: str) -> Ink:
        """The ink of a name."""
        colour = self.inks.get(name)
        return Ink(name, colour.cmyk, spot=colour.spot, overprint=colour.overprint) if colour else Ink()


@contextmanager
def named(where: str) -> Iterator[None]:
    """A ValueError inside says where it happened."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _known(where: str, name: str, inks: Mapping[str, Colour]) -> None:
    if name != "black" and name not in inks:
        raise ValueError(f"{where}: no {unknown('ink', name, ['black', *inks])}")


def short(value: Any) -> str:
    """A value as an error shows it."""
    text = repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."
