"""A session: one drawing of a folder, its history and its log, and what is done with them. One thread at a time calls it."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from crowquill import formats, preflight, styles
from crowquill.editor import log, opening
from crowquill.editor.drawing import Drawing, Layer, sheet_of
from crowquill.editor.folder import digests, located, within
from crowquill.editor.history import History
from crowquill.editor.lock import Lock
from crowquill.editor.log import Entry, Journal
from crowquill.editor.opening import Header
from crowquill.editor.operations import find, work
from crowquill.editor.states import States
from crowquill.recipe import Recipe
from crowquill.sheet import Sheet, Step
from crowquill.vector import contents

Watch = Callable[[Step], None]
OFTEN = 2.0  # s of work after which the state is kept, so that it need not be done again
ONCE = 0.5  # s of work for which it is kept when the session ends
OPENED = (".svg", ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".gif", ".bmp")


class Session:
    """A drawing that is edited: the file in its folder, the log beside it, and the state now."""

    def __init__(self, file: Path, settings: Recipe | None = None, watch: Callable[[int, int], None] | None = None) -> None:
        """Opens a picture, a drawing or a log, and does again what the log holds.

        settings  how a picture is laid out, where it has no log yet
        watch     sees how many entries of how many are done

        Raises ValueError for a drawing that is being edited already, for settings beside a log, and whatever opening raises.
        """
        if file.suffix == opening.SUFFIX:
            file = file.with_suffix("")
        self.file, self.folder = file, file.parent
        self.path = file.with_name(file.name + opening.SUFFIX)
        self.notes: tuple[str, ...] = ()
        self._worked = 0.0  # s of entries since a state was kept
        self.lock = Lock(file.with_name(file.name + opening.SUFFIX + ".lock"), str(file))
        try:
            self._open(settings)
            self._recover(watch)
        except BaseException:
            self.lock.release()
            raise

    def _open(self, settings: Recipe | None) -> None:
        if self.path.exists():
            if settings is not None:
                raise ValueError(f"{self.path}: has edits made with other settings; leave them out, or move it away to begin anew")
            found = log.read(self.path)
            self.header = found.header
            begun = opening.again(found.header, self.file)
            self.states = States(self.path, self.header, begun)
            entries = [*found.done, *found.undone]
            self.history = History(begun, entries, len(found.done), self._perform, states=self.states)
            self.journal = Journal(self.path, self.header, found.sound)
            if self.header.version != version("crowquill"):
                self.notes = (
                    f"the edits were begun with crowquill {self.header.version}, this is {version('crowquill')}; they may differ",
                )
        else:
            self.header, begun = opening.opened(self.file, settings)
            self.states = States(self.path, self.header, begun)
            self.states.clear()  # of a log that was moved away
            self.history = History(begun, (), 0, self._perform, states=self.states)
            self.journal = Journal(self.path, self.header)
        self.notes += begun.notes
        self.begun = self.drawing = begun

    def _recover(self, watch: Callable[[int, int], None] | None) -> None:
        try:
            for k in self.history.run():
                if watch:
                    watch(k, self.history.at)
        except ValueError as error:
            self.journal.close()
            raise ValueError(f"{self.path}: cannot be followed: {error}") from None
        self.drawing = self.history.drawing()

    def apply(self, op: str, params: Mapping[str, Any], seed: int | None, group: int, watch: Watch | None = None) -> bool:
        """Does an operation, which then waits to be written down; False where it changed nothing and is not kept.

        Raises ValueError for what is unknown or out of range, OSError for a file that cannot be read.
        """
        number = len(self.history.entries) if seed is None else seed
        entry = Entry(op, params, number, group, digests(self.folder, find(op).knobs, params))
        made = self._perform(self.drawing, entry, watch)
        if same(made, self.drawing):
            self.drawing = replace(self.drawing, facts=made.facts, notes=made.notes)
            return False
        self.history.push(entry, made)
        self.journal.append(entry.data())
        self.drawing = made
        return True

    def _perform(self, drawing: Drawing, entry: Entry, watch: Watch | None = None) -> Drawing:
        began = time.monotonic()
        made = performed(drawing, entry, self.folder, watch)
        self._worked += time.monotonic() - began
        return made

    def write(self) -> Callable[[], str] | None:
        """Writes down what waits. Once in a while it gives what keeps the state now, for any thread to call; that says why if it fails."""
        self.journal.write()
        if self._worked < OFTEN:
            return None
        self._worked = 0.0
        entries, drawing = self.history.entries[: self.history.at], self.drawing
        return lambda: self.states.keep(entries, drawing)

    def undo(self, groups: int = 1) -> int:
        """Goes back so many groups; how many entries that were."""
        return self._went("undo", self.history.back(groups))

    def redo(self, groups: int = 1) -> int:
        """Goes on so many groups; how many entries that were."""
        return self._went("redo", self.history.ahead(groups))

    def _went(self, way: str, at: int) -> int:
        count = self.history.go(at)
        if count:
            self.drawing = self.history.drawing()
            self.journal.append({way: count})
        return count

    def sheet(self) -> Sheet:
        """The drawing as files have it."""
        return written(self.header, self.drawing)

    def export(self, names: Sequence[str], options: Mapping[str, Any], *, overwrite: bool = False) -> list[str]:
        """Writes the drawing to files of the folder, all or none.

        Raises ValueError for names that are no bare ones and unknown options, FileExistsError for what is there and may not be replaced.
        """
        paths = [self.within(name) for name in names]
        if not paths:
            raise ValueError("files is empty; name one, such as drawing.pdf")
        read = [self.file, self.path]
        formats.check(paths, overwrite=overwrite, sources=read)
        takes = {key: knob for path in paths for key, knob in formats.knobs(path.suffix[1:].lower()).items()}
        chosen = located(self.folder, takes, options, digests(self.folder, takes, options))
        plan = formats.writers(self.sheet(), [(path, None) for path in paths], chosen)
        formats.replace_files(list(zip(paths, plan, strict=True)))
        return [path.name for path in paths]

    def checked(self, name: str) -> dict[str, Any]:
        """What preflight finds in a file of the folder."""
        found = preflight.check(contents(self.within(name)), name)
        return {"errors": found.errors, "findings": [asdict(finding) for finding in found.findings]}

    def files(self) -> list[str]:
        """The names in the folder that can be opened."""
        with os.scandir(self.folder) as entries:
            return sorted(one.name for one in entries if one.is_file() and Path(one.name).suffix.lower() in OPENED)

    def within(self, name: Any) -> Path:
        """The path of a file in the folder. ValueError for anything but a bare name, and for links that lead elsewhere."""
        return within(self.folder, name)

    def rescued(self) -> Path:
        """Writes the whole log to a new file of the folder for temporary ones, for when its own place is full. Raises OSError."""
        lines = [self.header.data(), *(entry.data() for entry in self.history.entries)]
        if undone := len(self.history.entries) - self.history.at:
            lines.append({"undo": undone})
        handle, name = tempfile.mkstemp(opening.SUFFIX, f"{self.file.name}-")
        with os.fdopen(handle, "wb") as file:
            file.write(b"".join(map(log.line, lines)))
        return Path(name)

    def close(self) -> None:
        """Ends the session, once what waits is written: a log without a single line goes, and so does the lock."""
        self.journal.write()
        self.journal.close()
        if not self.history.entries and not self.journal.waiting:
            self.path.unlink(missing_ok=True)
            self.states.clear()
        elif self._worked > ONCE and not self.journal.waiting:
            self.states.keep(self.history.entries[: self.history.at], self.drawing)
        self.lock.release()


def same(a: Drawing, b: Drawing) -> bool:
    """Whether two drawings are one in all that can be edited."""
    if a.tone is not b.tone or a.wish is not b.wish or a.wall is not b.wall or len(a.layers) != len(b.layers):
        return False
    if (a.size, a.margin) != (b.size, b.margin) or (a.picture.corner != b.picture.corner).any() or a.picture.size != b.picture.size:
        return False
    return all(one is other or _alike(one, other) for one, other in zip(a.layers, b.layers, strict=True))


def _alike(one: Layer, other: Layer) -> bool:
    """Whether two layers have the same settings and the same items."""
    if any(getattr(one, name) != getattr(other, name) for name in ("id", "name", "ink", "hidden", "locked", "tiling", "still")):
        return False
    pairs = zip(one.items.columns(), other.items.columns(), strict=True)
    return all(a is b or (a.shape == b.shape and bool((a == b).all())) for a, b in pairs)


def written(header: Header, drawing: Drawing) -> Sheet:
    """The drawing of a log as files have it."""
    return sheet_of(replace(drawing, recipe=opening.recipe_of(header, drawing)))


def performed(drawing: Drawing, entry: Entry, folder: Path, watch: Watch | None = None) -> Drawing:
    """The drawing that an entry makes, with the files that it reads from a folder. ValueError where one of them is another now."""
    params = located(folder, find(entry.op).knobs, entry.params, entry.files)
    return styles.run(work(drawing, entry.op, params, entry.seed), watch)


def edited(path: Path, header: Header) -> Path:
    """The file that a log is of: beside it by its own name, or by the log's."""
    named = path.with_suffix("") if path.suffix == opening.SUFFIX else path
    return named if named != path and named.exists() else path.parent / header.file.name


def replayed(path: Path) -> Iterator[tuple[int, int, Drawing, Header]]:
    """The drawing after each entry of a log, how many of how many are done, and its header; the file edited lies beside the log."""
    found = log.read(path)
    drawing = opening.again(found.header, edited(path, found.header))
    yield 0, len(found.done), drawing, found.header
    for k, entry in enumerate(found.done, 1):
        try:
            drawing = performed(drawing, entry, path.parent)
        except ValueError as error:
            raise ValueError(f"{path}: entry {k}, {entry.op}: {error}") from None
        yield k, len(found.done), drawing, found.header
