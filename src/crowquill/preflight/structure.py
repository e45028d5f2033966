"""Rules for a PDF's frame: boxes, version, output intent, what it says of itself, what must not be in the file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pikepdf

from crowquill.preflight.document import LEVEL, PART, PDFX, Document, TooLarge, claim, packings, unpacked
from crowquill.preflight.drawing import Box, same_paper
from crowquill.preflight.rules import ERROR, INFORMATION, WARNING, Hit, Limits, X, rule
from crowquill.preflight.values import real, text

FILE = "file"
SLACK = 0.01  # mm: boxes are written with two decimals of a point
NESTED = (("TrimBox", "BleedBox"), ("ArtBox", "BleedBox"), ("TrimBox", "MediaBox"), ("BleedBox", "MediaBox"), ("CropBox", "MediaBox"))
VERSIONS = {"x1a": ("1.3", "1.4"), "x3": ("1.3", "1.4"), "x4": ("1.3", "1.4", "1.5", "1.6")}
INTENTS = {"/GTS_PDFX": X, "/GTS_PDFA1": ("a",)}
REGISTRIES = ("http://www.color.org", "https://www.color.org")
CHANNELS = {b"GRAY": 1, b"RGB ": 3, b"CMYK": 4, b"Lab ": 3}
DC, PDF, XAP, MM = (
    "{http://purl.org/dc/elements/1.1/}",
    "{http://ns.adobe.com/pdf/1.3/}",
    "{http://ns.adobe.com/xap/1.0/}",
    "{http://ns.adobe.com/xap/1.0/mm/}",
)
SAME = (
    ("/Title", DC + "title"),
    ("/Author", DC + "creator"),
    ("/Subject", DC + "description"),
    ("/Keywords", PDF + "Keywords"),
    ("/Creator", XAP + "CreatorTool"),
    ("/Producer", PDF + "Producer"),
    ("/Trapped", PDF + "Trapped"),
)
DATES = (("/CreationDate", XAP + "CreateDate"), ("/ModDate", XAP + "ModifyDate"))
LARGE = 50 * 2**20  # bytes
COMPRESSED = {
    "/LZWDecode": ("x1a", "x3", "x4", "a"),
    "/JPXDecode": ("x1a", "x3", "a1"),
    "/JBIG2Decode": ("x1a", "x3"),
    "/Crypt": ("x1a", "x3", "x4", "a"),
}


def strict(document: Document) -> str:
    """An error where a file is held to a standard, a warning elsewhere."""
    return ERROR if document.held else WARNING


@rule("damage", ERROR, "pdf")
def damage(document: Document, _: Limits) -> Iterator[Hit]:
    """The file is whole: readers need not rebuild it."""
    if document.warnings:
        more = f", and {len(document.warnings) - 1} more" if len(document.warnings) > 1 else ""
        yield Hit(FILE, f"it is damaged and was mended to be read: {document.warnings[0][:120]}{more}", len(document.warnings))


@rule("pages", ERROR, "pdf")
def pages(document: Document, _: Limits) -> Iterator[Hit]:
    """There is a page, and all are looked at."""
    count = len(document.pdf.pages)
    if not count:
        yield Hit(FILE, "it has no page", 0)
    if count > len(document.pages) > 0:
        yield Hit(FILE, f"only the first {len(document.pages)} of {count} pages were looked at", count)


@rule("file-size", WARNING, "pdf")
def file_size(document: Document, _: Limits) -> Iterator[Hit]:
    """The file is below 50 MB."""
    if document.bytes > LARGE:
        yield Hit(FILE, f"{document.bytes / 2**20:.0f} MB is much for a plate", document.bytes)


@rule("boxes", ERROR, "pdf")
def nested(document: Document, _: Limits) -> Iterator[Hit]:
    """Each page has a MediaBox, with Trim or Art inside Bleed, and all inside Crop and Media."""
    for page in document.pages:
        if not page.sound:
            yield Hit(page.where, "it has no MediaBox that can be read; A4 was taken")
        if min(page.boxes["MediaBox"][2] - page.boxes["MediaBox"][0], page.boxes["MediaBox"][3] - page.boxes["MediaBox"][1]) < 1:
            yield Hit(page.where, "its MediaBox has no area")
        for inner, outer in NESTED:
            if inner in page.boxes and outer in page.boxes and not _inside(page.boxes[inner], page.boxes[outer]):
                yield Hit(page.where, f"its {inner} goes beyond its {outer}", list(page.boxes[inner]))


def _inside(inner: Box, outer: Box) -> bool:
    turned = (1, 1, -1, -1)
    return all((a - b) * turn >= -SLACK for a, b, turn in zip(inner, outer, turned, strict=True))


@rule("trim-box", ERROR, "pdf", *X)
def trim_box(document: Document, _: Limits) -> Iterator[Hit]:
    """Each page has a TrimBox or an ArtBox, and not both."""
    for page in document.pages:
        if ("TrimBox" in page.boxes) == ("ArtBox" in page.boxes):
            yield Hit(page.where, "it has both TrimBox and ArtBox" if "TrimBox" in page.boxes else "it has neither TrimBox nor ArtBox")


@rule("trim-size", ERROR, "pdf")
def trim_size(document: Document, limits: Limits) -> Iterator[Hit]:
    """The trim is the paper asked for by --size within 0.1 mm, upright or turned."""
    for page in document.pages:
        left, top, right, bottom = page.drawing.trim
        size = (right - left, bottom - top)
        if limits.size and not same_paper(size, limits.size):
            wish = f"{limits.size[0]:g} x {limits.size[1]:g} mm"
            yield Hit(page.where, f"its trim is {size[0]:.2f} x {size[1]:.2f} mm, not {wish}", [round(side, 3) for side in size])


@rule("version", ERROR, "pdf", *X, "a")
def version(document: Document, _: Limits) -> Iterator[Hit]:
    """The version of PDF is one that the standard knows."""
    for kind in sorted(document.held & set(VERSIONS)):
        if document.version not in VERSIONS[kind]:
            yield Hit(FILE, f"PDF {document.version}, where {kind} takes {' and '.join(VERSIONS[kind])}", document.version)
    if "a" in document.held and document.part == 1 and document.version > "1.4":
        yield Hit(FILE, f"PDF {document.version}, where PDF/A-1 takes 1.4 at most", document.version)


@rule("intent", ERROR, "pdf", *X, "a")
def intent(document: Document, _: Limits) -> Iterator[Hit]:
    """There is exactly one output intent of the standard, with the name of its printing condition."""
    for kind, held in INTENTS.items():
        if not document.held & set(held):
            continue
        found = [one for one in document.intents if one.get("/S") == pikepdf.Name(kind)]
        if len(found) != 1 and not (kind == "/GTS_PDFA1" and not found and not _device(document)):
            yield Hit(FILE, f"{len(found) or 'no'} output intents {kind[1:]}, where there must be one", len(found))
        for one in found:
            if not text(one.get("/OutputConditionIdentifier")).strip():
                yield Hit(FILE, f"the output intent {kind[1:]} does not name its condition")


def _device(document: Document) -> bool:
    """Whether colours are used that depend on the device."""
    return any(label.startswith("Device") for page in document.pages for label in page.spaces)


@rule("profile", ERROR, "pdf", *X, "a")
def profile(document: Document, _: Limits) -> Iterator[Hit]:
    """The intent's profile is of a printer, its colours agree with its number of channels, and it is there where it must be."""
    for one in document.intents:
        kind = text(one.get("/S"))
        if not document.held & set(INTENTS.get(kind, ())):
            continue
        found = one.get("/DestOutputProfile")
        if not isinstance(found, pikepdf.Stream):
            registered = text(one.get("/RegistryName")).rstrip("/") in REGISTRIES
            if "a" in document.held and kind == "/GTS_PDFA1":
                yield Hit(FILE, "PDF/A wants the intent's profile embedded")
            elif "x4" in document.held:
                yield Hit(FILE, "PDF/X-4 wants the intent's profile embedded")
            elif not registered:
                yield Hit(FILE, "the intent has no profile, and its condition is not of the registry of color.org")
            continue
        yield from _header(found, kind)


