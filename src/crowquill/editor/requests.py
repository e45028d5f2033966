"""Requests of a page: what there are, and how they are read."""

from __future__ import annotations

import json
from typing import Any

WITH: dict[str, dict[str, Any]] = {  # what requests take beside do and n, and what is left out
    "apply": {"op": None, "params": {}, "seed": None, "group": None, "times": 1},
    "undo": {"count": 1},
    "redo": {"count": 1},
    "pause": {},
    "resume": {},
    "stop": {},
    "cancel": {},
    "show": {"what": None, "layer": None},
    "export": {"files": None, "options": {}, "overwrite": False},
    "check": {"file": None},
    "files": {},
    "open": {"file": None},
    "refresh": {},
}
KINDS: dict[str, tuple[type, ...]] = {
    "op": (str,), "params": (dict,), "seed": (int, type(None)), "group": (int, type(None)), "times": (int,), "count": (int,),
    "what": (str,), "layer": (int, type(None)), "files": (list,), "options": (dict,), "file": (str,), "overwrite": (bool,),
}  # fmt: skip

Request = dict[str, Any]


class Halted(Exception):
    """Raised in the midst of work that is not wanted any more."""


class Refused(ValueError):
    """A refusal of a request of a number."""

    def __init__(self, text: str, n: Any) -> None:
        super().__init__(text)
        self.n = n


def read(text: str | None) -> Request:
    """A request. Raises ValueError for what is none, with its number where it has one."""
    try:
        data = json.loads(text if text is not None else "")
    except (ValueError, RecursionError):
        raise ValueError("a request is a JSON object in a text frame") from None
    n = data.get("n") if isinstance(data, dict) else None
    if not isinstance(n, int) or isinstance(n, bool) or not 0 <= n < 2**53:
        raise ValueError("a request is a JSON object with do, and a whole number n")
    if not isinstance(data.get("do"), str) or data["do"] not in WITH:
        raise Refused(f"no request {str(data.get('do'))[:40]!r}; there are {', '.join(WITH)}", n)
    takes = WITH[data["do"]]
    for key in data:
        if key not in ("do", "n", *takes):
            raise Refused(f"{data['do']} has no {key[:40]!r}; it takes {', '.join(takes) or 'nothing more'}", n)
    request = {**takes, **data}
    for key in takes:
        value = request[key]
        if not isinstance(value, KINDS[key]) or (isinstance(value, bool) and KINDS[key] != (bool,)):
            raise Refused(f"{key} is {str(value)[:40]!r}; it takes another kind of value", n)
    return request


def told(error: Exception) -> str:
    """What an error says, in a line; what is not foreseen is a fault of ours."""
    if isinstance(error, MemoryError):
        return "not enough memory; draw fewer marks"
    if isinstance(error, OSError) and error.errno:
        return f"{error.filename or 'a file'}: {(error.strerror or 'failed').lower()}"
    text = " ".join(str(error).split())
    expected = isinstance(error, (ValueError, OSError, Halted))
    return text if expected else f"a fault in the program ({type(error).__name__}: {text[:200]}); nothing was changed"
