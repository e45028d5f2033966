"""Workers for work in many parts: processes of this machine, or those of a Dask cluster, behind one Executor.

    with workers(None, 4) as pool:
        for future in concurrent.futures.as_completed([pool.submit(f, x) for x in parts]):
            ...

Functions and what they take and give must be picklable: functions of modules, never of the script that is run.
"""

from __future__ import annotations

import contextlib
import logging
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from crowquill import kernel
from crowquill.processes import ENDED, Heard, LostError, Processes, Workers, told

__all__ = ["GoneError", "LostError", "Workers", "at", "tell", "workers"]

PATIENCE = 5.0  # s until a scheduler, or its first worker, must have answered
TOPIC = "crowquill"  # of what tasks on a cluster tell


class GoneError(LostError):
    """The scheduler is gone, and all that it had with it."""


@contextlib.contextmanager
def workers(scheduler: str | None, n: int, heard: Heard | None = None) -> Iterator[Workers]:
    """`n` processes of this machine, or all workers of the Dask scheduler at an address such as tcp://host:8786.

    heard  is called, in a thread of its own, with what tasks tell() while they run: numbers, texts, tuples of them

    The cores are shared out among the workers of a machine. A worker that ends is replaced here, and its task done again,
    by others on a cluster; a task that ends three workers fails with LostError. At the end of the context, or when it is left by
    an error or Ctrl-C, tasks that run are stopped and those that wait are dropped.

    Raises ValueError for a scheduler that does not answer within seconds, one without workers, workers with
    another version of crowquill, and where Dask is not installed.
    """
    if n < 1:
        raise ValueError(f"workers is {n}; it takes 1 or more")
    pool = Processes(n, heard) if scheduler is None else _Cluster(scheduler, heard)
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def tell(message: Any) -> None:
    """Says a message to who handed out the task that calls this; where nobody did, to no one.

    Raises CancelledError in a task on a cluster whose answer nobody waits for any more.
    """
    if told(message):
        return
    if worker := _dask_worker():
        task = worker.state.tasks.get(worker.get_current_task())
        if task is None or task.state in ("cancelled", "released", "forgotten"):
            raise CancelledError
        worker.log_event(TOPIC, message)


def at() -> str:
    """The name of the worker on a cluster that runs this, or "" on this machine."""
    worker = _dask_worker()
    return str(worker.address) if worker else ""


class _Cluster(Workers):
    """The workers of a Dask scheduler."""

    here = False

    def __init__(self, scheduler: str, heard: Heard | None) -> None:
        self._scheduler, self._avoided, self._closed = scheduler, set[str](), False
        self._client = _connected(scheduler)
        try:
            if heard:
                self._client.subscribe_topic(TOPIC, lambda event: heard(event[1]))
            self.count = self._prepared()
        except BaseException:
            self._client.close(timeout=1)
            raise

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The future of fn(*args, **kwargs) on a worker that is not avoided."""
        where = {"workers": self._others()} if self._avoided else {}
        if where == {"workers": []}:
            raise GoneError(f"{self._scheduler}: no worker is left that has room; free some space there")
        future = Future[Any]()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of tasks with pictures in them; one that is scattered is lost with its worker
            given = self._client.get_executor(pure=False, **where).submit(fn, *args, **kwargs)
        future.add_done_callback(lambda done: done.cancelled() and given.cancel())
        given.add_done_callback(lambda given: self._passed_on(given, future))
        return future

    def _passed_on(self, given: Future[Any], future: Future[Any]) -> None:
        """Gives a future what another came to, in our words."""
        if not future.set_running_or_notify_cancel():
            return
        if given.cancelled():
            future.set_exception(
                CancelledError() if self._closed else GoneError(f"{self._scheduler}: the scheduler is gone; begin it again")
            )
        elif (error := given.exception()) is None:
            future.set_result(given.result())
        else:
            future.set_exception(LostError(ENDED) if type(error).__name__ == "KilledWorker" else error)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: ARG002
        """Leaves the cluster; its scheduler drops what was not done."""
        self._closed = True
        self._client.close(timeout=PATIENCE)

    def avoid(self, worker: str) -> bool:
        """Hands this worker no more tasks; gives whether any other is left."""
        self._avoided.add(worker)
        return bool(self._others())

    def _others(self) -> list[str]:
        return [address for address in self._client.scheduler_info(n_workers=-1)["workers"] if address not in self._avoided]

    def _prepared(self) -> int:
        """How many tasks the workers run side by side, once each is of our version and has its share of its machine's cores."""
        found = {f"worker {address}": theirs for address, theirs in self._client.run(version, "crowquill", on_error="return").items()}
        with contextlib.suppress(PackageNotFoundError):
            found["the scheduler"] = self._client.run_on_scheduler(version, "crowquill")  # it takes tasks apart
        for who in ("the scheduler", *found):
            if (theirs := found.get(who)) != (ours := version("crowquill")):
                what = f"crowquill {theirs}" if isinstance(theirs, str) else "no crowquill"
                raise ValueError(f"{self._scheduler}: {who} has {what}, here is {ours}; install the same there")
        threads: dict[str, int] = self._client.nthreads()
        hosts = {address: address.rsplit(":", 1)[0] for address in threads}
        for host in set(hosts.values()):
            those = [address for address in threads if hosts[address] == host]
            self._client.run(kernel.share, sum(threads[address] for address in those), workers=those)
        return sum(threads.values())


def _silent(_: logging.LogRecord) -> bool:
    return False


def _connected(scheduler: str) -> Any:
    """A client of the scheduler at an address, where there is one with workers."""
    try:
        from distributed import Client
    except ImportError:
        raise ValueError('a scheduler takes Dask; install it with: pip install "crowquill[cluster]"') from None
    if not re.fullmatch(r"(tcp|tls|wss?)://.+:\d{1,5}", scheduler):
        raise ValueError(f"{scheduler!r} is no address of a scheduler; give one such as tcp://host:8786")
    for name in [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]:
        logging.getLogger(name).addFilter(_silent)  # what is wrong is said once, by us
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions of other packages
            client: Any = Client(scheduler, timeout=PATIENCE, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, RuntimeError):
        raise ValueError(f"{scheduler}: no scheduler answers; begin one with: dask scheduler") from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        client.close(timeout=1)
        raise ValueError(f"{scheduler}: the scheduler has no workers; begin some with: dask worker {scheduler}") from None
    return client


def _dask_worker() -> Any:
    """The Dask worker that this is called in, or None."""
    if "distributed" not in sys.modules:
        return None
    try:
        return sys.modules["distributed"].get_worker()
    except ValueError:
        return None
