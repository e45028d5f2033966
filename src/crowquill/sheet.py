"""What lies on the paper, and how it came there: Ink, Glyph, Marks, Layer, Sheet, Step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array, Index, Paths, frozen
from crowquill.units import INCH, PAPERS, UM, paper

THIN = 1e-4  # area over the square of the length: below, a shape is a hair, and its area may be rounding
SHOWN = 20_000  # shapes of an SVG in a notebook; more make browsers slow
TURN_STEPS = 65536  # angles are kept to this part of a turn: 1.4e-5 mm at the rim of a 0.3 mm dot


@dataclass(frozen=True)
class Ink:
    """A process colour by its share of cyan, magenta, yellow and black, each 0 to 1.

    pen: None fills; a width in mm strokes with round ends.
    """

    name: str = "black"
    cmyk: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    pen: float | None = None

    def __post_init__(self) -> None:
        if len(self.cmyk) != 4 or not all(0 <= share <= 1 for share in self.cmyk):
            raise ValueError(f"cmyk {self.cmyk} of ink {self.name!r} is not four shares from 0 to 1")
        if self.pen is not None and not 0 < self.pen < 1000:
            raise ValueError(f"pen {self.pen} mm of ink {self.name!r} is not a width; give None to fill")

    @property
    def rgb(self) -> tuple[int, int, int]:
        """The ink on a screen, red, green and blue of 0 to 255: each colour takes its share of the light away."""
        cyan, magenta, yellow, black = self.cmyk
        red, green, blue = (round(255 * (1 - share) * (1 - black)) for share in (cyan, magenta, yellow))
        return red, green, blue


@dataclass(frozen=True, eq=False)
class Glyph:
    """The outline of a dot: one path of area 1, centroid 0 and long axis on x; `size` is its true diameter in mm."""

    paths: Paths
    size: float

    @classmethod
    def of(cls, outline: Paths) -> Glyph:
        """The unit glyph of a closed outline in mm, which may wind either way.

        Raises ValueError for an outline without area.
        """
        m = outline.green().sum(axis=0) if len(outline) == 1 and outline.closed else np.zeros(6)
        extent = np.ptp(outline.xy, axis=0).max() if len(outline.xy) else 0.0
        if not abs(m[0]) > THIN * extent**2:
            raise ValueError("its shape is no dot; a glyph takes one closed outline with an area over 0")
        x, y = m[1:3] / m[0]
        xx, xy, yy = m[3] / m[0] - x * x, m[4] / m[0] - x * y, m[5] / m[0] - y * y
        long = 0.5 * np.arctan2(2 * xy, xx - yy)
        cos, sin = np.cos(long), np.sin(long)
        centred = outline.moved(np.eye(2), -(outline[0][0] + (x, y)))
        scale = abs(m[0]) ** -0.5
        unit = centred.moved(scale * np.array([[cos, sin], [-sin, cos]]))
        points = unit.xy
        if m[0] < 0:  # the same ring the other way round; a cubic's controls trade places by it
            points = np.roll(points[::-1], 1, axis=0)
        return cls(Paths(points, unit.start, True, outline.cubic), float(2 * np.sqrt(abs(m[0]) / np.pi)))

    @property
    def reach(self) -> float:
        """The greatest distance of the outline from its centroid, a thousandth of the mark's scale too large at most."""
        return float(np.hypot(*self.paths.flat(1e-3).xy.T).max()) + 1e-3


