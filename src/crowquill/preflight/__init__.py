"""Preflight: what stands between a PDF or an SVG and the press, rule by rule. Structure is checked; no file is validated.

A rule is a function of `structure` (a PDF's frame), `contents` (what its pages use), `geometry` (what is drawn, in millimetres) or
`svg`, registered with its severity and the kinds of file that it is for. A rule that cannot look says so in a finding.
"""

from __future__ import annotations

from dataclasses import dataclass

from crowquill.preflight import contents, geometry, structure, svg
from crowquill.preflight.document import Document, Page, held, opened, unsound
from crowquill.preflight.rules import ERROR, INFORMATION, RULES, WARNING, Finding, Limits, Rule, run
from crowquill.preflight.svg import opened as opened_svg
from crowquill.preflight.values import told
from crowquill.preflight.walker import page

__all__ = ["ERROR", "INFORMATION", "RULES", "WARNING", "Checked", "Finding", "Limits", "Rule", "check"]

PAGES = 100  # of a file that are looked at
MODULES = (structure, contents, geometry, svg)  # whose rules there are


@dataclass(frozen=True)
class Checked:
    """What was found in a file, errors first, and what it was held to: kinds of PDF, or nothing."""

    name: str
    held: tuple[str, ...]
    findings: tuple[Finding, ...]

    @property
    def errors(self) -> int:
        """How many findings are errors."""
        return sum(finding.severity == ERROR for finding in self.findings)


def check(data: bytes, name: str, limits: Limits | None = None, *, pdfx: str | None = None, pdfa: bool = False) -> Checked:
    """What the rules find in a PDF or an SVG.

    pdfx, pdfa  what a PDF is held to: x1a, x3, x4, PDF/A; left out, what it claims to be

    Raises ValueError for what is neither, or cannot be read.
    """
    limits = limits or Limits()
    if b"%PDF-" in data[:1024] or name.lower().endswith(".pdf"):
        return _pdf(data, name, limits, pdfx, pdfa)
    if pdfx or pdfa:
        raise ValueError(f"{name}: an SVG is no PDF/X or PDF/A; leave out the standard, or give a PDF")
    found = opened_svg(data, name)
    return _checked(name, (), run("svg", found, limits) + run("drawing", found.drawing, limits))


def _pdf(data: bytes, name: str, limits: Limits, pdfx: str | None, pdfa: bool) -> Checked:
    with opened(data, name) as pdf:
        try:
            kinds = held(pdf, pdfx, pdfa)
            pages = [Page(number, one.obj, *page(one, number)) for number, one in enumerate(pdf.pages[:PAGES], 1)]
            warnings = tuple(told(text) for text in pdf.get_warnings())
            document = Document(name, pdf, len(data), pdf.pdf_version, tuple(pages), kinds, warnings)
        except MemoryError:
            raise
        except Exception as error:  # a file of anybody's may break in any way
            raise unsound(name, error) from None
        findings = run("pdf", document, limits, kinds)
        for one_page in pages:
            findings += run("drawing", one_page.drawing, limits, kinds)
    return _checked(name, tuple(sorted(kinds)), findings)


def _checked(name: str, kinds: tuple[str, ...], findings: list[Finding]) -> Checked:
    rank = {ERROR: 0, WARNING: 1, INFORMATION: 2}
    return Checked(name, kinds, tuple(sorted(findings, key=lambda finding: rank[finding.severity])))
