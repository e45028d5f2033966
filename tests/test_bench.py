"""The bench: its scorer knows bad from good, its report is made of a file of rows, and what was not run is said."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import charts
import common
import drawing
import numpy as np
import page
import peers
import published
import pytest
import scoring
import solvers
from common import Report, Taken

from crowquill import relax
from crowquill.tone import Tone

BENCH = Path(__file__).resolve().parents[1] / "bench"
Y, X = np.mgrid[0:200, 0:200] / 200
DARK = 0.15 + 0.6 * X * (1 - Y)
RNG = np.random.default_rng(0)
RELAXED = next(
    state.sites for state in relax.lloyd(relax.scatter(Tone(DARK, (200, 200)), 800, RNG), Tone(DARK, (200, 200))) if state.done == 20
)
RANDOM = RNG.random((800, 2)) * 200


def report(file: Path | None = None) -> Report:
    """A short report of two parts with a bar met, one missed, a peer ahead and one behind, and something not run."""
    made = Report(file)
    for part in ("kernels", "editor"):
        made.data["parts"].append(part)
        made.data["d"].append({"part": part, "seconds": 0.5, "cpu": 0.5, "load": 1.0})
    made.row("a quick thing", Taken(0.1, 0.2, 0.01, 0.1), bar=0.35)
    made.row("a slow <thing>", Taken(2.0, 2.1, 0.1, 1.9), "said of it", bar=3, got=4.5, unit="times another")
    made.line("insert 3.1 ms at least")
    made.missing("a program", "it could not be installed")
    run = {"seconds": 9.0, "cpu": 8.0, "memory": 100.0}
    ours = {"solver": "default", "step": 3, "seconds": 0.1, "cpu": 0.2, "ratio": 80.0, "cpu_ratio": 40.0}
    line = {
        "peer": "another",
        "dots": 800,
        "passes": "50 passes",
        "tone": 0.06,
        "rho": 0.87,
        "loop": {"least": 8.0, "cpu": 8.0},
        "run": run,
    }
    made.figure("peers", [{**line, "near": ours, "even": {**ours, "ratio": 0.5}}, {**line, "peer": "a third"}])
    way = [{"step": k, "seconds": 0.1 * k + 0.1, "energy": 2 / (k + 1), "tone": 0.1 / (k + 1), "rho": 0.8} for k in range(4)]
    made.figure("solvers", {"800": {"plain": way, "default": way[:2]}})
    stages = {"read": 0.1, "moments": 0.4, "other": 0.5}
    memory = {"memory": 300.0, "iteration_memory": 200.0}
    points = [{"side": 1000, "dots": n, "seconds": n / 1e4, "cpu": n / 1e4, "iteration": n / 1e6, **memory, "iterations": 30,
               "stages": stages} for n in (1000, 10_000, 100_000)]  # fmt: skip
    made.figure("dots", points)
    return made


def test_relaxed_dots_are_nearer_and_more_even_than_random_ones():
    good, bad = scoring.scored(RELAXED, DARK), scoring.scored(RANDOM, DARK)
    assert good.tone < bad.tone / 2
    assert good.rho > 0.8 > 0.6 > bad.rho
    assert good.reaches(bad, even=True)
    assert not bad.reaches(good, even=False)


def test_dots_as_near_in_tone_but_less_even_do_not_reach_both():
    assert scoring.Score(0.03, 0.8).reaches(scoring.Score(0.03, 0.87), even=False)
    assert not scoring.Score(0.03, 0.8).reaches(scoring.Score(0.03, 0.87), even=True)


def test_dots_of_several_sizes_are_judged_by_the_better_of_both_ways():
    areas = np.where(RELAXED[:, 0] < 100, 1.0, 4.0)  # of equal dots wanted
    assert scoring.tone_error(RELAXED, DARK, areas) > scoring.tone_error(RELAXED, DARK)
    assert scoring.scored(RELAXED, DARK, areas).tone == scoring.tone_error(RELAXED, DARK)


def test_tone_error_does_not_heed_the_unit_of_areas():
    areas = RNG.uniform(1, 2, len(RELAXED))
    assert scoring.tone_error(RELAXED, DARK, 7 * areas) == pytest.approx(scoring.tone_error(RELAXED, DARK, areas), rel=1e-9)


def test_cells_integrated_along_scan_lines_agree_with_exact_ones():
    rows = np.arange(DARK.shape[1]) + 0.5
    sums = np.zeros((2, 200, 201))
    sums[0, :, 1:], sums[1, :, 1:] = DARK.cumsum(axis=1), (DARK * rows).cumsum(axis=1)
    tone = Tone(DARK, (200, 200))
    exact = relax.measured(RANDOM[:100], tone, tone).moments.centroid
    # whole pixels of cells 20 wide: a twentieth of a pixel on the mean, under half of one
    assert abs(published.centroids(RANDOM[:100], sums) - exact).max() < 0.5
    assert abs(published.centroids(RANDOM[:100], sums) - exact).mean() < 0.06


def test_the_published_method_comes_nearer_with_its_passes():
    first, later = (scoring.scored(published.secord(DARK, 300, passes), DARK) for passes in (0, 10))
    assert later.tone < first.tone
    assert later.rho > first.rho + 0.1


def test_a_halftone_has_a_dot_for_each_black_pixel():
    sites = published.pillow(DARK, 800)
    assert len(sites) == pytest.approx(800, rel=0.05)
    assert scoring.tone_error(sites, DARK) < 0.7 * scoring.tone_error(RANDOM, DARK)


def test_every_solver_gives_as_many_dots_and_comes_nearer():
    for name, solver in solvers.SOLVERS.items():
        points = solvers.timed(solver, DARK, 300, solvers.scores, 1)
        assert [point["step"] for point in points] == list(solvers.LOOKED_AT), name
        assert points[-1]["energy"] < points[0]["energy"]
        assert points[-1]["tone"] < points[0]["tone"]


def test_the_solver_that_is_as_good_soonest_is_found():
    point = {"step": 1, "seconds": 2.0, "cpu": 2.0, "tone": 0.05, "rho": 0.9}
    ways = {
        "slow": [point],
        "quick, uneven": [{**point, "seconds": 1.0, "rho": 0.7}],
        solvers.HALFTONE: [{**point, "step": 0, "seconds": 0.1}, {**point, "seconds": 3.0}],
    }
    wanted = scoring.Score(0.06, 0.87)
    assert peers.reached(ways, wanted, even=False, relaxed=True)[0] == "quick, uneven"
    assert peers.reached(ways, wanted, even=True, relaxed=True)[0] == "slow"
    assert peers.reached(ways, wanted, even=True, relaxed=False)[0] == solvers.HALFTONE
    assert peers.reached(ways, scoring.Score(0.01, 0.87), even=False, relaxed=True) is None


def test_a_peer_that_fails_is_said_to_be_missing(tmp_path):
    made = report()
    broken = peers.Peer("broken", "", lambda *_: [sys.executable, "-c", "raise SystemExit('no such thing')"], peers.circles, "none")
    peers.one(made, broken, 300, {300: {}}, peers.CommandLine(tmp_path, DARK, 1), [])
    assert "no such thing" in made.data["missing"][-1]["why"]


def test_the_page_is_made_of_the_file_of_rows(tmp_path):
    report(tmp_path / "rows.json")
    subprocess.run([sys.executable, str(BENCH / "page.py"), str(tmp_path / "rows.json")], check=True)
    made = (tmp_path / "report.html").read_text(encoding="utf-8")
    facts = ("a slow &lt;thing&gt;", "4.50 times another; bar 3, MISSED", "1 of 2 met", "a program", "it could not be installed")
    figures = ("insert 3.1 ms", "<b>80</b> ahead", "behind", "not reached", "Energy of 800 dots", "Stages of a whole drawing, by dots")
    for words in (*facts, *figures):
        assert words in made
    assert not re.search(r"(src|href)\s*=|url\(|@import|<script", made)  # nothing is fetched, nothing runs
    plots = re.findall(r"<svg.*?</svg>", made)
    assert len(plots) == 8
    for plot in plots:
        assert "nan" not in plot
        ElementTree.fromstring(plot)


def test_a_page_of_nothing_says_so():
    made = page.html(Report(None).data)
    assert made.count("not run") >= 3


def test_two_runs_are_compared_row_by_row():
    old, new = report().data, report().data
    new["rows"][0]["d"] *= 2
    new["rows"].append({"part": "editor", "what": "a new thing", "d": 1.0})
    told = page.compared(old, new)
    assert told[0].split()[-2:] == ["2.00", "times"]
    assert told[-1].endswith("only in the newer")


def test_a_plot_leaves_out_what_a_logarithm_has_no_place_for():
    plot = charts.lines("Plot", "x", "y", [charts.Series("one", [0.0, 1.0, 10.0], [1.0, 0.0, 5.0])])
    assert len(re.search(r'points="([^"]*)"', plot).group(1).split()) == 1


@pytest.mark.parametrize(("value", "words"), [(0.05, "0.05"), (1000, "1000"), (1e4, "10⁴"), (2e5, "2·10⁵"), (1e-5, "10⁻⁵"), (0, "0")])
def test_numbers_of_axes_are_short(value, words):
    assert charts.number(value) == words


def test_the_time_of_an_inner_stage_is_not_the_outer_ones(monkeypatch):
    clock = iter([10.0, 11.0, 14.0, 16.0])  # the outer begins, the inner begins and ends, the outer ends
    monkeypatch.setattr(drawing, "time", SimpleNamespace(perf_counter=lambda: next(clock)))
    watch = drawing.Stopwatch()
    watch.timed(watch.timed(lambda: None, "inner"), "outer")()
    assert watch.seconds == {"inner": 3.0, "outer": 3.0}


def test_a_stage_without_a_function_is_noted():
    watch = drawing.Stopwatch()
    watch.watch("relax", "no_such_function", "start")
    assert watch.missing == ["relax.no_such_function"]


def test_a_drawing_tells_its_stages(tmp_path):
    from PIL import Image

    Image.fromarray((255 * (1 - DARK)).astype(np.uint8)).save(tmp_path / "picture.png")
    wanted = {"picture": str(tmp_path / "picture.png"), "out": str(tmp_path / "out.pdf"), "dots": 400, "iterations": 3, "repeats": 1}
    done = subprocess.run([sys.executable, str(BENCH / "drawing.py"), json.dumps(wanted)], capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert (tmp_path / "out.pdf").stat().st_size > 0
    assert found["missing"] == []
    assert found["marks"] == pytest.approx(400, abs=2)
    assert all(found["stages"][stage] > 0 for stage in ("read", "start", "triangulation", "clipping", "moments", "placing", "writing"))
    assert sum(found["stages"].values()) == pytest.approx(found["seconds"], rel=0.01)
    assert found["iteration"] > 0
    assert found["memory"] >= found["iteration_memory"] > 50


def test_an_unknown_part_is_refused_in_a_line():
    done = subprocess.run([sys.executable, str(BENCH / "bench.py"), "--only", "nothing"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "no part nothing" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_command_is_measured_and_ended_at_its_limit():
    run = common.process(sys.executable, "-c", "data = bytearray(80_000_000); data[::4096] = b'1' * len(data[::4096])")
    assert 80 < run.memory < 200
    with pytest.raises(ChildProcessError, match=r"ended after 0\.2 s"):
        common.process(sys.executable, "-c", "import time; time.sleep(60)", limit=0.2)
    with pytest.raises(ChildProcessError, match="no such thing"):
        common.process(sys.executable, "-c", "raise SystemExit('no such thing')")


def test_a_peer_is_put_beside_the_solver_that_is_as_good_soonest(tmp_path):
    made, table = report(), []
    np.save(tmp_path / "out.npy", RANDOM)
    (tmp_path / "figures.json").write_text('{"seconds": 5.0, "cpu": 4.0}')
    command, read = lambda *_: [sys.executable, "-c", ""], lambda folder: (np.load(folder / "out.npy"), None)
    peer = peers.Peer("a poor one", "", command, read, "one pass", relaxes=False)
    ways = {800: {solvers.DEFAULT: [{"step": k, "seconds": 9.0, "cpu": 9.0, "tone": 0.4 - 0.15 * k, "rho": 0.7} for k in range(4)]}}
    ours = peers.CommandLine(tmp_path, DARK, 1)
    ours.known[800, 1] = common.Run(2.0, 2.0, 100.0), scoring.Score(0.1, 0.8)
    peers.one(made, peer, 800, ways, ours, table)
    assert table[0]["near"]["step"] == 1
    assert table[0]["near"]["ratio"] == pytest.approx(5 / table[0]["near"]["seconds"])
    assert table[0]["command"]["steps"] == 1
    assert "a poor one" in page.html(made.data)
    assert any(row["what"] == "  crowquill's own halftone, 800 dots" for row in made.data["rows"] if "seconds" in row)


def test_what_a_start_relaxes_is_the_starts(monkeypatch):
    clock = iter([10.0, 16.0, 20.0, 21.0])
    monkeypatch.setattr(drawing, "time", SimpleNamespace(perf_counter=lambda: next(clock)))
    watch = drawing.Stopwatch()
    moments = watch.timed(lambda: None, "moments")
    watch.timed(moments, "start")()
    moments()
    assert watch.seconds == {"start": 6.0, "moments": 1.0}
