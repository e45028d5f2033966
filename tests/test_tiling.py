"""Tiles: where dots go tile by tile is where they go on the whole page, whoever works the tiles, and whatever happens to them."""

from __future__ import annotations

import errno
import os
import signal
import warnings
from itertools import islice
from pathlib import Path
from typing import Any

import clusters
import numpy as np
import pytest
import shapely
from PIL import Image

import crowquill
from crowquill import Tone, processes, relax, styles, tiling
from crowquill.__main__ import main
from crowquill.cluster import Workers
from crowquill.tiling import page, seams, windows
from crowquill.tiling.grid import Grid, asked
from crowquill.tiling.hands import submitted

STEPS = 4
NEAR = 1e-6  # mm: of steps that differ by rounding, 1e-13 mm each, and pull dots together
SIZE = (160.0, 120.0)
Y, X = np.mgrid[:240, :320] / 240
SOFT = 0.05 + 0.85 * (0.5 + 0.5 * np.sin(5 * X) * np.cos(4 * Y))
ISLANDS = np.where((np.hypot(X - 0.6, Y - 0.5) < 0.35) | (np.hypot(X - 0.12, Y - 0.12) < 0.1), SOFT, 0.0)
GRAIN = np.where(np.random.default_rng(5).random(SOFT.shape) < 0.4, 0.0, SOFT)
RING = shapely.Point(80, 60).buffer(58).difference(shapely.Point(76, 60).buffer(16)).union(shapely.box(2, 2, 18, 18))
TONES = {
    "soft": Tone(SOFT, SIZE),
    "islands in white": Tone(ISLANDS, SIZE),
    "grain with white in it": Tone(GRAIN, SIZE),
    "a ring with an island": Tone(SOFT, SIZE, RING),
}


def first(tone: Tone, n: int = 4500, seed: int = 3) -> np.ndarray[Any, Any]:
    return relax.scatter(tone, n, np.random.default_rng(seed))


def tiled(sites: Any, tone: Tone, **how: Any) -> tiling.Relaxed:
    return styles.run(tiling.relaxed(sites, tone, **{"tiles": "2x2", "iterations": STEPS, **how}))


def whole(sites: Any, tone: Tone, steps: int = STEPS, **how: Any) -> relax.State:
    avoid = how.pop("avoid", True)
    states = relax.lloyd(sites, tone, banned=tone.coverage == 0 if avoid else None, **how)
    return next(islice(states, steps, None))


def off(found: tiling.Relaxed, state: relax.State) -> float:
    """How far a dot is at most from where it is on the whole page, mm."""
    return float(np.abs(found.sites - state.sites).max())


@pytest.mark.parametrize("name", TONES)
def test_dots_go_in_tiles_where_they_go_on_the_whole_page(name):
    tone = TONES[name]
    sites = first(tone)
    found, state = tiled(sites, tone), whole(sites, tone)
    assert off(found, state) < NEAR
    assert found.grid.shape == (2, 2)
    assert found.energy == pytest.approx(state.energy, rel=1e-9)
    assert found.movement == pytest.approx(state.movement, rel=0.03)  # cells that white lets reach out of sight end with the window


@pytest.mark.parametrize("how", [{"exponent": 0.0}, {"exponent": 1.0, "step": 1.0}, {"avoid": False}], ids=str)
def test_so_they_do_by_other_weights_and_steps(how):
    tone = TONES["islands in white"]
    sites = first(tone)
    assert off(tiled(sites, tone, **how), whole(sites, tone, **how)) < NEAR


def test_a_tile_that_was_given_too_little_is_done_again_with_more(monkeypatch):
    tone = TONES["soft"]
    sites = first(tone)
    monkeypatch.setattr(page, "HALO", 0.01)
    monkeypatch.setattr(page, "MORE", 1.0)
    found = tiled(sites, tone)
    assert found.again > 4
    assert off(found, whole(sites, tone)) < NEAR


def test_the_comparison_sees_tiles_that_do_not_look_far_enough(monkeypatch):
    tone = TONES["soft"]
    sites = first(tone)
    monkeypatch.setattr(page, "HALO", 0.01)
    monkeypatch.setattr(windows, "_farthest_ink", lambda _state, _weight, own, _known: np.zeros(own))
    assert off(tiled(sites, tone), whole(sites, tone)) > 0.05


def test_movement_that_is_small_enough_ends_it():
    tone = TONES["soft"]
    sites = first(tone)
    found = tiled(sites, tone, iterations=200, until=0.03)
    states = relax.lloyd(sites, tone, banned=tone.coverage == 0)
    state = next(state for state in states if state.movement < 0.03)
    assert found.done == state.done
    assert off(found, state) < NEAR


