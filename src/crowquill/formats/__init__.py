"""Formats: how sheets become files, and come back. One file of this folder is one format; its name is the suffix.

A format is a function `write(sheet, file, *, knob=...)`, its knobs declared as a style's are; one that can be read back has
`read(data, name)` too, and one that keeps the sheet's recipe `recipe(data, name)`.
What a format cannot write it may say before the work, in `foresee(size, marks, **knobs)`.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import io
import os
import secrets
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from importlib.metadata import EntryPoints, entry_points
from pathlib import Path
from typing import Any, BinaryIO

from crowquill.knobs import Knob, checked, of, unknown
from crowquill.sheet import Sheet, Shown
from crowquill.vector import contents

Target = str | os.PathLike[str] | BinaryIO
PART = ".part"  # suffix of a file under way
SAME = {"tif": "tiff", "plt": "hpgl", "nc": "gcode"}  # suffixes by which a format is called too


@cache
def plugins() -> EntryPoints:
    """The formats of other packages, looked for once: that takes 15 ms, and a recipe asks twenty times."""
    return entry_points(group="crowquill.formats")


def names() -> list[str]:
    """The formats there are, sorted: files of this folder, and plug-ins of the group crowquill.formats."""
    own = {path.stem for path in Path(__file__).parent.glob("[a-z]*.py")}
    return sorted(own | {entry.name for entry in plugins()})


def knobs(format: str) -> dict[str, Knob]:
    """The knobs of a format, read from the signature of its `write`, in its order."""
    return of(module(format, format).write)


def shown(path: Path, values: Mapping[str, Any]) -> Shown:
    """How a file of this name will show a sheet, values being knobs of formats."""
    own = knobs(path.suffix[1:].lower())
    taken = {key: values.get(key, own[key].default) for key in own}
    return Shown(str(path), "bilevel" in own, bool(taken.get("grey_dots")) and not taken.get("bilevel"))


def save(sheet: Sheet, *targets: Target, format: str | None = None, overwrite: bool = True, **values: Any) -> None:
    """Writes the sheet to every target: paths, whose suffix names the format, or open binary files.

    values  knobs of formats, each for those targets that take it; one that none takes is a ValueError

    An open file takes `format`, or goes by its own name. Each file is written beside its place and
    renamed once all are whole, so that nothing is ever half written. Raises ValueError for an unknown
    format, FileExistsError where a file is there and may not be replaced, OSError where it cannot be written.
    """
    files = [path for path in targets if isinstance(path, (str, os.PathLike))]
    streams = [file for file in targets if not isinstance(file, (str, os.PathLike))]
    names = [Path(str(getattr(file, "name", "open file"))) for file in streams]
    paths = [Path(path) for path in files]
    every = writers(sheet, [*((path, None) for path in paths), *((name, format) for name in names)], values)
    check(paths, overwrite=overwrite)
    for file, write in zip(streams, every[len(paths) :], strict=True):
        write(file)
    replace_files(list(zip(paths, every, strict=False)))


def writers(sheet: Sheet, targets: Sequence[tuple[Path, str | None]], values: Mapping[str, Any]) -> list[Callable[[BinaryIO], object]]:
    """For each target, a path and a format or None for that of its suffix, the function that writes the sheet to an open file.

    Each gets those of the values that it has knobs for. Raises ValueError for an unknown format, and for a value that none takes.
    """
    modules = [module(format or path.suffix[1:].lower(), str(path)) for path, format in targets]
    takes = [of(found.write) for found in modules]
    for key in values:
        if not any(key in own for own in takes):
            known = sorted({name for own in takes for name in own})
            wish = unknown("knob", key, known) if known else f"knob {key!r}; leave it out"
            raise ValueError(f"none of the formats written has {wish}")
    chosen = [checked(own, {key: value for key, value in values.items() if key in own}, "format") for own in takes]
    return [partial(found.write, sheet, **own) for found, own in zip(modules, chosen, strict=True)]


def replace_files(plan: Sequence[tuple[Path, Callable[[BinaryIO], object]]]) -> None:
    """Fills each path by its function, all beside their places first, then renamed: all or none, never half of one.

    An OSError names the path it happened to.
    """
    done: list[tuple[str, Path, Path]] = []
    try:
        for given, fill in plan:
            path = Path(os.path.realpath(given))  # a link stays one, and what it names is replaced
            _clear(path)
            name = str(path.parent / f"{_mark(path)}{os.getpid()}.{secrets.token_hex(6)}{PART}")
            with _named(given):
                with open(name, "xb") as file:  # noqa: PTH123
                    done.append((name, path, given))
                    fill(file)
                    file.flush()
                    os.fsync(file.fileno())
                if path.exists():
                    Path(name).chmod(path.stat().st_mode & 0o777)
        while done:
            name, path, given = done[0]
            with _named(given):
                os.replace(name, path)
            del done[0]
    finally:
        for name, _, _ in done:
            with contextlib.suppress(OSError):
                os.unlink(name)


@contextlib.contextmanager
def _named(path: Path) -> Iterator[None]:
    """An OSError inside speaks of this path, whatever file it happened to."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def check(paths: Sequence[Path], *, overwrite: bool = True, sources: Sequence[Path] = ()) -> None:
    """Raises the error that saving to these paths would raise, before any work is done.

    sources  files read, none of which may be a target.
    """
    for path in paths:
        with contextlib.suppress(FileNotFoundError):
            path.stat()  # a name too long, a link to itself
        if path.is_dir():
            raise IsADirectoryError(f"{path}: is a folder; give a file name in it")
        if path.exists() and not path.is_file():
            raise ValueError(f"{path}: is not a regular file; give another name")
        if any(source.exists() and path.exists() and path.samefile(source) for source in sources):
            raise ValueError(f"{path}: would be written over a file that is read; give another name")
        if path.exists() and not overwrite:
            raise FileExistsError(f"{path}: is there already; remove it, or allow it with --overwrite")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"{path}: there is no folder {path.parent}; make it first")
        if not os.access(path.parent, os.W_OK):
            raise PermissionError(f"{path}: the folder cannot be written to; choose another")
    whole = [os.path.realpath(path) for path in paths]
    for path, real in zip(paths, whole, strict=True):
        if whole.count(real) > 1:
            raise ValueError(f"{path}: is named twice; give each output its own name")


