"""TIFF: a sheet as pixels of a true size; black and white alone in CCITT Group 4, as platesetters and scanners have it."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import replace
from fractions import Fraction
from typing import Annotated, Any, BinaryIO

import numpy as np

from crowquill.formats._bitmap import BILEVEL, BLACK_FROM, DESCRIPTION, DPI, GREY_DOTS, Bytes, bands, page, said
from crowquill.formats._bitmap import foresee as foresee  # what every format may have
from crowquill.formats._bitmap import recipe as recipe
from crowquill.greydots import RIM
from crowquill.knobs import Flag, Range
from crowquill.sheet import Sheet

GROUP_4, DEFLATE = 4, 8
ASCII, SHORT, LONG, RATIONAL = 2, 3, 4, 5  # types of a field, and their letters of struct
LETTERS = {ASCII: "B", SHORT: "H", LONG: "I", RATIONAL: "II"}


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    dpi: Annotated[float | None, Range(20, 4800, "", DPI)] = None,
    bilevel: Annotated[bool, Flag(BILEVEL)] = False,
    grey_dots: Annotated[bool, Flag(GREY_DOTS)] = True,
    black_from: Annotated[float, Range(0.01, 0.99, "", BLACK_FROM)] = RIM,
) -> None:
    """The sheet as a TIFF of one page that says how many pixels it has to the inch; grey unless an ink has colour.

    Grey and colour are deflated, as differences from pixel to pixel. Strips are packed one by one and held until all are known.
    Raises ValueError for more pixels than `_bitmap` takes, and for inks other than black in black and white.
    """
    of = replace(page(sheet, dpi, bilevel), grey_dots=grey_dots, black_from=black_from)
    pack = _deflated if of.channels else _group_4
    strips = [pack(rows, max(1, of.channels), of.width) for rows in bands(sheet, of)]
    sizes = [len(strip) for strip in strips]
    inch = Fraction(of.dpi).limit_denominator(10_000)
    channels = max(1, of.channels)
    fields: list[tuple[int, int, list[int]]] = [
        (256, LONG, [of.width]),
        (257, LONG, [of.height]),
        (258, SHORT, [8 if of.channels else 1] * channels),
        (259, SHORT, [DEFLATE if of.channels else GROUP_4]),
        (262, SHORT, [{0: 0, 1: 1, 3: 2}[of.channels]]),  # 0 is white, 0 is black, red, green and blue
        (273, LONG, sizes),  # where strips begin: told once the length of the fields is known
        (277, SHORT, [channels]),
        (278, LONG, [min(of.rows, of.height)]),
        (279, LONG, sizes),
        (282, RATIONAL, [inch.numerator, inch.denominator]),
        (283, RATIONAL, [inch.numerator, inch.denominator]),
        (284, SHORT, [1]),  # channels side by side
        (296, SHORT, [2]),  # inches
        (317, SHORT, [2]) if of.channels else (293, SHORT, [0]),  # each pixel less the one before; plain Group 4
    ]
    if text := said(sheet):
        fields.append((DESCRIPTION, ASCII, [*text, 0]))
    head = len(_head(fields))
    fields[5] = (273, LONG, [head + sum(sizes[:k]) for k in range(len(sizes))])
    file.write(_head(fields))
    for strip in strips:
        file.write(strip)


def _head(fields: list[tuple[int, int, list[int]]]) -> bytes:
    """Everything before the strips: the fields in order of their tags, values over four bytes behind them."""
    table, behind = b"", b""
    at = 8 + 2 + 12 * len(fields) + 4
    for tag, kind, values in sorted(fields):
        data = struct.pack(f"<{LETTERS[kind][0] * len(values)}", *values)
        table += struct.pack("<HHI", tag, kind, len(values) // len(LETTERS[kind]))
        table += data.ljust(4, b"\0") if len(data) <= 4 else struct.pack("<I", at + len(behind))
        behind += data if len(data) > 4 else b""
        behind += b"\0" * (len(behind) % 2)
    return struct.pack("<2sHIH", b"II", 42, 8, len(fields)) + table + b"\0\0\0\0" + behind


def _deflated(rows: Bytes, channels: int, width: int) -> bytes:
    """Rows as differences from the pixel to the left, packed."""
    less = rows.reshape(len(rows), width, channels).copy()
    less[:, 1:] -= less[:, :-1].copy()
    return zlib.compress(np.ascontiguousarray(less).data, 6)


def _group_4(rows: Bytes, _channels: int, width: int) -> bytes:
    """Rows of bits as Group 4, which begins anew with each strip: taken out of a file that libtiff makes of these rows."""
    from PIL import Image

    made = io.BytesIO()
    image = Image.frombytes("1", (width, len(rows)), rows.tobytes())
    image.save(made, "TIFF", compression="group4", strip_size=1 << 31)
    with Image.open(made, formats=("TIFF",)) as opened:
        read: Any = opened
        (at,), (size,) = read.tag_v2[273], read.tag_v2[279]
    return made.getvalue()[at : at + size]
