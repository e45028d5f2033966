"""G-code: strokes for machines that hold a pen, each described by a profile, a TOML file.

Keys of a profile, of which `pen_down`, `pen_up`, `feed_down` and `feed_up` are needed:

header, footer      lines before and after all else
pen_down, pen_up    lines that put the pen on the paper and lift it, with what time that takes
dot                 lines at a dot, pen down; {seconds} and {milliseconds} are those of `dwell`
pen_change          lines before each pen but the first; {pen} is its number, {name} its layer's name
decimals, ...       the fields of Machine, below

Lengths are millimetres; strokes are G1, ways between them G0.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from crowquill.formats._strokes import Pen, by_pen, fit, plain, upright
from crowquill.formats._text import number
from crowquill.knobs import Choice, Flag, Numbers, Range, Text, checked, of, unknown
from crowquill.sheet import Sheet
from crowquill.vector import contents

STROKES = True  # fills are refused
FOLDER = Path(__file__).parent / "profiles"
LINES: dict[str, tuple[str, ...]] = {  # keys that hold lines, and the fields these may have
    "header": (),
    "pen_down": (),
    "pen_up": (),
    "dot": ("seconds", "milliseconds"),
    "pen_change": ("pen", "name"),
    "footer": (),
}
NEEDED = {
    "pen_down": 'the lines that put the pen down, such as ["M3 S90", "G4 P0.2"]',
    "pen_up": 'the lines that lift the pen, such as ["M5", "G4 P0.2"]',
    "feed_down": "the speed of drawing in mm/min",
    "feed_up": "the speed between strokes in mm/min",
}


@dataclass(frozen=True, kw_only=True)
class Machine:
    """The settings of a profile that are not lines."""

    feed_down: Annotated[float, Range(1, 100_000, "mm/min", "speed of drawing")]
    feed_up: Annotated[float, Range(1, 100_000, "mm/min", "speed between strokes")]
    decimals: Annotated[int, Range(0, 4, "", "digits behind the point, which are the machine's step")] = 2
    dwell: Annotated[float, Range(0, 60, "s", "how long the pen stays down at a dot; at 0 the lines of `dot` are left out")] = 0.1
    invert_y: Annotated[bool, Flag("y goes up from the sheet's bottom left, not down from its top left")] = True
    bed: Annotated[tuple[float, float] | None, Numbers(1, 100_000, "mm", "width and height of the largest sheet", 2)] = None
    comment: Annotated[str, Choice((";", "()", "none"), "how comments are marked")] = ";"
    change_first: Annotated[bool, Flag("lines of `pen_change` before the first pen too, for machines that fetch it")] = False


@dataclass(frozen=True)
class Profile:
    """A machine by its settings, and its lines by what they are for."""

    name: str
    machine: Machine
    lines: Mapping[str, tuple[str, ...]]

    def said(self, key: str, **values: str) -> list[str]:
        """The lines of a key, their fields filled in."""
        filled = self.lines[key]
        for field, value in values.items():
            filled = tuple(line.replace(f"{{{field}}}", value) for line in filled)
        return list(filled)

    def comment(self, text: str) -> list[str]:
        """The line that says this and does nothing, where there is one."""
        return {";": [f"; {text}"], "()": [f"({text})"], "none": []}[self.machine.comment]


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    profile: Annotated[str, Text("the machine that G-code is for: servo, z, marlin-servo, or your own TOML", file=True)] = "servo",
) -> None:
    """The sheet as G-code in millimetres for a machine: each layer a pen, strokes in their order; a dot is a place where the pen dwells.

    Raises ValueError for fills, for what is wrong with a profile, for sheets larger than its bed, and for several
    pens where it has no lines to change them.
    """
    known = load(profile)
    _fit(sheet.size, known)
    place = upright(sheet) if known.machine.invert_y else lambda xy: xy
    found = by_pen(sheet, 10.0**-known.machine.decimals, "gcode", place)
    if len(found) > 1 and not known.lines["pen_change"]:
        raise ValueError(f"{profile}: has no pen_change lines, and {len(found)} pens draw; give it some, such as M0, or draw with one ink")
    file.write("\n".join([*_lines(sheet, found, known), ""]).encode("ascii"))


def foresee(size: tuple[float, float], _marks: int, *, profile: str) -> None:
    """Raises the ValueError of a profile that is not sound, or of a sheet of this size in mm that is larger than its bed."""
    _fit(size, load(profile))


def names() -> list[str]:
    """The profiles that come with the package, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def load(source: str | os.PathLike[str]) -> Profile:
    """The profile of a name from names(), or of a TOML file by its path.

    Raises ValueError for an unknown name and for what is wrong with the file, OSError where it cannot be read.
    """
    path = FOLDER / f"{source}.toml" if str(source) in names() else Path(source)
    if path.suffix.lower() != ".toml":
        raise ValueError(f"no profile {str(source)!r}; there are {', '.join(names())}, or the path of a TOML file")
    return parsed(contents(path), str(source))