@pytest.mark.parametrize(
    "sites",
    [np.zeros((0, 2)), np.array([[5.0, 5.0]]), np.full((7, 2), 30.0), np.stack([np.linspace(1, 150, 9), np.full(9, 20.0)], axis=1)],
    ids=["none", "one", "coincident", "in a row"],
)
def test_few_sites_and_awkward_ones_have_an_answer(sites):
    found = tiled(sites, TONES["soft"])
    assert found.sites.shape == sites.shape
    assert np.isfinite(found.sites).all()
    assert TONES["soft"].holds(found.sites).all()


def test_sites_that_coincide_across_tiles_do_not_disturb_the_others():
    tone = TONES["soft"]
    sites = np.concatenate([first(tone, 4000), np.full((40, 2), 60.0)])
    found = tiled(sites, tone, tiles="2x2", iterations=2)
    far = np.hypot(*(sites - 60).T) > 25
    assert np.abs(found.sites - whole(sites, tone, 2).sites)[far].max() < NEAR


def test_every_tile_begins_with_as_many_dots_and_each_dot_is_in_one():
    sites = first(TONES["islands in white"], 9001)
    grid = Grid.of(sites, 4, 3, SIZE)
    counts = np.bincount(grid.tile(sites), minlength=12)
    assert counts.sum() == 9001
    assert np.ptp(counts) <= 2
    assert len(grid.lines) == 3 + 4 * 2


@pytest.mark.parametrize(
    ("wish", "dots", "shape"),
    [("auto", 100, (1, 1)), ("auto", 640_000, (3, 3)), ("auto", 100_000_000, (41, 30)), ("4x2", 8000, (4, 2)), (" 1x1 ", 5, (1, 1))],
)
def test_tiles_are_as_many_as_asked_or_as_give_each_some_80_000_dots(wish, dots, shape):
    assert asked(wish, dots, SIZE) == (*shape, [])


def test_tiles_of_too_few_dots_are_fewer_and_that_is_said():
    columns, rows, said = asked("40x40", 20_000, SIZE)
    assert columns * rows * 1000 <= 20_000
    assert "12.5 dots each" in said[0]
    assert "4x4 are used" in said[0]


@pytest.mark.parametrize("wish", ["", "4", "0x3", "3x0", "-1x2", "1001x1", "axb", "2x2x2", "99999999999x1"])
def test_what_is_no_number_of_tiles_is_refused(wish):
    with pytest.raises(ValueError, match=r"it takes auto, or columns by rows such as 4x4, each from 1 to 1000"):
        asked(wish, 1000, SIZE)


@pytest.fixture(scope="module")
def alone() -> tuple[Any, bytes]:
    """First sites, and the bytes of where they go in this process."""
    sites = first(TONES["islands in white"])
    return sites, tiled(sites, TONES["islands in white"]).sites.tobytes()


def hired(alone: tuple[Any, bytes], **hands: Any) -> bytes:
    """Where the same sites go when others work the tiles."""
    with tiling.hiring(tiling.Hands(**hands)):
        return tiled(alone[0], TONES["islands in white"]).sites.tobytes()


@pytest.mark.parametrize("workers", [1, 3])
def test_as_many_processes_as_you_like_give_the_same_bytes(alone, workers):
    assert hired(alone, workers=workers) == alone[1]


def test_workers_of_a_cluster_give_the_same_bytes(alone, tmp_path):
    with clusters.cluster(tmp_path, 2) as made:
        assert hired(alone, scheduler=made.address) == alone[1]


def test_a_worker_that_dies_changes_nothing(alone, monkeypatch):
    begun: list[int] = []
    begin = processes._Process.__init__

    def noted(self: Any, *arguments: Any) -> None:
        begin(self, *arguments)
        begun.append(self._child.pid)

    def killing(pool: Any, *task: Any) -> Any:
        """Ends the first worker when tasks are given out, of which it has one."""
        given.append(submitted(pool, *task))
        if len(given) == 6:
            os.kill(begun[0], signal.SIGKILL)
        return given[-1]

    given: list[Any] = []
    submitted = page.submitted
    monkeypatch.setattr(page, "submitted", killing)
    monkeypatch.setattr(processes._Process, "__init__", noted)
    found = hired(alone, workers=2)
    assert found == alone[1]
    assert len(begun) > 2, "no worker took the dead one's place; the test has missed its moment"