@dataclass(frozen=True, eq=False)
class Marks:
    """Many placed glyphs: xy (n, 2) mm, angle (n,) rad, scale (n,) mm, glyph (n,) index into `glyphs`.

    A closed mark's own area is scale**2 mm^2.
    """

    xy: Array
    angle: Array
    scale: Array
    glyph: Index
    glyphs: tuple[Glyph, ...]

    def __post_init__(self) -> None:
        n = len(self.xy)
        for name, dtype, shape in (
            ("xy", np.float64, (n, 2)),
            ("angle", np.float64, (n,)),
            ("scale", np.float64, (n,)),
            ("glyph", np.int64, (n,)),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), dtype, shape, name))
        if n and not 0 <= self.glyph.min() <= self.glyph.max() < len(self.glyphs):
            raise ValueError(f"glyph has an index outside 0 to {len(self.glyphs) - 1}")
        if n and self.scale.min() < 0:
            raise ValueError(f"scale {self.scale.min()} mm is negative")

    @classmethod
    def of(
        cls,
        xy: npt.ArrayLike,
        glyphs: tuple[Glyph, ...],
        *,
        scale: npt.ArrayLike,
        angle: npt.ArrayLike = 0.0,
        glyph: npt.ArrayLike = 0,
    ) -> Marks:
        """Marks at xy (n, 2); scale, angle and glyph are one value for all or (n,)."""
        points = np.asarray(xy, np.float64).reshape(-1, 2)
        n = len(points)
        return cls(
            points,
            np.broadcast_to(np.asarray(angle, np.float64), n),
            np.broadcast_to(np.asarray(scale, np.float64), n),
            np.broadcast_to(np.asarray(glyph, np.int64), n),
            tuple(glyphs),
        )

    def __len__(self) -> int:
        return len(self.xy)

    def take(self, which: Index | npt.NDArray[np.bool_] | slice) -> Marks:
        """The marks at these indices, this mask or slice."""
        return Marks(self.xy[which], self.angle[which], self.scale[which], self.glyph[which], self.glyphs)

    def moved(self, offset: npt.ArrayLike) -> Marks:
        """All marks moved by offset (2,) mm."""
        return replace(self, xy=self.xy + np.asarray(offset, np.float64))

    def snapped(self) -> Marks:
        """Places and scales in whole micrometres, angles in whole steps: what a file can keep."""
        step = 2 * np.pi / TURN_STEPS
        turns = np.round(self.angle / step) % TURN_STEPS
        return replace(self, xy=_whole(self.xy), scale=_whole(self.scale), angle=turns * step)

    def outlines(self) -> Paths:
        """Every mark's outline at its place, in the order of the marks. Straight and cubic glyphs may not be mixed."""
        if not len(self):
            return Paths.of([])
        shapes = self._shapes
        counts = np.diff(shapes.start)[self.glyph]
        start = np.concatenate([[0], np.cumsum(counts)])
        x, y = shapes.xy[np.repeat(shapes.start[self.glyph] - start[:-1], counts) + np.arange(start[-1])].T
        cos, sin = np.repeat(self.scale * np.cos(self.angle), counts), np.repeat(self.scale * np.sin(self.angle), counts)
        xy = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + np.repeat(self.xy, counts, axis=0)
        return Paths(xy, start, shapes.closed, shapes.cubic)

    @cached_property
    def _shapes(self) -> Paths:
        """All glyphs' outlines as one Paths."""
        kinds = {(glyph.paths.closed, glyph.paths.cubic) for glyph in self.glyphs}
        if len(kinds) > 1:
            raise ValueError("marks mix straight and cubic, or closed and open glyphs; make a layer of each")
        closed, cubic = kinds.pop()
        return Paths.of([glyph.paths.xy for glyph in self.glyphs], closed=closed, cubic=cubic)


@dataclass(frozen=True, eq=False)
class Layer:
    """Art in one ink; `name` is shown in editors and is the ink's when empty.

    Filled art follows the nonzero rule: holes turn the other way.
    """

    ink: Ink
    art: Marks | Paths
    name: str = ""

    @property
    def label(self) -> str:
        """The name shown in editors."""
        return self.name or self.ink.name


