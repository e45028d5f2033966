"""A lock: a file beside a drawing that says which process edits it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from crowquill.formats import alive

TRIES = 5  # of taking over what a process that was killed has left


class Lock:
    """Held from when it is made until it is released, or its process ends."""

    def __init__(self, path: Path, name: str) -> None:
        """Takes the lock; `name` is of what. Raises ValueError where another process has it, OSError where it cannot be written."""
        self.path = path
        for _ in range(TRIES):
            try:
                handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            except FileExistsError:
                self._clear(name)
                continue
            with os.fdopen(handle, "w") as file:
                file.write(f"{os.getpid()}\n")
            return
        raise ValueError(f"{name}: its lock {path.name} comes and goes; end the other process, or remove it")

    def _clear(self, name: str) -> None:
        """Removes the lock of a process that has ended."""
        try:
            text = self.path.read_text("ascii", "replace").strip()
        except FileNotFoundError:
            return
        if text.isdecimal() and (alive(int(text)) or int(text) == os.getpid()):
            raise ValueError(f"{name}: is being edited already, by process {text}; go to its page, or end it")
        with contextlib.suppress(FileNotFoundError):
            self.path.unlink()

    def release(self) -> None:
        """Gives the lock away."""
        with contextlib.suppress(OSError):
            self.path.unlink()
