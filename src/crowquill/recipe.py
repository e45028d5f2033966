"""Recipes: all that made a drawing, as plain data that its files keep, a person reads as TOML, and `redo` follows."""

from __future__ import annotations

import hashlib
import numbers
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

from crowquill import finishing, formats, inking, layout, pasting, plotting, styles
from crowquill.knobs import Choice, Flag, Knob, Text, checked, of, unknown
from crowquill.sheet import Sheet
from crowquill.vector import regular

SCHEMA = 1  # a reader refuses a newer one
TABLES = ("paper", "tone", "knobs", "inks", "finish", "files", "plot")
RESULTS = {"art_mm", "paper_mm", "art_at_mm"}  # what came of it: kept in files beside what made it
PICTURE = "picture"


@dataclass(frozen=True)
class Source:
    """A file that a drawing is made from: its bare name, and the SHA-256 of its bytes where that is known."""

    name: str
    sha256: str = ""

    @classmethod
    def of(cls, path: Path) -> Source:
        """The source that a file is; a folder, a pipe or a device is a ValueError."""
        regular(path)
        with path.open("rb") as file:
            return cls(path.name, hashlib.file_digest(file, "sha256").hexdigest())


@dataclass(frozen=True)
class Recipe:
    """A style with its seed, and every setting by name in seven tables; `sources` are the files by what they are for.

    paper, tone  the keywords of layout.placed and layout.lit
    knobs        of the style; `inks` of inking.steps; `finish` of finishing.finish
    files        of the formats written and the sheets they are cut to, only those that were asked for
    plot         of finished() and of plotting.plotted, which count for plotters only
    """

    style: str
    seed: int = 0
    paper: Mapping[str, Any] = field(default_factory=dict)
    tone: Mapping[str, Any] = field(default_factory=dict)
    knobs: Mapping[str, Any] = field(default_factory=dict)
    inks: Mapping[str, Any] = field(default_factory=dict)
    finish: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Any] = field(default_factory=dict)
    plot: Mapping[str, Any] = field(default_factory=dict)
    sources: Mapping[str, Source] = field(default_factory=dict)
    version: str = field(default_factory=lambda: version("crowquill"))

    def __post_init__(self) -> None:
        """Checks every value. Raises ValueError for what is unknown, with the nearest that is known, or of a wrong type."""
        if isinstance(self.seed, bool) or not isinstance(self.seed, numbers.Integral) or self.seed < 0:
            raise ValueError(f"seed is {self.seed!r}; it takes a whole number, 0 or more")
        for table in TABLES:
            takes, values = takes_of(table, self.style), getattr(self, table)
            whole = checked(takes, values, f"table {table}" if table != "knobs" else f"style {self.style}")
            kept = values if table == "files" else takes
            object.__setattr__(self, table, {key: whole[key] for key in kept})

    def data(self) -> dict[str, Any]:
        """The recipe as JSON and TOML can hold it: what is left to a default of None is left out."""
        unused = {"plot"} if self.plot["purpose"] != "plotter" else set()
        unused |= {"inks"} if all(value is None for value in self.inks.values()) else set()
        used = [table for table in TABLES if table not in unused]
        tables = {table: {key: _plain(value) for key, value in getattr(self, table).items() if value is not None} for table in used}
        sources = {key: {"name": source.name, "sha256": source.sha256} for key, source in self.sources.items()}
        return {"schema": SCHEMA, "version": self.version, "style": self.style, "seed": int(self.seed), "sources": sources, **tables}

    def toml(self) -> str:
        """The recipe as TOML; lengths are millimetres."""
        import tomli_w

        head = "# A recipe of crowquill; lengths are millimetres.\n"
        return _printable(head + tomli_w.dumps({key: value for key, value in self.data().items() if value != {}}))

    def with_paths(self, paths: Mapping[str, Path]) -> Recipe:
        """The recipe with these paths for the settings that name files."""
        changed: dict[str, Any] = {}
        for table in TABLES:
            own = getattr(self, table)
            changed[table] = {**own, **{key: str(path) for key, path in paths.items() if own.get(key) is not None}}
        return replace(self, **changed)


def takes_of(table: str, style: str) -> dict[str, Knob]:
    """The knobs of a table of recipes for a style."""
    if table == "files":
        return {key: knob for name in formats.names() for key, knob in formats.knobs(name).items()} | of(attached) | of(pasting.cut)
    if table == "plot":
        return of(finished) | of(plotting.plotted)
    if table == "knobs":
        return styles.knobs(style)
    functions: dict[str, Callable[..., Any]] = {
        "paper": layout.placed,
        "tone": layout.lit,
        "inks": inking.steps,
        "finish": finishing.finish,
    }
    return of(functions[table])


def files_of(recipe: Recipe) -> dict[str, str]:
    """The settings that name files, by their keys; a word, such as that of a library that comes along, has no suffix."""
    found = {}
    for table in TABLES:
        for key, knob in takes_of(table, recipe.style).items():
            value = getattr(recipe, table).get(key)
            if isinstance(knob.takes, Text) and knob.takes.file and value and Path(value).suffix:
                found[key] = value
    return found


