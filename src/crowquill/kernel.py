"""How hot loops are compiled and shared out over cores: one decorator, one function."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])
THREADS = "CROWQUILL_THREADS"  # of the environment: how many threads loops take, where not one a core


def _cores() -> int:
    """How many threads a loop is shared out to: as the environment says, or as many as this process has cores."""
    wish = os.environ.get(THREADS, "")
    if not wish:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not wish.isascii() or not wish.isdigit() or not 0 < int(wish) <= 4096:
        raise ValueError(f"{THREADS} is {wish!r}; it takes a whole number, 1 to 4096")
    return int(wish)


CORES = _cores()
HELPER = "crowquill-loop"


def share(n: int) -> None:
    """Lets loops take an n-th of the cores from now on, where so many processes or tasks are at work on them."""
    global CORES
    CORES = max(1, _cores() // n)


def compiled(function: F) -> F:
    """`function` compiled at its first call, kept on disk where a folder can be written, without the interpreter's lock.

    Inlined into other compiled functions as any numba function is. Never "fastmath": the
    same bytes are promised, and sums may not be reordered.
    """
    made: Any
    try:
        made = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # neither the package's folder nor the home folder can be written
        made = numba.njit(nogil=True, error_model="numpy")(function)
    else:
        save = made._cache.save_overload

        def save_if_there_is_room(*arguments: Any) -> None:
            with contextlib.suppress(OSError):
                save(*arguments)

        made._cache.save_overload = save_if_there_is_room
    return cast(F, made)


def shared_out(work: Callable[[int, int], None], n: int, least: int = 4096) -> None:
    """Calls work(lo, hi) on pieces of range(n), side by side when there are more than `least`.

    Each piece must write only its own rows, so that the answer does not depend on the
    number of cores.
    """
    pieces = max(1, min(CORES, n // least))
    bounds = [n * k // pieces for k in range(pieces + 1)]
    if pieces == 1 or threading.current_thread().name.startswith(HELPER):  # one that waited for others could wait for itself
        work(0, n)
        return
    others = [_helpers(CORES).submit(work, *piece) for piece in pairwise(bounds[1:])]
    try:
        work(0, bounds[1])
    finally:
        wait(others)
    for other in others:
        other.result()


@lru_cache(maxsize=1)
def _helpers(n: int) -> ThreadPoolExecutor:
    """Threads that stay: to begin them anew would cost a step of few sites more than its work."""
    return ThreadPoolExecutor(n, thread_name_prefix=HELPER)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # a child has none of its parent's threads
