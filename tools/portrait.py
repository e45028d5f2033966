"""Render gallery/portrait.png, which drawings of faces start from: a man in collar and tie, lit from the top left.

Head, hair and coat are smooth shapes grown together, each given by how far a point is from it; rays are marched to them,
shaded and shadowed, and seen on white as 8-bit grey. Nobody sat for it; the same script gives the same bytes.

Source: J. C. Hart, Sphere Tracing, The Visual Computer 12(10), 1996; smooth unions after I. Quilez.
"""

from __future__ import annotations

import math
from pathlib import Path

import numba
import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[np.float64]

OUT = Path(__file__).resolve().parents[1] / "gallery" / "portrait.png"

SIZE = (960, 1200)  # pixels, wide and high
OVER = 3  # rays to a pixel each way
HIGH = 4.1  # units of the scene that the picture is high; a head is about 2.2
MIDDLE = (0.02, -0.42)  # of the picture in the scene, whose y points up
YAW, PITCH, ROLL = math.radians(-27), math.radians(4), math.radians(-3)  # of the head
LIGHT = (-0.55, 0.58, 0.72)  # towards the lamp
FILL = (0.9, 0.1, 0.45)  # and a weak one from the other side
SKIN, HAIR, COAT, SHIRT, TIE, EYE, IRIS, PUPIL, BROW, LIPS = range(10)
ALBEDO = np.array([0.80, 0.14, 0.075, 0.92, 0.22, 0.86, 0.24, 0.02, 0.16, 0.56])
GLOSS = np.array([0.10, 0.16, 0.02, 0.02, 0.12, 0.9, 0.9, 0.9, 0.05, 0.16])
TONE = 1 / 2.2  # code value = light ** TONE

compiled = numba.njit(cache=False, error_model="numpy")
spread = numba.njit(parallel=True, error_model="numpy")


@compiled
def union(a: float, b: float, k: float) -> float:
    """The nearer of two shapes, grown together over a width k."""
    h = max(k - abs(a - b), 0.0) / k
    return min(a, b) - h * h * k / 4


@compiled
def ball(x: float, y: float, z: float, rx: float, ry: float, rz: float) -> float:
    """Distance to an ellipsoid about the origin, nearly."""
    k0 = math.sqrt((x / rx) ** 2 + (y / ry) ** 2 + (z / rz) ** 2)
    k1 = math.sqrt((x / rx**2) ** 2 + (y / ry**2) ** 2 + (z / rz**2) ** 2)
    return k0 * (k0 - 1) / k1 if k1 > 1e-9 else -min(rx, ry, rz)


@compiled
def rod(x: float, y: float, z: float, ax: float, ay: float, az: float, bx: float, by: float, bz: float, ra: float, rb: float) -> float:
    """Distance to a rod from a to b, whose radius goes from ra to rb."""
    px, py, pz, dx, dy, dz = x - ax, y - ay, z - az, bx - ax, by - ay, bz - az
    h = min(max((px * dx + py * dy + pz * dz) / (dx * dx + dy * dy + dz * dz), 0.0), 1.0)
    return math.sqrt((px - h * dx) ** 2 + (py - h * dy) ** 2 + (pz - h * dz) ** 2) - ra - h * (rb - ra)


@compiled
def step(t: float, low: float, high: float) -> float:
    """0 below low, 1 above high, and a cubic between."""
    t = min(max((t - low) / (high - low), 0.0), 1.0)
    return t * t * (3 - 2 * t)


