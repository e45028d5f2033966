"""Fonts as objects of a PDF: composite ones, whose codes of two bytes are their characters themselves."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Iterable
from typing import Any

import pikepdf

MOST = 100  # rows to a block of a map, as its format has it


def tag(program: bytes) -> str:
    """Six letters that stand for what is in a font, since printers keep fonts by name."""
    return "".join(chr(65 + byte % 26) for byte in hashlib.sha256(program).digest()[:6])


def composite(
    pdf: pikepdf.Pdf, name: str, *, kind: str, descriptor: dict[str, Any], character: dict[str, Any], unicode: bytes
) -> pikepdf.Object:
    """A font as an object of the file.

    kind        CIDFontType0 or CIDFontType2
    descriptor  what PDF is told of the font's look, and its program
    character   what it is told of the characters, widths among them
    unicode     the map from characters to letters; see `mapped`
    """
    Name, Dictionary = pikepdf.Name, pikepdf.Dictionary
    told = Dictionary(Type=Name.FontDescriptor, FontName=Name(f"/{name}"), Flags=4, **descriptor)  # 4: its codes are its own
    below = Dictionary(
        Type=Name.Font,
        Subtype=Name(f"/{kind}"),
        BaseFont=Name(f"/{name}"),
        CIDSystemInfo=Dictionary(Registry=b"Adobe", Ordering=b"Identity", Supplement=0),
        FontDescriptor=pdf.make_indirect(told),
        DW=0,
        **character,
    )
    whole = Dictionary(
        Type=Name.Font,
        Subtype=Name.Type0,
        BaseFont=Name(f"/{name}-Identity-H" if kind == "CIDFontType0" else f"/{name}"),  # PDF 32000, 9.7.6.2
        Encoding=Name("/Identity-H"),
        DescendantFonts=[pdf.make_indirect(below)],
        ToUnicode=pdf.make_stream(zlib.compress(unicode, 9), Filter=Name.FlateDecode),
    )
    return pdf.make_indirect(whole)


def mapped(rows: Iterable[str], kind: str) -> bytes:
    """The map of these rows from characters to letters, of kind char or range."""
    every = list(rows)
    lines = [
        "/CIDInit /ProcSet findresource begin\n12 dict begin\nbegincmap",
        "/CIDSystemInfo << /Registry (Adobe) /Ordering (UCS) /Supplement 0 >> def",
        "/CMapName /Adobe-Identity-UCS def\n/CMapType 2 def",
        "1 begincodespacerange\n<0000> <ffff>\nendcodespacerange",
    ]
    for lo in range(0, len(every), MOST):
        block = every[lo : lo + MOST]
        lines.append(f"{len(block)} beginbf{kind}\n" + "\n".join(block) + f"\nendbf{kind}")
    lines.append("endcmap\nCMapName currentdict /CMap defineresource pop\nend\nend")
    return "\n".join(lines).encode("ascii")
