"""Workers: processes of this machine and of a Dask cluster answer alike, are replaced when they end, and leave nothing behind."""

from __future__ import annotations

import importlib.metadata
import math
import os
import signal
import subprocess
import sys
from concurrent.futures import CancelledError, as_completed

import clusters
import pytest

from crowquill import kernel
from crowquill.cluster import LostError, at, workers
from crowquill.formats import alive


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory):
    with clusters.cluster(tmp_path_factory.mktemp("dask"), 2) as made:
        yield made


@pytest.fixture(params=["here", "dask"])
def scheduler(request: pytest.FixtureRequest) -> str | None:
    """No scheduler, or the address of one."""
    return request.getfixturevalue("dask").address if request.param == "dask" else None


def test_answers_come_in_order_and_as_they_are_done(scheduler):
    with workers(scheduler, 2) as pool:
        assert list(pool.map(math.sqrt, [0, 1, 4, 9])) == [0, 1, 2, 3]
        assert {future.result() for future in as_completed([pool.submit(pow, 2, k) for k in range(4)])} == {1, 2, 4, 8}
        assert pool.count == 2
        assert pool.here is (scheduler is None)


def test_an_error_of_a_task_is_that_of_its_future_and_the_next_task_is_done(scheduler):
    with workers(scheduler, 1) as pool:
        with pytest.raises(ValueError, match="math domain error"):
            pool.submit(math.sqrt, -1).result()
        with pytest.raises(Exception, match=r"this and that|OddError"):
            pool.submit(clusters.odd).result()
        assert pool.submit(math.sqrt, 4).result() == 2


def test_what_tasks_tell_is_heard(scheduler):
    heard: list[list[object]] = []
    with workers(scheduler, 1, lambda message: heard.append(list(message))) as pool:
        pool.submit(clusters.told, 3).result()
        clusters.waited_for(lambda: len(heard) == 3)
    assert sorted(heard) == [["step", 0], ["step", 1], ["step", 2]]


def test_outside_of_workers_nobody_hears_and_nothing_has_a_name():
    assert clusters.told(2) == 2
    assert at() == ""


def test_workers_of_a_cluster_have_names(dask):
    with workers(dask.address, 1) as pool:
        assert pool.submit(at).result().startswith("tcp://127.0.0.1:")
    with workers(None, 1) as pool:
        assert pool.submit(at).result() == ""


def test_a_worker_to_be_avoided_gets_no_more_tasks(dask):
    with workers(dask.address, 1) as pool:
        first = pool.submit(at).result()
        assert pool.avoid(first)
        others = {pool.submit(at).result() for _ in range(4)}
        assert first not in others
        assert not pool.avoid(others.pop())
    with workers(None, 2) as pool:
        assert not pool.avoid("")


def test_a_process_that_is_killed_is_replaced_and_its_task_done_again(tmp_path):
    with workers(None, 2) as pool:
        before = pool.submit(os.getpid).result()
        assert pool.submit(clusters.fallen, tmp_path / "once").result() != before
        assert pool.submit(math.sqrt, 4).result() == 2


def test_a_worker_of_a_cluster_that_is_killed_hands_its_task_to_the_others(tmp_path):
    with clusters.cluster(tmp_path, 2) as made, workers(made.address, 1) as pool:
        survivor = pool.submit(clusters.fallen, tmp_path / "once").result()
        assert sorted(process.pid for process in made.processes[1:] if process.poll() is None) == [survivor]


def test_a_task_that_ends_its_worker_again_and_again_is_given_up(tmp_path):
    with workers(None, 2) as pool:
        with pytest.raises(LostError, match="ended while they were at it; give them more memory"):
            pool.submit(clusters.fallen_always, tmp_path / "count").result()
        assert (tmp_path / "count").read_text() == "xxx"
        assert pool.submit(math.sqrt, 4).result() == 2


def test_a_scheduler_that_goes_away_ends_its_tasks(tmp_path):
    with clusters.cluster(tmp_path, 1) as made, workers(made.address, 1) as pool:
        future = pool.submit(clusters.asleep, tmp_path / "pid")
        clusters.waited_for((tmp_path / "pid").exists)
        made.end()
        with pytest.raises(LostError, match="the scheduler is gone"):
            future.result(timeout=clusters.PATIENCE)