def _header(stream: Any, kind: str) -> Iterator[Hit]:
    """What is wrong with a profile by its header."""
    try:
        head = unpacked(stream)[:128]
    except (TooLarge, pikepdf.PdfError):
        head = b""
    if len(head) < 128 or head[36:40] != b"acsp":
        yield Hit(FILE, "the intent's profile is none")
        return
    if kind == "/GTS_PDFX" and head[12:16] != b"prtr":
        yield Hit(FILE, f"the intent's profile is of class {head[12:16]!r}, not a printer's", head[12:16].decode("latin-1"))
    if kind == "/GTS_PDFA1" and head[12:16] not in (b"prtr", b"mntr"):
        yield Hit(
            FILE, f"the intent's profile is of class {head[12:16]!r}, neither a printer's nor a monitor's", head[12:16].decode("latin-1")
        )
    channels, number = CHANNELS.get(head[16:20]), real(stream.get("/N"), 0.0)
    if channels != number:
        said = head[16:20].decode("latin-1").strip()
        yield Hit(FILE, f"the intent's profile is of {said}, and its N says {number:g} channels", channels)


@rule("claim", ERROR, "pdf", *X, "a")
def claimed(document: Document, _: Limits) -> Iterator[Hit]:
    """The file says of itself what it is held to, where the standard wants it said."""
    for kind in sorted(document.held & set(X)):
        if claim(document.pdf, document.said) != kind:
            yield Hit(FILE, f"it does not say that it is PDF/{kind.upper().replace('X', 'X-', 1).replace('A', 'a')}")
        elif kind == "x1a" and not document.info.get("/GTS_PDFXConformance", "").startswith("PDF/X-1a"):
            yield Hit(FILE, "its Info has no GTS_PDFXConformance of PDF/X-1a")
        elif kind == "x4" and not document.said.get(PDFX, "").startswith("PDF/X-4"):
            yield Hit(FILE, "its XMP has no GTS_PDFXVersion of PDF/X-4")
    if "a" in document.held and (document.said.get(PART) not in ("1", "2", "3") or document.said.get(LEVEL, "") not in tuple("ABU")):
        yield Hit(FILE, "its XMP has no part and conformance of PDF/A")


