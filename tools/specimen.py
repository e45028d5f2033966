"""Render gallery/specimen.png, which the stipple plate starts from: an ammonite in raking light.

The shell is a height field: a tube wound on a logarithmic spiral, ribbed, a little worn, cracked,
its mouth broken open. It is lit from the top left, shaded, and cut out on white as 16-bit grey.
Nothing was photographed; the same seed gives the same bytes.

Source: D. M. Raup, Geometric analysis of shell coiling, J. Paleontology 40, 1966 (expansion W).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy import ndimage

Array = NDArray[np.floating[Any]]

OUT = Path(__file__).resolve().parents[1] / "gallery" / "specimen.png"

SIZE = (1800, 1960)  # pixels, wide and high
OVER = 2  # pixels are computed this many times finer each way, then averaged
UNIT = 995.0  # pixels from the axis of the coil to the venter (outer edge) at the mouth
AXIS = (0.5625, 0.525)  # where the axis stands, as a share of SIZE
MOUTH = math.radians(-118)  # direction of the mouth, from x towards y: up and a little to the left
GROWTH = math.log(1.8) / math.tau  # W = 1.8: each whorl is 1.8 times the one inside it
SEAM = 0.495  # inner edge of a whorl as a share of its outer: below 1 / W, so whorls overlap
FLANK = 0.27  # half the thickness of a whorl as a share of its outer radius
RIBS = 38  # primary ribs a turn
RELIEF = 0.021  # how far a rib stands out, as a share of the outer radius
PINCHED = ((-0.17, 0.10), (-2.3, 0.05), (-4.9, 0.05), (-7.4, 0.05))  # constrictions: turn, depth
LIGHT = math.radians(-128), math.radians(33)  # azimuth from x towards y (top left), elevation
CLOSED = ((0.014, 3.0), (0.09, 1.2), (0.3, 0.9))  # ambient shade: spread in UNIT, weight
WHORLS = 9
BARE = (420, 545, 290)  # where the shell has gone and the cast shows: x, y from the axis, radius
TONE = 0.51  # code value = light ** TONE; 1 / 2.2 is sRGB, a little more gives the shadows weight


def smoothstep(x: Array, low: float | Array, high: float | Array) -> Array:
    """0 below low, 1 above high, and a cubic between."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)


def resized(a: Array, size: tuple[int, int], how: Image.Resampling) -> Array:
    """The picture at another size (wide, high)."""
    return np.asarray(Image.fromarray(a.astype(np.float32)).resize(size, how))


def cloud(coarse: float, octaves: int, rng: np.random.Generator) -> Array:
    """Smooth noise of unit spread at the fine pixels; each octave has half the grain and weight."""
    wide, high = SIZE[0] * OVER, SIZE[1] * OVER
    total = np.zeros((high, wide), np.float32)
    for octave in range(octaves):
        grain = coarse * OVER / 2**octave
        grid = rng.standard_normal((int(high / grain) + 4, int(wide / grain) + 4))
        total += resized(grid, (wide, high), Image.Resampling.BICUBIC) / 2**octave
    return np.asarray(total / total.std(), np.float32)


def plane() -> tuple[Array, Array]:
    """x and y of the fine pixels from the axis of the coil, in pixels of the picture."""
    y, x = np.mgrid[: SIZE[1] * OVER, : SIZE[0] * OVER].astype(np.float32)
    return (x + 0.5) / OVER - AXIS[0] * SIZE[0], (y + 0.5) / OVER - AXIS[1] * SIZE[1]


