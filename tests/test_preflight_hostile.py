"""PDFs that nobody should trust: each ends in a finding or a refusal of one line, never in a traceback, never without end."""

from __future__ import annotations

import io
import json
import random
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pikepdf
import pytest
from pikepdf import Array, Dictionary, Encryption, Name
from presses import add, broken, disc, faults, good, page
from reportlab.pdfgen.canvas import Canvas

from crowquill import preflight
from crowquill.__main__ import main
from crowquill.preflight import ERROR, WARNING, canvas, document, placed, structure

WORDS = b"m l c v y h f f* S s b b* n W re q Q cm w g rg k gs cs scn sc sh Do Tf Td Tm T* Tj TJ ' \" Tc Tz Tr BT ET BI ID EI BDC EMC d"
ODDS = [
    b"1",
    b"-2.5",
    b"1e9",
    b"9" * 30,
    b"--4",
    b".",
    b"/X",
    b"/",
    b"(a(b)",
    b")",
    b"<41>",
    b"<4",
    b"<<",
    b">>",
    b"[",
    b"]",
    b"{",
    b"%x\n",
]


def raw(content: bytes) -> Callable[[pikepdf.Pdf], Any]:
    return lambda pdf: pdf.pages[0].obj.__setitem__("/Contents", pdf.make_stream(content))


def itself(pdf: pikepdf.Pdf) -> None:
    form = pdf.make_stream(b"/X Do", Subtype=Name.Form, BBox=[0, 0, 9, 9])
    form.Resources = Dictionary(XObject=Dictionary(X=form))
    add(pdf, "/X Do", XObject={"X": form})


def tower(pdf: pikepdf.Pdf) -> None:
    """Forms that draw ten forms that draw ten forms: a thousand million rectangles."""
    form = pdf.make_stream(b"0 0 1 1 re f", Subtype=Name.Form, BBox=[0, 0, 9, 9])
    for _ in range(9):
        inner = Dictionary(XObject=Dictionary(X=form))
        form = pdf.make_stream(b"/X Do " * 10, Subtype=Name.Form, BBox=[0, 0, 9, 9], Resources=inner)
    add(pdf, "/X Do", XObject={"X": form})


def bomb(pdf: pikepdf.Pdf) -> None:
    pdf.pages[0].obj.Contents = pikepdf.Stream(pdf, zlib.compress(bytes(40 << 20), 9), Filter=Name.FlateDecode)