@compiled
def skin(x: float, y: float, z: float) -> float:
    """The bare head; x is mirrored."""
    s = abs(x)
    d = ball(x, y - 0.30, z + 0.16, 0.72, 0.78, 0.88)  # cranium
    d = union(d, ball(x, y + 0.16, z - 0.16, 0.575, 0.78, 0.60), 0.30)  # face
    d = union(d, rod(s, y, z, 0.49, -0.42, 0.08, 0.15, -0.84, 0.50, 0.19, 0.16), 0.20)  # jaw
    d = union(d, ball(x, y + 0.84, z - 0.62, 0.18, 0.13, 0.14), 0.16)  # chin
    d = union(d, ball(s - 0.36, y + 0.12, z - 0.50, 0.16, 0.13, 0.16), 0.26)  # cheekbone
    d = union(d, rod(s, y, z, 0.05, 0.20, 0.735, 0.40, 0.20, 0.57, 0.07, 0.05), 0.16)  # brow
    d = -union(-d, ball(s - 0.265, y - 0.045, z - 0.83, 0.185, 0.115, 0.20), 0.12)  # socket
    nose = rod(x, y, z, 0.0, 0.16, 0.755, 0.0, -0.22, 0.975, 0.050, 0.070)
    nose = union(nose, ball(x, y + 0.255, z - 0.965, 0.085, 0.078, 0.085), 0.08)
    nose = union(nose, ball(s - 0.095, y + 0.28, z - 0.865, 0.058, 0.056, 0.085), 0.06)
    nose = -union(-nose, ball(s - 0.055, y + 0.345, z - 0.92, 0.034, 0.03, 0.05), 0.03)  # nostril
    d = union(d, nose, 0.10)
    d = union(d, ball(x, y + 0.53, z - 0.70, 0.25, 0.17, 0.125), 0.16)  # what lies under the lips
    d = -union(-d, rod(x, y, z, 0.0, -0.36, 0.905, 0.0, -0.455, 0.895, 0.014, 0.022), 0.05)  # philtrum
    d = -union(-d, rod(s, y, z, 0.17, -0.30, 0.83, 0.31, -0.50, 0.71, 0.002, 0.002), 0.06)  # from nose to mouth
    return -union(-d, rod(x, y, z, -0.12, -0.69, 0.80, 0.12, -0.69, 0.80, 0.02, 0.02), 0.10)  # above the chin


@compiled
def lips(s: float, y: float) -> tuple[float, bool]:
    """How far lips stand out from the face, seen from the front, less the line between them; and whether there are any."""
    if s > 0.24 or abs(y + 0.55) > 0.12:
        return 0.0, False
    t = 1 - (s / 0.24) ** 2
    v = y + 0.552 - 0.014 * math.cos(13 * s) * t + 0.01 * t
    high = 0.066 * t**0.8 * (1 - 0.22 * math.exp(-((s / 0.035) ** 2))) if v > 0 else 0.084 * t**0.7
    line = 0.020 * t**0.5 * math.exp(-((v / 0.010) ** 2))
    if abs(v) > high:
        return -line, False
    return (0.036 if v > 0 else 0.048) * math.sin(math.pi * abs(v) / high) ** 0.8 * t - line, True


@compiled
def lids(x: float, y: float, z: float) -> float:
    """Both lids of an eye: shells around its ball, open between two planes."""
    s = abs(x) - 0.265
    u, v, w = s, y - 0.045, z - 0.585
    r = math.sqrt(u * u + v * v + w * w)
    arch = 1 - (u / 0.17) ** 2
    upper = max(abs(r - 0.168) - 0.020, 0.056 * arch - 0.008 - v)
    lower = max(abs(r - 0.163) - 0.016, v + 0.064 * arch - 0.006)
    return union(upper, lower, 0.02)


@compiled
def ear(x: float, y: float, z: float) -> float:
    """An ear: a leaf with a rim, a hollow and a lobe."""
    u, v, w = abs(x) - 0.705 + 0.40 * z, y + 0.02, z + 0.08 + 0.20 * y
    d = ball(u, v, w, 0.05, 0.24, 0.135)
    round_ = math.sqrt((v / 0.215) ** 2 + (w / 0.118) ** 2) - 1
    rim = math.sqrt((0.13 * round_) ** 2 + (u - 0.045) ** 2) - 0.026
    d = union(d, max(rim, -w - 0.09), 0.04)
    d = -union(-d, ball(u - 0.075, v + 0.02, w - 0.01, 0.065, 0.11, 0.062), 0.04)
    return union(d, ball(u - 0.01, v + 0.21, w - 0.02, 0.045, 0.07, 0.055), 0.05)


@compiled
def hair(x: float, y: float, z: float) -> float:
    """Hair combed back from a parting: a cap with locks and strands, cut by a plane above the forehead and one before the ear."""
    turn = math.atan2(x - 0.30, y + 0.25)
    lift = 0.07 * step(turn, -0.9, 0.0) * step(-turn, -0.25, 0.12)
    d = ball(x, y - 0.33, z + 0.19, 0.775 + 0.3 * lift, 0.83 + lift, 0.93)
    flow = turn + 0.30 * z + 0.10 * math.sin(3.0 * z + 2.0 * turn)
    d -= 0.020 * math.sin(17 * flow + 1.5 * math.sin(5 * turn)) + 0.008 * math.sin(53 * flow + 2 * math.sin(9 * turn + z))
    d -= 0.004 * math.sin(131 * flow + 3 * math.sin(13 * turn))
    forehead = 0.60 + 0.06 * math.cos(4.5 * (x - 0.1)) + 0.012 * math.sin(31 * x) - y + 0.35 * (z - 0.6)  # over 0 is skin
    temple = z - 0.26 + 0.30 * max(y - 0.42, 0.0) ** 0.5 - 0.10 * step(-y, -0.02, 0.10)
    below = -0.16 - y - 0.9 * max(-z - 0.18, 0.0)
    bare = max(union(forehead, temple, 0.14), below)
    return -union(-d, -bare, 0.05)


