"""PDF at true size: one page, exact boxes, black as black ink alone, the same bytes each time."""

from __future__ import annotations

import hashlib
import io
import zlib
from decimal import Decimal
from typing import BinaryIO

import pikepdf
from reportlab.pdfgen.canvas import Canvas

from crowquill.formats._text import chunks, number, pdf_path
from crowquill.sheet import Ink, Sheet
from crowquill.units import POINT, UM


def write(sheet: Sheet, file: BinaryIO) -> None:
    """The sheet as a PDF page whose MediaBox and TrimBox are its size; art as chunks of plain path operators.

    Form XObjects and a font of dots were measured and left: the first take Poppler minutes, the second
    editors gigabytes.
    """
    width, height = (side / POINT for side in sheet.size)
    drawn = io.BytesIO()
    canvas = Canvas(drawn, pagesize=(width, height), invariant=1, pageCompression=0)
    canvas.setTitle(f"crowquill {sheet.recipe.get('style', 'drawing')}")
    canvas.setCreator("crowquill")
    canvas.setProducer("crowquill")
    canvas.setAuthor("")
    canvas.setSubject("")
    um = UM / POINT
    code = [f"{um:.12f} 0 0 {-um:.12f} 0 {height:.9f} cm"]
    for layer in sheet.layers:
        paint = "f" if layer.ink.pen is None else "S"
        code.append(f"q\n{_colour(layer.ink)}")
        code += [f"q\n{pdf_path(paths)}{paint}\nQ" for paths in chunks(layer.art)]
        code.append("Q")
    canvas._code[:] = code  # in place of the library's own opening, which names a font that is not embedded
    canvas._preamble = ""
    canvas.showPage()
    canvas.save()
    _finished(drawn, file, width, height)


def _colour(ink: Ink) -> str:
    """The operators that choose the ink; grey is the black plate alone, which RGB black is not."""
    fill, stroke = ("g", "G") if ink.cmyk[:3] == (0, 0, 0) else ("k", "K")
    shares = number(1 - ink.cmyk[3], 4) if fill == "g" else " ".join(number(share, 4) for share in ink.cmyk)
    if ink.pen is None:
        return f"{shares} {fill}"
    return f"{shares} {stroke} {number(ink.pen * 1000)} w 1 J 1 j"


def _finished(drawn: io.BytesIO, file: BinaryIO, width: float, height: float) -> None:
    """The library's file with exact boxes, a file ID, no unused font and no empty transition."""
    drawn.seek(0)
    with pikepdf.open(drawn) as pdf:
        page = pdf.pages[0]
        box = [Decimal(0), Decimal(0), round(Decimal(width), 9), round(Decimal(height), 9)]
        for name in ("/MediaBox", "/TrimBox"):
            page.obj[name] = pikepdf.Array(box)
        page.obj["/Resources"] = pikepdf.Dictionary(ProcSet=pikepdf.Array([pikepdf.Name.PDF]))
        del page.obj["/Trans"]
        for name in ("/Author", "/Subject", "/Keywords"):
            if name in pdf.docinfo:
                del pdf.docinfo[name]
        content = page.Contents.read_bytes()
        # 9 takes four times as long for 5 % less; the library's own level is one for all of a program
        page.obj["/Contents"] = pdf.make_stream(zlib.compress(content, 4), Filter=pikepdf.Name.FlateDecode)
        digest = hashlib.md5(content, usedforsecurity=False).digest()
        pdf.trailer["/ID"] = pikepdf.Array([digest, digest])  # one of its own for each drawing
        pdf.save(file, deterministic_id=True)