def foresee(paths: Sequence[Path], size: tuple[float, float], marks: int, values: Mapping[str, Any]) -> None:
    """Raises the ValueError that writing a sheet of this size, in mm, with so many marks would raise, where that is known before."""
    for path in paths:
        found = module(path.suffix[1:].lower(), str(path))
        own = of(found.write)
        if hasattr(found, "foresee"):
            found.foresee(size, marks, **checked(own, {key: value for key, value in values.items() if key in own}, "format"))


def to_bytes(sheet: Sheet, format: str, **values: Any) -> bytes:
    """The file's bytes in a format by name; values are its knobs."""
    buffer = io.BytesIO()
    writers(sheet, [(Path(format), format)], values)[0](buffer)
    return buffer.getvalue()


def load(source: str | os.PathLike[str] | BinaryIO) -> Sheet:
    """The sheet that a file of ours was made from: every mark, glyph and ink. SVG files keep it.

    A file edited since is read by its geometry, and the report says so in `warnings`.
    """
    name = str(source) if isinstance(source, (str, os.PathLike)) else str(getattr(source, "name", "drawing.svg"))
    reader = module(Path(name).suffix[1:].lower(), name)
    if not hasattr(reader, "read"):
        raise ValueError(f"{name}: drawings cannot be read back from this format; give the SVG")
    data = contents(Path(source)) if isinstance(source, (str, os.PathLike)) else source.read()
    sheet: Sheet = reader.read(data, name)
    return sheet


def recipe_of(path: Path) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What a drawing of ours says made it, as plain data, and the files kept inside it, by name."""
    reader = module(path.suffix[1:].lower(), str(path))
    if not hasattr(reader, "recipe"):
        raise ValueError(f"{path}: this format keeps no recipe; give the drawing's SVG or PDF")
    found: tuple[dict[str, Any], dict[str, bytes]] = reader.recipe(contents(path), str(path))
    return found


def module(format: str, target: str) -> Any:
    """The module of a format, or a ValueError that names those there are."""
    format = SAME.get(format, format)
    if format not in names():
        wish = "" if format else "; give a name with such a suffix"
        raise ValueError(f"{target}: no format {format!r}; there are {', '.join(names())}{wish}")
    for entry in plugins():
        if entry.name == format:
            return entry.load()
    return importlib.import_module(f"crowquill.formats.{format}")


def _mark(path: Path) -> str:
    """How names of files under way for this target begin: short, whatever its own name."""
    return f".crowquill-{hashlib.sha256(os.fsencode(path.name)).hexdigest()[:16]}."


def _clear(path: Path) -> None:
    """Removes what a run that was killed left beside this target; other runs under way are left alone."""
    for part in path.parent.glob(f"{_mark(path)}*{PART}"):
        number = part.name.removeprefix(_mark(path)).split(".")[0]
        if number.isdigit() and not alive(int(number)):
            with contextlib.suppress(OSError):
                part.unlink()


def alive(process: int) -> bool:
    """Whether there is a process of this number."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
