"""Processes of this machine that do tasks, each begun afresh when it ends before its task does.

They are no children of multiprocessing, which would run the script that began them over again, and would outlive it if it were killed.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from typing import Any, BinaryIO

from crowquill import kernel

TRIES = 3  # a task that ends its process so often is to blame; Dask counts so too
ENDED = "its workers ended while they were at it; give them more memory, or have fewer"
START = "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); from crowquill.processes import _serve; _serve()"
Heard = Callable[[Any], None]


class LostError(Exception):
    """The workers are gone, or those that had a task ended with it."""


class Workers(Executor):
    """An Executor that says how many tasks run side by side, and whether its workers read this machine's files."""

    count: int
    here: bool

    def avoid(self, worker: str) -> bool:  # noqa: ARG002
        """Hands this worker, by its name, no more tasks; gives whether any other is left."""
        return False


class Processes(Workers):
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


def told(message: Any) -> bool:
    """Says a message to who handed out the task under way; False where this is no process of ours."""
    if _answer is None:
        return False
    _answer("told", message)
    return True


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