def ribs(turn: Array, s: Array, character: Array) -> Array:
    """Relief of the ribs, 0 between them to about 1 on their crests.

    turn  how far along the spiral, rad; s  across the whorl, 0 at the seam and 1 at the venter.
    Each primary rib forks on the flank. Strength, place and fork differ by rib (character, rows);
    ribs are counted along the whole spiral, so nothing shows where the polar angle starts again.
    """
    ahead = 0.05 * s + 0.13 * s**3 - 0.05 * np.sin(np.pi * s)  # rad: back, then forward
    phase = (turn - ahead) * (RIBS / math.tau)
    nearest = np.round(phase).astype(np.int64)
    total = np.zeros_like(phase)
    for step in (-1, 0, 1):
        k = (nearest + step) % character.shape[1]
        off = phase - (nearest + step) - 0.12 * (character[1][k] - 0.5)
        t = np.clip((s - 0.36 - 0.16 * character[2][k]) / 0.42, 0, 1)
        parted = (1 - (1 - t) ** 2) * (character[3][k] > 0.08)  # the others stay single
        width = 0.17 - 0.035 * parted  # of a rib's pitch
        half = 0.25 * parted
        pair = np.exp(-(((off - half) / width) ** 2)) + np.exp(-(((off + half) / width) ** 2))
        total += (0.8 + 0.3 * character[0][k]) * pair / (1 + np.exp(-((2 * half / width) ** 2)))
    return np.asarray(total, np.float32)


def whorl(r: Array, turn: Array, worn: Array, character: Array) -> tuple[Array, Array, Array]:
    """Height of one whorl's near side, of its hollow far side (both -1 where it is not), and s.

    r  from the axis, in UNIT; turn  along the spiral, 0 at the mouth; worn  0 fresh to 1 bare.
    """
    outer = np.exp(GROWTH * turn)
    s = np.clip((r / outer - SEAM) / (1 - SEAM), 0, 1)
    young = smoothstep(outer, 0.03, 0.12)  # the first whorls are smooth
    crest = RELIEF * ribs(turn, s, character) * smoothstep(s, 0.0, 0.22) * young * (1 - 0.7 * worn)
    outward = np.clip(2 * s**0.82 - 1, 0, 1) ** 1.5  # share of a rib that stands out, not up
    s = (r / (outer * (1 + 0.75 * crest * outward)) - SEAM) / (1 - SEAM)
    inside = (s > 0) & (s < 1)
    s = np.clip(s, 1e-4, 1 - 1e-4)
    body = np.sqrt(1 - np.abs(2 * s**0.82 - 1) ** 2.15)  # thickest inside the middle of the flank
    pinch = np.zeros_like(turn)
    for at, depth in PINCHED:
        pinch += depth * np.exp(-(((turn - at - 0.12 * s**2) / 0.035) ** 2))
    upward = np.sqrt((1 - outward**2) * body) * (1 - 4 * pinch)
    lines = 0.00022 * np.sin((turn - 0.16 * s**2) * 260) * body * smoothstep(outer, 0.35, 0.6)
    near = outer * (FLANK * body * (1 - pinch) + crest * upward + lines * (1 - worn))
    return np.where(inside, near, -1), np.where(inside, -0.5 * outer * FLANK * body, -1), s


def coil(worn: Array, ragged: Array, character: Array) -> Array:
    """Height over the plane of the coil in UNIT, the highest whorl winning; -1 off the shell."""
    x, y = plane()
    r = np.hypot(x, y) / UNIT
    back = np.arctan2(y, x) - MOUTH  # growth runs clockwise as seen
    turn = np.mod(back - 0.9, math.tau) + 0.9 - math.tau
    height = np.full(r.shape, -1, np.float32)
    for n in range(WHORLS):
        t = turn - math.tau * n
        outer = np.exp(GROWTH * t)
        here = (r < outer * 1.04) & (r > outer * SEAM * 0.98) & (t < 0.8)
        t, rough = t[here], 0.012 * ragged[here]
        near, hollow, s = whorl(r[here], t, worn[here], character)
        lip = t - 0.10 * s**2 + 0.06 * np.sin(np.pi * s) - rough
        lip += 0.065 * smoothstep(s, 0.8, 1.0) ** 2  # the corner at the venter is lost
        near = np.where(lip < 0, near - 0.012 * smoothstep(lip, -0.02, 0.0), -1)
        far = t - 0.15 + 0.42 * np.abs(s - 0.4) ** 2.5 - rough
        hollow = np.where(far < 0, hollow, -1)
        height[here] = np.maximum(height[here], np.maximum(near, hollow))
    return np.where(r < 0.01, 0.003, height)  # the first chamber closes the middle


