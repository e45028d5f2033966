"""The files that a plate is made from: found in its folder and nowhere else, and known by their SHA-256."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path, PurePath

from crowquill.recipe import Source


class Folder:
    """A plate's folder: files by their name in it, and what they hold.

    known     the SHA-256 that a file of a name must have
    given     paths of files that lie elsewhere, by name
    digests   of all files asked for so far, by name
    """

    def __init__(self, root: Path, known: Mapping[str, str], given: Mapping[str, Path] | None = None) -> None:
        self.root, self._known, self._given = root, known, given or {}
        self.digests: dict[str, str] = {}

    def file(self, name: str, beside: Path | None = None) -> Path:
        """The path of a file in the folder, or in that of another file of it.

        Raises ValueError for a name that leads out of the folder, for what is missing, and for another file than is known.
        """
        if beside is None and name in self._given:
            return self._checked(self._given[name], name)
        parts = PurePath(name).parts
        if not parts or "\0" in name or "\\" in name or PurePath(name).is_absolute() or ".." in parts:
            raise ValueError(f"{name!r} is no file of the plate's folder; give its name there, without .. and without a root")
        path = (beside.parent if beside else self.root) / name
        inside = Path(os.path.realpath(self.root))
        if not Path(os.path.realpath(path)).is_relative_to(inside):
            raise ValueError(f"{name!r} is a link out of the plate's folder; put the file itself there")
        if not path.exists():
            raise ValueError(f"there is no file {name!r} in the plate's folder; check the name")
        return self._checked(path, name)

    def _checked(self, path: Path, name: str) -> Path:
        if self._known.get(self._own(path), "") not in ("", self.digest(path)):
            raise ValueError(f"{name!r} is not the file that the plate was drawn from (its SHA-256 differs); give the same file")
        return path

    def digest(self, path: Path) -> str:
        """The SHA-256 of one of its files, read once."""
        own = self._own(path)
        if own not in self.digests:
            self.digests[own] = Source.of(path).sha256
        return self.digests[own]

    def contents(self) -> dict[str, bytes]:
        """What the files asked for so far hold, by name."""
        return {name: path.read_bytes() for name, path in zip(sorted(self.digests), self.paths(), strict=True)}

    def paths(self) -> list[Path]:
        """Where they are, by name."""
        return [self._given.get(name, self.root / name) for name in sorted(self.digests)]

    def _own(self, path: Path) -> str:
        for name, elsewhere in self._given.items():
            if path == elsewhere:
                return name
        return path.relative_to(self.root).as_posix()