@dataclass(frozen=True, eq=False)
class Sheet:
    """A drawing: its size (width, height) in mm, its layers from the bottom up, what made it and what came of it.

    Lengths are snapped to whole micrometres when made, so that save, load, save gives the
    same bytes. `recipe` goes into the file; `report` holds times and warnings and does not. `attached` are
    files by name that go into the file whole.
    """

    size: tuple[float, float]
    layers: tuple[Layer, ...] = ()
    recipe: Mapping[str, Any] = field(default_factory=dict)
    report: Mapping[str, Any] = field(default_factory=dict)
    attached: Mapping[str, bytes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        width, height = (round(float(side), 3) for side in self.size)
        if not (0 < width < np.inf and 0 < height < np.inf):
            raise ValueError(f"sheet size {self.size} mm has no area; both sides must be over 0")
        object.__setattr__(self, "size", (width, height))
        object.__setattr__(self, "layers", tuple(replace(layer, art=_snapped(layer.art)) for layer in self.layers))
        object.__setattr__(self, "recipe", MappingProxyType(dict(self.recipe)))
        object.__setattr__(self, "report", MappingProxyType(dict(self.report)))
        object.__setattr__(self, "attached", MappingProxyType(dict(self.attached)))

    @property
    def marks(self) -> Marks:
        """The marks of the first layer that has any. Raises ValueError where there are none."""
        for layer in self.layers:
            if isinstance(layer.art, Marks):
                return layer.art
        raise ValueError("the sheet has no layer of marks")

    def on(self, page: str | tuple[float, float], *, margin: float = 15.0, orientation: str = "auto") -> Sheet:
        """The same drawing in the middle of a paper, by name or (width, height) mm.

        orientation is auto (a paper with a name is turned to suit the drawing, a size stays as it
        is), portrait or landscape. Raises ValueError where the drawing does not fit inside the margin.
        """
        if not 0 <= margin < np.inf:
            raise ValueError(f"margin is {margin} mm; it takes a length of 0 or more")
        size = turned(page, self.size, orientation)
        (width, height) = self.size
        check_fit(self.size, size, margin)
        offset = _whole(np.array([(size[0] - width) / 2, (size[1] - height) / 2]))
        layers = tuple(replace(layer, art=_shifted(layer.art, offset)) for layer in self.layers)
        recipe = {**self.recipe, "paper_mm": list(size), "art_mm": [width, height], "art_at_mm": offset.tolist()}
        return Sheet(size, layers, recipe, self.report, self.attached)

    def _repr_svg_(self) -> str | None:
        """What a notebook shows of a drawing that browsers bear: up to SHOWN paths and marks."""
        if sum(len(layer.art) for layer in self.layers) > SHOWN:
            return None
        return str(_formats().to_bytes(self, "svg").decode("utf-8"))

    def _repr_png_(self) -> bytes:
        """What a notebook shows of any drawing: some 900 pixels of its longer side."""
        data: bytes = _formats().to_bytes(self, "png", dpi=min(600.0, max(20.0, 900 * INCH / max(self.size))))
        return data


@dataclass(frozen=True)
class Step:
    """One state of work under way: what stage, how much of it is done, figures of interest, a Sheet where there is one."""

    stage: str
    done: int
    total: int
    facts: Mapping[str, float] = field(default_factory=dict)
    sheet: Sheet | None = None


def _formats() -> Any:
    """The one door that goes up: a sheet shows itself, and formats, which know how, stand above sheets."""
    return import_module("crowquill.formats")


def check_bar(x: float, y: float, length: float = 10.0) -> Layer:
    """A bar of known length with ticks at its ends, its left end at (x, y) mm: whoever lays a ruler on it knows the scale."""
    thin, tick = 0.2, 1.6  # mm
    bars = [(0, 0, length, thin), (0, thin / 2 - tick / 2, thin, tick), (length - thin, thin / 2 - tick / 2, thin, tick)]
    rings = [[(x + a, y + b), (x + a + w, y + b), (x + a + w, y + b + h), (x + a, y + b + h)] for a, b, w, h in bars]
    return Layer(Ink(), Paths.of(rings), f"check bar {length:g} mm")


def turned(page: str | tuple[float, float], art: tuple[float, float], orientation: str) -> tuple[float, float]:
    """The sides of a paper in the orientation asked for; auto turns one with a name to suit the art, unless that is square."""
    size = paper(page) if isinstance(page, str) else (float(page[0]), float(page[1]))
    short, long = sorted(size)
    if orientation == "auto":
        named = isinstance(page, str) and page.strip().lower() in PAPERS
        orientation = "as it is" if art[0] == art[1] or not named else "landscape" if art[0] > art[1] else "portrait"
    sides = {"portrait": (short, long), "landscape": (long, short), "as it is": size}
    if orientation not in sides:
        raise ValueError(f"no orientation {orientation!r}; there are auto, landscape, portrait")
    return sides[orientation]


def check_fit(art: tuple[float, float], size: tuple[float, float], margin: float) -> None:
    """Raises ValueError where a drawing does not go on a paper inside a margin, all in mm."""
    if art[0] > size[0] - 2 * margin + UM or art[1] > size[1] - 2 * margin + UM:
        raise ValueError(
            f"a drawing of {art[0]:.6g} x {art[1]:.6g} mm does not fit a paper of {size[0]:g} x {size[1]:g} mm "
            f"with a margin of {margin:g} mm; make it smaller, or the paper larger"
        )


def _whole(values: Array) -> Array:
    """Millimetres to the nearest whole micrometre: the float nearest to that decimal."""
    return np.round(values, 3)


def _snapped(art: Marks | Paths) -> Marks | Paths:
    return art.snapped() if isinstance(art, Marks) else replace(art, xy=_whole(art.xy))


def _shifted(art: Marks | Paths, offset: Array) -> Marks | Paths:
    return art.moved(offset) if isinstance(art, Marks) else art.moved(np.eye(2), offset)