def test_who_leaves_stops_what_runs_and_drops_what_waits(scheduler, tmp_path):
    with workers(scheduler, 1) as pool:
        futures = [pool.submit(clusters.asleep, tmp_path / "pid") for _ in range(4)]
        process = int(clusters.waited_for((tmp_path / "pid").read_text))
    if scheduler is None:
        assert not alive(process)
    else:  # its thread stops at what it tells next
        clusters.waited_for(lambda: not (tmp_path / "pid").exists())
        assert alive(process)
    for future in futures:
        with pytest.raises(CancelledError):
            future.result(timeout=clusters.PATIENCE)


def test_processes_end_with_who_began_them_even_if_that_is_killed(tmp_path):
    code = (
        "import clusters, pathlib, crowquill.cluster as c\n"
        f"with c.workers(None, 2) as pool: pool.submit(clusters.asleep, pathlib.Path({str(tmp_path / 'pid')!r})).result()"
    )
    with subprocess.Popen([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(clusters.HERE)}) as run:
        process = int(clusters.waited_for((tmp_path / "pid").read_text))
        assert alive(process)
        run.send_signal(signal.SIGKILL)
    clusters.waited_for(lambda: not alive(process))


def test_the_cores_are_shared_out_among_the_workers(monkeypatch):
    monkeypatch.setattr(kernel, "CORES", 7)
    for n, each in ((1, "7"), (2, "3"), (9, "1")):
        with workers(None, n) as pool:
            assert pool.submit(os.getenv, kernel.THREADS).result() == each
            assert pool.submit(clusters.threads).result() == int(each)


def test_the_cores_of_a_machine_are_shared_out_among_its_workers_of_a_cluster(tmp_path):
    environment = {kernel.THREADS: "6"}  # as if each saw six cores
    with clusters.cluster(tmp_path, 0, [environment] * 2) as made:
        for _ in range(2):  # a second batch takes no share of the share
            with workers(made.address, 1) as pool:
                assert pool.submit(clusters.threads).result() == 3


def test_a_scheduler_that_is_not_there_is_said():
    with (
        pytest.raises(ValueError, match=r"^tcp://127\.0\.0\.1:9: no scheduler answers; begin one with: dask scheduler$"),
        workers("tcp://127.0.0.1:9", 1),
    ):
        pass


@pytest.mark.parametrize("address", ["elsewhere", "tcp://elsewhere", "file:///etc/passwd", "tcp://a:b", ""])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(ValueError, match="is no address of a scheduler; give one such as"), workers(address, 1):
        pass


def test_a_scheduler_without_workers_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("crowquill.cluster.PATIENCE", 1.0)
    with (
        clusters.cluster(tmp_path) as made,
        pytest.raises(ValueError, match="the scheduler has no workers; begin some with: dask worker tcp"),
        workers(made.address, 1),
    ):
        pass


def test_workers_of_another_version_are_refused_by_name(tmp_path):
    older = tmp_path / "older" / "crowquill-0.0.9.dist-info"
    older.mkdir(parents=True)
    (older / "METADATA").write_text("Metadata-Version: 2.1\nName: crowquill\nVersion: 0.0.9\n")
    said = (
        rf"worker tcp://127\.0\.0\.1:\d+ has crowquill 0\.0\.9, here is {importlib.metadata.version('crowquill')}; install the same there"
    )
    with (
        clusters.cluster(tmp_path, 1, [{"FIRST": str(older.parent)}]) as made,
        pytest.raises(ValueError, match=said),
        workers(made.address, 1),
    ):
        pass


def test_without_dask_the_remedy_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ValueError, match=r'pip install "crowquill\[cluster\]"'), workers("tcp://127.0.0.1:9", 1):
        pass


def test_less_than_one_worker_is_refused():
    with pytest.raises(ValueError, match="workers is 0; it takes 1 or more"), workers(None, 0):
        pass


@pytest.mark.parametrize(("text", "threads"), [("1", 1), ("7", 7), ("", None), ("0", 0), ("-1", 0), ("many", 0), ("5000", 0)])
def test_the_environment_says_how_many_threads_loops_take(monkeypatch, text, threads):
    monkeypatch.setenv(kernel.THREADS, text)
    if threads == 0:
        with pytest.raises(ValueError, match=r"^CROWQUILL_THREADS is .*; it takes a whole number, 1 to 4096$"):
            kernel._cores()
    else:
        assert kernel._cores() == (threads or len(os.sched_getaffinity(0)))
