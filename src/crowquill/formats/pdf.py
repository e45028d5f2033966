"""PDF at true size: one page, exact boxes, black as black ink alone, the same bytes each time."""

from __future__ import annotations

import hashlib
import io
import zlib
from collections.abc import Sequence
from decimal import Decimal
from typing import Annotated, BinaryIO

import pikepdf
from reportlab.pdfgen.canvas import Canvas

from crowquill.formats._dotfont import Font, resource, takes, typeset
from crowquill.formats._kept import keep
from crowquill.formats._kept import recipe as recipe  # a format's own reader
from crowquill.formats._text import chunks, number, pdf_path
from crowquill.knobs import Flag
from crowquill.sheet import Ink, Sheet
from crowquill.units import POINT, UM

KEEPS_FILES = True  # attached to a sheet


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    compact: Annotated[bool, Flag("dots as characters of a font: smaller, faster to show, not for editing")] = False,
) -> None:
    """The sheet as a PDF page whose MediaBox and TrimBox are its size; art as chunks of plain path operators.

    compact  filled marks as characters of embedded fonts: a plate takes a tenth of the bytes and Poppler two thirds
             of the time; editors take gigabytes, and on screens dark tones look lighter than they print

    Form XObjects were measured and left: they take Poppler minutes.
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
    fonts: list[Font] = []
    for layer in sheet.layers:
        if compact and layer.ink.pen is None and takes(layer.art):
            text, new = typeset(layer.art)
            code.append(f"q\n{_colour(layer.ink)}\n{text}\nQ")
            fonts += new
            continue
        paint = "f" if layer.ink.pen is None else "S"
        code.append(f"q\n{_colour(layer.ink)}")
        code += [f"q\n{pdf_path(paths)}{paint}\nQ" for paths in chunks(layer.art)]
        code.append("Q")
    canvas._code[:] = code  # in place of the library's own opening, which names a font that is not embedded
    canvas._preamble = ""
    canvas.showPage()
    canvas.save()
    _finished(drawn, file, sheet, fonts)


def _colour(ink: Ink) -> str:
    """The operators that choose the ink; grey is the black plate alone, which RGB black is not."""
    fill, stroke = ("g", "G") if ink.cmyk[:3] == (0, 0, 0) else ("k", "K")
    shares = number(1 - ink.cmyk[3], 4) if fill == "g" else " ".join(number(share, 4) for share in ink.cmyk)
    if ink.pen is None:
        return f"{shares} {fill}"
    return f"{shares} {stroke} {number(ink.pen * 1000)} w 1 J 1 j"


def _finished(drawn: io.BytesIO, file: BinaryIO, sheet: Sheet, fonts: Sequence[Font]) -> None:
    """The library's file with exact boxes, the recipe, a file ID, no unused font and no empty transition."""
    width, height = (side / POINT for side in sheet.size)
    drawn.seek(0)
    with pikepdf.open(drawn) as pdf:
        page = pdf.pages[0]
        box = [Decimal(0), Decimal(0), round(Decimal(width), 9), round(Decimal(height), 9)]
        for name in ("/MediaBox", "/TrimBox"):
            page.obj[name] = pikepdf.Array(box)
        page.obj["/Resources"] = pikepdf.Dictionary(ProcSet=pikepdf.Array([pikepdf.Name.PDF]))
        if fonts:
            page.obj.Resources.ProcSet.append(pikepdf.Name.Text)
            page.obj.Resources.Font = pikepdf.Dictionary({f"/{font.key}": resource(pdf, font) for font in fonts})
        del page.obj["/Trans"]
        for name in ("/Author", "/Subject", "/Keywords"):
            if name in pdf.docinfo:
                del pdf.docinfo[name]
        content = page.Contents.read_bytes()
        # 9 takes four times as long for 5 % less; the library's own level is one for all of a program
        page.obj["/Contents"] = pdf.make_stream(zlib.compress(content, 4), Filter=pikepdf.Name.FlateDecode)
        keep(pdf, sheet, str(pdf.docinfo["/Title"]))
        digest = hashlib.md5(content, usedforsecurity=False).digest()
        pdf.trailer["/ID"] = pikepdf.Array([digest, digest])  # one of its own for each drawing
        pdf.save(file, deterministic_id=True)
