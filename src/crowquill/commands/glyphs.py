"""Libraries of dots: made from a scan of ink, listed, shown on a page."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import typer

from crowquill import contact, formats, glyphs
from crowquill.commands import note, say
from crowquill.options import lengths

OVERWRITE = Annotated[bool, typer.Option(help="Replace files that are there.")]


def add(app: typer.Typer) -> None:
    """Adds the group of commands."""
    group = typer.Typer(no_args_is_help=True, help=__doc__)
    for name, function in (("scan", _scanned), ("list", _listed), ("show", _shown)):
        group.command(name, no_args_is_help=name != "list")(function)
    app.add_typer(group, name="glyphs")


def _scanned(
    scan: Annotated[Path, typer.Argument(help="The page: PNG, JPEG, TIFF.", show_default=False, metavar="SCAN")],
    out: Annotated[Path, typer.Option("--out", "-o", help="The library to write: an SVG.", metavar="FILE")],
    dpi: Annotated[float | None, typer.Option(help="Pixels to the inch; the file's own, or a ruler's, when left out.")] = None,
    invert: Annotated[bool, typer.Option("--invert", help="The page is a negative: white dots on black.")] = False,
    pen: Annotated[
        float | None, typer.Option(help="Width of the pen; the mean diameter when left out.", parser=lengths, metavar="LENGTH")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the library; the file's when left out.")] = None,
    source: Annotated[str | None, typer.Option(help="Who drew the dots, with what, on what.")] = None,
    licence: Annotated[str, typer.Option(help="Who may use them.")] = "not stated",
    show: Annotated[Path | None, typer.Option(help="Draw the page with what was found and rejected.", metavar="FILE")] = None,
    overwrite: OVERWRITE = True,
) -> int:
    """Make a library of a scanned page of single ink dots: outlines, true diameters and greys.

    Scan at 1200 dpi. A photograph will do with a ruler on the page.
    """
    from crowquill.glyphs import scanning

    if out.suffix.lower() != ".svg":
        raise ValueError(f"{out}: a glyph library is an SVG; give a name that ends in .svg")
    targets = [out, *([show] if show else [])]
    if show:
        formats.module(show.suffix[1:].lower(), str(show))
    formats.check(targets, overwrite=overwrite, sources=[scan])
    found = scanning.scan(scan, dpi=dpi, invert=invert)
    mean = float(found.diameters.mean())
    word = re.sub("[^A-Za-z0-9.-]+", "-", out.stem).lstrip("-.0123456789")[:64]
    about: dict[str, Any] = {"simulated": False, "source": source or f"scan {scan.name}", "licence": licence}
    data = scanning.library(found, name=name or word or "dots", pen_mm=round(mean, 2) if pen is None else pen, about=about)
    plan: list[tuple[Path, Callable[[BinaryIO], object]]] = [(out, lambda file: file.write(data))]
    if show:
        plan += zip([show], formats.writers(contact.of_scan(found), [(show, None)], {}), strict=True)
    formats.replace_files(plan)
    for warning in found.warnings:
        note(warning)
    reasons = ", ".join(f"{count} {reason}" for reason, count in sorted(found.counts.items()))
    spread = found.diameters.std() / mean
    say(
        f"{len(found.diameters)} dots of {mean:.3f} mm (spread {spread:.1%}) at {found.dpi:g} dpi"
        f"{f'; rejected: {reasons}' if reasons else ''}: {out}"
    )
    return 0


def _listed() -> int:
    """List the libraries that come along: their names, dots, pens, and how they were made."""
    for name in glyphs.names():
        about = glyphs.load(name).about
        made = "simulated" if about.get("simulated") else "scanned"
        say(f"{name:<10} {about['count']:>4} dots  pen {about['pen_mm']:g} mm  {made}  {about['licence']}")
    return 0


def _shown(
    library: Annotated[str, typer.Argument(help="A library by its name, or an SVG file.", show_default=False, metavar="NAME|FILE")],
    out: Annotated[list[Path], typer.Option("--out", "-o", help="The page to write: .pdf, .svg, .png; may be repeated.", metavar="FILE")],
    overwrite: OVERWRITE = True,
) -> int:
    """Draw a library as a page: every dot enlarged with its diameter, and at true size."""
    for path in out:
        formats.module(path.suffix[1:].lower(), str(path))
    file = Path(library)
    formats.check(out, overwrite=overwrite, sources=[file] if file.suffix else [])
    sheet = contact.of_library(glyphs.load(library))
    formats.save(sheet, *out)
    say(f"{library} on {sheet.size[0]:g} x {sheet.size[1]:g} mm: {', '.join(map(str, out))}")
    return 0