def test_work_that_was_stopped_goes_on_in_its_folder_to_the_same_bytes(alone, tmp_path):
    hands = tiling.Hands(folder=tmp_path)
    with tiling.hiring(hands):
        work = tiling.relaxed(alone[0], TONES["islands in white"], tiles="2x2", iterations=STEPS)
        for step in work:
            if step.stage == "relax" and step.done == 2:
                break
        work.close()
        steps: list[int] = []
        again = tiling.relaxed(alone[0], TONES["islands in white"], tiles="2x2", iterations=STEPS)
        found = styles.run(again, lambda step: steps.append(step.done) if step.stage == "relax" else None)
    assert steps == [2, 3, 4]
    assert found.sites.tobytes() == alone[1]
    assert {path.name for path in tmp_path.iterdir()} == {hands.kept[0].name}


def test_what_is_kept_of_other_work_is_not_taken_up(alone, tmp_path):
    with tiling.hiring(tiling.Hands(folder=tmp_path)):
        tiled(alone[0] + 0.01, TONES["islands in white"])
        steps: list[int] = []
        work = tiling.relaxed(alone[0], TONES["islands in white"], tiles="2x2", iterations=1)
        styles.run(work, lambda step: steps.append(step.done) if step.stage == "relax" else None)
    assert steps == [0, 1]


@pytest.mark.parametrize("damage", [b"", b"PK", b"no such thing"], ids=["empty", "cut", "other"])
def test_what_is_kept_and_broken_is_begun_anew(alone, tmp_path, damage):
    hands = tiling.Hands(folder=tmp_path)
    with tiling.hiring(hands):
        tiled(alone[0], TONES["islands in white"])
        hands.kept[0].write_bytes(damage)
        assert tiled(alone[0], TONES["islands in white"]).sites.tobytes() == alone[1]


def test_large_windows_are_handed_out_without_a_word_and_other_warnings_are_heard():
    class Loud(Workers):
        count, here = 1, False

        def submit(self, fn: Any, /, *args: Any, **_: Any) -> Any:
            warnings.warn(fn(*args), stacklevel=2)

    submitted(Loud(), str, "Sending large graph of size 18.40 MiB.")
    with pytest.warns(UserWarning, match="something else"):
        submitted(Loud(), str, "something else")


# seams


@pytest.mark.parametrize("name", ["soft", "a ring with an island"])
def test_seams_cannot_be_told_from_the_rest(name):
    tone = TONES[name]
    found = tiled(first(tone, 16_000), tone, tiles="4x4")
    told = seams.of(found.sites, found.grid.lines, tone.size, np.random.default_rng(1))
    assert min(told.on, told.off) >= seams.FEWEST
    assert told.nearest is not None and told.nearest > 0.01, told
    assert told.spectrum is not None and told.spectrum > 0.01, told


def walled(sites: Any, tone: Tone, grid: Grid, steps: int) -> Any:
    """Where sites go when each tile is relaxed by itself between hard borders, and nothing more is done."""
    (columns, rows), placed, tile = grid.shape, sites.copy(), grid.tile(sites)
    x = [0.0, *grid.across, tone.size[0]]
    for k in range(columns * rows):
        column, row = divmod(k, rows)
        y = [0.0, *grid.down[column], tone.size[1]]
        alone = Tone(tone.coverage, tone.size, shapely.box(x[column], y[row], x[column + 1], y[row + 1]))
        placed[tile == k] = whole(sites[tile == k], alone, steps).sites
    return placed


def test_tiles_with_hard_borders_are_told_by_their_seams():
    tone = TONES["soft"]
    sites = first(tone, 16_000)
    grid = Grid.of(sites, 4, 4, tone.size)
    told = seams.of(walled(sites, tone, grid, STEPS), grid.lines, tone.size, np.random.default_rng(1))
    assert told.nearest is not None and told.nearest < 0.01, told
    assert told.spectrum is not None and told.spectrum < 0.01, told


def test_too_few_strips_say_nothing():
    tone = TONES["soft"]
    for sites, lines in ((first(tone, 300), Grid.of(first(tone, 300), 2, 2, SIZE).lines), (np.zeros((0, 2)), np.zeros((0, 2, 2)))):
        told = seams.of(sites, lines, SIZE, np.random.default_rng(1))
        assert (told.nearest, told.spectrum) == (None, None)


@pytest.mark.soak
@pytest.mark.parametrize("name", TONES)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_seams_of_many_dots_cannot_be_told_from_the_rest_nor_from_the_whole_drawing(name, seed):
    tone, steps = TONES[name], 20
    sites = first(tone, 40_000, seed)
    found, state = tiled(sites, tone, tiles="4x4", iterations=steps), whole(sites, tone, steps)
    assert off(found, state) < NEAR
    told, same = (seams.of(each, found.grid.lines, tone.size, np.random.default_rng(1)) for each in (found.sites, state.sites))
    print(name, seed, told, same)
    assert told == same, "seams show what the whole drawing does not"
    if name in ("soft", "islands in white"):  # in the others the picture itself differs from strip to strip, in the whole drawing too
        assert told.nearest is not None and told.nearest > 0.01, told
        assert told.spectrum is not None and told.spectrum > 0.01, told


