"""Render gallery/still_life.png, the picture in colour that drawings in several inks start from: fruit on a white table.

Solids are distances: rays go forward by what is free around them until they touch one. A sun and a sky light them; the table
is as white as the paper, and shows shadows alone. Nothing was photographed; the same numbers give the same bytes.

Source: J. C. Hart, Sphere Tracing, The Visual Computer 12(10), 1996.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[np.floating[Any]]
Solid = Callable[[Array], Array]

OUT = Path(__file__).resolve().parents[1] / "gallery" / "still_life.png"

SIZE = (760, 570)  # pixels, wide and high
OVER = 2  # pixels are computed this many times finer each way, then averaged
EYE, TARGET = (0.1, -6.2, 3.1), (-0.05, -0.14, 0.40)
VIEW = 0.272  # half the width of the picture over how far off it is
SUN = (-0.55, -0.42, 0.72)
STEPS, NEAR, FAR = 90, 1e-3, 14.0


def ball(centre: tuple[float, float, float], radius: float) -> Solid:
    """The distance to a ball."""
    return lambda p: np.asarray(np.linalg.norm(p - centre, axis=1) - radius)


def orange(p: Array) -> Array:
    """A ball a little flat, hollow at the stem, with a dimpled skin."""
    q = (p - (-0.75, 0.15, 0.62)) / (1, 1, 0.95)
    r = np.linalg.norm(q, axis=1)
    hollow = 0.05 * np.exp(-((q[:, 0] - 0.12) ** 2 + (q[:, 1] + 0.2) ** 2 + (q[:, 2] - 0.6) ** 2) / 0.012)
    skin = (
        0.0035
        * np.sin(47 * q[:, 0] + 3 * np.sin(19 * q[:, 1]))
        * np.sin(43 * q[:, 1] + 2)
        * np.sin(45 * q[:, 2] + 2 * np.sin(17 * q[:, 0]))
    )
    return np.asarray(0.9 * (r - 0.65 + hollow + skin))


def lemon(p: Array) -> Array:
    """An ellipsoid that lies on its side and ends in a nub."""
    turn = np.array([[0.86, 0.51, 0.05], [-0.51, 0.86, 0.0], [-0.04, -0.03, 1.0]])
    q = (p - (0.72, -0.62, 0.4)) @ turn.T
    along, round_ = q[:, 0], np.hypot(q[:, 1], q[:, 2])
    width = 0.4 * np.sqrt(np.maximum(1 - (np.abs(along) / 0.6) ** 2.1, 0)) + 0.075 * np.exp(-((np.abs(along) - 0.6) ** 2) / 0.006)
    rough = 0.003 * np.sin(39 * q[:, 0]) * np.sin(41 * q[:, 1] + 1) * np.sin(37 * q[:, 2])
    body = 0.55 * (round_ - width + rough)
    return np.where(np.abs(along) > 0.66, np.hypot(np.abs(along) - 0.66, np.maximum(round_ - 0.03, 0)), body)


def plum(p: Array) -> Array:
    """A long ball with a seam."""
    q = (p - (0.42, 0.55, 0.5)) / (0.94, 0.9, 1.06)
    r = np.linalg.norm(q, axis=1)
    seam = 0.035 * np.exp(-((q[:, 0] + 0.35 * q[:, 2] + 0.16) ** 2) / 0.004) * (q[:, 1] < 0)
    return np.asarray(0.8 * (r - 0.52 + seam))


def leaf(p: Array) -> Array:
    """A thin bowed leaf, pointed at both ends, with veins."""
    turn = np.array([[0.93, -0.36, 0.07], [0.36, 0.93, 0.0], [-0.07, 0.03, 0.99]])
    q = (p - (-1.02, -0.98, 0.1)) @ turn.T
    along, across = q[:, 0] / 0.66, q[:, 1]
    half = 0.27 * np.maximum(1 - along**2, 0) * (1 + 0.3 * along)
    ribs = 0.010 * np.exp(-np.abs(across) / 0.02) + 0.004 * np.cos(38 * (q[:, 0] - 0.8 * np.abs(across)))
    surface = 0.16 * along**2 + 0.6 * across**2 - ribs
    out = np.maximum(np.abs(across) - half, (np.abs(along) - 1) * 0.66)
    return np.asarray(0.5 * np.maximum(out, np.abs(q[:, 2] - surface) - 0.014))


def stem(p: Array) -> Array:
    """The stems of the cherries, bowed, that meet above them."""
    t = np.clip(p[:, 2] / 0.95, 0, 1)
    first = np.hypot(p[:, 0] + 0.13 - 0.24 * t**2, p[:, 1] + 1.06 - 0.34 * t) - 0.017
    second = np.hypot(p[:, 0] - 0.24 + 0.13 * t**1.5, p[:, 1] + 1.32 - 0.6 * t) - 0.017
    return np.asarray(0.8 * np.maximum(np.minimum(first, second), np.maximum(p[:, 2] - 0.95, 0.3 - p[:, 2])))


# each solid with its paint in linear light and how it shines: how much, how sharply
SOLIDS: list[tuple[Solid, tuple[float, float, float], tuple[float, float]]] = [
    (orange, (0.95, 0.30, 0.015), (0.22, 18)),
    (lemon, (0.96, 0.74, 0.04), (0.25, 20)),
    (plum, (0.085, 0.045, 0.19), (0.22, 12)),
    (leaf, (0.10, 0.33, 0.045), (0.16, 10)),
    (ball((-0.13, -1.06, 0.21), 0.21), (0.62, 0.012, 0.03), (0.75, 60)),
    (ball((0.24, -1.32, 0.2), 0.2), (0.52, 0.008, 0.025), (0.75, 60)),
    (stem, (0.20, 0.26, 0.05), (0.1, 10)),
]


def nearest(p: Array) -> tuple[Array, NDArray[np.intp]]:
    """The distance (n,) of points (n, 3) from the nearest solid, and which that is; the table is the last."""
    every = np.stack([*(solid(p) for solid, *_ in SOLIDS), p[:, 2]])
    return every.min(axis=0), every.argmin(axis=0)


def traced(start: Array, way: Array) -> Array:
    """How far rays go until they touch something, (n,); FAR where they touch nothing."""
    far = np.full(len(way), 0.05)
    going = np.arange(len(way))
    for _ in range(STEPS):
        free, _ = nearest(start[going] + far[going, None] * way[going])
        far[going] += free
        going = going[(free > NEAR) & (far[going] < FAR)]
        if not len(going):
            break
    return np.minimum(far, FAR)


def shadow(p: Array, way: Array) -> Array:
    """The share of a wide sun that points see, (n,): how nearly the rays towards it graze a solid."""
    seen, far = np.ones(len(p)), np.full(len(p), 0.03)
    for _ in range(46):
        free, _ = nearest(p + far[:, None] * way)
        seen = np.minimum(seen, 0.5 + 0.5 * 9 * free / far)
        far += np.clip(free, 0.025, 0.3)
    seen = np.clip(seen, 0, 1)
    return np.asarray(seen * seen * (3 - 2 * seen))


def open_sky(p: Array, up: Array) -> Array:
    """The share of the sky over points with these normals that solids leave free, (n,)."""
    shut = sum(0.55**k * np.maximum(0.13 * k - nearest(p + 0.13 * k * up)[0], 0) / (0.13 * k) for k in range(1, 6))
    return np.clip(1 - 0.85 * shut, 0, 1)


def normals(p: Array) -> Array:
    """The way in which the distance grows, (n, 3)."""
    sides = [nearest(p + step)[0] - nearest(p - step)[0] for step in 2e-3 * np.eye(3)]
    way = np.stack(sides, axis=1)
    return np.asarray(way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12))


def lit(p: Array, way: Array) -> Array:
    """The light (n, 3) that points send back along the rays that found them."""
    _, which = nearest(p)
    up, sun = normals(p), np.array(SUN) / np.linalg.norm(SUN)
    seen, sky = shadow(p + 4e-3 * up, np.broadcast_to(sun, p.shape)), open_sky(p, up)
    paint = np.array([paint for _, paint, _ in SOLIDS] + [(1.0, 1.0, 1.0)])[which]
    gloss, sharp = np.array([shine for *_, shine in SOLIDS] + [(0.0, 1.0)])[which].T
    toward = np.clip(up @ sun, 0, 1)
    half = sun - way
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    shine = gloss * np.clip((up * half).sum(axis=1), 0, 1) ** sharp * seen
    rim = 0.10 * (1 - np.clip(-(up * way).sum(axis=1), 0, 1)) ** 3 * sky * (gloss > 0)  # the table, seen in the skin
    below = 0.20 * np.clip(0.6 - up[:, 2], 0, 1)  # light that the table sends up
    colour = (0.80 * toward * seen)[:, None] * (1.0, 0.97, 0.90) + (0.30 * sky)[:, None] * (0.86, 0.93, 1.0) + below[:, None]
    table = (which == len(SOLIDS))[:, None]
    white = 1 - (1 - (0.36 + 0.64 * seen)[:, None] * (1 - 0.55 * (1 - sky))[:, None]) * (0.88, 0.87, 0.72)
    return np.where(table, white, paint * colour + shine[:, None] + rim[:, None])


def rendered() -> Image.Image:
    """The picture in sRGB."""
    wide, high = SIZE[0] * OVER, SIZE[1] * OVER
    eye = np.array(EYE)
    ahead = np.array(TARGET) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (0, 0, 1.0))
    right /= np.linalg.norm(right)
    x = VIEW * (2 * (np.arange(wide) + 0.5) / wide - 1)
    y = VIEW * high / wide * (1 - 2 * (np.arange(high) + 0.5) / high)
    light = np.ones((high, wide, 3))
    for row in range(0, high, 60):
        over, down = np.meshgrid(x, y[row : row + 60])
        way = ahead + over.reshape(-1, 1) * right + down.reshape(-1, 1) * np.cross(right, ahead)
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        far = traced(np.broadcast_to(eye, way.shape), way)
        hit = far < FAR
        found = np.ones((len(way), 3))
        found[hit] = lit(eye + far[hit, None] * way[hit], way[hit])
        light[row : row + 60] = found.reshape(-1, wide, 3)
    light = np.clip(light, 0, 1).reshape(SIZE[1], OVER, SIZE[0], OVER, 3).mean(axis=(1, 3))
    code = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.round(255 * code).astype(np.uint8))


if __name__ == "__main__":
    rendered().save(OUT, optimize=True)
