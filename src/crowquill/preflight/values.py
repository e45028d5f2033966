"""What others' objects and errors say: numbers and text of what may be neither, and causes in a line."""

from __future__ import annotations

import re
from typing import Any

import pikepdf

READER = re.compile(r"(?:stream )?<[^<>]* at 0x[0-9A-Fa-f]+>[:,]?")  # what pikepdf calls a file in memory: another name each time


def real(value: Any, other: float) -> float:
    """The number that a value is, or the other one."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return other


def text(value: Any) -> str:
    """The text that a name or a string is, a name that is no UTF-8 as the file writes it; nothing of what is neither."""
    if not isinstance(value, (pikepdf.Name, pikepdf.String)):
        return ""
    try:
        return str(value)
    except UnicodeDecodeError:
        return value.unparse().decode("latin-1")


def told(error: object) -> str:
    """What an error or a warning says, in one line that is the same every time."""
    return " ".join(READER.sub(" ", str(error)).split())
