"""Inks by their names: one, as --ink takes it, or several, as --inks does; and how each looks by itself."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from crowquill.paths import Array
from crowquill.picture import linear
from crowquill.sheet import SPOT, Ink, in_process

PROCESS = {"black": (0.0, 0.0, 0.0, 1.0), "cyan": (1.0, 0.0, 0.0, 0.0), "magenta": (0.0, 1.0, 0.0, 0.0), "yellow": (0.0, 0.0, 1.0, 0.0)}
LETTERS = {"c": "cyan", "m": "magenta", "y": "yellow", "k": "black"}
MOST = 8
ALIKE = 2  # of 255: inks whose colours differ by no more are of one colour
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of red, green and blue, in linear light
COLOUR = "NAME=#rrggbb or NAME=c,m,y,k of 0 to 1"


def one(text: str) -> Ink:
    """The ink of a name, a mix or a spot ink. Raises ValueError for what is none.

    >>> one("spot:PANTONE 124 C=0,0.3,0.9,0").cmyk
    (0.0, 0.3, 0.9, 0.0)
    """
    name = LETTERS.get(text.strip().lower(), text.strip().lower())
    if name in PROCESS:
        return Ink(name, PROCESS[name])
    found = re.fullmatch(r"\s*(spot:)?([^=:]+)=\s*(#[0-9a-fA-F]{6}|[^=#]+?)\s*", text)
    try:
        shares = _shares(found[3]) if found else ()
    except ValueError:
        shares = ()
    if not found or len(shares) != 4 or not all(0 <= share <= 1 for share in shares):
        raise ValueError(f"ink {text!r} is not understood; there are {', '.join(PROCESS)}, {COLOUR}, and spot: before such a name")
    name, (cyan, magenta, yellow, black) = found[2].strip(), shares
    if not SPOT.fullmatch(name):
        raise ValueError(f"name {name!r} of an ink; give plain letters, digits, spaces and -_.+&()")
    if not any(shares) and not found[1]:
        raise ValueError(f"ink {text!r} has no colour and prints nothing; give one that is darker than paper")
    return Ink(name, (cyan, magenta, yellow, black), spot=bool(found[1]))


def several(text: str) -> tuple[Ink, ...]:
    """The inks of a list such as "C,M,Y,K" or "ochre=#c8922b, black", the lightest first, as they are printed; at most MOST.

    Process inks go by name or letter. Every other has a colour, is a spot ink, and so has a plate to itself. Raises
    ValueError for a list without inks or with too many, for one that is white, and for two of one name or colour.
    """
    found: list[str] = []
    for part in text.split(","):  # shares of a mix are parted by commas too
        if found and re.fullmatch(r"[^=]+=(\s*[\d.]+\s*,){0,2}\s*[\d.]+\s*", found[-1]) and re.fullmatch(r"\s*[\d.]+\s*", part):
            found[-1] += f",{part}"
        elif part.strip():
            found.append(part)
    if not found:
        raise ValueError(f"inks {text!r} names none; give some such as C,M,Y,K, or ochre=#c8922b,black")
    if len(found) > MOST:
        raise ValueError(f"inks are {len(found)}, over the limit of {MOST}; name fewer")
    inks = [ink if ink.cmyk == PROCESS.get(ink.name) else replace(ink, spot=True) for ink in map(one, found)]
    for ink in inks:
        if max(255 - code for code in ink.rgb) <= ALIKE:
            raise ValueError(f"ink {ink.name!r} is as white as paper and prints nothing; leave it out")
    for ink, other in combinations(inks, 2):
        if ink.name.lower() == other.name.lower():
            raise ValueError(f"ink {ink.name!r} is named twice; leave one out")
        if max(abs(a - b) for a, b in zip(ink.rgb, other.rgb, strict=True)) <= ALIKE:
            raise ValueError(f"inks {ink.name!r} and {other.name!r} are of one colour, and nothing tells them apart; leave one out")
    return tuple(sorted(inks, key=lambda ink: -float(looks([ink])[0] @ LUMINANCE)))


def looks(inks: Sequence[Ink]) -> Array:
    """The linear light (n, 3), red, green and blue of 0 to 1, that each ink leaves where it covers the paper."""
    return np.asarray(linear(np.array([ink.rgb for ink in inks], np.float64).reshape(-1, 3) / 255))


def _shares(text: str) -> tuple[float, ...]:
    """Shares of cyan, magenta, yellow and black of a colour, to the four digits that files keep."""
    if text.startswith("#"):
        codes = [[int(text[k : k + 2], 16) for k in (1, 3, 5)]]
        return tuple(round(share, 4) for share in in_process(codes)[0].tolist())
    return tuple(float(part) for part in text.split(","))
