"""Measure a drawing, by itself or against its picture; two drawings side by side.

Drawings are SVG, ours or any of dots, or bitmaps with their dpi.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import figure, formats, judge, options, seen
from crowquill.commands import note, say

ROWS = (  # what is said of a drawing: the words, where in the facts it is, and how it is written
    ("dots", ("dots",), "{:d}"),
    ("diameter, mean mm", ("diameters", "mean_mm"), "{:.4f}"),
    ("diameter, spread", ("diameters", "cv"), "{:.3f}"),
    ("coverage", ("ink", "coverage"), "{:.4f}"),
    ("ink mm2", ("ink", "ink_mm2"), "{:.1f}"),
    ("overlap", ("ink", "overlap"), "{:.4f}"),
    ("nearest neighbour, mean mm", ("spacing", "nearest"), "{:.4f}"),
    ("nearest neighbour, least mm", ("spacing", "nearest_least"), "{:.4f}"),
    ("gap, least mm", ("spacing", "gap"), "{:.4f}"),
    ("evenness (rho)", ("spacing", "evenness"), "{:.4f}"),
    ("capacity error (CV)", ("spacing", "capacity_cv"), "{:.4f}"),
    ("normalised Poisson radius", ("spacing", "alpha"), "{:.4f}"),
    ("hexagons", ("spacing", "hexagons"), "{:.4f}"),
    ("spectrum, peak", ("spacing", "power"), "{:.3f}"),
    ("spectrum, at cycles a spacing", ("spacing", "frequency"), "{:.3f}"),
    ("spectrum, low", ("spacing", "low_power"), "{:.4f}"),
    ("anisotropy dB", ("spacing", "anisotropy"), "{:.1f}"),
    ("pair correlation, peak", ("spacing", "pair_peak"), "{:.3f}"),
    ("quadrature, smooth", ("spacing", "quadrature", 0), "{:.5f}"),
    ("quadrature, edges", ("spacing", "quadrature", 1), "{:.5f}"),
    ("quadrature, polynomials", ("spacing", "quadrature", 2), "{:.5f}"),
    ("  of random dots, smooth", ("spacing", "random", 0), "{:.5f}"),
    ("  of a square grid, smooth", ("spacing", "regular", 0), "{:.5f}"),
    ("correlation one spacing off", ("texture", "near"), "{:.3f}"),
    ("correlation two spacings off", ("texture", "far"), "{:.3f}"),
    ("reads as", ("texture", "verdict"), "{}"),
    ("tone, blur of a spacing, bias", ("tone", "blurs", 0, "bias"), "{:+.4f}"),
    ("tone, blur of a spacing, rmse", ("tone", "blurs", 0, "rmse"), "{:.4f}"),
    ("tone, worst band", ("tone", "blurs", 0, "worst_band", "bias"), "{:+.4f}"),
    ("tone, 8 px of 1000, rmse", ("tone", "scored"), "{:.4f}"),
    ("structural similarity", ("tone", "ssim"), "{:.4f}"),
    ("edges kept", ("tone", "edges_kept"), "{:.3f}"),
    ("shift x mm", ("tone", "shift_mm", 0), "{:+.4f}"),
    ("shift y mm", ("tone", "shift_mm", 1), "{:+.4f}"),
)


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("measure", help=__doc__, no_args_is_help=True)(options.lit(_measured))


def _measured(
    drawings: Annotated[list[Path], typer.Argument(help="One drawing, or two.", show_default=False, metavar="FILE [FILE]")],
    against: Annotated[Path | None, typer.Option(help="The picture that was drawn.", metavar="PICTURE")] = None,
    dpi: Annotated[float | None, typer.Option(help="Pixels to the inch of a bitmap; its own when left out.", min=10, max=100_000)] = None,
    report: Annotated[Path | None, typer.Option(help="Write all figures as JSON; - prints them.", metavar="FILE")] = None,
    show: Annotated[Path | None, typer.Option("--figure", help="Draw them as a page: .pdf, .svg, .png.", metavar="FILE")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace files that are there.")] = True,
    **light: Any,
) -> int:
    if len(drawings) > 2:
        raise ValueError(f"{len(drawings)} drawings are too many side by side; give one or two")
    if against is None and any(value is not None for value in light.values()):
        raise ValueError("options of tone say how a picture is read, and there is none; give --against PICTURE")
    to_file = report is not None and str(report) != "-"
    targets = [path for path in (report if to_file else None, show) if path is not None]
    if show is not None:
        formats.module(show.suffix[1:].lower(), str(show))
    formats.check(targets, overwrite=overwrite, sources=[*drawings, *([against] if against else [])])
    judged = []
    for path in drawings:
        found = seen.load(path, dpi=dpi)
        judged.append(judge.of(found, judge.asked(found, against, light) if against else None))
    facts = [dict(one.facts) for one in judged]
    plan = []
    if report is not None and to_file:
        data = f"{_json(facts)}\n".encode()
        plan.append((report, lambda file: file.write(data)))
    if show is not None:
        plan += zip([show], formats.writers(figure.of(judged), [(show, None)], {}), strict=True)
    formats.replace_files(plan)
    for one in facts:
        for text in one["notes"]:
            note(f"{one['file']}: {text}" if len(facts) > 1 else text)
    say(_json(facts) if report is not None and not to_file else _table(facts))
    return 0


def _json(facts: list[dict[str, Any]]) -> str:
    """One drawing's figures, or a list of two."""
    return json.dumps(facts[0] if len(facts) == 1 else facts, indent=2, allow_nan=False)


def _table(facts: list[dict[str, Any]]) -> str:
    """A row a figure, a column a drawing; rows of which nothing is known are left out."""
    names = [Path(one["file"]).name[-24:] for one in facts]
    lines = ["".join([" " * 32, *(f"{name:>26}" for name in names)])] if len(facts) > 1 else []
    for words, keys, form in ROWS:
        values = [_found(one, keys) for one in facts]
        if any(value is not None for value in values):
            lines.append(f"{words:<32}" + "".join(f"{'-' if value is None else form.format(value):>26}" for value in values))
    lines += [f"{name}: {reason}" for name, one in zip(names, facts, strict=True) for reason in one["texture"]["reasons"]]
    return "\n".join(lines)


def _found(facts: Any, keys: tuple[Any, ...]) -> Any:
    """What lies behind these keys, None where a part of the way is missing."""
    for key in keys:
        if facts is None or (isinstance(facts, dict) and key not in facts):
            return None
        facts = facts[key]
    return facts
