"""Items: what is edited, one row each, in the whole numbers that frames and files keep."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.marks import TURN_STEPS, Glyph
from crowquill.objects import Shape
from crowquill.paths import Array, Index, Paths

UM = 1000  # to the mm
STEP = 2 * np.pi / TURN_STEPS  # rad
OWN = 0x01000000  # of a fill: the item has a colour of its own, 0xRRGGBB

Mask = npt.NDArray[np.bool_]
Columns = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Kind:
    """A shape that items have: its outline about its centre, as large as it is at a scale of 1 mm.

    glyph  the unit glyph, where it is one: items of it are marks in files, others paths
    name   library and number, where it comes from one
    """

    paths: Paths
    glyph: Glyph | None = None
    name: str = ""

    @classmethod
    def of_glyph(cls, glyph: Glyph, name: str = "") -> Kind:
        """The kind that a glyph is."""
        return cls(glyph.paths, glyph, name)

    @cached_property
    def key(self) -> bytes:
        """The same for all kinds of the same outline."""
        head = f"{self.paths.closed}{self.paths.cubic}{self.glyph is None}{self.paths.start.tolist()}"
        return hashlib.sha256(head.encode() + self.paths.xy.tobytes()).digest()

    @cached_property
    def reach(self) -> float:
        """The greatest distance of the outline from the centre at scale 1, mm, up to a thousandth too large."""
        return self.glyph.reach if self.glyph else float(np.hypot(*self.paths.xy.T).max()) + 1e-3

    @property
    def axis(self) -> float:
        """The direction of its long axis, rad; of a glyph that is x."""
        return 0.0 if self.glyph else self.shape.axis

    @cached_property
    def shape(self) -> Shape:
        """The kind as what settles. Outlines that enclose nothing are taken for lines."""
        try:
            return Shape.of(self.paths)
        except ValueError:
            flat = self.paths.flat(1e-3 * self.reach).xy
            return Shape.of(Paths.of([flat if np.ptp(flat, axis=0).any() else flat[:1]], closed=False))


@dataclass(frozen=True, eq=False)
class Items:
    """Rows of items, by rising id.

    id        (n,) uint32
    um        (n, 2) int32, where the centre lies on the sheet
    scale     (n,) uint32, in thousandths of the kind's own size
    turn      (n,) uint16, 65536ths of a turn from x towards y
    kind      (n,) uint32 index into the drawing's kinds
    fill      (n,) uint32, 0 for the layer's ink, else OWN and red, green, blue
    selected  (n,) bool, and frozen (n,) bool
    """

    id: Columns
    um: Columns
    scale: Columns
    turn: Columns
    kind: Columns
    fill: Columns
    selected: Mask
    frozen: Mask

    def __post_init__(self) -> None:
        for name, dtype in COLUMNS.items():
            column = np.ascontiguousarray(getattr(self, name), dtype)
            column.setflags(write=False)
            object.__setattr__(self, name, column)

    @classmethod
    def none(cls) -> Items:
        """No items."""
        return cls(**{name: np.zeros((0, 2) if name == "um" else 0, dtype) for name, dtype in COLUMNS.items()})

    @classmethod
    def of(
        cls,
        first: int,
        xy: Array,
        *,
        scale: npt.ArrayLike,
        angle: npt.ArrayLike = 0.0,
        kind: npt.ArrayLike = 0,
        fill: npt.ArrayLike = 0,
    ) -> Items:
        """New items at xy (n, 2) mm, with ids from `first`; the others are one value for all or (n,): scale mm, angle rad."""
        n = len(xy)

        def column(values: npt.ArrayLike) -> Columns:
            return np.broadcast_to(np.asarray(values), n)

        return cls(
            np.arange(first, first + n), micrometres(xy), sizes(column(scale)), turns(column(angle)), column(kind), column(fill),
            np.zeros(n, bool), np.zeros(n, bool),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.id)

    @cached_property
    def xy(self) -> Array:
        """Where the centres lie, (n, 2) mm."""
        return np.asarray(self.um / UM, np.float64)

    @property
    def mm(self) -> Array:
        """The scale, (n,) mm."""
        return np.asarray(self.scale / UM, np.float64)

    @property
    def angle(self) -> Array:
        """The turn, (n,) rad."""
        return np.asarray(self.turn * STEP, np.float64)

    def columns(self) -> list[Columns]:
        """All columns."""
        return [getattr(self, name) for name in COLUMNS]

    def take(self, which: Index | Mask | slice) -> Items:
        """The items at these indices, this mask or slice."""
        return Items(**{name: getattr(self, name)[which] for name in COLUMNS})

    def posed(
        self,
        rows: Index | Mask | slice,
        *,
        xy: Array | None = None,
        mm: Array | None = None,
        angle: Array | None = None,
        frozen: bool = False,
    ) -> Items:
        """The items, those at these rows with other places, scales or angles; frozen ones keep what they have, but on request."""
        may = None if frozen else ~self.frozen
        changes = {
            name: _set(getattr(self, name), rows, values, may)
            for name, values in (
                ("um", None if xy is None else micrometres(xy)),
                ("scale", None if mm is None else sizes(mm)),
                ("turn", None if angle is None else turns(angle)),
            )
            if values is not None
        }
        return replace(self, **changes)

    def having(self, rows: Index | Mask | slice, **columns: npt.ArrayLike) -> Items:
        """The items, those at these rows with other values in these columns."""
        return replace(self, **{name: _set(getattr(self, name), rows, np.asarray(values), None) for name, values in columns.items()})

    @classmethod
    def joined(cls, parts: Sequence[Items]) -> Items:
        """The items of several, by id."""
        whole = {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}
        rises = (np.diff(whole["id"].astype(np.int64)) > 0).all()
        order = slice(None) if rises else np.argsort(whole["id"], kind="stable")
        return cls(**{name: column[order] for name, column in whole.items()})


COLUMNS: dict[str, Any] = {
    "id": np.uint32,
    "um": np.int32,
    "scale": np.uint32,
    "turn": np.uint16,
    "kind": np.uint32,
    "fill": np.uint32,
    "selected": np.bool_,
    "frozen": np.bool_,
}


def micrometres(xy: Array) -> Columns:
    """Millimetres as whole micrometres."""
    return np.round(np.asarray(xy) * UM).astype(np.int32)


def sizes(mm: npt.ArrayLike) -> Columns:
    """Scales in mm as thousandths, one at least: what has no size cannot be found again."""
    return np.clip(np.round(np.asarray(mm) * UM), 1, 2**31 - 1).astype(np.uint32)


def turns(angle: npt.ArrayLike) -> Columns:
    """Angles in rad as steps of a turn."""
    return (np.round(np.asarray(angle) / STEP).astype(np.int64) % TURN_STEPS).astype(np.uint16)


def colours(rgb: npt.ArrayLike) -> Columns:
    """Red, green, blue (n, 3) of 0 to 255 as fills."""
    red, green, blue = np.asarray(rgb, np.uint32).T
    return np.asarray(OWN | red << 16 | green << 8 | blue, np.uint32)


def _set(column: Columns, rows: Index | Mask | slice, values: Columns, may: Mask | None) -> Columns:
    found = column.copy()
    if may is not None and not may.all():
        free = may[rows]
        values = np.where(free[:, None] if values.ndim == 2 else free, values, found[rows])
    found[rows] = values
    return found
