"""Many drawings at once, here or on a cluster: each made once, whatever fails, ends or is killed on the way.

Workers give bytes and write nothing; who hands out the work writes each drawing when it is done, and then a line in a journal beside it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import secrets
import shutil
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO

from crowquill import formats
from crowquill.cluster import GoneError, Workers, at, tell
from crowquill.delivery import Delivered, delivered
from crowquill.recipe import Recipe
from crowquill.sheet import Step

JOURNAL = "batch.jsonl"
OFTEN = 0.25  # s between two messages of a drawing under way
Found = tuple[Recipe, Mapping[str, Path]]


@dataclass(frozen=True)
class Job:
    """A drawing to be made: what it is called, its files, and how its recipe and sources are found.

    find  gives the recipe, its sources with their hashes, and where they are; it may put files into the folder that it
          is given. Its ValueError or OSError fails the job
    of    files read, which are not written over
    """

    name: str
    out: tuple[Path, ...]
    find: Callable[[Path], Found]
    of: tuple[Path, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What became of a job: "drawn", "kept" from an earlier run, or "failed", for which `error` says why in one line."""

    job: Job
    status: str
    report: Mapping[str, Any] = field(default_factory=dict)
    error: Exception | None = None


class UnfitError(Exception):
    """A worker on a cluster cannot draw, whatever it is given: its disk is full, or it is of another version."""

    def __init__(self, worker: str, why: str) -> None:
        super().__init__(worker, why)
        self.worker, self.why = worker, why


class Journal:
    """What is made in a folder, a line a drawing: by what it was made from, and the SHA-256 of its files."""

    def __init__(self, folder: Path) -> None:
        """Reads what is there; a line that a kill cut short, and any other that is none, counts as not written."""
        self.path = folder / JOURNAL
        self._made: dict[str, dict[str, str]] = {}
        for line in self.path.read_bytes().splitlines() if self.path.exists() else ():
            try:
                data = json.loads(line)
                self._made[data["key"]] = {**self._made.get(data["key"], {}), **data["files"]}
            except (ValueError, LookupError, TypeError):
                continue

    def has(self, key: str, out: Sequence[Path]) -> bool:
        """Whether these files are here as they were made from what the key stands for."""
        made = self._made.get(key, {})
        return all(path.name in made and path.is_file() and _digest(path) == made[path.name] for path in out)

    def add(self, key: str, files: Mapping[str, bytes]) -> None:
        """Keeps that these files were made; on disk when this returns."""
        made = {name: hashlib.sha256(data).hexdigest() for name, data in files.items()}
        line = json.dumps({"key": key, "files": made}, sort_keys=True).encode() + b"\n"
        with self.path.open("a+b") as file:
            if file.tell():
                file.seek(-1, os.SEEK_END)
                line = line if file.read(1) == b"\n" else b"\n" + line
            file.write(line)
            file.flush()
            os.fsync(file.fileno())


