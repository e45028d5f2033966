"""PDF/X and PDF/A: what they ask of a file beyond a sound page. The ISO texts were not at hand; see the tests for what was checked."""

from __future__ import annotations

import os
import time
import uuid
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import escape

import pikepdf

from crowquill.formats import _icc
from crowquill.formats._icc import Profile
from crowquill.formats._kept import SPACE
from crowquill.forme import Forme, inks
from crowquill.units import POINT

REGISTRY = "http://www.color.org"
CONDITIONS = {  # of the ICC's registry of characterization data, and what each is in short
    "FOGRA39": "Offset on coated paper, ISO 12647-2:2004/Amd 1",
    "FOGRA47": "Offset on uncoated white paper, ISO 12647-2:2004/Amd 1",
    "FOGRA51": "Offset on premium coated paper, ISO 12647-2:2013",
    "FOGRA52": "Offset on wood-free uncoated paper, ISO 12647-2:2013",
    "CGATS TR 001": "Web offset on coated paper, SWOP",
    "CGATS21-2-CRPC6": "Premium coated paper, GRACoL 2013",
    "JC200103": "Offset on coated paper, Japan Color 2001",
    "IFRA26": "Newspaper offset, ISO 12647-3",
}
USUAL = "FOGRA39"
CUSTOM = "Custom"
PAGE = (3 * POINT, 14_400 * POINT)  # mm: sides that PDF's own limits allow
# A file of a standard must say when it was made, and the same drawing gives the same bytes: a fixed time, unless who
# builds it says another, as agreed on by https://reproducible-builds.org/specs/source-date-epoch.
MADE = 946_684_800  # seconds: 2000-01-01, which plain files have too


class Kind(NamedTuple):
    """A standard: what it is called, the version of PDF, the subtype of its intent, and what Info says of it."""

    name: str
    version: str
    intent: str
    info: dict[str, str]


KINDS = {
    "x1a": Kind("PDF/X-1a", "1.3", "/GTS_PDFX", {"GTS_PDFXVersion": "PDF/X-1:2001", "GTS_PDFXConformance": "PDF/X-1a:2001"}),
    "x3": Kind("PDF/X-3", "1.3", "/GTS_PDFX", {"GTS_PDFXVersion": "PDF/X-3:2002"}),
    "x4": Kind("PDF/X-4", "1.6", "/GTS_PDFX", {"GTS_PDFXVersion": "PDF/X-4"}),
    "a1b": Kind("PDF/A-1b", "1.4", "/GTS_PDFA1", {}),
}


