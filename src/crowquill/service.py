"""Drawings for programs that serve others: bytes in, bytes out, within limits, and no file read but the picture that came.

    try:
        pdf = drawing(picture, "stipple", "pdf", {"pen": "0.3mm", "paper": "a5"}, limits=Limits(seconds=20), cancelled=gone.is_set)
    except LimitError as error:  # a ValueError like any other refusal: str(error) is a line for who asked
        ...

It keeps nothing between calls, and may run in several threads at once; each takes the threads that CROWQUILL_THREADS says, or all cores.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from crowquill import formats, knobs, making, styles
from crowquill.delivery import delivered
from crowquill.formats import _bitmap
from crowquill.picture import pixels
from crowquill.recipe import PICTURE, TABLES, Recipe, takes_of
from crowquill.sheet import Sheet, Step

COUNTED = ("dots", "tiles")  # of what a style says before its work
SLACK = 4  # what is foretold may be wrong by so much
TRUE, FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


@dataclass(frozen=True)
class Limits:
    """What one drawing may take: pixels of the picture, of a halftone, and of a bitmap that is written; dots or tiles; seconds."""

    pixels: int = 40_000_000
    dots: int = 200_000
    seconds: float = 60.0


class LimitError(ValueError):
    """A drawing is over a limit: `what` is pixels, dots or seconds, `most` the limit."""

    def __init__(self, what: str, wanted: float, most: float) -> None:
        """`wanted` is how much it would take."""
        told = f"{wanted:,.0f} {what}" if what != "seconds" else f"{wanted:.1f} seconds"
        super().__init__(f"the drawing takes {told}, and {most:,.0f} are the limit; ask for less")
        self.what, self.wanted, self.most = what, wanted, most

    def __reduce__(self) -> tuple[type[LimitError], tuple[str, float, float]]:
        """As it travels between processes."""
        return LimitError, (self.what, self.wanted, self.most)


def drawing(
    data: bytes,
    style: str,
    out: str = "pdf",
    options: Mapping[str, Any] | None = None,
    *,
    seed: int = 0,
    limits: Limits | None = None,
    cancelled: Callable[[], bool] = lambda: False,
    files: Mapping[str, Path] | None = None,
) -> bytes:
    """A file in the format `out`, of what a style makes of a picture file's bytes; the same arguments give the same bytes.

    options    settings by the names of the command line's options, with underscores: paper, pen, tone, dpi, ...; texts take units
    limits     those of Limits() when left out; options cannot raise them
    cancelled  is asked at every Step; once it says yes, the work ends
    files      files by the option that names them, such as glyphs: they are the service's own, and options may name none

    What is over the limits is refused before the work where it is known: pixels always, dots and tiles as the style foretells
    them, seconds where it foretells over four times as many. Else time is looked at between Steps: of 20 000 dots one takes a second
    or so, in `mosaic`, `bluenoise`, `byexample` and `objects` ten to twenty. Who must end it sooner runs it in a process of
    cluster.workers(None, 1), and leaves that.

    Raises LimitError; ValueError in one line for what cannot be followed; concurrent.futures.CancelledError.
    """
    watch = _Watch(limits or Limits(), cancelled)
    watch.step()
    with tempfile.TemporaryDirectory(prefix="crowquill-") as folder:
        picture = Path(folder) / "picture"  # what errors call it, and recipes
        picture.write_bytes(data)
        own = {key: Path(path) for key, path in (files or {}).items()}
        try:
            watch.check("pixels", pixels(picture), watch.limits.pixels)
            tables = _tables(style, {**(options or {}), **{key: str(path) for key, path in own.items()}}, own)
            paths = {PICTURE: picture, **own}
            wanted = making.named(_suited(Recipe(style, seed, **tables), out), paths)
            bitmap = wanted.files if "bilevel" in formats.knobs(out) else None
            planned, drawn = partial(watch.planned, bitmap), partial(watch.drawn, bitmap)
            made = delivered(wanted, paths, [f"drawing.{out}"], planned=planned, watch=watch.step, drawn=drawn)
        except LimitError:
            raise
        except ValueError as error:
            raise ValueError(str(error).replace(f"{folder}/", "")) from None
    return made.files[f"drawing.{out}"]


def read(style: str, texts: Mapping[str, str]) -> dict[str, Any]:
    """Options from texts, such as those of a query: numbers, flags and lists as the style's options take them.

    Raises ValueError for an option that there is not, and for a text that cannot be read as what it takes.
    """
    takes = _takes(style)
    return {key: _read(_known(key, takes)[1], text) for key, text in texts.items()}


def _read(knob: knobs.Knob, text: str) -> Any:
    """The value of a knob in a text; lengths stay texts, for they have units."""
    takes = knob.takes
    try:
        if isinstance(takes, knobs.Flag):
            return {**dict.fromkeys(TRUE, True), **dict.fromkeys(FALSE, False)}[text.lower()]
        if isinstance(takes, knobs.Range) and takes.unit != "mm":
            return int(text) if knob.whole else float(text)
        if isinstance(takes, knobs.Numbers):
            return [part if takes.unit == "mm" else float(part) for part in text.split(",")]
    except (LookupError, ValueError):
        kind = "true or false" if isinstance(takes, knobs.Flag) else "numbers" if isinstance(takes, knobs.Numbers) else "a number"
        raise ValueError(f"{knob.name} is {text!r}; it takes {kind}: {takes.help}") from None
    return text


def _takes(style: str) -> dict[str, tuple[str, knobs.Knob]]:
    """Every option of drawings in a style: the table of recipes where it stands, and its knob."""
    return {key: (table, knob) for table in TABLES for key, knob in takes_of(table, style).items()}


def _known(key: str, takes: Mapping[str, tuple[str, knobs.Knob]]) -> tuple[str, knobs.Knob]:
    if key not in takes:
        raise ValueError(f"no {knobs.unknown('option', key, takes)}")
    return takes[key]


def _suited(wanted: Recipe, out: str) -> Recipe:
    """The recipe as it suits the file to be written."""
    return replace(wanted, knobs=styles.suited(wanted.style, wanted.knobs, [formats.shown(Path(f"drawing.{out}"), wanted.files)]))


def _tables(style: str, options: Mapping[str, Any], own: Mapping[str, Path]) -> dict[str, Any]:
    """The options, parted into a recipe's tables; `own` are the service's files. Raises ValueError for other files, and for no options."""
    takes = _takes(style)
    tables: dict[str, Any] = {table: {} for table in TABLES}
    for key, value in options.items():
        table, knob = _known(key, takes)
        named = isinstance(knob.takes, knobs.Text) and knob.takes.file
        if key in own and not named:
            raise ValueError(f"{key} takes no file; give it among the options")
        if named and key not in own and value is not None and set("/\\.\0") & set(str(value)):
            raise ValueError(f"{key} is {value!r}; here it takes no file, only what comes with crowquill")
        tables[table][key] = value
    return tables


class _Watch:
    """The limits of one drawing, looked at as it goes on."""

    def __init__(self, limits: Limits, cancelled: Callable[[], bool]) -> None:
        self.limits, self._cancelled = limits, cancelled
        self._began = time.monotonic()

    def planned(self, bitmap: Mapping[str, Any] | None, size: tuple[float, float], facts: Mapping[str, float]) -> None:
        """Refuses what is foretold to be over a limit; `bitmap` are the knobs of the bitmap to be written, if it is one."""
        self.step()
        self.check("dots", max(facts.get(key, 0) for key in COUNTED), self.limits.dots)
        self.check("pixels", facts.get("cells", 0), self.limits.pixels)
        if facts.get("seconds", 0) > SLACK * self.limits.seconds:
            raise LimitError("seconds", facts["seconds"], self.limits.seconds)
        self.drawn(bitmap, Sheet(size))

    def drawn(self, bitmap: Mapping[str, Any] | None, sheet: Sheet) -> None:
        """Refuses a bitmap of too many pixels; what a sheet's own are is known once it is drawn."""
        self.step()
        if bitmap is not None:
            page = _bitmap.pixels(sheet.size, bitmap.get("dpi") or _bitmap.finest(sheet), bool(bitmap.get("bilevel")))
            self.check("pixels", page[0] * page[1], self.limits.pixels)

    def step(self, _: Step | None = None) -> None:
        """Ends the work where nobody waits for it any more, or its time is over."""
        if self._cancelled():
            raise CancelledError
        self.check("seconds", time.monotonic() - self._began, self.limits.seconds)

    def check(self, what: str, wanted: float, most: float) -> None:
        """Refuses what is over a limit."""
        if wanted > most:
            raise LimitError(what, wanted, most)
