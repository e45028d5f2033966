"""Words as text in an embedded TrueType font, for PDF: a face's letters in use and no more, to be searched and copied."""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import pikepdf

from crowquill.formats._fonts import composite, mapped, tag
from crowquill.lettering import Words, file, lacking
from crowquill.sheet import Layer

TABLES = {"glyf", "head", "hhea", "hmtx", "loca", "maxp"}  # all that drawing letters takes
TOLD = {"cmap", "name", "post", "OS/2"}  # what is known of them, which is left out in the end
RESTRICTED = 2  # of OS/2's fsType: may not be embedded


@dataclass(frozen=True)
class Face:
    """A font with some letters: its name, the character of each letter, the widths of all characters, and the program.

    box, ascent, descent, capital, slant  as PDF tells them: in thousandths of its size, and degrees
    """

    name: str
    character: dict[str, int]
    widths: tuple[float, ...]
    box: tuple[float, ...]
    ascent: float
    descent: float
    capital: float
    slant: float
    program: bytes

    @property
    def key(self) -> str:
        """Its name in the page."""
        return self.name[:6]

    def shown(self, words: str) -> str:
        """The operand that shows a line of text: runs of letters, and how far to go back or on between them.

        Some readers take widths as whole numbers. So they are, and where what they miss adds up to one, it is made good.
        """
        parts, missed = ["<"], 0.0
        for letter in words:
            code = self.character[letter]
            if step := round(missed):
                parts.append(f">{-step}<")
                missed -= step
            parts.append(f"{code:04x}")
            missed += self.widths[code] - round(self.widths[code])
        return "[" + "".join(parts) + ">]"


def faces(layers: Iterable[Layer]) -> dict[str, Face]:
    """By the font that Words name, the face with the letters of all layers; a font without a letter to show has none.

    Raises ValueError for a letter that a font lacks, and for a font that cannot be embedded.
    """
    letters: dict[str, set[str]] = {}
    for art in (layer.art for layer in layers):
        if isinstance(art, Words):
            letters.setdefault(art.font, set()).update(*art.text)
    return {font: _face(font, sorted(found)) for font, found in letters.items() if found}


def _face(font: str, letters: list[str]) -> Face:
    from fontTools.subset import Options, Subsetter
    from fontTools.ttLib import TTFont, TTLibError

    path = file(font)
    try:
        whole = TTFont(path, recalcTimestamp=False, fontNumber=0)
        codes: dict[int, str] = whole.getBestCmap() or {}
    except (TTLibError, LookupError, ValueError, AssertionError) as error:
        raise ValueError(f"{path}: not a font that can be read ({str(error)[:80]}); give a TrueType font") from None
    if "glyf" not in whole:
        raise ValueError(f"{path}: its outlines are not TrueType; give a TrueType font")
    if "OS/2" in whole and whole["OS/2"].fsType & 0xF == RESTRICTED:
        raise ValueError(f"{path}: its licence forbids embedding; give another font")
    for letter in lacking(letters, font):
        raise ValueError(f"letter {letter!r} (U+{ord(letter):04X}) is not in font {font}; choose other words, or a font that has it")
    capital = _capital(whole, codes)
    for table in set(whole.keys()) - TABLES - TOLD - {"GlyphOrder"}:
        del whole[table]
    options = Options(hinting=False, notdef_outline=True, recalc_timestamp=False)
    subset = Subsetter(options)
    subset.populate(unicodes=[ord(letter) for letter in letters])
    subset.subset(whole)
    order = {glyph: k for k, glyph in enumerate(whole.getGlyphOrder())}
    return _told(whole, {letter: order[codes[ord(letter)]] for letter in letters}, capital)


def _capital(font: Any, codes: dict[int, str]) -> float:
    """How high capitals are, in the font's units: as it says, else as its H is, else as high as it goes."""
    said = getattr(font["OS/2"], "sCapHeight", 0) if "OS/2" in font else 0  # old fonts do not say
    high = getattr(font["glyf"][codes[ord("H")]], "yMax", 0) if ord("H") in codes else 0
    return float(said or high or font["hhea"].ascent)


def _told(font: Any, character: dict[str, int], capital: float) -> Face:
    """What PDF says of a font, and its program."""
    part = 1000 / font["head"].unitsPerEm
    head, across = font["head"], font["hhea"]
    widths = tuple(round(part * font["hmtx"][glyph][0], 4) for glyph in font.getGlyphOrder())
    box = tuple(round(part * edge) for edge in (head.xMin, head.yMin, head.xMax, head.yMax))
    slant = float(font["post"].italicAngle) if "post" in font else 0.0
    called = str(font["name"].getDebugName(6) or "Font") if "name" in font else "Font"
    for table in TOLD & set(font.keys()):
        del font[table]
    buffer = io.BytesIO()
    font.save(buffer, reorderTables=True)
    program = buffer.getvalue()
    plain = "".join(letter for letter in called if letter.isascii() and (letter.isalnum() or letter == "-")) or "Font"
    ascent, descent, high = (round(part * height) for height in (across.ascent, across.descent, capital))
    return Face(f"{tag(program)}+{plain}", character, widths, box, ascent, descent, high, slant, program)


def resource(pdf: pikepdf.Pdf, face: Face) -> pikepdf.Object:
    """The face as an object of the file."""
    packed = zlib.compress(face.program, 9)
    descriptor = {
        "FontBBox": list(face.box),
        "ItalicAngle": face.slant,
        "Ascent": face.ascent,
        "Descent": face.descent,
        "CapHeight": face.capital,
        "StemV": 80,
        "FontFile2": pdf.make_stream(packed, Filter=pikepdf.Name.FlateDecode, Length1=len(face.program)),
        "CIDSet": cid_set(pdf, len(face.widths)),
    }
    character = {"CIDToGIDMap": pikepdf.Name.Identity, "W": [0, [round(width) for width in face.widths]]}
    unicode = _unicode(face.character)
    return composite(pdf, face.name, kind="CIDFontType2", descriptor=descriptor, character=character, unicode=unicode)


def cid_set(pdf: pikepdf.Pdf, count: int) -> pikepdf.Object:
    """The list of characters in a font that PDF/A-1 asks for: a bit each, all of them."""
    bits = (1 << count) - 1 << -count % 8
    return pdf.make_stream(zlib.compress(bits.to_bytes(-(-count // 8), "big"), 9), Filter=pikepdf.Name.FlateDecode)


def _unicode(character: dict[str, int]) -> bytes:
    """The map from characters back to letters; of two letters that look the same, the first."""
    letters: dict[int, str] = {}
    for letter, code in sorted(character.items()):
        letters.setdefault(code, letter)
    pairs = [f"<{code:04x}> <{letter.encode('utf-16-be').hex()}>" for code, letter in sorted(letters.items())]
    return mapped(pairs, "char")
