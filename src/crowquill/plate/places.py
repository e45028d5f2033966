"""Where panels lie on a page: by rows and columns, or where they are put; and that none lies off it or over another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

from scipy.optimize import brentq

from crowquill.plate.parts import Content, Size
from crowquill.plate.platefile import Grid, Panel, named
from crowquill.units import UM

Spot = tuple[int, int, int, int]  # row, column, rows, columns
LEAST = 1.0  # mm: a picture that is smaller has no room


@dataclass(frozen=True)
class Box:
    """A rectangle of paper, mm."""

    left: float
    top: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Where it ends."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Where it ends below."""
        return self.top + self.height

    def meets(self, other: Box) -> bool:
        """Whether they share more than a border."""
        across = min(self.right, other.right) - max(self.left, other.left)
        down = min(self.bottom, other.bottom) - max(self.top, other.top)
        return across > UM and down > UM


@dataclass(frozen=True)
class Want:
    """A panel with what it shows, and what its words need: mm above its picture, and below it by the width it has."""

    panel: Panel
    content: Content
    above: float
    below: Callable[[float], float]

    @property
    def shape(self) -> float:
        """Height over width."""
        return self.content.shape[1] / self.content.shape[0]

    def natural(self, width: float) -> tuple[float, float]:
        """Heights in a place this wide: of its words and what has a stated size, and of a picture that may shrink."""
        fixed, words = self.content.fixed, self.above + self.below(width)
        return (words + fixed[1], 0.0) if fixed else (words, width * self.shape)

    def fitted(self, room: Size, share: float = 1.0) -> Size:
        """The picture's size in a room, at most this share of the room's width if it may shrink. Raises ValueError where it has none."""
        if min(room) < LEAST:
            raise ValueError(f"its picture has a room of {room[0]:.4g} x {room[1]:.4g} mm; make the page larger or its words fewer")
        if fixed := self.content.fixed:
            if fixed[0] > room[0] + UM or fixed[1] > room[1] + UM:
                raise ValueError(
                    f"it is {fixed[0]:.6g} x {fixed[1]:.6g} mm and has a room of {room[0]:.6g} x {room[1]:.6g} mm; "
                    "give a width, or make the room larger"
                )
            return fixed
        if self.panel.fit != "contain":
            return room
        width = min(share * room[0], room[1] / self.shape)
        return round(width, 3), round(min(room[1], width * self.shape), 3)


def spots(wants: Sequence[Want], names: Sequence[str], grid: Grid, margin: float, room: Size) -> list[tuple[Box, Box]]:
    """For each panel the box of its picture and that of it all: where `at` says, or in the rows and columns of a room in its margins.

    Raises ValueError, which says the panel's name, for one that has no room.
    """
    gridded = [k for k, want in enumerate(wants) if want.panel.at is None]
    found = {}
    if gridded:
        put = _in_grid([wants[k] for k in gridded], [names[k] for k in gridded], grid, margin, room)
        found = dict(zip(gridded, put, strict=True))
    for k, want in enumerate(wants):
        if want.panel.at is not None:
            with named(names[k]):
                found[k] = _put(want, want.panel.at)
    return [found[k] for k in range(len(wants))]


def _put(want: Want, at: Size) -> tuple[Box, Box]:
    """The boxes of a panel whose room begins at a place of the page."""
    panel, content = want.panel, want.content
    room = panel.size or content.fixed
    if room is None:
        raise ValueError("it does not say how large it is drawn; give size or width")
    width, height = want.fitted(room)
    left, top = at[0] + round((room[0] - width) / 2, 3), at[1] + round((room[1] - height) / 2, 3)
    art = Box(left, top, width, height)
    return art, Box(left, top - want.above, width, want.above + height + want.below(width))


def _in_grid(wants: Sequence[Want], names: Sequence[str], grid: Grid, margin: float, room: Size) -> list[tuple[Box, Box]]:
    """The boxes of panels in rows and columns."""
    at = _spots([want.panel for want in wants], names, grid)
    widths = list(grid.widths) or [(room[0] - (grid.columns - 1) * grid.gutter) / grid.columns] * grid.columns
    if sum(widths) + (len(widths) - 1) * grid.gutter > room[0] + UM or min(widths) < LEAST:
        raise ValueError(f"grid: its columns have a room of {room[0]:.6g} mm; make them or the gutter narrower")
    across = [_span(widths, column, columns, grid.gutter) for _, column, _, columns in at]
    natural = []
    for want, name, wide in zip(wants, names, across, strict=True):
        with named(name):
            natural.append(want.natural(wide))
    heights, share = _heights(natural, at, grid, room[1])
    found = []
    for want, name, (row, column, rows, _), wide in zip(wants, names, at, across, strict=True):
        left = margin + sum(widths[:column]) + column * grid.gutter
        top = margin + sum(heights[:row]) + row * grid.gutter
        deep = _span(heights, row, rows, grid.gutter)
        with named(name):
            width, height = want.fitted((wide, deep - want.above - want.below(wide)), share)
        art = Box(round(left + (wide - width) / 2, 3), round(top + want.above, 3), width, height)
        found.append((art, Box(left, top, wide, deep)))
    return found


