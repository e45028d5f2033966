"""Who works the tiles of a drawing: this process, others beside it, or a cluster; a setting of who runs, not of what is drawn."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from crowquill.cluster import LostError, Workers, workers

Given = TypeVar("Given")
Found = TypeVar("Found")


@dataclass(frozen=True)
class Hands:
    """Who works tiles: so many processes here, or the workers of a Dask scheduler; none is this very process.

    folder  where what is done is kept from step to step, so that the same work goes on there after it was stopped
    kept    the files of that folder in use: who has what came of them may remove them
    """

    workers: int = 0
    scheduler: str | None = None
    folder: Path | None = None
    kept: list[Path] = field(default_factory=list)


hired: ContextVar[Hands | None] = ContextVar("hired", default=None)  # nobody: this process does it all


@contextlib.contextmanager
def hiring(hands: Hands) -> Iterator[None]:
    """Has these work the tiles of all that is drawn inside."""
    before = hired.set(hands)
    try:
        yield
    finally:
        hired.reset(before)


def submitted(pool: Workers, fn: Callable[[Given], Found], given: Given) -> Future[Found]:
    """The future of a task that is handed out, whatever its size: Dask warns of 10 MB and more, which a window of a picture may be."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
        return pool.submit(fn, given)


class _Here(Workers):
    """This very process, which does a task when it is handed out."""

    count, here = 0, True

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The future of what is done already."""
        future = Future[Any]()
        future.set_result(fn(*args, **kwargs))
        return future


@contextlib.contextmanager
def pooled() -> Iterator[Workers]:
    """Those who were hired."""
    wanted = hired.get() or Hands()
    if not wanted.workers and wanted.scheduler is None:
        yield _Here()
        return
    try:
        with workers(wanted.scheduler, max(1, wanted.workers)) as pool:
            yield pool
    except LostError as error:
        raise ValueError(f"a tile was given up: {error}") from None