@rule("trapped", ERROR, "pdf", *X)
def trapped(document: Document, _: Limits) -> Iterator[Hit]:
    """Info says whether the file is trapped, True or False."""
    said = document.info.get("/Trapped", document.said.get(PDF + "Trapped", "") if "x4" in document.held else "").strip("/")
    if said not in ("True", "False"):
        yield Hit(FILE, f"Trapped is {said or 'not said'}, where it must be True or False", said)


@rule("title-dates", ERROR, "pdf", *X)
def title_dates(document: Document, _: Limits) -> Iterator[Hit]:
    """Title, creator and dates are said, in Info, and in the XMP of X-4."""
    for key in ("/Title", "/CreationDate", "/ModDate"):
        if not document.info.get(key, "").strip():
            yield Hit(FILE, f"Info has no {key[1:]}")
    if "x4" in document.held:
        for key in (
            DC + "title",
            XAP + "CreateDate",
            XAP + "ModifyDate",
            XAP + "MetadataDate",
            MM + "DocumentID",
            MM + "VersionID",
            MM + "RenditionClass",
        ):
            if not document.said.get(key, "").strip():
                yield Hit(FILE, f"XMP has no {key.rsplit('}', 1)[1]}")


@rule("info-xmp", ERROR, "pdf")
def info_xmp(document: Document, _: Limits) -> Iterator[Hit]:
    """Info and XMP agree in what both say."""
    for key, name in SAME:
        one, other = document.info.get(key, "").strip("/ "), document.said.get(name, "").strip()
        if one and other and one != other:
            yield Hit(FILE, f"Info and XMP differ in {key[1:]}: {one[:40]!r} and {other[:40]!r}", None, strict(document))
    for key, name in DATES:
        one, other = (
            "".join(letter for letter in text if letter.isdigit())[:14]
            for text in (document.info.get(key, ""), document.said.get(name, ""))
        )
        if one and other and one != other:
            yield Hit(FILE, f"Info and XMP differ in {key[1:]}: {one} and {other}", None, strict(document))


