"""PDF at true size: one page, exact boxes, black as black ink alone, spot inks by name, the same bytes each time."""

from __future__ import annotations

import io
from decimal import Decimal
from typing import Annotated, BinaryIO

import pikepdf
from reportlab.pdfgen.canvas import Canvas

from crowquill.formats._bitmap import GREY_DOTS
from crowquill.formats._content import Content
from crowquill.formats._kept import keep
from crowquill.formats._kept import recipe as recipe  # a format's own reader
from crowquill.formats._page import Page
from crowquill.formats._pdfx import Standard, dated
from crowquill.forme import Forme, locked
from crowquill.knobs import Choice, Flag, Range, Text
from crowquill.sheet import Sheet
from crowquill.units import POINT

KEEPS_FILES = True  # attached to a sheet


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    compact: Annotated[bool, Flag("dots as characters of a font: smaller, faster to show, not for editing")] = False,
    bleed: Annotated[float, Range(0, 100, "mm", "room around the trimmed page for what is drawn over its edge")] = 0.0,
    marks: Annotated[bool, Flag("crop and registration marks around the page, and the names of its inks")] = False,
    colour_bar: Annotated[bool, Flag("patches of each ink below the page, full and in three tints")] = False,
    pdfx: Annotated[str | None, Choice(("x1a", "x3", "x4"), "as PDF/X, which printers ask for")] = None,
    pdfa: Annotated[bool, Flag("as PDF/A-1b, which archives ask for")] = False,
    output_condition: Annotated[str | None, Text("what it is printed by, such as FOGRA39, for PDF/X")] = None,
    icc: Annotated[str | None, Text("the press's profile, which PDF/X and PDF/A keep inside", file=True)] = None,
    grey_dots: Annotated[bool, Flag(GREY_DOTS)] = False,
) -> None:
    """The sheet as a PDF page whose TrimBox is its size, and MediaBox too where nothing is around it.

    compact           filled marks as characters of embedded fonts: a plate takes a tenth of the bytes and Poppler two
                      thirds of the time; editors take gigabytes, and on screens dark tones look lighter than they print
    pdfx              x1a is PDF/X-1a:2001, x3 is PDF/X-3:2002, x4 is PDF/X-4; not together with pdfa
    output_condition  a name of the ICC's registry, FOGRA39 if none is given; any other takes its profile in icc
    icc               x4 and pdfa embed a profile; a drawing in black alone gets one made here, where none is given
    grey_dots         dots that have scans, and all below them, as one image of 600 dpi, in black and white ink alone

    Form XObjects were measured and left: they take Poppler minutes. Raises ValueError for letters that a font lacks,
    for what a standard has no room for, and what forme.inks raises.
    """
    standard = Standard.of(pdfx, pdfa, output_condition, icc)
    compose(locked(sheet, bleed=bleed, marks=marks, colour_bar=colour_bar), file, standard, compact=compact, grey_dots=grey_dots)


def foresee(
    _size: tuple[float, float], _dots: int, *, pdfx: str | None, pdfa: bool, output_condition: str | None, icc: str | None, **_: object
) -> None:
    """Raises the ValueError of standards that do not go together, and of a profile that cannot be used."""
    Standard.of(pdfx, pdfa, output_condition, icc)


def compose(forme: Forme, file: BinaryIO, standard: Standard | None = None, *, compact: bool = False, grey_dots: bool = False) -> None:
    """A sheet and the furniture around it as a PDF page; see `write`."""
    standard, date = standard and standard.settled(forme), dated()
    width, height = (side / POINT for side in forme.size)
    drawn = io.BytesIO()
    canvas = Canvas(drawn, pagesize=(width, height), invariant=1, pageCompression=0)
    canvas.setTitle(": ".join(part for part in (f"crowquill {forme.sheet.recipe.get('style', 'drawing')}", forme.plate) if part))
    canvas.setCreator("crowquill")
    canvas.setProducer("crowquill")
    canvas.setAuthor("")
    canvas.setSubject("")
    canvas._code.clear()  # the library's own opening names a font that is not embedded
    canvas._preamble = ""
    canvas.showPage()
    canvas.save()
    with Content(drawn.getvalue(), file) as content:
        _finished(file, forme, Page.of(forme, content, compact, grey_dots), standard, date)


def _finished(file: BinaryIO, forme: Forme, page: Page, standard: Standard | None, date: int) -> None:
    """The library's file with the page's content, exact boxes, resources, the recipe, a file ID, and no empty transition."""
    with pikepdf.open(page.code.whole()) as pdf:
        made = pdf.pages[0].obj
        for name, box in _boxes(forme).items():
            made[f"/{name}"] = pikepdf.Array(box)
        made["/Resources"] = page.resources(pdf)
        del made["/Trans"]
        for name in ("/Author", "/Subject", "/Keywords"):
            if name in pdf.docinfo:
                del pdf.docinfo[name]
        digest = page.code.digest
        keep(pdf, forme.sheet, str(pdf.docinfo["/Title"]), standard.said(digest, date) if standard else "")
        if standard:
            standard.put(pdf, date)
        pdf.trailer["/ID"] = pikepdf.Array([digest, digest])  # one of its own for each drawing
        pdf.save(
            file,
            deterministic_id=True,
            force_version=standard.kind.version if standard else "",
            fix_metadata_version=False,  # the packet stays as it is written: PDF/A's checkers are particular
            object_stream_mode=pikepdf.ObjectStreamMode.disable,  # newer than PDF 1.3
        )


def _boxes(forme: Forme) -> dict[str, list[Decimal]]:
    """The page's boxes in points. No CropBox: who opens the file sees the marks; no BleedBox where it would be the page."""

    def box(out: float) -> list[Decimal]:
        low = forme.slug - out
        edges = (low, low, *(side - low for side in forme.size))
        return [round(Decimal(edge / POINT), 9) for edge in edges]

    boxes = {"MediaBox": box(forme.slug), "TrimBox": box(0.0)}
    return boxes | ({"BleedBox": box(forme.bleed)} if forme.slug else {})
