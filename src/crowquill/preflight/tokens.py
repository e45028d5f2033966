"""The words of page content that are no plain numbers and operators: names, strings, and resources by their names."""

from __future__ import annotations

import re
from typing import Any

import pikepdf

TOKEN = re.compile(
    rb"%[^\r\n]*|(?P<number>[-+.\d][-+.\d]*)|(?P<name>/[^\x00\t\n\f\r ()<>\[\]{}/%]*)|(?P<hex><[0-9A-Fa-f\s]*>)|(?P<open>\()"
    rb"|(?P<mark><<|>>|[\[\]{}<>)])|(?P<word>[^\x00\t\n\f\r ()<>\[\]{}/%]+)"
)
ESCAPE = re.compile(rb"\\([0-7]{1,3}|\r\n?|\n|.)", re.DOTALL)
BRACKET = re.compile(rb"[()\\]")
LETTERS = {b"n": b"\n", b"r": b"\r", b"t": b"\t", b"b": b"\b", b"f": b"\f"}


class Name(str):
    """A name among operands, with its slash."""

    __slots__ = ()


def value_of(found: re.Match[bytes], code: bytes) -> tuple[Any, int]:
    """The number, name or string that a token begins, and where it ends."""
    text = found[0]
    if found.lastgroup == "number":
        try:
            return float(text), found.end()
        except ValueError:  # signs in odd places
            digits = re.search(rb"\d*\.?\d*", text.lstrip(b"+-"))
            return (-1 if text.startswith(b"-") else 1) * float(digits[0] or 0 if digits and digits[0] != b"." else 0), found.end()
    if found.lastgroup == "name":
        plain = re.sub(rb"#([0-9A-Fa-f]{2})", lambda hexed: bytes([int(hexed[1], 16)]), text)
        return Name(plain.decode("utf-8", "replace")), found.end()
    if found.lastgroup == "hex":
        digits_ = re.sub(rb"\s", b"", text[1:-1])
        return bytes.fromhex((digits_ + b"0" * (len(digits_) % 2)).decode("ascii")), found.end()
    at, depth = found.end(), 1
    while depth:
        bracket = BRACKET.search(code, at)
        if not bracket:
            return code[found.end() :], len(code)
        at = bracket.end() + (bracket[0] == b"\\")
        depth += {b"(": 1, b")": -1}.get(bracket[0], 0)
    return ESCAPE.sub(_escaped, code[found.end() : at - 1]), at


def _escaped(found: re.Match[bytes]) -> bytes:
    letter = found[1]
    if letter[:1].isdigit() and letter[:1] < b"8":
        return bytes([int(letter, 8) & 255])
    return b"" if letter[:1] in b"\r\n" else LETTERS.get(letter, letter)


def of(resources: Any, sort: str, name: Any) -> Any:
    """A resource by its name; LookupError says which there is not."""
    found = resources.get(sort)
    if not isinstance(name, Name) or not isinstance(found, pikepdf.Dictionary) or name not in found:
        raise LookupError(f"there is no {sort[1:]} {name}")
    return found[name]
