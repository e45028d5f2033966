"""Workers for work in many parts: processes of this machine, or those of a Dask cluster, behind one Executor.

    with workers(None, 4) as pool:
        for future in concurrent.futures.as_completed([pool.submit(f, x) for x in parts]):
            ...

Functions and what they take and give must be picklable: functions of modules, never of the script that is run.
"""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import queue
import re
import subprocess
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from importlib.metadata import version
from typing import Any, BinaryIO

from crowquill import kernel

TRIES = 3  # a task that ends its worker so often is to blame; Dask counts so too
PATIENCE = 5.0  # s until a scheduler, or its first worker, must have answered
ENDED = "its workers ended while they were at it; give them more memory, or have fewer"
TOPIC = "crowquill"  # of what tasks on a cluster tell
START = "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); from crowquill.cluster import _serve; _serve()"
Heard = Callable[[Any], None]


class LostError(Exception):
    """The workers are gone, or the one that had a task ended with it, several times over."""


class Workers(Executor):
    """An Executor that says how many tasks run side by side, and whether its workers read this machine's files."""

    count: int
    here: bool

    def avoid(self, worker: str) -> bool:  # noqa: ARG002
        """Hands this worker, by its name, no more tasks; gives whether any other is left."""
        return False


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
    pool = _Processes(n, heard) if scheduler is None else _Cluster(scheduler, heard)
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def tell(message: Any) -> None:
    """Says a message to who handed out the task that calls this; where nobody did, to no one.

    Raises CancelledError in a task on a cluster whose answer nobody waits for any more.
    """
    if _answer is not None:
        _answer("told", message)
    elif worker := _dask_worker():
        task = worker.state.tasks.get(worker.get_current_task())
        if task is None or task.state in ("cancelled", "released", "forgotten"):
            raise CancelledError
        worker.log_event(TOPIC, message)


def at() -> str:
    """The name of the worker on a cluster that runs this, or "" on this machine."""
    worker = _dask_worker()
    return str(worker.address) if worker else ""


