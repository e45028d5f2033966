"""What a PDF keeps beside its page: the recipe in XMP, the sources as attachments; and how both are read back."""

from __future__ import annotations

import io
import json
import zlib
from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import escape

import pikepdf

from crowquill.sheet import Sheet
from crowquill.vector import LIMIT

SPACE = "urn:crowquill:drawing"
PACKET = """<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/">
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
<rdf:Description rdf:about="" xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:pdf="http://ns.adobe.com/pdf/1.3/"
 xmlns:xmp="http://ns.adobe.com/xap/1.0/" xmlns:crowquill="{space}">
<dc:title><rdf:Alt><rdf:li xml:lang="x-default">{title}</rdf:li></rdf:Alt></dc:title>
<pdf:Producer>crowquill</pdf:Producer>
<xmp:CreatorTool>crowquill</xmp:CreatorTool>
<crowquill:recipe>{recipe}</crowquill:recipe>
</rdf:Description>
{more}</rdf:RDF>
</x:xmpmeta>
<?xpacket end="w"?>
"""


def keep(pdf: pikepdf.Pdf, sheet: Sheet, title: str, more: str = "") -> None:
    """Puts the sheet's recipe and attached files into a PDF, without dates; `more` is what else its XMP says, as rdf:Descriptions."""
    text = json.dumps(dict(sheet.recipe), sort_keys=True)  # in ASCII, as SVG keeps it
    packet = PACKET.format(space=SPACE, title=escape(title), recipe=escape(text), more=more)
    pdf.Root.Metadata = pdf.make_stream(packet.encode(), Type=pikepdf.Name.Metadata, Subtype=pikepdf.Name.XML)
    for name, contents in sheet.attached.items():
        pdf.attachments[name] = pikepdf.AttachedFileSpec(
            pdf, contents, filename=name, description="", mime_type="", creation_date="", mod_date=""
        )


def recipe(data: bytes, name: str) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What made the drawing in a PDF of ours, and the files attached to it, by name."""
    try:
        with pikepdf.open(io.BytesIO(data)) as pdf:
            packet = _unpacked(pdf.Root.Metadata) if "/Metadata" in pdf.Root else b""
            kept = {key: _unpacked(spec.get_file().obj) for key, spec in pdf.attachments.items()}
    except (pikepdf.PdfError, LookupError, TypeError, AttributeError, zlib.error) as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"{name}: not a sound PDF ({said}); give the file as it was drawn") from None
    try:
        if b"<!" in packet:  # declarations have no place in XMP
            raise ValueError("it declares entities")
        found = ElementTree.fromstring(packet).find(f".//{{{SPACE}}}recipe") if packet else None
        about = json.loads("{}" if found is None else found.text or "{}")
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise ValueError(f"{name}: its recipe is broken ({error}); give the file as it was drawn") from None
    if not isinstance(about, Mapping) or not about:
        raise ValueError(f"{name}: keeps no recipe of crowquill; give a PDF that it drew")
    return dict(about), kept


def _unpacked(stream: Any) -> bytes:
    """A stream's bytes, plain or deflated, up to the limit for files from outside."""
    raw = bytes(stream.read_raw_bytes())
    packing = stream.get("/Filter")
    if isinstance(packing, pikepdf.Array) and len(packing) == 1:
        packing = packing[0]
    if packing is None:
        return raw
    if packing != pikepdf.Name.FlateDecode or "/DecodeParms" in stream:
        raise TypeError(f"a stream is packed by {packing}")
    opener = zlib.decompressobj()
    found = opener.decompress(raw, LIMIT)
    if opener.unconsumed_tail:
        raise TypeError("what is attached is too large")
    return found