def check(boxes: Sequence[Box], names: Sequence[str], size: Size) -> None:
    """Raises ValueError for a panel that reaches over the page, and for two that overlap."""
    for name, box in zip(names, boxes, strict=True):
        over = max(-box.left, -box.top, box.right - size[0], box.bottom - size[1])
        if over > UM:
            raise ValueError(f"{name}: reaches {over:.4g} mm over a page of {size[0]:g} x {size[1]:g} mm; move it or make it smaller")
    for (one, box), (other, next_box) in combinations(zip(names, boxes, strict=True), 2):
        if box.meets(next_box):
            raise ValueError(f"{one} and {other} overlap; move one, or make it smaller")


def _spots(panels: Sequence[Panel], names: Sequence[str], grid: Grid) -> list[Spot]:
    """Row, column, rows and columns of each panel; who says no cell takes the next that is free."""
    taken: set[tuple[int, int]] = set()
    found, at = [], 0
    for panel, name in zip(panels, names, strict=True):
        rows, columns = panel.span
        if panel.cell:
            row, column = panel.cell[0] - 1, panel.cell[1] - 1
        else:
            row, column = divmod(at, grid.columns)
            while columns <= grid.columns and (column + columns > grid.columns or taken & _cells(row, column, rows, columns)):
                at += 1
                row, column = divmod(at, grid.columns)
        if column + columns > grid.columns or (grid.rows and row + rows > grid.rows):
            size = f"{grid.columns} wide" + (f" and {grid.rows} high" if grid.rows else "")
            raise ValueError(f"{name}: is outside a grid {size}; give another cell or span, or more columns")
        taken |= _cells(row, column, rows, columns)
        found.append((row, column, rows, columns))
    return found


def _cells(row: int, column: int, rows: int, columns: int) -> set[tuple[int, int]]:
    return {(row + r, column + c) for r in range(rows) for c in range(columns)}


def _span(sides: Sequence[float], first: int, count: int, gutter: float) -> float:
    return sum(sides[first : first + count]) + (count - 1) * gutter


def _heights(natural: Sequence[Size], spots: Sequence[Spot], grid: Grid, most: float) -> tuple[list[float], float]:
    """The heights of rows, and the share of their own size that pictures have in them.

    Rows are as high as is said, or as their panels are by themselves. Where those are over `most`, words keep their size and
    all pictures shrink by one factor.
    """
    gutters = (max(row + rows for row, _, rows, _ in spots) - 1) * grid.gutter
    room = most - gutters
    if grid.heights:
        if sum(grid.heights) + (len(grid.heights) - 1) * grid.gutter > most + UM:
            raise ValueError(f"grid: its rows have a room of {most:.6g} mm; make them or the gutter lower")
        return list(grid.heights), 1.0
    if room <= LEAST:
        raise ValueError(f"grid: its rows have a room of {most:.6g} mm; make the page higher, or the gutter lower")
    low, share = 0.0, 1.0
    if sum(_rows(natural, spots, grid.gutter, share)) > room:
        if (words := sum(_rows(natural, spots, grid.gutter, low))) >= room:
            raise ValueError(f"grid: its rows have a room of {room:.6g} mm and their words take {words:.4g} mm; make the page higher")
        share = float(brentq(lambda part: sum(_rows(natural, spots, grid.gutter, part)) - room, low, share, xtol=1e-9))
    return _rows(natural, spots, grid.gutter, share), share


def _rows(natural: Sequence[Size], spots: Sequence[Spot], gutter: float, share: float) -> list[float]:
    """The heights of rows whose pictures have this share of their own size."""
    heights = [0.0] * max(row + rows for row, _, rows, _ in spots)
    for (words, art), (row, _, rows, _) in sorted(zip(natural, spots, strict=True), key=lambda each: each[1][2]):  # those of one row first
        heights[row + rows - 1] += max(0.0, words + share * art - _span(heights, row, rows, gutter))
    return heights