def place(turn: Array, s: Array) -> Array:
    """Fine pixels (n, 2) of points given along the spiral and across the whorl."""
    r = np.exp(GROWTH * turn) * (SEAM + (1 - SEAM) * s) * UNIT
    angle = turn + MOUTH
    xy = np.stack([r * np.cos(angle), r * np.sin(angle)], 1) + np.multiply(AXIS, SIZE)
    return np.asarray(xy * OVER, np.float32)


def engraved(curves: list[Array], width: float) -> Array:
    """Where the curves run, 0 to 1, a groove of so many pixels."""
    page = Image.new("L", (SIZE[0] * OVER, SIZE[1] * OVER))
    draw = ImageDraw.Draw(page)
    for xy in curves:
        draw.line(xy.ravel().tolist(), fill=255, width=round(width * OVER), joint="curve")
    return ndimage.gaussian_filter(np.asarray(page, np.float32) / 255, 0.4 * OVER)


def sutures() -> list[Array]:
    """Where the walls of the chambers met the shell: lobes and saddles, and frills upon them."""
    u = np.linspace(0, 1, 1600)
    curves = []
    for start in np.arange(-4.9, -2.2, 0.21):
        turn = start + 0.055 * np.cos(16.3 * u) * (0.6 + 0.4 * u)
        s = 0.04 + 0.9 * u
        along, across = np.gradient(turn), np.gradient(s * 0.65)
        frill = 0.016 * np.sin(98 * u) + 0.008 * np.sin(258 * u + start)
        frill *= (0.65 + 0.35 * np.sin(27 * u + 3 * start)) / np.hypot(along, across)
        curves.append(place(turn + across * frill, s - along * frill / 0.65))
    return curves


def walk(turn: float, s: float, lean: float, steps: int, rng: np.random.Generator) -> Array:
    """A random walk (steps, 2) in (turn, s) from a point inwards, leaning along the spiral."""
    down = np.linspace(0, steps / 70, steps)
    drift = np.cumsum(0.4 * np.cumsum(rng.normal(0, 0.0012, steps)) + rng.normal(0, 0.007, steps))
    return np.stack([turn + lean * down + drift, s - down + rng.normal(0, 0.006, steps)], 1)