class _Processes(Workers):
    """Processes of this machine, each with a thread here that waits for it."""

    here = True

    def __init__(self, n: int, heard: Heard | None) -> None:
        self.count = n
        self._heard, self._threads, self._own = heard or (lambda _: None), ThreadPoolExecutor(n, "worker"), threading.local()
        self._every: set[_Process] = set()
        self._guard, self._closed = threading.Lock(), False

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The future of fn(*args, **kwargs) in a process."""
        return self._threads.submit(self._done, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends all processes, those at work too unless they are waited for."""
        if wait:
            self._threads.shutdown(True, cancel_futures=cancel_futures)
        with self._guard:
            self._closed = True
            every = list(self._every)
        for process in every:
            process.end()
        self._threads.shutdown(True, cancel_futures=cancel_futures)
        for process in every:
            process.close()

    def _done(self, fn: Callable[..., Any], args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> Any:
        task = pickle.dumps((fn, args, kwargs))
        for _ in range(TRIES):
            process = self._process()
            try:
                return process.done(task, self._heard)
            except (EOFError, BrokenPipeError):
                process.end()
                with self._guard:
                    if self._closed:
                        raise CancelledError from None
                    self._every.discard(process)
                process.close()
                self._own.process = None
        raise LostError(ENDED)

    def _process(self) -> _Process:
        """The process of this thread, begun where there is none."""
        found: _Process | None = getattr(self._own, "process", None)
        if found is None:
            with self._guard:
                if self._closed:
                    raise CancelledError
                found = self._own.process = _Process(max(1, kernel.CORES // self.count))
                self._every.add(found)
        return found


class _Process:
    """A process that does tasks one after another. It ends with its standard input: when it is closed, or we are gone."""

    def __init__(self, threads: int) -> None:
        environment = {**os.environ, kernel.THREADS: str(threads)}
        self._child = subprocess.Popen(  # of a session of its own: Ctrl-C is for us to answer
            [sys.executable, "-c", START],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # of C libraries; what is wrong comes as an answer
            env=environment,
            start_new_session=True,
        )
        assert self._child.stdin and self._child.stdout
        self._to, self._from = self._child.stdin, self._child.stdout
        with contextlib.suppress(BrokenPipeError):
            pickle.dump(sys.path, self._to)
            self._to.flush()

    def done(self, task: bytes, heard: Heard) -> Any:
        """What a pickled task comes to, or the exception it ended with. EOFError or BrokenPipeError where the process ended first."""
        _put(self._to, task)
        while True:
            kind, value = pickle.loads(_got(self._from))
            if kind == "told":
                heard(value)
            elif kind == "failed":
                raise value
            else:
                return value

    def end(self) -> None:
        """Ends the process, whatever it does."""
        self._child.kill()
        self._child.wait()

    def close(self) -> None:
        """Closes our ends of what a process that ended was spoken to by."""
        with contextlib.suppress(OSError):
            self._to.close()
        self._from.close()


_answer: Callable[[str, Any], None] | None = None  # in a process of ours: how it speaks to who began it


def _serve() -> None:
    """What a process of ours does: tasks from standard input, answers to standard output, until that input ends."""
    global _answer
    out, tasks = os.fdopen(os.dup(1), "wb"), queue.SimpleQueue[bytes]()
    os.dup2(2, 1)  # what anyone prints is no answer
    threading.Thread(target=_listen, args=(tasks,), daemon=True).start()
    _answer = lambda kind, value: _put(out, pickle.dumps((kind, value)))  # noqa: E731
    while True:
        function, args, kwargs = pickle.loads(tasks.get())
        try:
            answer = pickle.dumps(("done", function(*args, **kwargs)))
        except BaseException as error:
            answer = _failure(error)
        _put(out, answer)
        del function, args, kwargs, answer  # nothing is held while waiting


def _failure(error: BaseException) -> bytes:
    """An exception as an answer, with where it happened as its note."""
    error.add_note("".join(traceback.format_exception(error)))
    try:
        answer = pickle.dumps(("failed", error))
        pickle.loads(answer)
    except Exception:  # of a kind that cannot travel
        return pickle.dumps(("failed", RuntimeError(f"{type(error).__name__}: {error}")))
    return answer


def _listen(tasks: queue.SimpleQueue[bytes]) -> None:
    """Takes in tasks; when no more can come, nobody waits for what is under way."""
    with contextlib.suppress(EOFError):
        while True:
            tasks.put(_got(sys.stdin.buffer))
    os._exit(0)


def _put(file: BinaryIO | Any, data: bytes) -> None:
    file.write(len(data).to_bytes(8, "big"))
    file.write(data)
    file.flush()


def _got(file: BinaryIO | Any) -> bytes:
    head = file.read(8)
    data: bytes = file.read(int.from_bytes(head, "big")) if len(head) == 8 else b""
    if len(head) < 8 or len(data) < int.from_bytes(head, "big"):
        raise EOFError
    return data


class _Cluster(Workers):
    """The workers of a Dask scheduler."""

    here = False

    def __init__(self, scheduler: str, heard: Heard | None) -> None:
        self._scheduler, self._avoided, self._closed = scheduler, set[str](), False
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what is wrong is said once, by us
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
        given, future = self._client.get_executor(pure=False, **where).submit(fn, *args, **kwargs), Future[Any]()
        future.add_done_callback(lambda done: done.cancelled() and given.cancel())
        given.add_done_callback(lambda given: self._passed_on(given, future))
        return future

    def _passed_on(self, given: Future[Any], future: Future[Any]) -> None:
        """Gives a future what another came to, in our words."""
        if not future.set_running_or_notify_cancel():
            return
        if given.cancelled():
            future.set_exception(
                CancelledError() if self._closed else LostError(f"{self._scheduler}: the scheduler is gone; begin it again")
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
        ours = version("crowquill")
        for address, theirs in self._client.run(version, "crowquill", on_error="return").items():
            if theirs != ours:
                what = f"crowquill {theirs}" if isinstance(theirs, str) else "no crowquill"
                raise ValueError(f"{self._scheduler}: worker {address} has {what}, here is {ours}; install the same there")
        threads: dict[str, int] = self._client.nthreads()
        hosts = {address: address.rsplit(":", 1)[0] for address in threads}
        for host in set(hosts.values()):
            those = [address for address in threads if hosts[address] == host]
            self._client.run(kernel.share, sum(threads[address] for address in those), workers=those)
        return sum(threads.values())


def _connected(scheduler: str) -> Any:
    """A client of the scheduler at an address, where there is one with workers."""
    try:
        from distributed import Client
    except ImportError:
        raise ValueError('a scheduler takes Dask; install it with: pip install "crowquill[cluster]"') from None
    if not re.fullmatch(r"(tcp|tls|wss?)://.+:\d{1,5}", scheduler):
        raise ValueError(f"{scheduler!r} is no address of a scheduler; give one such as tcp://host:8786")
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
