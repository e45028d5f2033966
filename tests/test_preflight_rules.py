"""Rules for PDFs: sound files pass, and each file with one thing broken is caught by the rule that is meant, and by no other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pikepdf
import pytest
from pikepdf import Array, Dictionary, Encryption, Name
from presses import CLAIM, MM, XMP, add, broken, faults, found, good, profile, said, separation

from crowquill.preflight import ERROR, RULES, WARNING

SPOT, OTHER, EMPTY, ALL = (
    separation("Gold", 0, 0.2, 0.8, 0),
    separation("Gold", 0, 0.2, 0.7, 0),
    separation("Gold", 0, 0, 0, 0),
    separation("All", 1, 1, 1, 1),
)
HELVETICA = Dictionary(Type=Name.Font, Subtype=Name.Type1, BaseFont=Name.Helvetica)
BOX = "50 50 20 20 re f"
Break = Callable[[pikepdf.Pdf], object]


def at(*path: str, value: Any = None) -> Break:
    """Sets what a path of keys leads to, from the root; None deletes it."""

    def breaks(pdf: pikepdf.Pdf) -> None:
        target: Any = pdf.Root
        for key in path[:-1]:
            target = target[int(key)] if key.isdigit() else target[f"/{key}"]
        made = value(pdf) if callable(value) else value
        if made is None:
            del target[f"/{path[-1]}"]
        else:
            target[f"/{path[-1]}"] = made

    return breaks


def info(key: str, value: Any = None) -> Break:
    def breaks(pdf: pikepdf.Pdf) -> None:
        if value is None:
            del pdf.docinfo[f"/{key}"]
        else:
            pdf.docinfo[f"/{key}"] = value

    return breaks


def xmp(kind: str, old: str, new: str) -> Break:
    assert old in XMP.format(claim=CLAIM[kind])
    return lambda pdf: said(pdf, XMP.format(claim=CLAIM[kind]).replace(old, new))


def code(text: str, **resources: Any) -> Break:
    return lambda pdf: add(pdf, text, **resources)


def state(**entries: Any) -> Break:
    return code(f"/Odd gs 0 g {BOX}", ExtGState={"Odd": Dictionary(**entries)})


def spot(*spaces: Array) -> Break:
    names = {f"S{k}": space for k, space in enumerate(spaces)}
    return code(" ".join(f"/{name} cs 1 scn {BOX}" for name in names), ColorSpace=names)


def stream(data: bytes = b"", **entries: Any) -> Callable[[pikepdf.Pdf], Any]:
    return lambda pdf: pdf.make_stream(data, **entries)


def picture(**entries: Any) -> Break:
    """A bitmap of 300 ppi in grey with entries of its own; functions are given the file."""

    def breaks(pdf: pikepdf.Pdf) -> None:
        own = {key: value(pdf) if callable(value) else value for key, value in entries.items()}
        plain = {
            "Type": Name.XObject,
            "Subtype": Name.Image,
            "Width": 240,
            "Height": 240,
            "BitsPerComponent": 8,
            "ColorSpace": Name.DeviceGray,
        }
        image = pdf.make_stream(bytes(240 * 240), **(plain | own))
        add(pdf, "20 0 0 20 50 50 cm /Odd Do", XObject={"Odd": image})

    return breaks


def form(**entries: Any) -> Break:
    return lambda pdf: add(
        pdf,
        "/Odd Do",
        XObject={"Odd": pdf.make_stream(b"0 g 50 50 9 9 re f", Type=Name.XObject, Subtype=Name.Form, BBox=[0, 0, 99, 99], **entries)},
    )


def packed(name: str) -> Break:
    """A stream that says it is packed so; it is not drawn."""
    return lambda pdf: pdf.Root.__setitem__(
        "/Odd", pdf.make_indirect(pdf.make_stream(b"\x80\x0b\x60\x50\x22\x0c\x0c\x85\x01", Filter=Name(name)))
    )


def note(pdf: pikepdf.Pdf) -> None:
    pdf.pages[0].obj.Annots = Array([pdf.make_indirect(Dictionary(Type=Name.Annot, Subtype=Name.Text, Rect=[200, 200, 220, 220]))])


def attach(pdf: pikepdf.Pdf) -> None:
    pdf.attachments["notes.txt"] = pikepdf.AttachedFileSpec(pdf, b"notes", filename="notes.txt")


def twice(pdf: pikepdf.Pdf) -> None:
    pdf.Root.OutputIntents.append(pdf.Root.OutputIntents[0])


def blending(space: str) -> Break:
    return at("Pages", "Kids", "0", "Group", value=Dictionary(S=Name.Transparency, CS=Name(space)))


def letters(pdf: pikepdf.Pdf) -> None:
    add(pdf, "BT /Odd 4 Tf 50 50 Td (plate) Tj ET", Font={"Odd": HELVETICA})


def icc(pdf: pikepdf.Pdf) -> None:
    add(pdf, f"/S cs {BOX}", ColorSpace={"S": Array([Name.ICCBased, pdf.make_stream(profile(), N=4)])})


PAGE = ("Pages", "Kids", "0")
INTENT = ("OutputIntents", "0")
# the kind of file, what is done to it, the rule that must say so
BROKEN: list[tuple[str, Break, str]] = [
    ("plain", lambda pdf: pdf.pages[0].obj.__setitem__("/TrimBox", Array([-9, 0, 300, 300])), "boxes"),
    ("plain", at(*PAGE, "MediaBox", value=Array([0, 0, 0, 0])), "boxes"),
    ("x1a", at(*PAGE, "BleedBox", value=Array([100, 100, 300, 300])), "boxes"),
    ("x1a", at(*PAGE, "TrimBox"), "trim-box"),
    ("x4", at(*PAGE, "ArtBox", value=Array([100, 100, 300, 300])), "trim-box"),
    ("x3", at("OutputIntents"), "intent"),
    ("a", at("OutputIntents"), "intent"),
    ("x1a", twice, "intent"),
    ("x4", at(*INTENT, "OutputConditionIdentifier", value=" "), "intent"),
    ("x4", at(*INTENT, "DestOutputProfile"), "profile"),
    ("a", at(*INTENT, "DestOutputProfile"), "profile"),
    ("x4", at(*INTENT, "DestOutputProfile", value=stream(profile(b"mntr"), N=4)), "profile"),
    ("x1a", at(*INTENT, "DestOutputProfile", value=stream(profile(), N=3)), "profile"),
    ("x3", at(*INTENT, "DestOutputProfile", value=stream(b"no profile", N=4)), "profile"),
    ("x1a", info("GTS_PDFXConformance"), "claim"),
    ("a", xmp("a", "<pdfaid:conformance>B", "<pdfaid:conformance>Z"), "claim"),
    ("x1a", info("Trapped"), "trapped"),
    ("x3", info("Trapped", Name.Unknown), "trapped"),
    ("x1a", info("Title"), "title-dates"),
    ("x3", info("ModDate"), "title-dates"),
    ("x4", xmp("x4", "<xmpMM:VersionID>1</xmpMM:VersionID>", ""), "title-dates"),
    ("x4", xmp("x4", "Plate 1", "Plate 2"), "info-xmp"),
    ("a", xmp("a", "<xmp:CreateDate>2026-01-02", "<xmp:CreateDate>2025-01-02"), "info-xmp"),
    ("x1a", packed("/LZWDecode"), "filters"),
    ("a", packed("/LZWDecode"), "filters"),
    ("x3", packed("/JBIG2Decode"), "filters"),
    ("a", packed("/JPXDecode"), "filters"),
    ("x4", at("OpenAction", value=Dictionary(S=Name.GoTo)), "actions"),
    ("x1a", at("Odd", value=Dictionary(S=Name.JavaScript, JS="app.alert(1)")), "actions"),
    ("x3", note, "annotations"),
    ("x1a", attach, "attachments"),
    ("a", attach, "attachments"),
    ("x4", attach, "attachments"),
    ("plain", code("1 0 0 R"), "content"),
    ("x1a", code("/Gone gs"), "content"),
    ("x4", code("/Gone Do"), "content"),
    ("plain", code("Q"), "content"),
    ("x1a", code(f"1 0 0 rg {BOX}"), "colour-spaces"),
    ("x3", code("1 0 0 RG 1 w 50 50 m 60 60 l S"), "colour-spaces"),
    ("a", code(f"1 0 0 rg {BOX}"), "colour-spaces"),
    ("x1a", code(f"/L cs 90 0 0 sc {BOX}", ColorSpace={"L": Array([Name.Lab, Dictionary(WhitePoint=[1, 1, 1])])}), "colour-spaces"),
    ("x1a", picture(ColorSpace=Name.DeviceRGB), "colour-spaces"),
    (
        "x1a",
        lambda pdf: add(pdf, f"/S cs {BOX}", ColorSpace={"S": Array([Name.ICCBased, pdf.make_stream(profile(), N=4)])}),
        "colour-spaces",
    ),
    ("x1a", state(ca=0.5), "transparency"),
    ("x3", state(BM=Name.Multiply), "transparency"),
    ("a", state(SMask=Dictionary(S=Name.Luminosity)), "transparency"),
    ("x3", picture(SMask=stream(bytes(4), Width=2, Height=2)), "transparency"),
    ("x1a", form(Group=Dictionary(S=Name.Transparency)), "transparency"),
    ("x4", blending("/DeviceRGB"), "blend-space"),
    ("x1a", at("OCProperties", value=Dictionary(OCGs=Array([]))), "layers"),
    ("x3", code(f"/OC /Top BDC 0 g {BOX} EMC"), "layers"),
    ("x4", state(TR=Name.Identity), "transfer"),
    ("x1a", state(TR2=Dictionary(FunctionType=2)), "transfer"),
    ("x1a", state(HTP=Array([0, 0])), "halftones"),
    ("x4", state(HT=Dictionary(HalftoneType=1, HalftoneName=Name.Fine)), "halftones"),
    ("x3", lambda pdf: add(pdf, "/Odd Do", XObject={"Odd": pdf.make_stream(b"showpage", Subtype=Name.PS)}), "postscript"),
    ("x1a", picture(Alternates=Array([])), "replaced"),
    ("x4", form(OPI=Dictionary()), "replaced"),
    ("plain", letters, "fonts"),
    ("x1a", code("BT /Odd 12 Tf ET", Font={"Odd": HELVETICA}), "fonts"),
    ("plain", spot(SPOT, OTHER), "spot-mixtures"),
    ("x4", spot(EMPTY), "spot-mixtures"),
    ("plain", code(f"/White gs 1 g {BOX}", ExtGState={"White": Dictionary(op=True)}), "white-overprint"),
    ("plain", code(f"1 1 1 0.5 k {BOX}"), "total-ink"),
]
# the same, with warnings: what may be printed, and had better not
DOUBTFUL: list[tuple[str, Break, str]] = [
    ("plain", at("OpenAction", value=Dictionary(S=Name.GoTo)), "actions"),
    ("plain", note, "annotations"),
    ("plain", state(TR=Name.Identity), "transfer"),
    ("plain", code("BT /Odd 12 Tf ET", Font={"Odd": HELVETICA}), "fonts"),
    ("plain", spot(ALL), "registration"),
    ("x4", code(f"0 0 0 rg {BOX}", ColorSpace={"DefaultRGB": Array([Name.CalRGB, Dictionary(WhitePoint=[1, 1, 1])])}), "rgb-black"),
    ("plain", code("0.5 0.5 0.5 1 K 0.2 w 50 50 m 80 50 l S"), "black-lines"),
    ("plain", picture(Width=200), "resolution"),
    ("x1a", code("0 g 12 100 9 9 re f"), "safe-zone"),
    ("plain", code("0 g -1 100 9 9 re f"), "bleed"),
    ("x1a", code("0 g 9 100 9 9 re f"), "bleed"),
]


@pytest.mark.parametrize("kind", ["plain", "x1a", "x3", "x4", "a"])
def test_a_sound_file_of_each_kind_has_no_fault(kind: str) -> None:
    assert faults(good(kind)) == set()


@pytest.mark.parametrize(("kind", "breaks", "rule"), BROKEN, ids=[f"{k}-{kind}-{rule}" for k, (kind, _, rule) in enumerate(BROKEN)])
def test_one_thing_broken_is_found_by_its_rule_alone(kind: str, breaks: Break, rule: str) -> None:
    assert faults(broken(kind, breaks)) == {(rule, ERROR)}


@pytest.mark.parametrize(("kind", "breaks", "rule"), DOUBTFUL, ids=[f"{k}-{kind}-{rule}" for k, (kind, _, rule) in enumerate(DOUBTFUL)])
def test_what_is_doubtful_is_a_warning_of_its_rule_alone(kind: str, breaks: Break, rule: str) -> None:
    assert faults(broken(kind, breaks)) == {(rule, WARNING)}


def nothing(_: pikepdf.Pdf) -> None:
    """Breaks nothing."""


@pytest.mark.parametrize(("kind", "version"), [("x1a", "1.6"), ("x3", "1.7"), ("x4", "1.7"), ("a", "1.7")])
def test_a_version_that_the_standard_does_not_know_is_found(kind: str, version: str) -> None:
    assert faults(broken(kind, nothing, version)) == {("version", ERROR)}


def test_an_encrypted_file_is_found_even_where_it_opens() -> None:
    locked = Encryption(owner="owner", user="", R=3, aes=False, metadata=False)
    assert faults(broken("x4", nothing, encryption=locked)) == {("encryption", ERROR)}
    assert faults(broken("plain", nothing, encryption=locked)) == {("encryption", WARNING)}


def test_a_file_without_an_id_is_found() -> None:
    data = good("x1a")
    assert data.count(b"/ID [") == 1 and faults(data.replace(b"/ID [", b"/XX [")) == {("file-id", ERROR)}


def test_a_damaged_table_of_contents_is_found_though_readers_mend_it() -> None:
    assert faults(good("plain").replace(b"startxref", b"startxrfe")) == {("damage", ERROR)}


def test_a_file_without_pages_is_found() -> None:
    assert ("pages", ERROR) in faults(broken("plain", lambda pdf: pdf.pages.remove(p=1)))


def test_the_trim_is_the_paper_asked_for() -> None:
    assert faults(good("x1a"), size=(148.0, 210.0)) == set()
    assert faults(good("x1a"), size=(210.0, 148.0)) == set()  # turned
    assert faults(good("x1a"), size=(148.2, 210.0)) == {("trim-size", ERROR)}
    larger = at(*PAGE, "TrimBox", value=Array([10 * MM, 10 * MM, 158.09 * MM, 220 * MM]))  # 0.09 mm more
    assert faults(broken("x1a", larger), size=(148.0, 210.0)) == set()


def test_spot_inks_are_held_to_the_list() -> None:
    assert faults(good("x1a"), spots=("PANTONE 124 C",)) == set()
    assert faults(good("x1a"), spots=("PANTONE 300 C",)) == {("spots", ERROR)}
    assert faults(good("x1a"), spots=()) == {("spots", ERROR)}


def test_what_is_asked_for_goes_before_what_is_claimed() -> None:
    assert ("claim", ERROR) in faults(good("plain"), pdfx="x4")
    assert faults(good("x1a"), pdfx="x3") == {("claim", ERROR)}
    assert {"x4", "a"} == {rule for rule in ("x4", "a") if faults(good("plain"), **({"pdfx": "x4"} if rule == "x4" else {"pdfa": True}))}


def test_elements_are_counted() -> None:
    assert faults(good("plain"), max_elements=50) == {("elements", WARNING)}


def test_inks_are_those_really_used() -> None:
    assert found(good("plain"))["inks"][0].value == ["Black", "PANTONE 124 C"]
    assert "Cyan" in found(broken("plain", code(f"0.2 0 0 0 k {BOX}")))["inks"][0].value


def test_rules_explain_themselves_and_each_for_pdf_is_broken_somewhere() -> None:
    tried = {rule for _, _, rule in (*BROKEN, *DOUBTFUL)} | {"version", "encryption", "file-id", "damage", "pages", "trim-size", "spots"}
    elsewhere = {"file-size", "limits"}  # in the tests of hostile files
    assert {rule.name for rule in RULES.values() if rule.on == "pdf"} - elsewhere <= tried
    assert all(rule.about.endswith(".") and len(rule.about) < 140 for rule in RULES.values())
