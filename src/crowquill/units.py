"""Lengths and papers as people write them, in millimetres.

Everything behind this module is in millimetres; this is the only door. One constant a unit.
"""

import re

MM = 1.0
CM = 10.0  # millimetres to the centimetre
UM = 0.001  # millimetres to the micrometre
INCH = 25.4  # millimetres to the inch, exact since 1959
POINT = INCH / 72  # the PostScript point, which PDF counts in
UNITS = {"mm": MM, "cm": CM, "um": UM, "in": INCH, "pt": POINT}
PAPERS = {"a4": (210.0, 297.0), "a5": (148.0, 210.0), "letter": (8.5 * INCH, 11 * INCH)}
LARGEST = 100_000.0  # mm: a length over 100 m is a slip of the keyboard

_NUMBER = r"(\d+(?:\.\d*)?|\.\d+)"


def length(text: str) -> float:
    """Millimetres of a length with its unit, such as "0.3mm", "12pt" or "1in".

    The unit is one of mm, cm, um, in, pt and cannot be left out: a bare number once
    meant pixels to one program and points to the next. Raises ValueError otherwise.

    >>> length("0.3mm"), length("1 in")
    (0.3, 25.4)
    """
    found = re.fullmatch(rf"\s*([+-]?){_NUMBER}\s*(mm|cm|um|in|pt)\s*", text, re.IGNORECASE | re.ASCII)
    if not found:
        bare = re.fullmatch(rf"\s*[+-]?{_NUMBER}\s*", text)
        wish = f"write {text.strip()}mm" if bare else f"write a number and one of {', '.join(UNITS)}, such as 0.3mm"
        raise ValueError(f"length {text!r} has no unit; {wish}" if bare else f"length {text!r} is not understood; {wish}")
    sign, number, unit = found.groups()
    value = float(sign + number) * UNITS[unit.lower()]
    if abs(value) > LARGEST:
        raise ValueError(f"length {text!r} is over {LARGEST / 1000:g} m; give at most {LARGEST:g}mm")
    return value


def duration(text: str) -> float:
    """Seconds of a time with its unit, such as "90min" or "1.5h". Raises ValueError otherwise.

    >>> duration("90min"), duration("2h")
    (5400.0, 7200.0)
    """
    found = re.fullmatch(rf"\s*{_NUMBER}\s*(s|min|h)\s*", text, re.IGNORECASE | re.ASCII)
    if not found or float(found[1]) <= 0:
        raise ValueError(f"time {text!r} is not understood; write a number over 0 and one of s, min, h, such as 90min")
    return float(found[1]) * {"s": 1, "min": 60, "h": 3600}[found[2].lower()]


def paper(text: str) -> tuple[float, float]:
    """Width and height in mm of a paper by name (a4, a5, letter, upright) or as "WxH" with a unit.

    One unit may serve both numbers. Raises ValueError for an unknown name or a size that
    is not positive.

    >>> paper("a5"), paper("100x50mm"), paper("8.5x11in")
    ((148.0, 210.0), (100.0, 50.0), (215.9, 279.4))
    """
    name = text.strip().lower()
    if name in PAPERS:
        return PAPERS[name]
    found = re.fullmatch(rf"{_NUMBER}\s*(mm|cm|um|in|pt)?\s*[x×]\s*{_NUMBER}\s*(mm|cm|um|in|pt)", name)
    if not found:
        raise ValueError(f"no paper {text!r}; there are {', '.join(PAPERS)}, or a size such as 120x80mm")
    width, first, height, last = found.groups()
    size = round(length(width + (first or last)), 6), round(length(height + last), 6)
    if min(size) <= 0:
        raise ValueError(f"paper {text!r} has no area; both sides must be over 0")
    return size
