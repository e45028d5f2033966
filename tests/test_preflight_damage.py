"""Damaged files: a rule that cannot look says so, a refusal names the file, and the same bytes are told of in the same words."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pikepdf
import pytest
from pikepdf import Array, Name
from presses import broken, faults, found, good, page

from crowquill import preflight
from crowquill.__main__ import main
from crowquill.preflight import ERROR, RULES
from crowquill.preflight.rules import Hit, Limits, Rule, run
from crowquill.preflight.values import real, text, told

KINDS = ["plain", "x1a", "x3", "x4", "a"]
NAME = pikepdf.Object.parse(b"/Fl#84te")


def test_a_number_that_is_text_is_a_finding_of_its_rule() -> None:
    def breaks(pdf: pikepdf.Pdf) -> None:
        pdf.Root.OutputIntents[0].DestOutputProfile.N = pikepdf.String("four")

    for kind in ("x1a", "x4", "a"):
        (hit,) = found(broken(kind, breaks))["profile"]
        assert hit.severity == ERROR and "0 channels" in hit.message


def _fails(_: Any, __: Limits) -> Iterator[Hit]:
    yield Hit("page 1", "something")
    raise RuntimeError("stream <_io.BytesIO object at 0x7f83>: lost")


def test_a_rule_that_fails_says_so_beside_what_it_found(monkeypatch: pytest.MonkeyPatch) -> None:
    for on, data, name in (("pdf", good("plain"), "a.pdf"), ("drawing", good("plain"), "a.pdf"), ("svg", b"", "")):
        monkeypatch.setitem(RULES, "odd", Rule("odd", "information", on, (), "", _fails))
        findings = preflight.check(data, name).findings if data else run(on, None, Limits())
        one, other = sorted((finding for finding in findings if finding.rule == "odd"), key=lambda finding: finding.severity)
        assert (one.severity, other.severity) == (ERROR, "information")
        assert one.message == "this rule could not look: RuntimeError: lost"


def changed(data: bytes, chance: random.Random) -> bytes:
    """The same with some bytes changed, or a few of its words put in each other's place, or cut off."""
    letters, kind = bytearray(data), chance.randrange(3)
    for _ in range(chance.choice([1, 5, 30])):
        letters[chance.randrange(len(letters))] = chance.randrange(256)
    if kind == 1:
        spans = [found_.span() for found_ in re.finditer(rb"/[A-Za-z]+|\d+ 0 R|\[[^\[\]]*\]|\([^()]*\)", bytes(letters))]
        for _ in range(4):
            (a, b), (c, d) = chance.choice(spans), chance.choice(spans)
            letters[a:b] = bytes(letters[c:d])[: b - a].ljust(b - a)
    return bytes(letters[: chance.randrange(len(letters))] if chance.random() < 0.1 else letters)


@pytest.mark.parametrize("kind", KINDS)
def test_changed_bytes_end_in_findings_or_a_refusal_that_names_the_file(kind: str) -> None:
    chance, data = random.Random(KINDS.index(kind)), good(kind)
    for _ in range(25):
        try:
            checked = preflight.check(changed(data, chance), "plate.pdf")
        except ValueError as error:
            assert str(error).startswith("plate.pdf: ") and "\n" not in str(error) and " at 0x" not in str(error)
        else:
            said = json.dumps([[one.message, one.value] for one in checked.findings], allow_nan=False)
            assert " at 0x" not in said


def test_names_that_are_no_utf_8_are_told_as_they_are_written() -> None:
    assert text(NAME) == "/Fl#84te" and text(Name.DeviceGray) == "/DeviceGray"
    assert text(pikepdf.String("plate")) == "plate" and text(None) == text(Array([])) == ""
    breaks: list[Callable[[pikepdf.Pdf], Any]] = [
        lambda pdf: pdf.Root.OutputIntents[0].__setitem__("/S", NAME),
        lambda pdf: pdf.docinfo.__setitem__("/Trapped", NAME),
        lambda pdf: pdf.docinfo.__setitem__("/GTS_PDFXVersion", NAME),
        lambda pdf: pdf.Root.__setitem__("/Odd", pdf.make_stream(b"", Filter=NAME)),
        lambda pdf: pdf.pages[0].obj.__setitem__("/Group", pikepdf.Dictionary(S=Name.Transparency, CS=NAME)),
    ]
    for one in breaks:
        every = preflight.check(broken("x1a", one), "plate.pdf", pdfx="x1a").findings
        assert every and not any("could not look" in found_.message for found_ in every)


def test_numbers_that_are_none_are_the_other_one() -> None:
    assert real(pikepdf.String("x"), 1.5) == real(Array([]), 1.5) == real(None, 1.5) == real(10**400, 1.5) == 1.5
    assert real(3, 0.0) == 3


def test_no_address_of_the_memory_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert told(ValueError("stream <_io.BytesIO object at 0x7f83>: file\n is damaged")) == "file is damaged"
    file = tmp_path / "plate.pdf"
    data = good("plain")
    file.write_bytes(data[: data.rindex(b"startxref") - 50])
    printed = []
    for _ in range(2):
        assert main(["check", str(file), "--json"]) == 1
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1] and "0x" not in printed[0] and "damaged" in printed[0]
    assert ("damage", ERROR) in faults(file.read_bytes())


# the command


def test_what_was_found_is_printed_though_another_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sound, none = tmp_path / "sound.pdf", tmp_path / "none.pdf"
    sound.write_bytes(page("0 w 20 20 m 40 40 l S"))
    for order in ([sound, none], [none, sound]):
        assert main(["check", *map(str, order)]) == 2
        out, err = capsys.readouterr()
        assert "min-line" in out and err.count("\n") == 1 and "none.pdf" in err
        assert main(["check", "--json", *map(str, order)]) == 2
        assert [Path(one["file"]).name for one in json.loads(capsys.readouterr().out)] == ["sound.pdf"]


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        ("--min-dot -1mm", "over 0"),
        ("--min-gap 0mm", "over 0"),
        ("--min-line -0.1mm", "over 0"),
        ("--min-text 0pt", "over 0"),
        ("--safe -1mm", "0 or more"),
        ("--size banana", "no paper 'banana'"),
    ],
)
def test_a_limit_that_is_none_is_refused_with_the_name_of_its_option(
    words: str, cause: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "plate.pdf"
    file.write_bytes(good("plain"))
    assert main(["check", str(file), *words.split()]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and words.split()[0] in err and cause in err
