"""Plate files read: TOML or plain data as a Plate, or one line that says where it is wrong, and what would be right."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from crowquill import recipe
from crowquill.knobs import unknown
from crowquill.plate.platefile import SCHEMA, Bars, Colour, Drawn, Grid, Letters, Page, Panel, Plate, Text, short
from crowquill.vector import regular

LARGEST = 2**18  # bytes; a panel takes some 300
TABLES = {"page": Page, "grid": Grid, "letters": Letters, "text": Text, "bars": Bars, "panel": Panel, "layer": Drawn, "inks": Colour}
TAKES = {  # what is right, by pydantic's name of what is wrong
    "string_type": "a text",
    "int_type": "a whole number",
    "float_type": "a number",
    "finite_number": "a number",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "literal_error": "one of {expected}",
    "greater_than_equal": "{ge} or more",
    "less_than_equal": "{le} or less",
    "less_than": "less than {lt}",
    "too_short": "{min_length} at least",
    "too_long": "{max_length} at most",
    "string_too_long": "{max_length} letters at most",
    "string_pattern_mismatch": "64 hexadecimal digits",
}


def read(data: bytes, name: str) -> tuple[Plate, dict[str, Any]]:
    """The plate in a TOML file, and its plain data. ValueError in one line that begins with `name`."""
    if len(data) > LARGEST:
        raise ValueError(f"{name}: {len(data)} bytes are no plate file; it has at most {LARGEST}")
    try:
        values = tomllib.loads(data.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{name}: not sound TOML ({str(error)[:100]}); mend it, or begin with: crowquill plate --init") from None
    return parsed(values, name)


def contents(path: Path) -> bytes:
    """The bytes of a plate file; what is too large to be one is not read."""
    if regular(path) > LARGEST:
        raise ValueError(f"{path}: {path.stat().st_size} bytes are no plate file; it has at most {LARGEST}")
    return path.read_bytes()


def parsed(values: Any, name: str) -> tuple[Plate, dict[str, Any]]:
    """The plate in plain data, and the data as JSON can hold them."""
    if not isinstance(values, Mapping):
        raise ValueError(f"{name}: is {short(values)}; a plate is a table with panels")
    try:
        data = json.loads(json.dumps({key: value for key, value in values.items() if key not in recipe.RESULTS}, allow_nan=False))
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(f"{name}: holds what is no text, number, list or table ({str(error)[:80]}); mend it") from None
    newer = data.get("schema", SCHEMA)
    if isinstance(newer, int) and newer > SCHEMA:
        raise ValueError(f"{name}: made by a newer crowquill (plate schema {newer}); update this one")
    try:
        return Plate.model_validate(data), data
    except ValidationError as error:
        raise ValueError(f"{name}: {_said(error)}") from None


def _said(error: ValidationError) -> str:
    """The first of a table's errors as a line: where, what, and what would be right."""
    every = error.errors(include_url=False)
    first = next((one for one in every if one["type"] == "extra_forbidden"), every[0])  # a slip in a key leaves another missing
    *above, last = first["loc"] or ("",)
    kind, value = first["type"], first.get("input")
    if kind == "extra_forbidden":
        return f"{_where(above)}no {unknown('key', str(last), _keys(above))}"
    if kind == "missing":
        wish = f"number {last + 1}" if isinstance(last, int) else last
        return f"{_where(above)}has no {wish}; give one" if last != "panel" else "has no panel; give at least one [[panel]]"
    if kind == "value_error":
        said = str(first["ctx"]["error"])
        return f"{_where([*above, last])}{said if '; ' in said else f'{said}; mend it'}"
    if kind == "too_long" and last in ("panel", "layer"):
        return f"{_where(above)}has {len(value)} {last}s; it takes {first['ctx']['max_length']} at most"
    takes = TAKES.get(kind, "what its documentation says").format(**first.get("ctx", {}))
    what = f"number {last + 1}" if isinstance(last, int) else str(last)
    return f"{_where(above)}{what} is {short(value)}; it takes {takes}"


def _where(loc: Any) -> str:
    """A place in a plate file, as a person counts."""
    words: list[str] = []
    for part in loc:
        if isinstance(part, int) and words:
            words[-1] += f" {part + 1}" if words[-1] in ("panel", "layer") else ""
        elif part:
            words.append(str(part))
    return "".join(f"{word}: " for word in words)


def _keys(loc: Any) -> list[str]:
    """The keys that a place in a plate file takes."""
    table: Any = Plate
    for part in loc:
        table = TABLES.get(part, table)
    return [field.alias or name for name, field in table.model_fields.items()]