class Batch:
    """Jobs at work: iterating over outcomes() has them done. `tokens` says which job a message (token, stage, done, total) is from.

    overwrite  whether files that are there may be replaced
    note       is called with what is to be said of workers
    """

    def __init__(
        self,
        jobs: Sequence[Job],
        folder: Path,
        *,
        overwrite: bool = True,
        note: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Jobs whose journal is in a folder. Raises ValueError where two would write the same file."""
        _check_names(jobs)
        run = secrets.token_hex(8)
        self.tokens = {f"{run}-{k}": job for k, job in enumerate(jobs)}
        self._journal, self._overwrite, self._note = Journal(folder), overwrite, note
        self._unfit: dict[str, str] = {}
        self._keys: dict[str, str] = {}

    @property
    def made(self) -> int:
        """How many jobs, of those that were begun, the journal on the disk has; whoever counts outcomes may be one short when stopped."""
        journal = Journal(self._journal.path.parent)
        return sum(journal.has(key, self.tokens[token].out) for token, key in self._keys.items())

    def outcomes(self, pool: Workers) -> Iterator[Outcome]:
        """What becomes of each job, in the order in which they are done. Who stops iterating may begin anew, and goes on.

        Raises GoneError where the workers are gone for good.
        """
        waiting, running = deque(self.tokens.items()), dict[Future[Delivered], _Task]()
        with tempfile.TemporaryDirectory(prefix="crowquill-") as inside:
            while waiting or running:
                while waiting and len(running) < 2 * pool.count:  # so that no worker waits for its next
                    token, job = waiting.popleft()
                    found = self._ready(token, job, Path(inside) / token)
                    if isinstance(found, Outcome):
                        yield found
                    else:
                        running[found.given(pool)] = found
                for future in wait(running, return_when=FIRST_COMPLETED).done if running else ():
                    task = running.pop(future)
                    if self._elsewhere(future, pool):
                        running[task.given(pool)] = task
                    else:
                        yield self._done(task, future)

    def plan(self) -> Iterator[Outcome]:
        """What is known before any work: what is kept, what has failed already, and what is "to do"."""
        with tempfile.TemporaryDirectory(prefix="crowquill-") as inside:
            for token, job in self.tokens.items():
                found = self._ready(token, job, Path(inside) / token)
                yield found if isinstance(found, Outcome) else Outcome(job, "to do")

    def _ready(self, token: str, job: Job, folder: Path) -> _Task | Outcome:
        """The job as a task, or what has become of it already."""
        error: Exception | None = None
        try:
            folder.mkdir()
            wanted, paths = job.find(folder)
            key = self._keys[token] = _key(wanted)
            if not self._journal.has(key, job.out):
                formats.check(job.out, overwrite=self._overwrite, sources=[*job.of, *paths.values()])
                return _Task(token, job, key, wanted, paths, folder)
        except (ValueError, OSError) as failed:
            error = failed
        shutil.rmtree(folder, ignore_errors=True)
        return Outcome(job, "failed" if error else "kept", error=error)

    def _elsewhere(self, future: Future[Delivered], pool: Workers) -> bool:
        """Whether the task is to be done by another worker, since the one that had it is unfit."""
        error = future.exception()
        if not isinstance(error, UnfitError):
            return False
        left = pool.avoid(error.worker)
        if error.worker not in self._unfit:
            self._unfit[error.worker] = error.why
            self._note(f"worker {error.worker}: {error.why}{', others do its drawings' if left else ''}")
        return left

    def _done(self, task: _Task, future: Future[Delivered]) -> Outcome:
        """What became of a task that is done, its files written."""
        try:
            made = future.result()
            formats.replace_files([(path, partial(_put, made.files[path.name])) for path in task.job.out])
            self._journal.add(task.key, made.files)
        except GoneError:
            raise
        except Exception as error:  # whatever happened to one, the others are done
            return Outcome(task.job, "failed", error=error)
        finally:
            shutil.rmtree(task.folder, ignore_errors=True)
        return Outcome(task.job, "drawn", made.report)


@dataclass(frozen=True)
class _Task:
    """A job that is ready to be handed out."""

    token: str
    job: Job
    key: str
    wanted: Recipe
    paths: Mapping[str, Path]
    folder: Path

    def given(self, pool: Workers) -> Future[Delivered]:
        """Its future, once it is handed out; workers elsewhere get what its sources hold, and where that is gone it is so at once."""
        names = [path.name for path in self.job.out]
        if pool.here:
            return pool.submit(_drawn, self.wanted, dict(self.paths), names, self.token)
        try:
            held = {key: (path, path.read_bytes()) for key, path in self.paths.items()}
        except OSError as error:
            gone = Future[Delivered]()
            gone.set_exception(error)
            return gone
        return pool.submit(_carried, self.wanted, held, names, self.token, version("crowquill"))


def _drawn(wanted: Recipe, paths: Mapping[str, Path], names: Sequence[str], token: str) -> Delivered:
    """The task of a worker that reads our files; the report says the seconds that it took in all."""
    began = last = time.monotonic()

    def watch(step: Step) -> None:
        nonlocal last
        if (now := time.monotonic()) - last >= OFTEN:
            last = now
            tell((token, step.stage, step.done, step.total))

    tell((token, "", 0, 1))
    made = delivered(wanted, paths, names, watch=watch)
    seconds = {**made.report["seconds"], "total": round(time.monotonic() - began, 3)}
    return Delivered(made.files, {**made.report, "seconds": seconds})


def _carried(wanted: Recipe, held: Mapping[str, tuple[Path, bytes]], names: Sequence[str], token: str, ours: str) -> Delivered:
    """The task of a worker elsewhere, which puts what the sources hold into a folder of its own while it draws."""
    if (own := version("crowquill")) != ours:  # it has joined since all were asked
        raise UnfitError(at(), f"has crowquill {own}, and {ours} is wanted; install the same there")
    with contextlib.ExitStack() as stack:
        try:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="crowquill-")))
            paths = {key: folder / key / path.name for key, (path, _) in held.items()}
            for key, (_, data) in held.items():
                paths[key].parent.mkdir()
                paths[key].write_bytes(data)
        except OSError as error:
            raise UnfitError(at(), f"{(error.strerror or 'no folder can be written to').lower()}; free some space there") from None
        try:
            return _drawn(wanted, paths, names, token)
        except ValueError as error:  # it speaks of files by where they are here
            said = str(error)
            for key, (path, _) in held.items():
                said = said.replace(str(paths[key]), str(path))
            raise ValueError(said) from None


def _put(data: bytes, file: BinaryIO) -> None:
    file.write(data)


def _key(wanted: Recipe) -> str:
    """What a drawing's bytes come from: every setting, the sources' hashes, and this version of the program."""
    text = json.dumps({**wanted.data(), "version": version("crowquill")}, sort_keys=True)
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _check_names(jobs: Iterable[Job]) -> None:
    taken: dict[Path, Job] = {}
    for job in jobs:
        for path in job.out:
            if (other := taken.setdefault(path, job)) is not job:
                as_well = f"would be written to {path}, as {other.name} would; give one of them another name"
                raise ValueError(f"{job.name}: {as_well if job.name != other.name else 'is given twice; give it once'}")
