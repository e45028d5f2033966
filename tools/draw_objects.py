"""Draw the libraries of objects: src/crowquill/shapes/<name>.svg. Same program, same bytes.

Each outline is a curve of an angle: the cosine leads along the object, the sine across it, as wide as its profile; then the
whole is bent. Twenty cubics go through it with its own tangents.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from crowquill.paths import Array, Paths

FOLDER = Path(__file__).resolve().parents[1] / "src" / "crowquill" / "shapes"
SEED = 311
SPACE = "urn:crowquill:glyphs"

Profile = Callable[[Array], Array]  # of the place along the object, -1 to 1: half its width over half its length


def curve(at: Callable[[Array], Array], anchors: int) -> Paths:
    """The closed curve of a function of the angle, through evenly spaced angles, its handles a third of its slopes."""
    turn = 2 * np.pi * np.arange(anchors) / anchors
    slope = (at(turn + 1e-5) - at(turn - 1e-5)) / 2e-5 * (2 * np.pi / anchors / 3)
    xy = at(turn)
    after, lead = np.roll(xy, -1, axis=0), np.roll(slope, -1, axis=0)
    return Paths.of([np.stack([xy, xy + slope, after - lead], axis=1).reshape(-1, 2)], cubic=True)


def body(
    profile: Profile, anchors: int = 16, *, tips: tuple[float, float] = (1, 1), bend: float = 0.0, sway: float = 0.0, skew: float = 0.0
) -> Paths:
    """An object two long about a spine on x.

    tips  left and right end: 1 as an ellipse's, more the more pointed, less the more blunt, down to 0, square
    bend  the turn of the spine from end to end, rad; sway bends it as an S; skew makes the side of rising y wider
    """

    def at(turn: Array) -> Array:
        x, side = np.cos(turn), np.sin(turn)
        sharp = tips[0] + (tips[1] - tips[0]) * (1 + x) / 2
        blunt = np.sqrt(1 - np.clip(1 - sharp, 0, 1) * x**2)
        y = profile(x) * np.sign(side) * np.abs(side) ** np.maximum(sharp, 1) / blunt * (1 + skew * np.sign(side) * side**2)
        spine = bend * x / 2  # the direction of the spine, which is an arc
        middle = np.stack([np.sinc(spine / np.pi) * x, bend * x**2 / 4 + sway * (x - x**3)], axis=1)
        lean = spine + sway * (1 - 3 * x**2)
        return middle + y[:, None] * np.stack([-np.sin(lean), np.cos(lean)], axis=1)

    return curve(at, anchors)


def round_body(radius: Callable[[Array], Array], anchors: int) -> Paths:
    """An object around its middle, of a radius for each angle."""
    return curve(lambda turn: radius(turn)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1), anchors)


def grains(rng: np.random.Generator) -> list[Paths]:
    """Ten grains such as of rice, wheat and sesame: plump, a little bent, no two ends alike."""
    found = []
    for k in range(10):
        plump, taper, bend = 0.36 + 0.022 * k + 0.02 * rng.random(), rng.uniform(-0.32, 0.32), rng.uniform(-0.5, 0.5)
        wave, phase = rng.uniform(0.0, 0.05), rng.uniform(0, 2 * np.pi)
        found.append(
            body(
                lambda x, p=plump, t=taper, w=wave, f=phase: p * (1 + t * x + w * np.sin(5 * x + f)),
                tips=(rng.uniform(0.7, 1.1), rng.uniform(0.7, 1.1)), bend=bend, skew=rng.uniform(-0.12, 0.12),
            )
        )  # fmt: skip
    return found


def leaves(rng: np.random.Generator) -> list[Paths]:
    """Ten leaves from willow to lime, on short stalks, their tips drawn out."""
    found = []
    for k in range(10):
        broad, stalk = 0.28 + 0.03 * k + 0.02 * rng.random(), rng.uniform(0.16, 0.28)
        widest = rng.uniform(0.4, 0.48)  # from the stalk's end to the tip

        def profile(x: Array, b: float = broad, s: float = stalk, m: float = widest) -> Array:
            t = np.clip((x + 1 - s) / (2 - s), 0, 1)
            power = np.log(0.5) / np.log(m)
            blade = b * np.sin(np.pi * t**power) ** (0.75 + 0.4 * t)
            return np.sqrt(blade**2 + 0.05**2)

        bend = rng.uniform(0.25, 0.75) * (1 if k % 2 else -1)
        found.append(body(profile, 28, tips=(0.1, 1.0), bend=bend, sway=rng.uniform(-0.05, 0.05), skew=rng.uniform(-0.12, 0.12)))
    return found


def ticks(rng: np.random.Generator) -> list[Paths]:
    """Eight short strokes of a pointed pen: pressed down at once, and lifted while still moving."""
    found = []
    for k in range(8):
        press, heel = 0.11 + 0.012 * k, rng.uniform(-0.5, -0.25)
        found.append(
            body(
                lambda x, p=press, h=heel: p * (0.42 + 0.58 * np.exp(-2.2 * (x - h) ** 2)) * (1 - 0.3 * x),
                tips=(0.3, 1.3), bend=rng.uniform(-0.45, 0.45), sway=rng.uniform(-0.04, 0.04), skew=rng.uniform(-0.2, 0.2),
            )
        )  # fmt: skip
    return found


def diatoms(rng: np.random.Generator) -> list[Paths]:
    """Twelve silhouettes of diatoms: boats with drawn-out ends, clubs, bananas, an S, a bone, discs, a triangle and a cross."""
    headed = lambda p, n, w: lambda x: p * np.cos(np.pi / 2 * np.clip(np.abs(x) * n, 0, 1)) ** 1.2 + w * (1 + 0.35 * np.abs(x) ** 6)  # noqa: E731
    boats = [
        body(lambda x: 0.30 * (1 - 0.45 * x**2), tips=(1.25, 1.25)),  # Navicula
        body(headed(0.26, 1.25, 0.09), 28, tips=(0.1, 0.1)),  # Stauroneis
        body(headed(0.36, 1.15, 0.08), 28, tips=(0.1, 0.1)),
        body(lambda x: 0.17 * (1 + 0.18 * np.cos(3 * np.pi * x)), 32, tips=(0.12, 0.12)),  # Pinnularia, thrice undulate
        body(lambda x: 0.30 * (1 + 0.30 * x - 0.18 * x**2), tips=(1.3, 0.7)),  # Gomphonema
        body(lambda x: 0.30 * (1 - 0.35 * x**2), tips=(1.1, 1.1), bend=1.1, skew=0.25),  # Cymbella
        body(lambda x: 0.17 * (1 - 0.2 * x**2), tips=(0.9, 0.9), sway=0.3),  # Gyrosigma
        body(lambda x: 0.24 * (1 - 0.4 * np.exp(-5 * x**2)), 24, tips=(0.2, 0.2)),  # Achnanthes
        body(lambda x: 0.66 * (1 - 0.08 * x**2), tips=(1.05, 1.05)),  # Cocconeis
    ]
    phase = rng.uniform(0, 2 * np.pi)
    return [
        *boats,
        round_body(lambda turn: 0.62 * (1 + 0.035 * np.cos(13 * turn + phase)), 52),  # Cyclotella, its rim scalloped
        round_body(lambda turn: 0.66 * (1 + 0.16 * np.cos(3 * turn)), 24),  # Triceratium
        round_body(lambda turn: 0.62 * (1 + 0.24 * np.cos(4 * turn)), 32),  # Amphitetras
    ]


LENGTHS = {"grains": 1.6, "leaves": 2.4, "ticks": 2.0, "diatoms": 2.0}  # mm, of an object two long


def svg(name: str, drawn: list[Paths], about: str) -> str:
    """A library as SVG, its objects in a row, at true size."""
    half, step = LENGTHS[name] / 2, 1.25 * LENGTHS[name]
    width, height = step * len(drawn), step
    meta = {"name": name, "how": f"drawn by tools/draw_objects.py: {about}", "by": "crowquill", "licence": "CC0-1.0", "simulated": True}
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" viewBox="0 0 {width:g} {height:g}">',
        f'<metadata><library xmlns="{SPACE}">{json.dumps(meta)}</library></metadata>',
    ]
    for k, outline in enumerate(drawn):
        points = np.round(outline.xy * half + (step * (k + 0.5), height / 2), 4)
        text = [f"{x:g} {y:g}" for x, y in points]
        sides = ["C" + " ".join([*text[i + 1 : i + 3], text[(i + 3) % len(text)]]) for i in range(0, len(text), 3)]
        lines.append(f'<path id="{name}{k + 1}" d="M{text[0]}{"".join(sides)}Z"/>')
    return "\n".join([*lines, "</svg>\n"])


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for k, maker in enumerate((grains, leaves, ticks, diatoms)):
        name, about = maker.__name__, (maker.__doc__ or "").splitlines()[0].rstrip(".")
        drawn = maker(np.random.default_rng([SEED, k]))
        (FOLDER / f"{name}.svg").write_text(svg(name, drawn, about[0].lower() + about[1:]), encoding="utf-8")
