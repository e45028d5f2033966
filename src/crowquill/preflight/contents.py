"""Rules for what a PDF's pages use: colour spaces, spot inks, transparency, layers, states, fonts; and content that does not run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pikepdf

from crowquill.preflight.document import Document, Page, TooLarge, unpacked
from crowquill.preflight.drawing import EVERY, Box
from crowquill.preflight.rules import ERROR, WARNING, Hit, Limits, X, rule
from crowquill.preflight.structure import INTENTS, strict
from crowquill.preflight.values import text

SHOWN = 3  # of a sort are named
HARMLESS = {"/TrapNet", "/PrinterMark"}  # annotations that are the printer's own
CALIBRATED = ("ICCBased", "CalRGB", "CalGray", "Lab")
PROFILES = {b"GRAY": "DeviceGray", b"RGB ": "DeviceRGB", b"CMYK": "DeviceCMYK"}


def _met(document: Document, sort: str, words: str, severity: str | None = None) -> Iterator[Hit]:
    """A hit for each page on which something of a sort was met."""
    for page in document.pages:
        found = page.met.all(sort)
        if found:
            more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
            yield Hit(page.where, f"{words}{', '.join(list(found)[:SHOWN])}{more}", sum(found.values()), severity)


@rule("content", ERROR, "pdf")
def content(document: Document, _: Limits) -> Iterator[Hit]:
    """All content can be run: nothing is cut off, unknown, missing or goes round in a circle."""
    yield from _met(document, "content", "it has ")


@rule("limits", ERROR, "pdf")
def limits(document: Document, _: Limits) -> Iterator[Hit]:
    """All content was looked at: there is not more of it than anybody could print."""
    yield from _met(document, "limits", "it was not looked at wholly: ")


@rule("colour-spaces", ERROR, "pdf", *X, "a")
def spaces(document: Document, _: Limits) -> Iterator[Hit]:
    """Colours are of spaces that the standard knows, and device colours are those of the output intent."""
    output = _output(document)
    for page in document.pages:
        bad = [label for label in page.spaces if _wrong(label, document, page, output)]
        if bad:
            yield Hit(page.where, f"it uses {', '.join(sorted(bad))}", sorted(bad))


def _output(document: Document) -> str | None:
    """The device space of the output intent: of its profile, or CMYK for a condition of the registry; None where that is not known."""
    kinds = {kind for kind, held in INTENTS.items() if document.held & set(held)}
    found = [one for one in document.intents if text(one.get("/S")) in kinds]
    if not found:
        return None
    stream = found[0].get("/DestOutputProfile")
    if not isinstance(stream, pikepdf.Stream):
        return "DeviceCMYK"
    try:
        return PROFILES.get(unpacked(stream)[16:20])
    except (TooLarge, pikepdf.PdfError):
        return None


def _wrong(label: str, document: Document, page: Page, output: str | None) -> bool:
    """Whether a space breaks the standard."""
    if "x1a" in document.held:
        return any(space in label for space in (*CALIBRATED, "DeviceRGB"))
    for space in ("DeviceRGB", "DeviceCMYK") if output else ():
        if label.endswith(space) and space != output and f"/Default{space[6:]}" not in page.defaults:
            return True
    return False


@rule("transparency", ERROR, "pdf", "x1a", "x3", "a")
def transparency(document: Document, _: Limits) -> Iterator[Hit]:
    """Nothing is transparent, where the standard has none."""
    if document.held & {"x1a", "x3"} or document.part == 1:
        yield from _met(document, "transparency", "it has ")


@rule("blend-space", ERROR, "pdf", "x4")
def blend_space(document: Document, _: Limits) -> Iterator[Hit]:
    """Transparency blends in the colours of the output intent."""
    output = _output(document)
    for page in document.pages:
        bad = [
            space
            for space in page.met.all("blends")
            if space != output and output and not (space == "DeviceGray" and output == "DeviceCMYK")
        ]
        if bad:
            yield Hit(page.where, f"it blends in {', '.join(bad)}, and is printed in {output}", bad)


@rule("layers", ERROR, "pdf", "x1a", "x3", "a")
def layers(document: Document, _: Limits) -> Iterator[Hit]:
    """There are no layers to be turned on and off, where the standard has none."""
    if document.held & {"x1a", "x3"} or document.part == 1:
        if "/OCProperties" in document.pdf.Root:
            yield Hit("file", "it has layers that can be turned off")
        else:
            yield from _met(document, "layers", "it has optional content: ")


@rule("transfer", ERROR, "pdf")
def transfer(document: Document, _: Limits) -> Iterator[Hit]:
    """No state has a transfer function, which changes tones behind everybody's back."""
    yield from _met(document, "transfer", "it has ", strict(document))