@pytest.mark.soak
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_hard_borders_of_many_dots_are_told(seed):
    tone = TONES["soft"]
    sites = first(tone, 40_000, seed)
    grid = Grid.of(sites, 4, 4, tone.size)
    bad = seams.of(walled(sites, tone, grid, 20), grid.lines, tone.size, np.random.default_rng(1))
    print("hard borders", seed, bad)
    assert bad.nearest is not None and bad.spectrum is not None
    assert max(bad.nearest, bad.spectrum) < 0.01, bad


# the command line

QUICK = ("--paper", "80x60mm", "--margin", "5mm", "--tone", "grey", "--dots", "4000", "--iterations", "3", "--quiet")


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Image.fromarray((255 * (1 - ISLANDS)).astype(np.uint8)).save("islands.png")
    return tmp_path


def drawn(name: str, *more: str) -> int:
    return main(["stipple", "islands.png", name, *QUICK, *more])


@pytest.mark.usefixtures("desk")
def test_a_drawing_in_tiles_has_the_dots_of_the_whole_one():
    assert drawn("whole.svg") == drawn("tiles.svg", "--tiles", "2x2", "--workers", "2") == 0
    marks, others = (crowquill.load(name).marks for name in ("whole.svg", "tiles.svg"))
    for column in ("xy", "angle", "scale", "glyph"):
        np.testing.assert_array_equal(getattr(marks, column), getattr(others, column))


@pytest.mark.usefixtures("desk")
def test_redo_gives_the_same_bytes_in_tiles_and_says_what_came_of_them():
    assert drawn("one.pdf", "--tiles", "2x2", "--workers", "1", "--report", "one.json") == 0
    assert '"tiles": {' in Path("one.json").read_text()
    assert main(["redo", "one.pdf", "again.pdf", "--workers", "2", "--quiet"]) == 0
    assert Path("one.pdf").read_bytes() == Path("again.pdf").read_bytes()


@pytest.mark.usefixtures("desk")
def test_a_folder_of_work_is_empty_once_the_files_are_written():
    Path("work").mkdir()
    assert drawn("one.svg", "--tiles", "2x2", "--work", "work") == 0
    assert list(Path("work").iterdir()) == []


def test_a_disk_that_is_full_is_said_in_one_line_and_leaves_nothing(desk, monkeypatch, capsys):
    Path("work").mkdir()

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(page.np, "savez", full)
    assert drawn("one.svg", "--tiles", "2x2", "--work", "work") == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("crowquill: work/tiles-")
    assert error.endswith("no space left on device; free some space\n")
    assert {path.name for path in desk.iterdir()} == {"islands.png", "work"}
    assert list(Path("work").iterdir()) == []


REFUSED = {
    "tiles 0x3": (["--tiles", "0x3"], "--tiles is '0x3'"),
    "workers without tiles": (["--workers", "2"], "--workers is for drawings in tiles; add --tiles auto"),
    "a folder without tiles": (["--work", "."], "--work is for drawings in tiles"),
    "no folder": (["--tiles", "2x2", "--work", "nowhere"], "there is no folder nowhere"),
    "workers here and there": (["--tiles", "2x2", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "leave one out"),
    "no scheduler": (["--tiles", "2x2", "--scheduler", "tcp://127.0.0.1:1"], "no scheduler answers"),
    "no address": (["--tiles", "2x2", "--scheduler", "here"], "is no address of a scheduler"),
    "several sizes": (["--tiles", "2x2", "--sizes", "0.2mm,0.3mm", "--dots", "500"], "tiles are for dots of one size"),
    "sizes by tone": (["--tiles", "2x2", "--size-by", "tone"], "tiles are for dots of one size"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_done_in_tiles_is_refused_in_one_line(desk, capsys, name):
    arguments, said = REFUSED[name]
    assert drawn("one.svg", *arguments) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error
    assert {path.name for path in desk.iterdir()} == {"islands.png"}


@pytest.mark.usefixtures("desk")
def test_other_styles_have_no_tiles(capsys):
    assert main(["cells", "islands.png", "one.svg", "--tiles", "2x2"]) == 2
    assert capsys.readouterr().err.startswith("crowquill: No such option: --tiles")
    assert main(["cells", "islands.png", "one.svg", "--workers", "2"]) == 2
    assert "add --tiles auto to stipple" in capsys.readouterr().err
