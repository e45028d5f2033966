"""A page's content as PDF operators, in micrometres, and the fonts, inks and images that it names."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pikepdf

from crowquill.formats import _bitmap, _dotfont, _letters
from crowquill.formats._content import Content
from crowquill.formats._letters import Face
from crowquill.formats._text import chunks, number, pdf_path
from crowquill.forme import Forme, registers, shares
from crowquill.greydots import scanned
from crowquill.lettering import Words
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet
from crowquill.units import INCH, POINT, UM

OVER = "Over"  # the graphics state in which inks overprint
ALL = "All"  # the spot ink that is every plate
GREY = "Grey"  # the image of grey dots


@dataclass
class Page:
    """Where operators go; by the names that they call them fonts of dots, faces of letters, spot inks, images; if any ink overprints."""

    faces: Mapping[str, Face]
    code: Content
    compact: bool = False
    dots: dict[str, _dotfont.Font] = field(default_factory=dict)
    spots: dict[str, Ink] = field(default_factory=dict)
    images: dict[str, Bitmap] = field(default_factory=dict)
    grey: tuple[_bitmap.Page, bytes] | None = None
    overprints: bool = False

    @classmethod
    def of(cls, forme: Forme, code: Content, compact: bool, grey_dots: bool = False) -> Page:
        """The page of a sheet and what is around it; where there is more than the sheet, its art ends with the bleed.

        code       where the operators go
        grey_dots  dots that have scans, and all below them, are one image
        """
        page = cls(_letters.faces(forme.layers), code, compact)
        um, out = UM / POINT, forme.slug
        page.code.append(f"{um:.12f} 0 0 {-um:.12f} {number(out / POINT, 9)} {(forme.size[1] - out) / POINT:.9f} cm")
        if forme.slug:
            low, (width, height) = -forme.bleed, (side + 2 * forme.bleed for side in forme.sheet.size)
            page.code.append("q\n" + " ".join(number(1000 * edge, 0) for edge in (low, low, width, height)) + " re W n")
        layers = forme.sheet.layers
        grey = [k for k, layer in enumerate(layers, 1) if isinstance(layer.art, Marks) and scanned(layer.art)] if grey_dots else []
        if grey:
            page._greyed(Sheet(forme.sheet.size, layers[: grey[-1]]))
        for layer in layers[max(grey, default=0) :]:
            page._add(layer)
        if forme.slug:
            page.code.append("Q")
        for layer in forme.around:
            page._add(layer)
        return page

    def resources(self, pdf: pikepdf.Pdf) -> pikepdf.Dictionary:
        """All that the operators name, as objects of the file."""
        fonts = {f"/{key}": _dotfont.resource(pdf, font) for key, font in self.dots.items()}
        for key, font in self.dots.items():
            fonts[f"/{key}"].DescendantFonts[0].FontDescriptor.CIDSet = _letters.cid_set(pdf, font.count + 1)
        fonts |= {f"/{face.key}": _letters.resource(pdf, face) for face in self.faces.values()}
        kinds: dict[str, dict[str, pikepdf.Object]] = {
            "Font": fonts,
            "ColorSpace": {f"/{key}": _separation(ink) for key, ink in self.spots.items()},
            "XObject": {f"/{key}": _mask(pdf, bitmap) for key, bitmap in self.images.items()}
            | ({f"/{GREY}": _image(pdf, *self.grey)} if self.grey else {}),
            "ExtGState": {f"/{OVER}": pikepdf.Dictionary(Type=pikepdf.Name.ExtGState, OP=True, op=True, OPM=1)} if self.overprints else {},
        }
        sets = ["/PDF", *(["/Text"] if fonts else []), *(["/ImageB"] if self.images or self.grey else [])]
        found = {f"/{kind}": pikepdf.Dictionary(named) for kind, named in kinds.items() if named}
        return pikepdf.Dictionary({"/ProcSet": pikepdf.Array([pikepdf.Name(name) for name in sets]), **found})

    def _add(self, layer: Layer) -> None:
        """A layer's operators. Pixels have no outlines for a pen."""
        ink, art = layer.ink, layer.art
        self.overprints |= ink.overprint
        self.code.append(f"q\n/{OVER} gs" if ink.overprint else "q")
        if layer.fill is None:
            self.code.append(self._colour(ink))
        if layer.fill is not None and isinstance(art, Paths):
            self._filled(art, layer.fill, ink.overprint)
        elif isinstance(art, Words):
            self._words(art, stroked=ink.pen is not None)
        elif isinstance(art, Bitmap) and ink.pen is None:
            self._bitmap(art)
        elif self.compact and ink.pen is None and isinstance(art, Marks) and _dotfont.takes(art):
            text, fonts = _dotfont.typeset(art)
            self.code.extend([text])
            self.dots |= {font.key: font for font in fonts}
        else:
            paint = "f" if ink.pen is None else "S"
            self.code.extend([f"q\n{pdf_path(paths)}{paint}\nQ"] for paths in chunks(art))
        self.code.append("Q")

    def _colour(self, ink: Ink) -> str:
        """The operators that choose the ink."""
        stroke = ink.pen is not None
        if ink.spot or registers(ink):
            key, (share,) = self._spot(ink), shares(ink).values() if ink.spot else (1.0,)
            said = f"/{key} {'CS' if stroke else 'cs'} {number(share, 4)} {'SCN' if stroke else 'scn'}"
        else:
            said = _process(ink.cmyk, ink.overprint)
            said = said.upper() if stroke else said
        return said if ink.pen is None else f"{said} {number(ink.pen * 1000)} w 1 J 1 j"

    def _spot(self, ink: Ink) -> str:
        """What the page calls a spot ink."""
        if registers(ink):
            self.spots[ALL] = ink
            return ALL
        named = [key for key, known in self.spots.items() if known.name == ink.name]
        key = named[0] if named else f"Spot{len(self.spots) + 1}"
        self.spots.setdefault(key, ink)
        return key

    def _filled(self, art: Paths, fill: Array, overprints: bool) -> None:
        """Rings in colours of their own, as many at once as follow each other in the same."""
        bounds = [0, *(np.flatnonzero((fill[1:] != fill[:-1]).any(axis=1)) + 1).tolist(), len(art)]
        for lo, hi in pairwise(bounds):
            self.code.append(_process(fill[lo].tolist(), overprints))
            self.code.extend([f"q\n{pdf_path(paths)}f\nQ"] for paths in chunks(art.take(np.arange(lo, hi))))

    def _words(self, words: Words, *, stroked: bool) -> None:
        """Lines of text, upright on a page whose y goes down."""
        if words.font not in self.faces:
            return
        face = self.faces[words.font]
        self.code.append("BT" if not stroked else "BT\n1 Tr")
        for line, (x, y), size in zip(words.text, words.xy.tolist(), words.size.tolist(), strict=True):
            place = f"{number(1000 * x, 0)} {number(1000 * y, 0)}"
            self.code.append(f"/{face.key} {number(1000 * size, 0)} Tf 1 0 0 -1 {place} Tm {face.shown(line)} TJ")
        self.code.append("ET")

    def _greyed(self, sheet: Sheet) -> None:
        """Layers as an image of grey pixels. It hides nothing, as it is the lowest, and needs no transparency, which old standards lack."""
        try:
            made = _bitmap.page(sheet, _bitmap.USUAL, bilevel=False)
        except ValueError:
            raise ValueError(
                f"grey-dots make too many pixels of {_bitmap.USUAL:g} dpi of this sheet; leave it out, or draw smaller"
            ) from None
        if made.channels != 1:
            raise ValueError(
                "grey-dots in a PDF are grey, and there is ink with a colour among or below them; leave it out, or save a TIFF"
            )
        packer = zlib.compressobj(6)
        parts = [packer.compress(rows.data) for rows in _bitmap.bands(sheet, made)]
        self.grey = made, b"".join([*parts, packer.flush()])
        width, height = (number(count * INCH / made.dpi, 9) for count in (made.width, made.height))
        self.code.append(f"q\n1000 0 0 1000 0 0 cm\n{width} 0 0 -{height} 0 {height} cm\n/{GREY} Do\nQ")

    def _bitmap(self, bitmap: Bitmap) -> None:
        """Pixels as a mask that the ink is painted through; in mm, as PDF/A's fractions end at 32767."""
        key = next((key for key, known in self.images.items() if known is bitmap), f"Pixels{len(self.images) + 1}")
        self.images[key] = bitmap
        x, y = (number(1000 * edge, 0) for edge in bitmap.corner.tolist())
        width, height = (number(side, 9) for side in bitmap.size)
        self.code.append(f"1000 0 0 1000 {x} {y} cm\n{width} 0 0 -{height} 0 {height} cm\n/{key} Do")


