"""Other programs on the same picture in the same run, and how soon ours is as good: as near in tone, and as even besides.

Each runs in an environment of its own below bench/.peers, made at its first run; nothing of ours needs them. What cannot
be installed or fails is said as not run.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from common import HERE, Report, Run, Taken, process, seconds
from PIL import Image
from scoring import Score, camera, darkness, scored
from solvers import DEFAULT, HALFTONE, LOOKED_AT, SOLVERS, Point, steps_of, until

import crowquill
from crowquill import judge, relax, seen
from crowquill.tone import Tone

HOME, SCRIPTS = HERE / ".peers", HERE / "others"
PROGRAM = str(Path(sys.executable).parent / "crowquill")
LIMIT = 900.0  # seconds, after which a peer is ended
ENOUGH = 20.0  # seconds: what takes longer is run once, else three times
MOST_STEPS = 200  # of ours
PAGE = ("--tone", "grey", "--paper", "210x210mm", "--margin", "5mm", "--quiet")
COMPARED = (20_000, 100_000)  # dots; a program that places fewer is compared at its most


Ways = dict[int, dict[str, list[Point]]]  # of solvers, by dots and name


@dataclass(frozen=True)
class Peer:
    """Another program: what it is installed as, how it is run on the files in a folder, and how its dots are read.

    needs    "pip NAME==VERSION" or "npm NAME@VERSION", or nothing where our own environment has all
    command  its words, by its environment, the folder with camera.png, dark.npy and dark.f64, and the number of dots; it writes
             figures.json and the drawing
    read     sites in pixels, and areas where dots differ, from the folder
    passes   of its own or published choice
    most     dots it can place
    relaxes  its dots, and is no halftone; slow, too slow for a quick run
    whole    a command that reads a picture and writes a file, and not a loop alone
    """

    name: str
    needs: str
    command: Callable[[Path, Path, int], list[str]]
    read: Callable[[Path], tuple[np.ndarray, np.ndarray | None]]
    passes: str
    most: int = 10**9
    whole: bool = False
    relaxes: bool = True
    slow: bool = False

    def environment(self) -> Path:
        """The folder it is installed in, made now where it is not there. Raises ChildProcessError where that fails."""
        kind, what = self.needs.split()
        place = HOME / re.sub(r"[^\w.]+", "-", what)
        if (place / "made").exists():
            return place
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        steps = {
            "pip": [[sys.executable, "-m", "venv", str(place)], [str(place / "bin" / "python"), "-m", "pip", "install", "--quiet", what]],
            "npm": [["npm", "install", "--silent", "--no-fund", "--no-audit", "--prefix", str(place), what]],
        }
        for step in steps[kind]:
            done = subprocess.run(step, capture_output=True, text=True, check=False, timeout=LIMIT)
            if done.returncode:
                raise ChildProcessError(f"{what} could not be installed: {(done.stderr.strip().splitlines() or ['no reason given'])[-1]}")
        (place / "made").touch()
        return place


def python(place: Path, folder: Path, function: str) -> list[str]:
    return [str(place / "bin" / "python"), str(SCRIPTS / "within.py"), function, str(folder / "figures.json")]


def inksep(place: Path, folder: Path, dots: int) -> list[str]:
    """Equal dots up to the border, which bring its tone error from .12 down to .065."""
    kind = ["--dot-range", "0", "--border", "0mm", "--no-preview", "--seed", "1"]
    return [*python(place, folder, "inksep.cli:main"), str(folder / "camera.png"), str(folder / "out.svg"), "--stipples", str(dots), *kind]


def plotline(place: Path, folder: Path, dots: int) -> list[str]:
    """Equal dots of the pen's width, which it draws as points: sooner than as spirals."""
    page = ["--width", "200", "--height", "200", "--margin", "0", "--set", "stipple.vary=0", "--set", "stipple.size_mm=0.3", "--quiet"]
    words = ["run", "stipple", str(folder / "camera.png"), "--out", str(folder / "out.svg"), "--set", f"voronoi.count={dots}", *page]
    return [*python(place, folder, "plotline.cli.main:main"), *words]


def d3(passes: int, step: float, jitter: float) -> Callable[[Path, Path, int], list[str]]:
    return lambda place, folder, dots: [
        "node", str(SCRIPTS / "d3.mjs"), str(place), str(folder / "figures.json"), str(folder / "dark.f64"), "1000",
        str(dots), str(passes), str(step), str(jitter), str(folder / "out.f64"),
    ]  # fmt: skip


