"""PNG: a sheet as pixels of a true size, in grey, in colour, or in black and white alone; a bitmap as a stencil for SVG."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import replace
from typing import Annotated, BinaryIO

import numpy as np

from crowquill.formats._bitmap import BILEVEL, BLACK_FROM, DPI, GREY_DOTS, KEYWORD, Bytes, bands, page, said
from crowquill.formats._bitmap import foresee as foresee  # what every format may have
from crowquill.formats._bitmap import recipe as recipe
from crowquill.greydots import RIM
from crowquill.knobs import Flag, Range
from crowquill.sheet import Bitmap, Sheet
from crowquill.units import INCH


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    dpi: Annotated[float | None, Range(20, 4800, "", DPI)] = None,
    bilevel: Annotated[bool, Flag(BILEVEL)] = False,
    grey_dots: Annotated[bool, Flag(GREY_DOTS)] = True,
    black_from: Annotated[float, Range(0.01, 0.99, "", BLACK_FROM)] = RIM,
) -> None:
    """The sheet as a PNG that says how many pixels it has to the metre, a whole number; grey unless an ink has colour.

    Written band by band. Raises ValueError for more pixels than `_bitmap` takes, and for
    inks other than black in black and white.
    """
    of = replace(page(sheet, dpi, bilevel), grey_dots=grey_dots, black_from=black_from)
    file.write(b"\x89PNG\r\n\x1a\n")
    kind = 2 if of.channels == 3 else 0
    _chunk(file, b"IHDR", struct.pack(">IIBBBBB", of.width, of.height, 8 if of.channels else 1, kind, 0, 0, 0))
    metre = round(of.dpi / INCH * 1000)
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


def stencil(art: Bitmap, rgb: tuple[int, int, int]) -> bytes:
    """A bitmap as a PNG of its own pixels: one colour where there is ink, and nothing where there is none."""
    file = io.BytesIO()
    file.write(b"\x89PNG\r\n\x1a\n")
    _chunk(file, b"IHDR", struct.pack(">IIBBBBB", art.width, len(art.bits), 1, 3, 0, 0, 0))
    _chunk(file, b"PLTE", bytes((255, 255, 255, *rgb)))
    _chunk(file, b"tRNS", b"\0")
    _chunk(file, b"IDAT", zlib.compress(_plain(art.bits).data, 6))
    _chunk(file, b"IEND", b"")
    return file.getvalue()


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
