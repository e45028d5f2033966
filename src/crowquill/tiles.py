"""Tiles of a mosaic as polygons: cut off lines and canvas, measured, and in the picture's colours.

Source: A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001; G. Di Blasi, G. Gallo, Artificial Mosaics, The Visual
Computer 21(6), 2005, for stones that are cut.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import moments
from crowquill.cells import Cells
from crowquill.paths import Array, Paths
from crowquill.picture import encoded, linear
from crowquill.tone import Tone
from crowquill.tracing import XYZ
from crowquill.vector import contents

SNAP = 1.5e-3  # mm: corners go to whole micrometres, and two move towards each other by 1.42 of them at most
LEAST = 0.3  # of a stone's area; what is cut smaller is a sliver
SLIT = 1.08  # of its hull's length that a stone's outline may have; a line that ends inside one gives it more

Stones = npt.NDArray[np.object_]  # shapely Polygons


def squares(xy: Array, angle: Array, sides: Array) -> Stones:
    """Rectangles about centres (n, 2) mm, turned by angles (n,) rad, with sides (n, 2) mm, the first along the angle."""
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, None]
    v = u[..., ::-1] * (-1, 1)
    along, across = np.array([-0.5, 0.5, 0.5, -0.5]), np.array([-0.5, -0.5, 0.5, 0.5])
    corners = xy[:, None] + u * (sides[:, :1] * along)[..., None] + v * (sides[:, 1:] * across)[..., None]
    found: Stones = shapely.polygons(corners) if len(xy) else np.zeros(0, object)
    return found


def severed(stones: Stones, lines: Paths, gap: float) -> Stones:
    """Stones with what lies across a line cut off, half a gap in mm away from it: of its parts each keeps the largest.

    A line that ends inside a stone, or goes round within it, cuts nothing.
    """
    strokes = shapely.linestrings(lines.xy, indices=lines.path) if len(lines.xy) else np.zeros(0, object)
    pieces = shapely.get_parts(strokes)
    ends = [np.stack([xy[:-1], xy[1:]], axis=1) for xy in map(shapely.get_coordinates, pieces)]
    sides = shapely.linestrings(np.concatenate([np.empty((0, 2, 2)), *ends]))
    reach = (gap + SNAP) / 2 * 1.01  # round ends are drawn by chords, which fall short of the circle by 0.5 %
    stone, side = shapely.STRtree(sides).query(stones, predicate="dwithin", distance=reach)
    found = stones.copy()
    if not len(stone):
        return found
    which, group = np.unique(stone, return_inverse=True)
    order = np.argsort(group, kind="stable")
    knives = shapely.buffer(shapely.multilinestrings(sides[side[order]], indices=group[order]), reach, quad_segs=8)
    rest = largest(shapely.difference(stones[which], knives))
    rest = shapely.polygons(shapely.get_exterior_ring(rest))
    sound = shapely.length(rest) <= SLIT * shapely.length(shapely.convex_hull(rest))
    found[which] = np.where(sound | (shapely.area(rest) < LEAST * shapely.area(stones[which])), rest, stones[which])
    return found


def held(stones: Stones, canvas: shapely.Geometry, gap: float, fine: float = 0.0) -> Stones:
    """Stones cut half a gap in mm inside a canvas; each keeps its largest part, or is empty.

    fine  mm: an outline that needs fewer corners to stay within so much, as one of steps along pixels, is cut along
          those, and further inside by as much
    """
    inner = shapely.buffer(canvas, -(gap + SNAP) / 2, join_style="mitre")
    if shapely.get_num_coordinates(shapely.simplify(inner, fine)) < shapely.get_num_coordinates(inner):
        plain = shapely.simplify(shapely.buffer(inner, -fine, join_style="mitre"), fine)
        inner = shapely.intersection(plain, inner)
    shapely.prepare(inner)
    found = stones.copy()
    over = ~shapely.contains_properly(inner, stones)
    found[over] = largest(shapely.intersection(stones[over], inner))
    return found


def largest(shapes: npt.NDArray[np.object_]) -> Stones:
    """The largest Polygon of each shape, an empty one where it has none."""
    parts, whole = shapely.get_parts(shapes, return_index=True)
    solid = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    parts, whole = parts[solid], whole[solid]
    order = np.lexsort((shapely.area(parts), whole))
    found = np.full(len(shapes), shapely.Polygon(), dtype=object)
    found[whole[order]] = parts[order]
    return found


def rings_of(stones: Stones) -> Paths:
    """The outlines of stones in whole micrometres, each sound; a stone none is left of has no points.

    Where rounding folds a stone up or pinches it in two, its largest part stays.
    """
    snapped = shapely.orient_polygons(largest(shapely.set_precision(stones, 1e-3)))
    xy, stone = shapely.get_coordinates(shapely.get_exterior_ring(snapped), return_index=True)
    kept = ~np.append(stone[1:] != stone[:-1], True)[: len(xy)]  # shapely repeats the first point of a ring
    return Paths(np.round(xy[kept], 3), np.concatenate([[0], np.cumsum(np.bincount(stone[kept], minlength=len(stones)))]))


def met(rings: Paths) -> tuple[float, float]:
    """How rings lie to each other: the area of overlaps, mm^2, and the least distance between two, infinite where there is one."""
    stones = rings.polygons()
    if len(stones) < 2:
        return 0.0, np.inf
    tree = shapely.STRtree(stones)
    i, j = tree.query(stones, predicate="intersects")
    i, j = i[i < j], j[i < j]
    over = float(shapely.area(shapely.intersection(stones[i], stones[j])).sum())
    _, far = tree.query_nearest(stones, exclusive=True, return_distance=True)
    return over, float(far.min(initial=np.inf))


def means(rings: Paths, values: Array, size: tuple[float, float]) -> Array:
    """The mean over each ring of values (h, w) of 0 to 1, one a pixel of a rectangle of this size in mm: exact, (n,)."""
    middle = moments.of_rings(rings)
    cells = Cells(middle.centroid, rings, np.arange(len(rings)), shapely.box(0, 0, *size))
    mass = moments.of_tone(cells, Tone(values, size)).mass
    return np.clip(mass / np.where(middle.mass > 0, middle.mass, 1), 0, 1)


def colours(rings: Paths, tone: Tone) -> Array:
    """The colour of each ring, (n, 3) sRGB code values of 0 to 255, of the mean of the light that the picture has there.

    Light is averaged, not code values, as an eye does that stands so far off that tiles are one. Where a tone has no
    colours the codes are those of grey ink by its coverage.
    """
    if tone.rgb is None:
        return np.asarray(np.repeat(255 * (1 - means(rings, tone.coverage, tone.size))[:, None], 3, axis=1))
    bands = [means(rings, linear(tone.rgb[..., k] / 255), tone.size) for k in range(3)]
    return np.asarray(255 * encoded(np.stack(bands, axis=1)))


def palette(text: str) -> Array:
    """The colours (n, 3), 0 to 255, of a list such as "#aa3322,#e8e0d0", or of a file of such, or a GIMP palette.

    A colour is #rrggbb or #rgb; a name may follow it, and in a file "# " begins a line of comment. Raises ValueError where there
    are none, and for what is no colour.
    """
    file = bool(text) and not text.lstrip().startswith("#") and (bool(Path(text).suffix) or Path(text).exists())
    listed = contents(Path(text)).decode("utf-8-sig", "replace") if file else text
    codes = _of_gimp(listed, text) if listed.startswith("GIMP Palette") else _of_list(listed, text)
    if not codes:
        raise ValueError(f"palette {text!r} has no colours; give some as #aa3322,#e8e0d0, a file of such, or a GIMP palette")
    return np.array(codes, np.float64)


def _of_list(listed: str, text: str) -> list[list[int]]:
    """Colours between commas, semicolons and ends of lines, each with a name after it or without."""
    codes = []
    for entry in re.split(r"[,;\n]", re.sub(r"^[ \t]*#([ \t\r].*)?$", "", listed, flags=re.MULTILINE)):
        for place, word in enumerate(entry.split()):
            if place and not word.startswith("#"):
                continue
            if not re.fullmatch(r"#([0-9a-fA-F]{3}){1,2}", word):
                raise ValueError(f"palette {text!r} has no colours; give some as #aa3322,#e8e0d0, not {word[:20]!r}")
            digits = word[1:] if len(word) == 7 else "".join(2 * digit for digit in word[1:])
            codes.append([int(digits[k : k + 2], 16) for k in (0, 2, 4)])
    return codes


def _of_gimp(listed: str, text: str) -> list[list[int]]:
    """Colours of the rows of a GIMP palette: three numbers, and a name or none."""
    codes = []
    for line in listed.splitlines()[1:]:
        if not line.strip() or re.match(r"\s*#|(Name|Columns|Channels):", line):
            continue
        row = re.match(r"\s*(\d+)\s+(\d+)\s+(\d+)(\s|$)", line)
        if not row or max(map(int, row.groups()[:3])) > 255:
            raise ValueError(f"palette {text!r}: {line.strip()[:40]!r} is no colour; give three numbers from 0 to 255")
        codes.append([int(part) for part in row.groups()[:3]])
    return codes


def matched(codes: Array, choice: Array) -> Array:
    """Of the colours to choose from, (k, 3), the one nearest to each of codes (n, 3), by distance in CIE Lab."""
    from scipy.spatial import cKDTree

    return np.asarray(choice[cKDTree(lab(choice)).query(lab(codes))[1]])


def lab(codes: Array) -> Array:
    """CIE Lab (n, 3) of sRGB code values of 0 to 255."""
    ratio = linear(codes / 255) @ (XYZ / XYZ.sum(axis=1, keepdims=True)).T
    x, y, z = np.where(ratio > 216 / 24389, np.cbrt(ratio), ratio * (24389 / 27 / 116) + 16 / 116).T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


def shrunk(rings: Paths, area: Array) -> Paths:
    """Rings made smaller about their centroids until each has so many mm^2, (n,); those that have less stay as they are."""
    own = moments.of_rings(rings)
    scale = np.sqrt(np.clip(area / np.where(own.mass > 0, own.mass, 1), 0, 1))
    middle = own.centroid[rings.path]
    return rings_of(Paths(middle + (rings.xy - middle) * scale[rings.path][:, None], rings.start).polygons())
