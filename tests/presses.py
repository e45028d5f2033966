"""Print files for tests of the preflight: sound ones of each kind, and pages of any content in millimetres."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pikepdf
import reportlab
from pikepdf import Array, Dictionary, Name
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas

from crowquill import preflight

MM = 72 / 25.4  # points
SLUG, BLEED = 10.0, 3.0  # mm
TRIM = (148.0, 210.0)
INTENT = {"x1a": "/GTS_PDFX", "x3": "/GTS_PDFX", "x4": "/GTS_PDFX", "a": "/GTS_PDFA1"}
VERSION = {"x1a": "1.3", "x3": "1.3", "x4": "1.6", "a": "1.4"}
XMP = """<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
<rdf:Description rdf:about="" xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:pdf="http://ns.adobe.com/pdf/1.3/"
 xmlns:xmp="http://ns.adobe.com/xap/1.0/" xmlns:xmpMM="http://ns.adobe.com/xap/1.0/mm/"
 xmlns:pdfxid="http://www.npes.org/pdfx/ns/id/" xmlns:pdfaid="http://www.aiim.org/pdfa/ns/id/">
<dc:title><rdf:Alt><rdf:li xml:lang="x-default">Plate 1</rdf:li></rdf:Alt></dc:title>
<xmp:CreateDate>2026-01-02T03:04:05Z</xmp:CreateDate><xmp:ModifyDate>2026-01-02T03:04:05Z</xmp:ModifyDate>
<xmp:MetadataDate>2026-01-02T03:04:05Z</xmp:MetadataDate><xmpMM:DocumentID>uuid:1</xmpMM:DocumentID>
<xmpMM:VersionID>1</xmpMM:VersionID><xmpMM:RenditionClass>default</xmpMM:RenditionClass><pdf:Trapped>False</pdf:Trapped>{claim}
</rdf:Description></rdf:RDF></x:xmpmeta>"""
CLAIM = {
    "x4": "<pdfxid:GTS_PDFXVersion>PDF/X-4</pdfxid:GTS_PDFXVersion>",
    "a": "<pdfaid:part>1</pdfaid:part><pdfaid:conformance>B</pdfaid:conformance>",
}


def profile(kind: bytes = b"prtr", space: bytes = b"CMYK") -> bytes:
    """The header of a colour profile, which is all that is looked at."""
    head = bytearray(128)
    head[:4], head[12:16], head[16:20], head[20:24], head[36:40] = struct.pack(">I", 132), kind, space, b"Lab ", b"acsp"
    return bytes(head) + bytes(4)


def drawn() -> bytes:
    """A page of dots and lines in black and in a spot ink, some words in an embedded face, as ReportLab leaves it."""
    if "Vera" not in pdfmetrics.getRegisteredFontNames():
        pdfmetrics.registerFont(TTFont("Vera", Path(reportlab.__file__).parent / "fonts" / "Vera.ttf"))
    from reportlab.lib.colors import CMYKColor, CMYKColorSep

    width, height = (side + 2 * SLUG for side in TRIM)
    file = io.BytesIO()
    canvas = Canvas(file, pagesize=(width * MM, height * MM), invariant=1, initialFontName="Vera", initialFontSize=12)
    canvas.scale(MM, MM)
    canvas.setFillColor(CMYKColor(0, 0, 0, 1))
    for k in range(20):
        canvas.circle(40 + 3 * k, 100, 0.5, stroke=0, fill=1)
    canvas.setStrokeColor(CMYKColor(0, 0, 0, 1))
    canvas.setLineWidth(0.3)
    canvas.line(40, 120, 100, 120)
    canvas.setFont("Vera", 4)
    canvas.drawString(40, 150, "Femur, natural size")
    canvas.setFillColor(CMYKColorSep(0, 0.4, 0.9, 0, spotName="PANTONE 124 C"))
    canvas.rect(40, 60, 30, 20, stroke=0, fill=1)
    canvas.showPage()
    canvas.save()
    return file.getvalue()


def good(kind: str) -> bytes:
    """A sound file of a kind: x1a, x3, x4, a, or plain."""
    with pikepdf.open(io.BytesIO(drawn())) as pdf:
        page = pdf.pages[0]
        media, slug = [float(side) for side in page.MediaBox], SLUG * MM
        if kind != "plain":
            page.obj.TrimBox = Array([slug, slug, media[2] - slug, media[3] - slug])
            edge = (SLUG - BLEED) * MM
            page.obj.BleedBox = Array([edge, edge, media[2] - edge, media[3] - edge])
        if "/Trans" in page.obj:
            del page.obj["/Trans"]
        finish(pdf, kind)
        return saved(pdf, VERSION.get(kind, "1.4"))


def finish(pdf: pikepdf.Pdf, kind: str) -> None:
    """Puts what a kind wants into a file: Info, XMP, output intent."""
    for key in list(pdf.docinfo.keys()):
        del pdf.docinfo[key]
    if kind == "plain":
        return
    date = "D:20260102030405Z"
    pdf.docinfo.update({"/Title": "Plate 1", "/CreationDate": date, "/ModDate": date, "/Trapped": Name("/False")})
    if kind == "x1a":
        pdf.docinfo.update({"/GTS_PDFXVersion": "PDF/X-1:2001", "/GTS_PDFXConformance": "PDF/X-1a:2001"})
    if kind == "x3":
        pdf.docinfo["/GTS_PDFXVersion"] = "PDF/X-3:2002"
    if kind in CLAIM:
        said(pdf, XMP.format(claim=CLAIM[kind]))
    intent = Dictionary(
        Type=Name.OutputIntent,
        S=Name(INTENT[kind]),
        OutputConditionIdentifier="FOGRA39",
        RegistryName="http://www.color.org",
        Info="Coated",
        DestOutputProfile=pdf.make_stream(profile(), N=4),
    )
    pdf.Root.OutputIntents = Array([intent])


def said(pdf: pikepdf.Pdf, packet: str) -> None:
    """Puts a packet of XMP into a file."""
    pdf.Root.Metadata = pdf.make_stream(packet.encode(), Type=Name.Metadata, Subtype=Name.XML)


def saved(pdf: pikepdf.Pdf, version: str = "1.4", **more: Any) -> bytes:
    file = io.BytesIO()
    if "encryption" not in more:
        more |= {"deterministic_id": True, "stream_decode_level": pikepdf.StreamDecodeLevel.none, "compress_streams": False}
    pdf.save(file, force_version=version, object_stream_mode=pikepdf.ObjectStreamMode.disable, **more)
    return file.getvalue()


def broken(kind: str, breaks: Callable[[pikepdf.Pdf], object], version: str | None = None, **more: Any) -> bytes:
    """A sound file of a kind with one thing done to it."""
    with pikepdf.open(io.BytesIO(good(kind))) as pdf:
        breaks(pdf)
        return saved(pdf, version or VERSION.get(kind, "1.4"), **more)


def page(content: str | bytes, size: tuple[float, float] = (100.0, 100.0), **resources: Any) -> bytes:
    """A page of content in millimetres, y down, with resources as they are given; `None` values are left out."""
    code = content.encode("latin-1") if isinstance(content, str) else content
    with pikepdf.new() as pdf:
        pdf.add_blank_page(page_size=(size[0] * MM, size[1] * MM))
        one = pdf.pages[0].obj
        one.Contents = pdf.make_stream(f"{MM:.9f} 0 0 {-MM:.9f} 0 {size[1] * MM:.9f} cm\n".encode() + code)
        one.Resources = Dictionary({f"/{key}": value for key, value in resources.items()})
        return saved(pdf)


def add(pdf: pikepdf.Pdf, code: str, **resources: Any) -> None:
    """Puts content under that of the first page of a sound file, in millimetres from its lower left, and resources with it."""
    one = pdf.pages[0].obj
    for key, value in resources.items():
        found = one.Resources.get(f"/{key}", Dictionary())
        for name, entry in value.items():
            if isinstance(entry, (Dictionary, Array)):  # its own copy: an object is of one file
                entry = pdf.make_indirect(Array(list(entry)) if isinstance(entry, Array) else Dictionary(dict(entry.items())))
            found[f"/{name}"] = entry
        one.Resources[f"/{key}"] = found
    streams = pdf.make_stream(f"q {MM:.9f} 0 0 {MM:.9f} 0 0 cm {code} Q\n".encode())
    contents = one.Contents
    one.Contents = Array([streams, *(contents if isinstance(contents, Array) else [contents])])


def disc(x: float, y: float, diameter: float) -> str:
    """Content that draws an outline of a circle by four cubics."""
    r, k = diameter / 2, diameter * 0.2761424
    return (
        f"{x + r} {y} m {x + r} {y + k} {x + k} {y + r} {x} {y + r} c {x - k} {y + r} {x - r} {y + k} {x - r} {y} c "
        f"{x - r} {y - k} {x - k} {y - r} {x} {y - r} c {x + k} {y - r} {x + r} {y - k} {x + r} {y} c h "
    )


def separation(name: str, *full: float) -> Array:
    """A spot ink whose full tint is this much of cyan, magenta, yellow and black."""
    tint = Dictionary(FunctionType=2, Domain=[0, 1], C0=[0] * 4, C1=list(full), N=1)
    return Array([Name.Separation, Name(f"/{name}"), Name.DeviceCMYK, tint])


def found(data: bytes, name: str = "plate.pdf", **more: Any) -> dict[str, list[Any]]:
    """The findings by their rules; limits and standards by keyword."""
    standards = {key: more.pop(key) for key in ("pdfx", "pdfa") if key in more}
    rules: dict[str, list[Any]] = {}
    for finding in preflight.check(data, name, preflight.Limits(**more), **standards).findings:
        rules.setdefault(finding.rule, []).append(finding)
    return rules


def faults(data: bytes, name: str = "plate.pdf", **more: Any) -> set[tuple[str, str]]:
    """Rules that found more than something to tell, with the worst that each says."""
    rules = found(data, name, **more)
    worst = {rule: min((one.severity for one in ones), key=["error", "warning", "information"].index) for rule, ones in rules.items()}
    return {(rule, severity) for rule, severity in worst.items() if severity != "information"}
