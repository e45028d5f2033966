"""PNG: a sheet as pixels of a true size, in grey, in colour, or in black and white alone."""

from __future__ import annotations

import struct
import zlib
from typing import Annotated, BinaryIO

import numpy as np

from crowquill.formats._bitmap import BILEVEL, DPI, KEYWORD, Bytes, bands, page, said
from crowquill.formats._bitmap import foresee as foresee  # what every format may have
from crowquill.formats._bitmap import recipe as recipe
from crowquill.knobs import Flag, Range
from crowquill.sheet import Sheet
from crowquill.units import INCH


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    dpi: Annotated[float, Range(20, 4800, "", DPI)] = 600,
    bilevel: Annotated[bool, Flag(BILEVEL)] = False,
) -> None:
    """The sheet as a PNG that says how many pixels it has to the metre, a whole number; grey unless an ink has colour.

    Written band by band. Raises ValueError for more pixels than `_bitmap` takes, and for
    inks other than black in black and white.
    """
    of = page(sheet, dpi, bilevel)
    file.write(b"\x89PNG\r\n\x1a\n")
    kind = 2 if of.channels == 3 else 0
    _chunk(file, b"IHDR", struct.pack(">IIBBBBB", of.width, of.height, 8 if of.channels else 1, kind, 0, 0, 0))
    metre = round(dpi / INCH * 1000)
    _chunk(file, b"pHYs", struct.pack(">IIB", metre, metre, 1))
    if text := said(sheet):
        _chunk(file, b"iTXt", KEYWORD.encode() + b"\0\0\0\0\0" + text)
    packer = zlib.compressobj(6)
    above = np.zeros((1, of.width * of.channels), np.uint8)
    for rows in bands(sheet, of):
        filtered = _filtered(rows, above) if of.channels else _plain(~rows)
        above = rows[-1:]
        _chunk(file, b"IDAT", packer.compress(filtered.data))
    _chunk(file, b"IDAT", packer.flush())
    _chunk(file, b"IEND", b"")


def _filtered(rows: Bytes, above: Bytes) -> Bytes:
    """Rows as differences from the row above each, behind the number of that filter."""
    up = np.full((len(rows), rows.shape[1] + 1), 2, np.uint8)
    np.subtract(rows, np.concatenate([above, rows[:-1]]), out=up[:, 1:])
    return up


def _plain(rows: Bytes) -> Bytes:
    """Rows as they are, behind the number that says so: bits have no differences to speak of."""
    plain = np.zeros((len(rows), rows.shape[1] + 1), np.uint8)
    plain[:, 1:] = rows
    return plain


def _chunk(file: BinaryIO, kind: bytes, data: bytes) -> None:
    """Writes a chunk with its length and checksum; one of image data that is empty is left out."""
    if data or kind != b"IDAT":
        file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
