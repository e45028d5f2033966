"""The boxes of a PDF's page, and the way from its units to millimetres."""

from __future__ import annotations

from typing import Any

import pikepdf

from crowquill.preflight.drawing import Box
from crowquill.preflight.values import real
from crowquill.units import POINT

A4 = (0.0, 0.0, 595.276, 841.89)  # points
BOXES = ("/MediaBox", "/CropBox", "/BleedBox", "/TrimBox", "/ArtBox")
FURTHEST = 14_400 * 75  # points: ten times the largest page, in its largest unit


def boxes(page: Any) -> dict[str, Box]:
    """The page's boxes in mm from the top left of its MediaBox; broken ones are left out, and a page without takes A4."""
    found = {"MediaBox": A4, **sides_of(page)}
    unit, (left, _, _, top) = POINT * real(page.get("/UserUnit"), 1.0), found["MediaBox"]
    return {name: ((a - left) * unit, (top - d) * unit, (c - left) * unit, (top - b) * unit) for name, (a, b, c, d) in found.items()}


def sides_of(page: Any) -> dict[str, Box]:
    """The boxes that can be read, in the page's own units, each from its low corner to its high one."""
    found: dict[str, Box] = {}
    for name in BOXES:
        box = _inherited(page, name)
        if isinstance(box, pikepdf.Array) and len(box) == 4:
            a, b, c, d = (real(side, float("nan")) for side in box)
            if all(abs(value) < FURTHEST for value in (a, b, c, d)):
                found[name[1:]] = min(a, c), min(b, d), max(a, c), max(b, d)
    return found


def base(page: Any) -> tuple[float, float, float, float, float, float]:
    """The matrix from the page's own units to mm from the top left of its MediaBox, y down."""
    unit, (left, _, _, top) = POINT * real(page.get("/UserUnit"), 1.0), sides_of(page).get("MediaBox", A4)
    return unit, 0.0, 0.0, -unit, -left * unit, top * unit


def _inherited(page: Any, name: str) -> Any:
    """A box of a page, or of the nodes it hangs from."""
    for _ in range(50):
        if name in page:
            return page[name]
        page = page.get("/Parent")
        if not isinstance(page, pikepdf.Dictionary) or name not in ("/MediaBox", "/CropBox"):
            return None
    return None
