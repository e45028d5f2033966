"""Check print files, PDF or SVG, before they go to press: structure checked, rule by rule.

Exit code 1 where there are errors, 2 where a file cannot be read; the others are checked all the same. What is not named by --pdfx
or --pdfa is held to what it claims.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from crowquill import preflight, units
from crowquill.commands import REFUSED, plain, refused, say
from crowquill.options import lengths
from crowquill.vector import contents

FOUND = 1  # exit code where there are errors
PRESS = "What the press bears"
SAFE = "5mm on a paper's size or with a bleed, and else 0"  # the default


class Standard(StrEnum):
    """The kinds of PDF/X that there are rules for."""

    x1a = "x1a"
    x3 = "x3"
    x4 = "x4"


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("check", help=__doc__, no_args_is_help=True)(_checked)


def _length(words: str, parser: Callable[[Any], float]) -> typer.models.OptionInfo:
    option: typer.models.OptionInfo = typer.Option(help=words, parser=parser, metavar="LENGTH", rich_help_panel=PRESS)
    return option


def _over(text: Any) -> float:
    """A length over 0."""
    if (value := lengths(text)) <= 0:
        raise typer.BadParameter(f"length {text!r} must be over 0")
    return value


def _least(text: Any) -> float:
    """A length of 0 or more."""
    if (value := lengths(text)) < 0:
        raise typer.BadParameter(f"length {text!r} must be 0 or more")
    return value


def _paper(text: str) -> tuple[float, float]:
    try:
        return units.paper(text)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="'--size'") from None


def _checked(
    files: Annotated[list[Path] | None, typer.Argument(help="PDF or SVG.", show_default=False, metavar="FILE...")] = None,
    pdfx: Annotated[Standard | None, typer.Option(help="Hold PDFs to PDF/X-1a, X-3 or X-4.")] = None,
    pdfa: Annotated[bool, typer.Option("--pdfa", help="Hold PDFs to PDF/A.")] = False,
    size: Annotated[str | None, typer.Option(help="The trim that is expected: a4, 120x80mm.", metavar="PAPER")] = None,
    spots: Annotated[str | None, typer.Option(help="The only spot inks that may be used.", metavar="NAME,NAME")] = None,
    min_dot: Annotated[str, _length("Warn of smaller dots; half of it is an error.", _over)] = "0.1mm",
    min_gap: Annotated[str, _length("Warn of less white between marks.", _over)] = "0.1mm",
    min_line: Annotated[str, _length("Warn of thinner lines; half of it is an error.", _over)] = "0.1mm",
    min_text: Annotated[str, _length("Warn of smaller sizes of fonts.", _over)] = "5pt",
    safe: Annotated[str | None, _length(f"Warn of art nearer to the trim; {SAFE}.", _least)] = None,
    max_ink: Annotated[float, typer.Option(help="Most ink in one place, in percent.", min=0, max=10_000, rich_help_panel=PRESS)] = 280,
    min_ppi: Annotated[float, typer.Option(help="Least pixels to the inch of bitmaps.", min=1, max=100_000, rich_help_panel=PRESS)] = 300,
    min_ppi_line: Annotated[float, typer.Option(help="The same for one bit.", min=1, max=100_000, rich_help_panel=PRESS)] = 600,
    max_elements: Annotated[int, typer.Option(help="Most operators or elements.", min=1, rich_help_panel=PRESS)] = 1_000_000,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
    rules: Annotated[bool, typer.Option("--rules", help="List the rules.")] = False,
) -> int:
    if rules:
        say("\n".join(_rules()))
        return 0
    if not files:
        raise ValueError("there is no file to check; name a PDF or an SVG")
    numbers = {"min_dot": min_dot, "min_gap": min_gap, "min_line": min_line, "min_text": min_text}
    limits = preflight.Limits(
        **{key: float(value) for key, value in numbers.items()},
        safe=float(safe) if safe is not None else None,
        max_ink=max_ink,
        min_ppi=min_ppi,
        min_ppi_line=min_ppi_line,
        max_elements=max_elements,
        spots=tuple(name.strip() for name in spots.split(",")) if spots is not None else None,
        size=_paper(size) if size is not None else None,
    )
    checked: list[preflight.Checked] = []
    refusals: list[Exception] = []
    for path in files:
        try:
            checked.append(preflight.check(contents(path), str(path), limits, pdfx=pdfx.value if pdfx else None, pdfa=pdfa))
        except (ValueError, OSError) as error:
            refusals.append(error)
    if checked and as_json:
        say(json.dumps([_facts(one) for one in checked], indent=2, allow_nan=False))
    elif checked:
        say("\n".join(line for one in checked for line in _table(one)))
    for refusal in refusals:
        refused(refusal)
    if refusals:
        return REFUSED
    return FOUND if any(one.errors for one in checked) else 0


def _facts(checked: preflight.Checked) -> dict[str, object]:
    return {
        "file": checked.name,
        "held_to": list(checked.held),
        "structure_checked": True,
        "errors": checked.errors,
        "findings": [asdict(finding) for finding in checked.findings],
    }


def _table(checked: preflight.Checked) -> list[str]:
    """A line for the file, and one for each finding."""
    names = {"x1a": "PDF/X-1a", "x3": "PDF/X-3", "x4": "PDF/X-4", "a": "PDF/A"}
    held = " and ".join(names[kind] for kind in checked.held) or "the general rules"
    warnings = sum(finding.severity == preflight.WARNING for finding in checked.findings)
    lines = [plain(f"{checked.name}: structure checked by {held}: {checked.errors} errors, {warnings} warnings")]
    for found in checked.findings:
        lines.append(plain(f"  {found.severity:<11}  {found.rule:<15}  {found.where}: {found.message}"))
    return lines


def _rules() -> list[str]:
    """A line a rule: its name, its severity, what it is for, what it asks."""
    lines = []
    for one in preflight.RULES.values():
        on = {"pdf": "PDF", "svg": "SVG", "drawing": "PDF, SVG"}[one.on] if not one.kinds else ", ".join(one.kinds)
        lines.append(f"{one.name:<15}  {one.severity:<11}  {on:<14}  {one.about}")
    return lines