@compiled
def turned(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point of the scene in the frame of the head."""
    y, z = y + 0.3, z
    x, y = x * math.cos(ROLL) + y * math.sin(ROLL), -x * math.sin(ROLL) + y * math.cos(ROLL)
    x, z = x * math.cos(YAW) - z * math.sin(YAW), x * math.sin(YAW) + z * math.cos(YAW)
    y, z = y * math.cos(PITCH) + z * math.sin(PITCH), -y * math.sin(PITCH) + z * math.cos(PITCH)
    return x, y - 0.3, z


@compiled
def near(x: float, y: float, z: float) -> tuple[float, int]:
    """How far the nearest shape is, and which."""
    hx, hy, hz = turned(x, y, z)
    what, s = SKIN, abs(hx)
    d = skin(hx, hy, hz)
    d = union(d, ear(hx, hy, hz), 0.05)
    neck = rod(x, y, z, 0.02, -0.55, -0.16, 0.0, -1.75, -0.32, 0.40, 0.46)
    d = union(d, neck, 0.16)
    d = union(d, lids(hx, hy, hz), 0.022)
    if hz > 0.3:
        mouth, red = lips(s, hy)
        d -= mouth
        what = LIPS if red else SKIN
    if what == SKIN and hz > 0.3:
        arch = hy - 0.215 - 0.055 * math.sin(5.2 * (s - 0.06)) + 0.003 * math.sin(110 * s + 50 * hy)
        if 0.10 < s < 0.48 and abs(arch) < 0.042 * step(s, 0.09, 0.14) * (1 - 0.8 * step(s, 0.2, 0.48)):
            what = BROW
            d -= 0.006
    ex, ey, ez = s - 0.265, hy - 0.045, hz - 0.585
    globe = math.sqrt(ex * ex + ey * ey + ez * ez) - 0.152
    if globe < d:
        d = globe
        gaze = math.hypot(hx - math.copysign(0.265, hx) + 0.035, ey - 0.004)
        what = PUPIL if gaze < 0.030 else IRIS if gaze < 0.070 else EYE
    top = hair(hx, hy, hz)
    if top < d:
        d, what = top, HAIR
    coat, cloth = dressed(x, y - 0.22, z)
    return (coat, cloth) if coat < d else (d, what)


@compiled
def dressed(x: float, y: float, z: float) -> tuple[float, int]:
    """Coat, shirt, collar and tie."""
    d = ball(x, y + 2.75, z + 0.32, 1.62, 1.12, 0.72)
    d = union(d, rod(abs(x), y, z, 0.25, -1.62, -0.40, 1.20, -2.02, -0.40, 0.28, 0.30), 0.35)
    open_ = 0.50 * (y + 2.75) / 1.0  # half the width of the coat's opening
    s, what = abs(x), COAT
    notch = -1.98 + 0.35 * (s - 0.4)
    lapel = step(s - open_, -0.01, 0.02) * step(open_ + 0.34 * step(y, -2.9, -2.1) - s, 0.0, 0.02)
    lapel *= 1 - step(abs(y - notch), 0.03, 0.012) * step(s - open_, 0.12, 0.15)
    folds = 0.012 * math.sin(9 * x + 5 * y + 2 * math.sin(3 * y)) * step(s, 0.7, 1.1)
    if z > -0.3:
        if s < open_:
            what = SHIRT
            d += 0.035
            wide = 0.085 + 0.055 * step(-y, 1.75, 2.6)
            if s < wide and y < -1.66:
                what = TIE
                d -= 0.035 + 0.02 * (1 - (s / wide) ** 2) + 0.004 * math.sin(34 * (y - 0.6 * x))
        d -= 0.045 * lapel
    d -= folds
    knot = ball(x, y + 1.66, z - 0.30, 0.115 - 0.10 * (-1.66 - y), 0.13, 0.09)
    if knot < d:
        d, what = knot, TIE
    ring = math.sqrt((x / 1.0) ** 2 + ((z + 0.24) / 1.02) ** 2)  # the collar stands around the neck, lower in front
    level = y + 1.46 + 0.20 * step(z, -0.3, 0.25) + 0.10 * step(z, 0.1, 0.3)
    stand = max(abs(ring - 0.475 + 0.12 * level) - 0.020, abs(level) - 0.16)
    stand = max(stand, 0.05 - s - 0.55 * max(0.0, -level + 0.02) if z > 0 else -9.0)
    if stand < d:
        d, what = stand * 0.8, SHIRT
    u, v = s - 0.06, y + 1.50  # a wing of the collar: a triangle that leans on the chest
    wing = max(max(-0.75 * u - 0.66 * v - 0.005, 0.95 * u + 0.31 * v - 0.33), max(v - 0.02, -v - 0.42 + 0.35 * u))
    wing = max(wing, abs(z - 0.30 + 0.55 * s * s + 0.16 * v) - 0.016)
    if wing < d:
        d, what = wing * 0.8, SHIRT
    return d, what


@compiled
def lit(x: float, y: float, z: float, lx: float, ly: float, lz: float, soft: float) -> float:
    """How much of a lamp is seen from a point, 0 to 1."""
    seen, t = 1.0, 0.03
    for _ in range(48):
        d = near(x + lx * t, y + ly * t, z + lz * t)[0]
        seen = min(seen, soft * d / t)
        if seen < 0.002 or t > 3.0:
            break
        t += min(max(d * 0.8, 0.015), 0.2)
    return step(seen, 0.0, 1.0)


@compiled
def shade(x: float, y: float, z: float, what: int) -> float:
    """Light that comes from a point of a surface."""
    e = 0.004
    nx = near(x + e, y, z)[0] - near(x - e, y, z)[0]
    ny = near(x, y + e, z)[0] - near(x, y - e, z)[0]
    nz = near(x, y, z + e)[0] - near(x, y, z - e)[0]
    n = math.sqrt(nx * nx + ny * ny + nz * nz) + 1e-12
    nx, ny, nz = nx / n, ny / n, nz / n
    lx, ly, lz = LIGHT
    n = math.sqrt(lx * lx + ly * ly + lz * lz)
    lx, ly, lz = lx / n, ly / n, lz / n
    key = max(nx * lx + ny * ly + nz * lz, 0.0)
    if key > 0:
        key *= lit(x + 0.01 * nx, y + 0.01 * ny, z + 0.01 * nz, lx, ly, lz, 7.0)
    fx, fy, fz = FILL
    weak = max(nx * fx + ny * fy + nz * fz, 0.0)
    open_ = 1.0
    for k in range(1, 6):
        open_ -= (0.06 * k - near(x + 0.06 * k * nx, y + 0.06 * k * ny, z + 0.06 * k * nz)[0]) / (0.06 * k) * 0.30 / k
    open_ = min(max(open_, 0.0), 1.0)
    hx, hy, hz = lx, ly, lz + 1
    n = math.sqrt(hx * hx + hy * hy + hz * hz)
    shine = max((nx * hx + ny * hy + nz * hz) / n, 0.0)
    gloss = GLOSS[what] * (shine**60 if GLOSS[what] > 0.5 else shine**14) * min(1.0, 4 * key)
    rim = (1 - nz) ** 3 * max(nx, 0.0) * 0.5
    return ALBEDO[what] * (0.92 * key + open_ * (0.11 + 0.13 * weak + 0.05 * max(ny, 0.0) + rim)) + gloss


@spread
def rendered(wide: int, high: int) -> Array:
    """Light (high, wide) of each ray, 1 where it meets nothing."""
    light = np.ones((high, wide))
    for row in numba.prange(high):
        for column in range(wide):
            x = MIDDLE[0] + ((column + 0.5) / wide - 0.5) * HIGH * wide / high
            y = MIDDLE[1] + (0.5 - (row + 0.5) / high) * HIGH
            z = 1.8
            for _ in range(160):
                d, what = near(x, y, z)
                if d < 0.0008:
                    light[row, column] = min(shade(x, y, z, what), 1.0)
                    break
                z -= 0.6 * d
                if z < -1.6:
                    break
    return light


if __name__ == "__main__":
    width, height = SIZE
    light = rendered(width * OVER, height * OVER).reshape(height, OVER, width, OVER).mean(axis=(1, 3))
    Image.fromarray(np.round(255 * light**TONE).astype(np.uint8)).save(OUT, optimize=True, dpi=(300, 300))