@dataclass(frozen=True)
class Standard:
    """What a file is to conform to: one of KINDS, its printing condition by name, and the profile to embed, None for none yet."""

    kind: Kind
    condition: str | None
    profile: Profile | None

    @classmethod
    def of(cls, pdfx: str | None, pdfa: bool, condition: str | None, icc: str | None) -> Standard | None:
        """The standard asked for, None for none. Raises ValueError for what does not go together, and for a bad profile."""
        if pdfx is None and not pdfa:
            if icc is not None or condition is not None:
                given = "icc" if icc is not None else "output_condition"
                raise ValueError(f"{given} is kept by PDF/X and PDF/A alone; add pdfx or pdfa, or leave it out")
            return None
        if pdfx is not None and pdfa:
            raise ValueError("pdfx and pdfa are two kinds of file; choose one, and write the other beside it")
        kind = KINDS[pdfx or "a1b"]
        if icc is not None and not Path(icc).suffix:  # a recipe takes such a name for a word, and would not keep the file
            raise ValueError(f"no icc {icc!r}; give a file with a suffix, such as press.icc")
        profile = None if icc is None else _icc.read(icc)
        if profile and profile.version > 2 and kind.name != "PDF/X-4":
            raise ValueError(f"{icc}: is a profile of version {profile.version}, and {kind.name} takes 2; give an older one, or use x4")
        if profile and profile.space == "GRAY" and kind.name == "PDF/X-1a":
            raise ValueError(f"{icc}: is for GRAY, and {kind.name} takes CMYK; give a CMYK profile, or none")
        if condition is not None and profile is None:
            if kind.name in ("PDF/X-4", "PDF/A-1b"):
                raise ValueError(f"output_condition {condition!r} alone is not enough for {kind.name}; give its profile too, as icc")
            if _registered(condition) is None:
                raise ValueError(
                    f"no output_condition {condition!r} without a profile; there are {', '.join(CONDITIONS)}, or give its profile as icc"
                )
        return cls(kind, condition, profile)

    def settled(self, forme: Forme) -> Standard:
        """The standard with the profile that this drawing takes. Raises ValueError for what the standard has no room for."""
        if forme.sheet.attached:
            raise ValueError(f"{self.kind.name} keeps no files inside, and the picture is to be embedded; leave out embed")
        if not all(PAGE[0] <= side <= PAGE[1] for side in forme.size):
            low, high = PAGE
            raise ValueError(
                f"a page of {forme.size[0]:g} x {forme.size[1]:g} mm is not for {self.kind.name}; it takes {low:.3g} to {high:g} mm"
            )
        coloured = sorted(name for name in inks(forme.layers) if name != "Black")
        if self.profile and self.profile.space == "GRAY" and coloured:
            raise ValueError(f"icc is for GRAY, and ink {coloured[0]!r} is no share of black; give a CMYK profile")
        if self.profile or self.kind.name not in ("PDF/X-4", "PDF/A-1b"):
            return self
        if coloured:
            raise ValueError(
                f"{self.kind.name} embeds a profile, and none for ink {coloured[0]!r} comes along; give the .icc that "
                "the printer names, with icc; or draw in black alone" + ("; or use x1a or x3" if self.kind.intent == "/GTS_PDFX" else "")
            )
        return Standard(self.kind, self.condition, _icc.grey())

    def put(self, pdf: pikepdf.Pdf, made: int) -> None:
        """Puts into a file the output intent, and into its Info what the standard asks for; made is in seconds since 1970."""
        date = time.strftime("D:%Y%m%d%H%M%SZ", time.gmtime(made))
        for key, value in {"CreationDate": date, "ModDate": date, **self.kind.info}.items():
            pdf.docinfo[f"/{key}"] = value
        pdf.docinfo["/Trapped"] = pikepdf.Name("/False")
        intent = pikepdf.Dictionary(Type=pikepdf.Name.OutputIntent, S=pikepdf.Name(self.kind.intent))
        for key, value in self._condition().items():
            intent[f"/{key}"] = value
        if self.profile:
            packed, channels = zlib.compress(self.profile.data, 9), self.profile.channels
            intent.DestOutputProfile = pdf.make_stream(packed, Filter=pikepdf.Name.FlateDecode, N=channels)
        pdf.Root.OutputIntents = pikepdf.Array([pdf.make_indirect(intent)])

    def said(self, digest: bytes, made: int) -> str:
        """What the XMP packet says of it, in accord with Info; `digest` are 16 bytes that only this drawing has."""
        date = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(made))
        dates = "".join(f"<xmp:{key}>{date}</xmp:{key}>\n" for key in ("CreateDate", "ModifyDate", "MetadataDate"))
        own = _OF_A if self.kind.name == "PDF/A-1b" else _of_x(self.kind.info, uuid.UUID(bytes=digest, version=4))
        return own + _ABOUT.format(space="http://ns.adobe.com/xap/1.0/", prefix="xmp", said=dates)

    def _condition(self) -> dict[str, str]:
        """How the intent names the printing condition: by the registry, or as the profile does."""
        name = USUAL if self.profile is None and self.condition is None else self.condition
        if name is not None and (known := _registered(name)):
            return {
                "OutputCondition": CONDITIONS[known],
                "OutputConditionIdentifier": known,
                "RegistryName": REGISTRY,
                "Info": CONDITIONS[known],
            }
        profile = self.profile
        assert profile is not None  # of() has seen to it
        said = name or profile.name
        return {"OutputCondition": said, "OutputConditionIdentifier": name or CUSTOM, "Info": profile.name}