def finished(
    sheet: Sheet,
    settings: Mapping[str, Any],
    *,
    purpose: Annotated[str, Choice(("print", "plotter"), "what draws it; a plotter gets strokes, in their order")] = "print",
    plot_time: Annotated[str | None, Text("time it may take, such as 90min or 2h; decides the number of dots")] = None,  # noqa: ARG001
) -> Sheet:
    """The sheet as it is, or, for a plotter, as strokes by these settings; the number of dots was decided before."""
    return plotting.plotted(sheet, **settings) if purpose == "plotter" else sheet


def attached(
    sheet: Sheet, recipe: Recipe, paths: Mapping[str, Path], *, embed: Annotated[bool, Flag("keep the picture in the files")] = False
) -> Sheet:
    """The sheet with its sources inside, where they are to be, under their bare names."""
    return replace(sheet, attached={recipe.sources[key].name: paths[key].read_bytes() for key in sorted(paths)}) if embed else sheet


def check_names(recipe: Recipe) -> None:
    """Raises ValueError for sources that redo could not find by their bare names, and names that cannot be embedded."""
    known: dict[str, str] = {}
    for source in recipe.sources.values():
        if recipe.files.get("embed") and source.name != _printable(source.name):
            raise ValueError(f"{source.name}: its name is not UTF-8 and cannot be embedded; rename it, or leave out embed")
        if known.setdefault(source.name, source.sha256) != source.sha256:
            raise ValueError(f"{source.name}: two different files of this name are read, and redo could not tell them apart; rename one")


def parsed(data: Any, name: str) -> Recipe:
    """The recipe in plain data; errors call it `name`. ValueError for a newer schema, what is unknown, missing or of a wrong type."""
    try:
        return _parsed(data)
    except ValueError as error:
        raise ValueError(error if str(error).startswith(f"{name}: ") else f"{name}: {_with_remedy(str(error))}") from None


def read_toml(data: bytes, name: str) -> Recipe:
    """The recipe in a TOML file."""
    try:
        values = tomllib.loads(data.decode("utf-8"))
    except (ValueError, RecursionError) as error:  # TOML's own errors, letters that are none, numbers of thousands of digits
        raise ValueError(f"{name}: not sound TOML ({str(error)[:100]}); mend it, or print a recipe with: crowquill recipe FILE") from None
    return parsed(values, name)


def _parsed(data: Any) -> Recipe:
    if isinstance(data, Mapping) and data.get("style") == "plate":
        raise ValueError("is a plate of several drawings; use crowquill plate, or plate.redo in Python")
    if isinstance(data, Mapping) and "edits" in data:
        raise ValueError("was edited by hand; draw it again from the editor's log with crowquill replay")
    if not isinstance(data, Mapping) or "style" not in data:
        raise ValueError("has no recipe: it does not say its style; give a file drawn by the command line")
    schema = data.get("schema", SCHEMA)
    if isinstance(schema, bool) or not isinstance(schema, int):
        raise ValueError(f"schema is {schema!r}; it takes a whole number")
    if schema < 1:
        raise ValueError(f"schema is {schema}; it takes 1 to {SCHEMA}")
    if schema > SCHEMA:
        raise ValueError(f"made by a newer crowquill (recipe schema {schema}); update this one")
    known = ["schema", "version", "style", "seed", "sources", *TABLES]
    for key in data:
        if key not in known and key not in RESULTS:
            raise ValueError(f"no {unknown('key', str(key), known)}")
    for key, kind in (("style", str), ("version", str), *((table, Mapping) for table in ("sources", *TABLES))):
        if not isinstance(data.get(key, kind() if kind is str else {}), kind):
            raise ValueError(f"{key} is {data[key]!r}; it takes {'a text' if kind is str else 'a table'}")
    sources = {str(key): _source(str(key), value) for key, value in data.get("sources", {}).items()}
    tables: dict[str, Any] = {table: dict(data.get(table, {})) for table in TABLES}
    recipe = Recipe(data["style"], data.get("seed", 0), **tables, sources=sources, version=data.get("version") or version("crowquill"))
    named = {key: _source(key, {"name": name}) for key, name in files_of(recipe).items()}
    for key, source in sources.items():
        if key != PICTURE and (key not in named or named[key].name != source.name):
            raise ValueError(f"source {key} is {source.name!r}, which no setting names; give both the same name")
    return replace(recipe, sources={**named, **sources})


def _source(key: str, value: Any) -> Source:
    name = value.get("name") if isinstance(value, Mapping) else None
    digest = value.get("sha256", "") if isinstance(value, Mapping) else None
    if not isinstance(name, str) or not name or Path(name).name != name or name == ".." or "\0" in name:
        raise ValueError(f"the name of source {key} is {name!r}; it takes the bare name of a file, without a folder")
    if not isinstance(digest, str) or not re.fullmatch("([0-9a-f]{64})?", digest):
        raise ValueError(f"the sha256 of source {key} is {digest!r}; it takes 64 hexadecimal digits")
    if extra := set(value) - {"name", "sha256"}:
        raise ValueError(f"source {key} has no {unknown('key', str(min(extra)), ['name', 'sha256'])}")
    return Source(name, digest)


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _printable(text: str) -> str:
    """The text with a question mark for bytes of names that are not UTF-8."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _with_remedy(said: str) -> str:
    return said if "; " in said else f"{said}; mend it"