def cut(pdf: pikepdf.Pdf) -> None:
    packed = zlib.compress(b" ".join(b"%d %d m %d %d l S" % (k, k, k + 9, k) for k in range(100, 200)))
    pdf.pages[0].obj.Contents = pikepdf.Stream(pdf, packed[: len(packed) // 2], Filter=Name.FlateDecode)


CONTENT = [
    (itself, "a form that draws itself"),
    (cut, "a stream that is cut off"),
    (raw(b"q " * 100_000), "states kept without end"),
    (raw(b"[" * 100_000), "arrays in arrays"),
    (raw(b"(" * 100_000), "a string without an end"),
    (raw(b"BI /W 1 ID " + b"x" * 100), "a bitmap without an end"),
    (raw(b"0 0 m " + b"9999999999 8888888888 0 0 1 1 c " * 1000 + b"f"), "curves that go to the moon and back"),
    (raw(b"1000000000 0 0 1000000000 0 0 cm " * 40 + b"0 0 5 5 re f"), "a scale beyond all numbers"),
    (raw(b"BT [" + b"1 " * 200_000 + b"] TJ ET"), "an array of 200 000 numbers"),
    (raw(random.Random(2).randbytes(20_000)), "noise"),
    (raw(b"/Span << /ActualText (\\ BDC"), "a dictionary that breaks off"),
    (lambda pdf: pdf.pages[0].obj.__setitem__("/Resources", Array([])) or raw(b"/X Do")(pdf), "resources that are none"),
]


@pytest.mark.parametrize(("breaks", "story"), CONTENT, ids=[story for _, story in CONTENT])
def test_content_that_cannot_be_run_is_found(breaks: Callable[[pikepdf.Pdf], Any], story: str) -> None:
    assert ("content", ERROR) in faults(broken("plain", breaks)), story


@pytest.mark.parametrize("seed", range(20))
def test_content_put_together_by_chance_raises_nothing(seed: int) -> None:
    chance = random.Random(seed)
    words = [*WORDS.split(), *ODDS * 2, *[b"%d" % k for k in range(20)]]
    font = Dictionary(Type=Name.Font, Subtype=Name.Type1, BaseFont=Name.Courier)
    content = b" ".join(chance.choices(words, k=3000))
    preflight.check(page(content, Font=Dictionary(X=font), ExtGState=Dictionary(X=Dictionary(Font=[font, 9]))), "chance.pdf")


@pytest.mark.parametrize("seed", range(30))
def test_a_file_with_bytes_changed_is_refused_or_checked(seed: int) -> None:
    chance, data = random.Random(seed), bytearray(good("x4"))
    for _ in range(40):
        data[chance.randrange(len(data))] = chance.randrange(256)
    try:
        preflight.check(bytes(data), "plate.pdf")
    except ValueError as error:
        assert str(error).startswith("plate.pdf: ") and "\n" not in str(error)


def test_what_is_more_than_anybody_prints_is_said_and_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(placed, "CALLS", 500)
    assert ("limits", ERROR) in faults(broken("plain", tower))
    monkeypatch.setattr("crowquill.preflight.walker.CONTENT", 2**20)
    assert ("limits", ERROR) in faults(broken("plain", bomb))
    monkeypatch.setattr(canvas, "POINTS", 1000)
    assert ("limits", ERROR) in faults(page("".join(disc(20 + k, 20, 0.5) for k in range(60)) + "f"))


def test_pages_beyond_those_looked_at_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preflight, "PAGES", 2)
    data = broken("plain", lambda pdf: [pdf.add_blank_page(page_size=(300, 300)) for _ in range(3)])
    assert faults(data) == {("pages", ERROR)}


def test_a_large_file_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(structure, "LARGE", 1000)
    assert faults(good("plain")) == {("file-size", WARNING)}


def test_xmp_with_entities_is_not_read() -> None:
    laughs = '<!DOCTYPE x [<!ENTITY a "ha">]><x:xmpmeta xmlns:x="adobe:ns:meta/">&a;</x:xmpmeta>'
    with pikepdf.new() as pdf:
        pdf.Root.Metadata = pdf.make_stream(laughs.encode())
        assert document.xmp(pdf) == {}


def test_the_defaults_of_reportlab_are_found_out() -> None:
    file = io.BytesIO()
    drawn = Canvas(file, pagesize=(300, 300), invariant=1)
    drawn.setFillColorRGB(0, 0, 0)
    drawn.drawString(100, 100, "Femur")
    drawn.showPage()
    drawn.save()
    assert faults(file.getvalue()) == {("fonts", ERROR), ("rgb-black", WARNING)}


# the command


def locked(password: str) -> bytes:
    return broken("plain", lambda _: None, encryption=Encryption(owner="owner", user=password, R=3, aes=False, metadata=False))


REFUSED = [
    (locked("secret"), "password"),
    (b"%PDF-1.4\nnothing more", "not a sound PDF"),
    (good("plain")[:300], "not a sound PDF"),
    (b"", "not a PDF"),
    (b"Dear Sir,", "not a PDF"),
    (b"%PDF-1.7\n1 0 obj<</Type/Catalog>>endobj\ntrailer<</Root 1 0 R>>\n%%EOF", "not a sound PDF"),
]


@pytest.mark.parametrize(("data", "cause"), REFUSED, ids=[f"{k}-{cause}" for k, (_, cause) in enumerate(REFUSED)])
def test_what_cannot_be_read_is_refused_in_one_line(data: bytes, cause: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.pdf"
    file.write_bytes(data)
    assert main(["check", str(file)]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and "plate.pdf" in err and cause in err and "; " in err


WRONG = ["missing.pdf", ".", "plate.svg --pdfx x1a", "plate.pdf --pdfx x2", "plate.pdf --min-dot 3", "plate.pdf --size a99", "--json"]


@pytest.mark.parametrize("words", WRONG)
def test_what_is_asked_wrongly_is_refused_in_one_line(
    words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plate.pdf").write_bytes(good("plain"))
    Path("plate.svg").write_bytes(b'<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9"/>')
    assert main(["check", *words.split()]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_exit_code_tells_of_errors_and_the_table_of_all(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sound, bad = tmp_path / "sound.pdf", tmp_path / "bad.pdf"
    sound.write_bytes(good("x1a"))
    bad.write_bytes(page("0 w 20 20 m 40 40 l S"))
    assert main(["check", str(sound)]) == 0
    said = capsys.readouterr().out
    assert "structure checked by PDF/X-1a: 0 errors, 0 warnings" in said and "valid" not in said
    assert main(["check", str(sound), str(bad)]) == 1
    assert "min-line" in capsys.readouterr().out


def test_findings_are_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.pdf"
    file.write_bytes(page("0 w 20 20 m 40 40 l S"))
    assert main(["check", str(file), "--json"]) == 1
    (facts,) = json.loads(capsys.readouterr().out)
    (line,) = [one for one in facts["findings"] if one["rule"] == "min-line"]
    assert set(line) == {"rule", "severity", "where", "message", "value"} and line["value"] == 0 and facts["errors"] == 1


def test_options_move_the_limits_and_rules_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.pdf"
    file.write_bytes(good("x1a"))
    assert main(["check", str(file), "--spots", "Gold", "--size", "a5", "--min-dot", "2mm"]) == 1
    said = capsys.readouterr().out
    assert "spots" in said and "min-dot" in said and "trim-size" not in said
    assert main(["check", "--rules"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in preflight.RULES)
