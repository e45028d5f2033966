"""What a plotter would draw of a file, and the comparison with the strokes of a sheet: written apart from what is tested."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

PAGE = (60.0, 40.0)


@dataclass
class Stroke:
    """What lay on the paper while the pen was down: the pen's number, its places in mm, seconds at rest."""

    pen: int
    places: list[tuple[float, float]] = field(default_factory=list)
    rest: float = 0.0


def hpgl(data: bytes) -> list[Stroke]:
    """The strokes of an HPGL file, origin bottom left and y up. AssertionError for what an old plotter does not know."""
    strokes: list[Stroke] = []
    pen, down, at = 0, False, (0.0, 0.0)
    for word in data.decode("ascii").replace("\n", "").split(";")[:-1]:
        name, numbers = word[:2], [float(part) for part in word[2:].split(",") if part]
        assert name in {"IN", "VS", "SP", "PU", "PD"}, word
        if name == "SP":
            pen, down = int(numbers[0]), False
        if name in {"PU", "PD"}:
            if name == "PD" and not down:
                strokes.append(Stroke(pen, [at]))
            down = name == "PD"
            for x, y in zip(numbers[::2], numbers[1::2], strict=True):
                at = x / 40, y / 40
                if down:
                    strokes[-1].places.append(at)
    assert not down and pen == 0, "the pen is left on the paper, or in the holder"
    return strokes


def gcode(data: bytes, lowered: Callable[[dict[str, float]], bool | None], milliseconds: bool = False) -> list[Stroke]:
    """The strokes of G-code in its own axes; `lowered` says of a line's words whether they put the pen down, lift it, or neither.

    A new pen is in the machine after each M0. AssertionError where the pen is down on G0.
    """
    strokes: list[Stroke] = []
    pen, down, at = 1, False, (0.0, 0.0)
    for line in data.decode("ascii").split("\n"):
        bare = re.sub(r"\(.*?\)|;.*|M117.*", "", line)
        words = {letter: float(number) for letter, number in re.findall(r"([A-Z])(-?[\d.]+)", bare)}
        assert re.fullmatch(r"(\s*[A-Z]-?\d+(\.\d+)?)*\s*", bare), line
        pen += words.get("M") == 0
        said = lowered(words)
        if said and not down:
            strokes.append(Stroke(pen, [at]))
        down = down if said is None else said
        if words.get("G") == 4 and down:
            strokes[-1].rest += words["P"] / (1000 if milliseconds else 1)
        if "X" in words:
            at = words["X"], words["Y"]
            assert words["G"] == down, f"{line}: G0 travels and G1 draws"
            if down:
                strokes[-1].places.append(at)
    assert not down
    return strokes


def asked(sheet: Sheet) -> list[tuple[int, npt.NDArray[np.float64]]]:
    """Layer and places of each stroke of a sheet, y down, curves in 50 parts a piece, rings back at their first point."""
    found = []
    for number, layer in enumerate(sheet.layers, 1):
        paths = layer.art.outlines() if isinstance(layer.art, Marks) else layer.art
        for path in paths:
            points = np.concatenate([path, path[:1]]) if paths.closed else path
            if paths.cubic:
                t = np.linspace(0, 1, 51)[:, None]
                runs = [points[i : i + 4] for i in range(0, len(points) - 1, 3)]
                bent = [(1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d for a, b, c, d in runs]
                points = np.concatenate(bent)
            found.append((number, points))
    return found


def faults(drawn: list[Stroke], sheet: Sheet, step: float) -> list[str]:
    """Where the strokes drawn, in mm and y down, are not those of the sheet, in its order.

    A curve may stray by half a step and its places, rounded both ways, by .71 of one: 1.21 in all. Strokes that
    round to one place are dots.
    """
    wanted = asked(sheet)
    if len(drawn) != len(wanted):
        return [f"{len(drawn)} strokes for {len(wanted)}"]
    said = []
    for i, (stroke, (layer, points)) in enumerate(zip(drawn, wanted, strict=True)):
        places = np.array(stroke.places)
        if stroke.pen != layer:
            said.append(f"stroke {i} has pen {stroke.pen} for {layer}")
        ends = np.abs(places[[0, -1]] - points[[0, -1]]).max()
        there = shapely.distance(shapely.points(places), _line(points)).max()
        back = shapely.distance(shapely.points(points), _line(places)).max()
        if ends > 0.5001 * step or max(there, back) > 1.21 * step:
            said.append(f"stroke {i} strays by {max(ends, there, back):.4f} mm")
    return said


def _line(points: npt.NDArray[np.float64]) -> shapely.Geometry:
    return shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])


def scribble(seed: int = 1, names: tuple[str, ...] = ("one", "two", "three")) -> Sheet:
    """Strokes of all kinds on a small page: lines, curves, rings, dots smaller than any step, one layer a name and an empty one."""
    rng = np.random.default_rng(seed)

    def near(n: int, reach: float) -> npt.NDArray[np.float64]:
        return np.asarray(rng.uniform(5, 35, 2) + rng.uniform(-reach, reach, (n, 2)))

    lines = Paths.of([*(near(n, 5) for n in (2, 3, 9)), near(1, 0), near(2, 0.002), near(2, 1)], closed=False)
    curves = Paths.of([near(4, 5), near(7, 3), near(4, 0.001)], closed=False, cubic=True)
    rings = Paths.of([near(3, 4), near(6, 0.002), near(6, 0.1), near(1, 1)])
    blobs = Paths.of([near(12, 4), near(12, 0.2)], cubic=True)
    arts = [lines, Paths.of([]), curves, rings, blobs][: len(names) + 1]
    labels = [names[0], "empty", *names[1:]]
    inks = [Ink("black", pen=0.3), Ink("none"), *[Ink("ink", pen=0.1)] * 3]
    return Sheet(PAGE, tuple(Layer(ink, art, name) for ink, art, name in zip(inks, arts, labels, strict=False)), {"style": "stipple"})