def published(way: str, passes: int) -> Callable[[Path, Path, int], list[str]]:
    files = ("figures.json", "dark.npy"), ("out.npy",)
    return lambda _, folder, dots: [
        sys.executable, str(SCRIPTS / "published.py"), way, *(str(folder / name) for name in files[0]),
        str(dots), str(passes), *(str(folder / name) for name in files[1]),
    ]  # fmt: skip


def numbers(folder: Path, pattern: str) -> np.ndarray:
    """What a pattern's groups hold, a row a match, in the drawing."""
    return np.array(re.findall(pattern, (folder / "out.svg").read_text()), np.float64)


def circles(folder: Path) -> tuple[np.ndarray, np.ndarray | None]:
    rows = numbers(folder, r'cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"')
    return rows[:, :2], rows[:, 2] ** 2


def points(folder: Path) -> tuple[np.ndarray, np.ndarray | None]:
    return numbers(folder, r'd="M ([\d.]+) ([\d.]+) L') * 1000 / 200, None


PEERS = (
    Peer("inksep 1.0.0", "pip inksep==1.0.0", inksep, circles, "100 generations, its default", whole=True, slow=True),
    Peer("plotline 0.2.0", "pip plotline==0.2.0", plotline, points, "30 iterations, its default", most=50_000, whole=True),
    Peer("d3-delaunay 6.0.4, plain", "npm d3-delaunay@6.0.4", d3(50, 1.0, 0), lambda f: (np.fromfile(f / "out.f64").reshape(-1, 2), None),
         "50 passes"),
    Peer("d3-delaunay 6.0.4, step 1.8, jitter", "npm d3-delaunay@6.0.4", d3(80, 1.8, 10),
         lambda f: (np.fromfile(f / "out.f64").reshape(-1, 2), None), "80 passes"),
    Peer("Secord by NumPy and SciPy", "", published("secord", 50), lambda f: (np.load(f / "out.npy"), None), "50 passes, as Rougier's",
         slow=True),
    Peer("Pillow, Floyd-Steinberg", "", published("pillow", 1), lambda f: (np.load(f / "out.npy"), None), "one pass", relaxes=False),
)  # fmt: skip


@dataclass(frozen=True)
class Result:
    """What a peer did: its loop alone, all of its process, and how good its dots are."""

    loop: Taken
    run: Run
    score: Score
    dots: int


def measured(peer: Peer, folder: Path, dots: int, dark: np.ndarray) -> Result:
    """The best of three runs, or of one that takes long. Raises ChildProcessError or OSError where it cannot be run."""
    place = peer.environment() if peer.needs else HOME
    command, walls, cpus, runs = peer.command(place, folder, dots), [], [], []
    while len(runs) < 3 and sum(run.seconds for run in runs) < ENOUGH:
        runs.append(process(*command, limit=LIMIT))
        figures = json.loads((folder / "figures.json").read_text())
        walls.append(figures["seconds"])
        cpus.append(figures["cpu"])
    sites, areas = peer.read(folder)
    if not len(sites):
        raise ChildProcessError("no dots could be read from its drawing")
    return Result(Taken.of(walls, cpus), min(runs), scored(sites, dark, areas), len(sites))


def score(point: Point) -> Score:
    """How good a point of a trace is."""
    return Score(point["tone"], point["rho"])


def reached(ways: dict[str, list[Point]], wanted: Score, *, even: bool, relaxed: bool) -> tuple[str, Point] | None:
    """The solver that is as good soonest, and where on its way; relaxed: a halftone by itself does not count."""
    found = []
    for name, way in ways.items():
        own = way[1:] if relaxed and name == HALFTONE else way
        there = next((point for point in own if score(point).reaches(wanted, even=even)), None)
        found += [(name, there)] if there else []
    return min(found, key=lambda pair: pair[1]["seconds"], default=None)


class CommandLine:
    """Our own command on the picture, by dots and iterations, each kept once run."""

    def __init__(self, folder: Path, dark: np.ndarray, times: int) -> None:
        self.folder, self.dark, self.times = folder, dark, times
        self.known: dict[tuple[int, int], tuple[Run, Score]] = {}

    def at(self, dots: int, steps: int) -> tuple[Run, Score]:
        """The best of some runs, and the score of the dots that are read back from its SVG."""
        if (dots, steps) not in self.known:
            out = self.folder / "ours.svg"
            words = ("stipple", str(self.folder / "camera.png"), str(out), "--dots", str(dots), "--iterations", str(steps), *PAGE)
            run = min(process(PROGRAM, *words) for _ in range(self.times))
            drawn = seen.of_sheet(crowquill.load(out))
            left, top, width, _ = judge.where(drawn)
            self.known[dots, steps] = run, scored((drawn.sites - (left, top)) * (len(self.dark) / width), self.dark)
        return self.known[dots, steps]

    def reaching(self, dots: int, wanted: Score, steps: int) -> tuple[Run, int] | None:
        """The first run from so many steps on that is as near in tone, and its steps."""
        while steps <= MOST_STEPS:
            run, good = self.at(dots, steps)
            if good.reaches(wanted, even=False):
                return run, steps
            steps = max(steps + 1, round(1.3 * steps))
        return None