@rule("file-id", ERROR, "pdf", *X, "a")
def file_id(document: Document, _: Limits) -> Iterator[Hit]:
    """The trailer has a file ID."""
    found = document.pdf.trailer.get("/ID")
    if not isinstance(found, pikepdf.Array) or len(found) != 2 or not isinstance(found[0], pikepdf.String) or not bytes(found[0]):
        yield Hit(FILE, "its trailer has no ID")


@rule("encryption", ERROR, "pdf")
def encryption(document: Document, _: Limits) -> Iterator[Hit]:
    """The file is not encrypted, not even against changes."""
    if document.pdf.is_encrypted:
        yield Hit(FILE, "it is encrypted; printers refuse it", None, strict(document))


@rule("filters", ERROR, "pdf", *X, "a")
def filters(document: Document, _: Limits) -> Iterator[Hit]:
    """No stream is packed in a way that the standard leaves out: LZW, JPX, JBIG2, Crypt."""
    held = document.held | ({"a1"} if "a" in document.held and document.part == 1 else set())
    found: dict[str, int] = {}
    for one in document.objects():
        if isinstance(one, pikepdf.Stream):
            for name in packings(one):
                if held & set(COMPRESSED.get(name, ())):
                    found[name] = found.get(name, 0) + 1
    for page in document.pages:
        if page.met.all("lzw"):
            found["/LZWDecode"] = found.get("/LZWDecode", 0) + 1
    for key, count in found.items():
        yield Hit(FILE, f"{count} streams are packed by {key[1:]}", count)


@rule("actions", ERROR, "pdf")
def actions(document: Document, _: Limits) -> Iterator[Hit]:
    """Nothing happens when the file is opened or clicked: no actions, no JavaScript."""
    root = document.pdf.Root
    found = [key[1:] for key in ("/OpenAction", "/AA") if key in root]
    names = root.get("/Names")
    if isinstance(names, pikepdf.Dictionary) and "/JavaScript" in names:
        found.append("JavaScript")
    for one in document.objects():
        kind = one.get("/S")
        if isinstance(one, pikepdf.Dictionary) and (
            kind in (pikepdf.Name.JavaScript, pikepdf.Name.Launch, pikepdf.Name.URI, pikepdf.Name.SubmitForm)
        ):
            found.append(text(kind)[1:])
        if one.get("/Type") in (pikepdf.Name.Page, pikepdf.Name.Annot) and "/AA" in one:
            found.append("AA of a page")
    if found:
        yield Hit(FILE, f"it has {', '.join(dict.fromkeys(found))}", list(dict.fromkeys(found)), strict(document))


@rule("attachments", ERROR, "pdf")
def attachments(document: Document, _: Limits) -> Iterator[Hit]:
    """No file is attached, nor named, where the standard leaves it out."""
    count = 0
    for one in document.objects():
        count += (isinstance(one, pikepdf.Dictionary) and one.get("/Type") in (pikepdf.Name.Filespec, pikepdf.Name("/F"))) or (
            isinstance(one, pikepdf.Stream) and "/F" in one
        )
    if count:
        strict_ = bool(document.held & {"x1a", "x3", "x4"}) or ("a" in document.held and document.part < 3)
        yield Hit(FILE, f"{count} files are attached or named", count, ERROR if strict_ else INFORMATION)