@rule("halftones", ERROR, "pdf", *X, "a")
def halftones(document: Document, _: Limits) -> Iterator[Hit]:
    """No state has a halftone by name, or a phase of one: screening is the printer's."""
    yield from _met(document, "halftones", "it has ")


@rule("postscript", ERROR, "pdf")
def postscript(document: Document, _: Limits) -> Iterator[Hit]:
    """There is no PostScript among what is drawn."""
    yield from _met(document, "postscript", "", strict(document))


@rule("replaced", ERROR, "pdf", *X)
def replaced(document: Document, _: Limits) -> Iterator[Hit]:
    """No bitmap or form is to be replaced by another when it is printed: no OPI, no alternates."""
    yield from _met(document, "opi", "")
    yield from _met(document, "alternates", "")


@rule("fonts", ERROR, "pdf")
def fonts(document: Document, _: Limits) -> Iterator[Hit]:
    """Every font is embedded, the base 14 too; one that is named and shows nothing is a fault of standards alone."""
    for page in document.pages:
        missing = [name for name, embedded in page.met.fonts.items() if not embedded]
        used = [name for name in missing if name in page.met.shown]
        idle = [name for name in missing if name not in page.met.shown]
        if used:
            yield Hit(page.where, f"fonts are used that are not embedded: {', '.join(used)}", used)
        if idle:
            yield Hit(page.where, f"fonts are named that are not embedded: {', '.join(idle)}", idle, strict(document))


@rule("spots", ERROR, "pdf")
def spots(document: Document, limits: Limits) -> Iterator[Hit]:
    """Spot inks are on the list of --spots, where there is one."""
    for page in document.pages:
        bad = [name for name in page.spots if limits.spots is not None and name not in limits.spots]
        if bad:
            yield Hit(page.where, f"spot inks that are not on the list: {', '.join(bad)}", bad)


@rule("spot-mixtures", ERROR, "pdf")
def mixtures(document: Document, _: Limits) -> Iterator[Hit]:
    """A spot ink has one mixture that stands for it, in the whole file, and one that can be worked out."""
    every: dict[str, set[str]] = {}
    for page in document.pages:
        for name, mixes in page.spots.items():
            every.setdefault(name, set()).update(mixes)
    for name, mixes in every.items():
        if len(mixes) > 1:
            yield Hit("file", f"spot ink {name} is mixed in {len(mixes)} ways", len(mixes))
    yield from _met(document, "tints", "spot ink ")


@rule("registration", WARNING, "pdf")
def registration(document: Document, _: Limits) -> Iterator[Hit]:
    """Registration colour, which is on every plate, is kept for marks outside the trim."""
    for page in document.pages:
        art, (left, top, right, bottom) = page.drawing.art, page.drawing.trim
        every = np.array([one.space == EVERY and not one.white for one in art.colours] + [False])
        a, b, c, d = art.boxes.T
        shown = (every[art.fill] | every[art.stroke])[art.thing]
        count = int((shown & (a < right) & (c > left) & (b < bottom) & (d > top)).sum())
        if count:
            yield Hit(page.where, f"{count} marks inside the trim are in registration colour", count)


@rule("annotations", ERROR, "pdf")
def notes(document: Document, _: Limits) -> Iterator[Hit]:
    """No annotation lies within the bleed, where it might be printed."""
    for page in document.pages:
        found = [kind for kind, box in page.notes if kind not in HARMLESS and _meets(box, page.drawing.bleed)]
        if found:
            said = ", ".join(sorted({kind[1:] for kind in found}))
            yield Hit(page.where, f"{len(found)} annotations lie within the bleed ({said})", len(found), strict(document))


def _meets(box: Box, other: Box) -> bool:
    return box[0] < other[2] and box[2] > other[0] and box[1] < other[3] and box[3] > other[1]