def parsed(data: bytes, name: str) -> Profile:
    """The profile in the bytes of a TOML file; errors call it `name`."""
    try:
        values = tomllib.loads(data.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise ValueError(f"{name}: not sound TOML ({error}); mend it") from None
    takes = of(Machine)
    try:
        for key in values:
            if key not in takes and key not in LINES:
                raise ValueError(f"no {unknown('key', key, [*takes, *LINES])}")
        for key, wish in NEEDED.items():
            if key not in values or values[key] == []:
                raise ValueError(f"has no {key}; give {wish}")
        machine = Machine(**checked(takes, {key: value for key, value in values.items() if key in takes}, "it"))
        return Profile(name, machine, {key: _checked(key, values.get(key, []), fields) for key, fields in LINES.items()})
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def _checked(key: str, lines: Any, fields: tuple[str, ...]) -> tuple[str, ...]:
    """The lines of a key, or a ValueError for what is no line and for fields that it does not have."""
    if not isinstance(lines, list):
        raise ValueError(f"{key} is {lines!r}; it takes a list of lines")
    for line in lines:
        if not isinstance(line, str) or not re.fullmatch("[ -~]+", line):
            raise ValueError(f"{key} has {line!r}; it takes lines of ASCII, each a text of its own")
        for field in re.findall(r"\{(.*?)\}", line):
            if field not in fields:
                wish = unknown("field", field, fields) if fields else f"field {field!r}; it takes none"
                raise ValueError(f"{key} has no {wish}")
    return tuple(lines)


def _fit(size: tuple[float, float], profile: Profile) -> None:
    try:
        fit(size, profile.machine.bed, "turn the paper with orientation")
    except ValueError as error:
        raise ValueError(f"{profile.name}: {error}") from None


def _lines(sheet: Sheet, found: list[Pen], profile: Profile) -> Iterator[str]:
    """Every line of the file. The pen is up wherever it travels."""
    machine, (width, height) = profile.machine, sheet.size
    yield from profile.said("header")
    yield from profile.comment(f"crowquill {plain(str(sheet.recipe.get('style', 'drawing')))}")
    corner = "bottom left, y up" if machine.invert_y else "top left, y down"
    yield from profile.comment(f"sheet {number(width)} x {number(height)} mm from its {corner}")
    yield from profile.said("pen_up")
    for rank, pen in enumerate(found):
        yield from profile.comment(f"pen {pen.number} {pen.name}")
        if rank or machine.change_first:
            yield from profile.said("pen_change", pen=str(pen.number), name=pen.name)
        yield from _strokes(pen, profile)
    yield from profile.said("footer")


def _strokes(pen: Pen, profile: Profile) -> Iterator[str]:
    """The lines of one pen's strokes. Speeds are said at each turn: some machines have one for drawing and travel."""
    machine, step = profile.machine, 10.0**profile.machine.decimals
    down, up = profile.said("pen_down"), profile.said("pen_up")
    waits = profile.said("dot", seconds=number(machine.dwell), milliseconds=number(machine.dwell * 1000, 0)) if machine.dwell else []
    travel, draw = (f" F{number(feed)}" for feed in (machine.feed_up, machine.feed_down))
    for points in pen:
        first, *rest = (f"X{x / step:.{machine.decimals}f} Y{y / step:.{machine.decimals}f}" for x, y in points)
        yield f"G0 {first}{travel}"
        yield from down
        yield from (f"G1 {place}{'' if i else draw}" for i, place in enumerate(rest)) if rest else waits
        yield from up