def _process(cmyk: Sequence[float], overprints: bool) -> str:
    """The operator that fills with shares of the process inks; grey is the black plate alone, which RGB black is not.

    What overprints is said as four shares, of which those of 0 leave what is below: grey would take it away.
    """
    if not any(cmyk[:3]) and not overprints:
        return f"{number(1 - cmyk[3], 4)} g"
    return f"{' '.join(number(share, 4) for share in cmyk)} k"


def _separation(ink: Ink) -> pikepdf.Array:
    """The colour space of a spot ink, whose looks are four shares of the process inks; every plate looks black."""
    every = registers(ink)
    look = {"C0": [1.0], "C1": [0.0]} if every else {"C0": [0.0] * 4, "C1": list(ink.cmyk)}
    tint = pikepdf.Dictionary({"/FunctionType": 2, "/Domain": [0, 1], "/N": 1, **{f"/{key}": value for key, value in look.items()}})
    space = pikepdf.Name.DeviceGray if every else pikepdf.Name.DeviceCMYK
    return pikepdf.Array([pikepdf.Name.Separation, pikepdf.Name(f"/{ALL if every else ink.name}"), space, tint])


def _image(pdf: pikepdf.Pdf, made: _bitmap.Page, packed: bytes) -> pikepdf.Object:
    """Grey pixels as an image, 255 is paper."""
    return pdf.make_stream(
        packed,
        Type=pikepdf.Name.XObject,
        Subtype=pikepdf.Name.Image,
        Width=made.width,
        Height=made.height,
        ColorSpace=pikepdf.Name.DeviceGray,
        BitsPerComponent=8,
        Filter=pikepdf.Name.FlateDecode,
    )


def _mask(pdf: pikepdf.Pdf, bitmap: Bitmap) -> pikepdf.Object:
    """The pixels as an image mask, 1 is ink.

    Deflated: of 93 Mpx of dots at 2400 dpi 387 kB. Group 4 makes 103 kB of them, and Pillow, which packs it, takes a
    byte a pixel.
    """
    return pdf.make_stream(
        zlib.compress(bitmap.bits.tobytes(), 6),
        Type=pikepdf.Name.XObject,
        Subtype=pikepdf.Name.Image,
        Width=bitmap.width,
        Height=len(bitmap.bits),
        ImageMask=True,
        BitsPerComponent=1,
        Decode=[1, 0],
        Filter=pikepdf.Name.FlateDecode,
    )