def dated() -> int:
    """Seconds since 1970 that files are dated by. Raises ValueError for a SOURCE_DATE_EPOCH that is no such number."""
    told = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not told:
        return MADE
    if not told.isdecimal() or int(told) > 253_402_300_799:  # the end of the year 9999
        raise ValueError(f"SOURCE_DATE_EPOCH is {told!r}; it takes seconds since 1970, or unset it")
    return int(told)


def _registered(name: str) -> str | None:
    """The registry's own spelling of a name, whatever its case, spaces and hyphens."""
    plain = {_letters(known): known for known in CONDITIONS}
    return plain.get(_letters(name))


def _letters(name: str) -> str:
    return "".join(letter for letter in name.casefold() if letter.isalnum())


_ABOUT = '<rdf:Description rdf:about="" xmlns:{prefix}="{space}">\n{said}</rdf:Description>\n'
# PDF/A takes no property that is not described
_OF_A = (
    _ABOUT.format(
        prefix="pdfaid",
        space="http://www.aiim.org/pdfa/ns/id/",
        said="<pdfaid:part>1</pdfaid:part>\n<pdfaid:conformance>B</pdfaid:conformance>\n",
    )
    + f"""<rdf:Description rdf:about="" xmlns:pdfaExtension="http://www.aiim.org/pdfa/ns/extension/"
 xmlns:pdfaSchema="http://www.aiim.org/pdfa/ns/schema#" xmlns:pdfaProperty="http://www.aiim.org/pdfa/ns/property#">
<pdfaExtension:schemas><rdf:Bag><rdf:li rdf:parseType="Resource">
<pdfaSchema:schema>What made a drawing</pdfaSchema:schema>
<pdfaSchema:namespaceURI>{SPACE}</pdfaSchema:namespaceURI>
<pdfaSchema:prefix>crowquill</pdfaSchema:prefix>
<pdfaSchema:property><rdf:Seq><rdf:li rdf:parseType="Resource">
<pdfaProperty:name>recipe</pdfaProperty:name>
<pdfaProperty:valueType>Text</pdfaProperty:valueType>
<pdfaProperty:category>external</pdfaProperty:category>
<pdfaProperty:description>Its settings, seed and sources, as JSON</pdfaProperty:description>
</rdf:li></rdf:Seq></pdfaSchema:property>
</rdf:li></rdf:Bag></pdfaExtension:schemas>
</rdf:Description>
"""
)


def _of_x(info: dict[str, str], name: uuid.UUID) -> str:
    """The packet's part that PDF/X asks for; X-1a and X-3, which ask for none, get it all the same, as readers look there."""
    said = "".join(f"<pdfx:{key}>{escape(value)}</pdfx:{key}>\n" for key, value in info.items())
    about = {
        "pdfxid": ("http://www.npes.org/pdfx/ns/id/", f"<pdfxid:GTS_PDFXVersion>{info['GTS_PDFXVersion']}</pdfxid:GTS_PDFXVersion>\n"),
        "pdfx": ("http://ns.adobe.com/pdfx/1.3/", said),
        "pdf": ("http://ns.adobe.com/pdf/1.3/", "<pdf:Trapped>False</pdf:Trapped>\n"),
        "xmpMM": (
            "http://ns.adobe.com/xap/1.0/mm/",
            f"<xmpMM:DocumentID>uuid:{name}</xmpMM:DocumentID>\n<xmpMM:VersionID>1</xmpMM:VersionID>\n"
            "<xmpMM:RenditionClass>default</xmpMM:RenditionClass>\n",
        ),
    }
    return "".join(_ABOUT.format(prefix=prefix, space=space, said=part) for prefix, (space, part) in about.items())