def cracks(rng: np.random.Generator) -> list[Array]:
    """Breaks in the shell, from the venter inwards, each with a branch."""
    curves = []
    for turn, lean, steps in ((-1.30, -0.10, 60), (-4.15, 0.20, 40)):
        stem = walk(turn, 1.02, lean, steps, rng)
        turn, s = stem[steps // 2].tolist()
        branch = walk(turn, s, -3 * lean, steps // 3, rng)
        curves += [place(*stem.T), place(*branch.T)]
    return curves


def shadow(height: Array) -> Array:
    """How much of the light from LIGHT reaches each pixel, 0 to 1, by a sweep towards the light."""
    clear = np.ones_like(height)
    ground = np.maximum(height, -FLANK)
    for reach in (*np.geomspace(3, 40, 18), *np.arange(44, 430, 6)):
        dx, dy = (round(OVER * reach * f(LIGHT[0])) for f in (math.cos, math.sin))
        run = math.hypot(dx, dy) / (UNIT * OVER)
        over = np.full_like(height, -1)
        over[-dy:, -dx:] = ground[:dy, :dx]  # both negative: the light stands to the top left
        rise = (over - ground) / run - math.tan(LIGHT[1])
        clear = np.minimum(clear, 1 - smoothstep(rise, -0.20, 0.40))
    return ndimage.gaussian_filter(clear, 1.5 * OVER)  # hides the steps of the sweep


def hollowness(height: Array, spread: float) -> Array:
    """How far each pixel lies below its surroundings within spread (UNIT), in spreads; 0 on top."""
    shrink = max(1, int(spread * UNIT * OVER / 6))
    high, wide = height.shape
    tiny = resized(height, (wide // shrink, high // shrink), Image.Resampling.BOX)
    soft = ndimage.gaussian_filter(tiny, spread * UNIT * OVER / shrink)
    around = resized(soft, (wide, high), Image.Resampling.BICUBIC)
    below = np.maximum(around - height, 0) / spread
    return np.asarray(below**2 / (below + 0.12), np.float32)


def lit(height: Array, paint: Array) -> Array:
    """Light sent to the eye by each pixel, 1 for white."""
    dy, dx = np.gradient(height, 1 / (UNIT * OVER))
    nz = 1 / np.sqrt(1 + dx**2 + dy**2)
    nx, ny = -dx * nz, -dy * nz
    azimuth, up = LIGHT
    toward = math.cos(up) * (math.cos(azimuth) * nx + math.sin(azimuth) * ny) + math.sin(up) * nz
    closed = np.zeros_like(height)
    for spread, weight in CLOSED:
        closed += weight * hollowness(np.maximum(height, -FLANK), spread)
    open_sky = 0.1 + 0.9 * np.exp(-closed)
    clear = shadow(height)
    direct = 0.5 * (toward + np.sqrt(toward**2 + 0.015)) * clear * open_sky**0.7
    bounce = np.maximum(0.62 * nx + 0.60 * ny - 0.08 * nz, 0) ** 1.5  # from below right
    gloss = np.maximum(2 * toward * nz - math.sin(up), 0) ** 14 * clear
    paint = paint * (1 - 0.35 * (1 - nz) ** 3)  # a little tone along the edge, to hold it on white
    diffuse = 0.94 * direct + open_sky * (0.04 * nz + 0.19 * bounce)
    return np.asarray(paint * diffuse + 0.10 * gloss)


def picture(seed: int) -> tuple[Array, Array]:
    """Code values, 0 black to 1 white, and the share of each pixel on the shell."""
    form, wear, grain = np.random.default_rng(seed).spawn(3)
    x, y = plane()
    patch = np.hypot(x - BARE[0], y - BARE[1]) / BARE[2]
    worn = smoothstep(1.1 - patch + 0.15 * cloud(220, 5, wear), 0.1, 0.16)
    height = coil(worn, cloud(120, 5, form), form.random((4, 512)).astype(np.float32))
    shell = height > -0.9
    crack = engraved(cracks(wear), 1.8) * np.clip(0.7 + 0.5 * cloud(20, 2, wear), 0.15, 1)
    suture = engraved(sutures(), 1.5) * worn
    rough = 0.0005 * cloud(40, 4, grain) - 0.0025 * worn - 0.004 * crack - 0.0012 * suture
    paint = (1 + 0.035 * cloud(90, 5, grain)) * (1 - 0.05 * worn)
    paint *= (1 - 0.5 * crack) * (1 - 0.35 * suture)
    light = np.where(shell, np.clip(lit(height + shell * rough, paint), 0, 1), 1)
    fine = (SIZE[1], OVER, SIZE[0], OVER)
    code = light.reshape(fine).mean((1, 3)) ** TONE
    return code.astype(np.float32), shell.reshape(fine).mean((1, 3), dtype=np.float32)


def main() -> None:
    """Write the picture, and say how its tones lie."""
    code, shell = picture(seed=1822)
    levels = np.minimum(np.round(code * 4096) * 16, 65535)  # 12 bits: a smaller file
    Image.fromarray(levels.astype(np.uint16)).save(OUT, optimize=True)
    inside = code[shell == 1]
    tones = np.percentile(inside, (1, 5, 25, 50, 75, 95, 99)).round(3).tolist()
    print(f"{OUT.stat().st_size} bytes; {shell.mean():.3f} of the picture is shell")
    print(f"code value: mean {inside.mean():.3f}; at 1 5 25 50 75 95 99 %: {tones}")


if __name__ == "__main__":
    main()