def compared(report: Report, ways: Ways) -> None:
    """Every peer at every number of dots that solvers were traced for."""
    dark = darkness(camera())
    report.missing("scikit-image's halftone", "scikit-image has no halftoning; Pillow's stands for both")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        Image.fromarray(camera()).save(folder / "camera.png")
        np.save(folder / "dark.npy", dark)
        dark.tofile(folder / "dark.f64")
        ours = CommandLine(folder, dark, 1 if report.quick else 2)
        table: list[dict[str, Any]] = []
        for dots in ways:
            for peer in PEERS:
                if dots in COMPARED or dots == peer.most:
                    one(report, peer, dots, ways, ours, table)


def halftone(report: Report, dots: int, dark: np.ndarray, theirs: Taken) -> None:
    """Our own halftone by itself, from the picture's array to the dots."""
    tone = Tone(dark, (dark.shape[1], dark.shape[0]))
    work = partial(relax.scatter, tone, dots, np.random.default_rng(0), "floyd-steinberg")
    own, good = seconds(work, 3), scored(work(), dark)
    said = f"tone error {good.tone:.4f}, rho {good.rho:.3f}; {theirs.least / own.least:.2f} times as fast"
    report.row(f"  crowquill's own halftone, {dots} dots", own, said)


def one(report: Report, peer: Peer, dots: int, ways: Ways, ours: CommandLine, table: list[dict[str, Any]]) -> None:
    """One peer at one number of dots: its row, ours for the same quality, and the line of the table."""
    if report.quick and peer.slow:
        report.missing(f"{peer.name}, {dots} dots", "it takes long and this run is quick")
        return
    if dots > peer.most:
        report.missing(f"{peer.name}, {dots} dots", f"it places {peer.most} at most, and is compared at these")
        return
    try:
        theirs = measured(peer, ours.folder, dots, ours.dark)
    except (OSError, ValueError, subprocess.SubprocessError) as error:
        report.missing(f"{peer.name}, {dots} dots", str(error))
        return
    said = f"{peer.passes}: tone error {theirs.score.tone:.4f}, rho {theirs.score.rho:.3f}, {theirs.run.memory:.0f} MB"
    report.row(f"{peer.name}, {theirs.dots} dots", theirs.loop, said)
    line = {"peer": peer.name, "dots": dots, "passes": peer.passes, **theirs.score._asdict(),
            "loop": theirs.loop._asdict(), "run": theirs.run._asdict()}  # fmt: skip
    if not peer.relaxes:
        halftone(report, dots, ours.dark, theirs.loop)
    for goal, even in (("near", False), ("even", True)):
        won = reached(ways[dots], theirs.score, even=even, relaxed=peer.relaxes)
        asked = f"{'as near in tone as' if goal == 'near' else 'as near and as even as'} {peer.name}, {dots} dots"
        if won is None:
            report.missing(f"crowquill {asked}", f"not reached in {LOOKED_AT[-1]} steps")
            continue
        solver, point = won
        spent = until(SOLVERS[solver], ours.dark, dots, point["step"])  # anew, beside theirs: hours differ
        ratio = theirs.loop.least / spent.least
        how = f"{solver}, {steps_of(point['step'])}"
        report.row(f"  crowquill {asked}", spent, how, bar=1, got=ratio, unit="times as fast", least=True)
        line[goal] = {"solver": solver, **point, "seconds": spent.least, "cpu": spent.cpu, "ratio": ratio}
        line[goal]["cpu_ratio"] = theirs.loop.cpu / spent.cpu
    first = next((point["step"] for point in ways[dots][DEFAULT] if score(point).reaches(theirs.score, even=False)), 1)
    if command := ours.reaching(dots, theirs.score, int(first)):
        run, steps = command
        ratio = theirs.run.seconds / run.seconds
        what = f"  crowquill stipple --iterations {steps}, as near as {peer.name}, {dots} dots"
        report.row(what, run.taken, f"picture to SVG; {ratio:.2f} times as fast as {'its command' if peer.whole else 'all of its process'}")
        line["command"] = {"steps": steps, **run._asdict(), "ratio": ratio, "cpu_ratio": theirs.run.cpu / run.cpu}
    table.append(line)
    report.figure("peers", table)
