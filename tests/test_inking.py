"""Any style in several inks, or with white dots on solid ink: colours, ink, layers, plates, recipes, and what is refused."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pikepdf
import pytest
import shapely
from PIL import Image
from scipy.ndimage import gaussian_filter
from test_styles import DEGENERATE, LITTLE, STYLES, inked

from crowquill import Sheet, Tone, draw, formats, inks, layout, raster, styles, to_bytes
from crowquill.__main__ import main
from crowquill.marks import Marks
from crowquill.picture import linear
from crowquill.sheet import Ink

QUICK = ("--paper", "24x20mm", "--margin", "5mm", "--pen", "0.4mm", "--iterations", "3", "--quiet")
PIXEL = 0.025  # mm; dots are a dozen across, and where two meet their covers multiply pixel by pixel
OCHRE = "Ochre=#c8922b, black"


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder where we are: it has colours.png, colours that run into each other, and grey.png, a ramp."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(colours()).save("colours.png")
    Image.fromarray(np.tile(np.linspace(255, 30, 40), (32, 1)).astype(np.uint8)).save("grey.png")


def colours() -> np.ndarray[Any, Any]:
    """Red, yellow, green and blue in the corners, (32, 40, 3) of 0 to 255, lighter in the middle."""
    corners = np.array([[(200, 40, 50), (235, 200, 60)], [(40, 60, 130), (70, 140, 60)]], np.float64)
    y, x = np.meshgrid(np.linspace(0, 1, 32), np.linspace(0, 1, 40), indexing="ij")
    share = np.stack([(1 - y) * (1 - x), (1 - y) * x, y * (1 - x), y * x], axis=-1)
    light = np.exp(-((x - 0.5) ** 2 + (y - 0.5) ** 2) / 0.05)[..., None]
    return np.round((share @ corners.reshape(4, 3)) * (1 - light) + 250 * light).astype(np.uint8)


def run(*arguments: str) -> int:
    return main([str(argument) for argument in arguments])


def coloured(width: float = 15.0) -> Tone:
    return Tone.load("colours.png", width=width, colour=True)


def seen(sheet: Sheet, blur: float) -> np.ndarray[Any, Any]:
    """The light (h, w, 3) that a sheet's inks leave together as filters, through a blur in mm, on pixels of PIXEL mm."""
    grid = tuple(round(side / PIXEL) for side in reversed(sheet.size))
    light = np.ones((*grid, 3))
    for layer in sheet.layers:
        cover = raster.covered(layer.art, grid, pixel=(PIXEL, PIXEL), lines=4, flat=1e-3)
        light *= 1 - cover[..., None] * (1 - inks.looks([layer.ink])[0])
    return np.stack([gaussian_filter(light[..., k], blur / PIXEL, mode="nearest") for k in range(3)], axis=-1)


def colour_error(sheet: Sheet, tone: Tone, blur: float) -> float:
    """How far the light is from the picture's, on the mean, both through the same blur in mm."""
    assert tone.rgb is not None
    found = seen(sheet, blur)
    asked = linear(tone.rgb / 255)
    finer = [
        np.asarray(Image.fromarray(asked[..., k].astype(np.float32)).resize(found.shape[1::-1], Image.Resampling.NEAREST)) for k in range(3)
    ]
    wanted = np.stack([gaussian_filter(part, blur / PIXEL, mode="nearest") for part in finer], axis=-1)
    return float(np.abs(found - wanted).mean())


def of_ink(sheet: Sheet, name: str) -> Sheet:
    """The layers of one ink alone."""
    return Sheet(sheet.size, tuple(layer for layer in sheet.layers if layer.ink.name == name))


def test_dots_of_four_inks_look_like_the_picture_and_each_has_the_ink_asked_for():
    tone = coloured()
    sheet = draw("stipple", tone, inks="C,M,Y,K", pen=0.3)
    assert [layer.ink.name for layer in sheet.layers] == ["yellow", "cyan", "magenta", "black"]
    assert colour_error(sheet, tone, 0.6) < 0.03  # one spacing of dots at .25; it is .012
    assert sheet.report["colour_error"] < 0.01
    for told in sheet.report["inks"]:
        ink = inked(of_ink(sheet, told["ink"]))
        assert ink == pytest.approx(told["ink_asked_mm2"], rel=0.01)
        assert told["ink_placed_mm2"] == pytest.approx(ink, rel=2e-3)
    assert sheet.report["ink_asked_mm2"] == pytest.approx(sum(told["ink_asked_mm2"] for told in sheet.report["inks"]))


def test_a_drawing_in_the_wrong_inks_is_seen():
    tone = coloured(12.0)
    sheet = draw("stipple", tone, inks="C,M,Y,K", pen=0.4, iterations=3)
    swapped = {"cyan": "yellow", "yellow": "cyan"}
    layers = [(layer, inks.one(swapped.get(layer.ink.name, layer.ink.name))) for layer in sheet.layers]
    wrong = Sheet(sheet.size, tuple(type(layer)(ink, layer.art) for layer, ink in layers))
    assert colour_error(wrong, tone, 0.6) > 0.1 > 2 * colour_error(sheet, tone, 0.6)


def test_spot_inks_overprint_from_the_lightest_up():
    sheet = draw("stipple", coloured(12.0), inks="Night=#1c2a5e, Sun=#f0b020, Rose=#d04060", pen=0.4, iterations=3)
    assert [(layer.ink.name, layer.ink.spot, layer.ink.overprint) for layer in sheet.layers] == [
        ("Sun", True, False),
        ("Rose", True, True),
        ("Night", True, True),
    ]
    assert all(isinstance(layer.art, Marks) for layer in sheet.layers)


def test_pixels_show_overprinting_ink_as_a_filter_and_svg_asks_for_it():
    sheet = draw("stipple", coloured(12.0), inks="C,M,Y,K", pen=0.4, iterations=3)
    with Image.open(io.BytesIO(to_bytes(sheet, "png", dpi=600))) as image:
        codes = np.asarray(image.convert("RGB")).reshape(-1, 3)
    found = {tuple(code) for code in codes[(codes % 255 == 0).all(axis=1)].tolist()}
    assert {(255, 0, 0), (0, 255, 0), (0, 0, 255)} <= found, "where two of them meet there is red, green and blue"
    assert to_bytes(sheet, "svg").count(b"mix-blend-mode:multiply") == 3


def test_a_duotone_has_the_lightness_of_the_tone():
    tone = Tone(np.tile(np.linspace(0, 0.9, 40), (30, 1)), (24.0, 18.0))
    sheet = draw("stipple", tone, inks=OCHRE, ink_match="lightness", pen=0.3)
    light = seen(sheet, 0.8) @ inks.LUMINANCE
    wanted = gaussian_filter(np.kron(1 - tone.coverage, np.ones((24, 24))), 0.8 / PIXEL, mode="nearest")
    assert np.abs(light - wanted)[60:-60, 60:-60].mean() < 0.03
    ochre, black = sheet.layers
    assert ochre.art.xy[:, 0].mean() < black.art.xy[:, 0].mean() and len(ochre.art) > len(black.art)


def test_a_picture_without_colours_leaves_coloured_inks_unused_and_says_so():
    sheet = draw("stipple", LITTLE, inks=OCHRE, pen=0.4, iterations=3)
    assert [layer.ink.name for layer in sheet.layers] == ["black"]
    assert any("Ochre has nothing to draw" in said and "lightness" in said for said in sheet.report["warnings"])


def test_inks_of_which_none_is_dark_are_drawn_and_that_is_said():
    sheet = draw("stipple", LITTLE, inks="ochre=#c8922b, sand=#e0c080", pen=0.4, iterations=3)
    assert len(sheet.layers) == 2
    assert any("no ink is dark: all together leave 20% of the light" in said for said in sheet.report["warnings"])


def test_colours_out_of_reach_are_said():
    sheet = draw("stipple", coloured(12.0), inks="Y,K", pen=0.4, iterations=3)
    assert sheet.report["colour_error"] > 0.03 and any(
        "add an ink of a colour that is missing" in said for said in sheet.report["warnings"]
    )


def test_one_ink_alone_is_the_style_s_own_drawing_of_its_tone():
    tone = Tone(LITTLE.coverage, LITTLE.size)
    alone, plain = draw("stipple", tone, inks="K", ink_match="lightness", pen=0.4, seed=3), draw("stipple", tone, pen=0.4, seed=3)
    assert len(alone.marks) == pytest.approx(len(plain.marks), rel=0.01) and alone.layers[0].ink == Ink()


def test_a_number_of_dots_is_that_of_all_inks():
    sheet = draw("stipple", coloured(12.0), inks="C,M,Y,K", dots=800, iterations=3)
    assert sum(len(layer.art) for layer in sheet.layers) == pytest.approx(800, abs=8)
    sizes = [layer.art.scale.mean() for layer in sheet.layers]
    assert max(sizes) < 1.05 * min(sizes), "all inks are drawn with dots of one size"


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("how", [{"inks": "C,M,K"}, {"reverse_from": 0.6}], ids=["inks", "reversed"])
def test_every_style_draws_it_or_refuses_in_one_line(style: str, how: dict[str, Any]):
    rgb = np.round(255 * np.stack([1 - LITTLE.coverage, 1 - 0.6 * LITTLE.coverage, 1 - LITTLE.coverage], axis=2)).astype(np.uint8)
    tone = Tone(LITTLE.coverage, LITTLE.size, rgb=rgb)
    try:
        sheet = draw(style, tone, **how)
    except ValueError as error:
        assert "; " in str(error) and "\n" not in str(error) and style in str(error)
        assert styles.says(style, "INKS", True) is False or styles.coloured(style) or "drew no dots" in str(error)
        return
    report = json.loads(json.dumps(dict(sheet.report)))
    assert report["marks"] and {"energy", "movement", "iterations", "seconds", "warnings", "coverage_missing"} <= set(report)
    used = {layer.ink.name for layer in sheet.layers}
    assert used <= {"cyan", "magenta", "black"} and len(used) == (2 if "inks" in how else 1)  # the picture is grey and green
    for layer in sheet.layers:
        if isinstance(layer.art, Marks):
            assert tone.holds(layer.art.xy).all() and np.isfinite(layer.art.scale).all()


@pytest.mark.parametrize("name", ["white", "black", "one pixel of ink", "a ring of canvas", "two islands", "a canvas inside one pixel"])
@pytest.mark.parametrize("how", [{"inks": OCHRE, "ink_match": "lightness"}, {"reverse_from": 0.45}], ids=["inks", "reversed"])
def test_an_awkward_tone_has_an_answer(name: str, how: dict[str, Any]):
    tone = DEGENERATE[name]
    sheet = draw("stipple", tone, iterations=1, **how)
    for layer in sheet.layers:
        assert np.isfinite(layer.art.xy).all()
        assert tone.holds(layer.art.xy).all() or not isinstance(layer.art, Marks)
    assert json.loads(json.dumps(dict(sheet.report))) == dict(sheet.report)
    assert sheet.report["warnings"] or any(len(layer.art) for layer in sheet.layers)


def test_screens_are_turned_from_ink_to_ink():
    sheet = draw("dots", coloured(12.0), inks="C,M,Y,K", lpi=30)
    turns = []
    for layer in sheet.layers:
        near = np.array([np.roll(layer.art.xy, 1, axis=0) - layer.art.xy])[0]
        near = near[np.hypot(*near.T) < 0.9]  # of a pitch of .847 mm: along a row
        turns.append(float(np.median(np.degrees(np.arctan2(near[:, 1], near[:, 0])) % 90)))
    assert sorted(turns) == pytest.approx([0.0, 15.0, 45.0, 75.0], abs=0.5)


def test_white_dots_are_holes_in_solid_ink_of_the_same_tone():
    tone = Tone(np.tile(np.linspace(0.2, 0.9, 60), (40, 1)), (30.0, 20.0))
    sheet = draw("stipple", tone, reverse_from=0.55, pen=0.3)
    solid, dots = sheet.layers
    assert (solid.name, solid.ink, dots.ink) == ("solid", Ink(), Ink())
    area = shapely.build_area(shapely.geometrycollections([shapely.LinearRing(ring) for ring in solid.art]))
    assert sheet.report["white_marks"] > 200 and (solid.art.areas < 0).sum() > 150
    assert area.bounds[0] == pytest.approx(15, abs=0.5), "half the way to the right the tone is .55"
    assert not shapely.contains_xy(area.buffer(-0.2), *dots.art.xy.T).any()
    ink = shapely.union_all([area, *dots.art.outlines().flat(1e-4).polygons()]).area
    assert ink == pytest.approx(tone.ink, rel=0.01) and sheet.report["ink_placed_mm2"] == pytest.approx(ink, rel=2e-3)
    assert sheet.report["ink_asked_mm2"] == pytest.approx(tone.ink, rel=2e-3)


def test_where_nothing_is_dark_nothing_is_reversed():
    sheet = draw("stipple", LITTLE.mapped(lambda c: c / 3), reverse_from=0.6, pen=0.4, iterations=3)
    assert len(sheet.layers) == 1 and any("nothing is reversed" in said for said in sheet.report["warnings"])


def test_the_command_line_draws_plates_and_draws_again_to_the_byte():
    Path("films").mkdir()
    made = ("colours.png", "a.svg", "a.pdf", "--inks", "Sun=#f0b020,Night=#1c2a5e,K", "--plates", "films", "--pdfx", "x1a", *QUICK)
    assert run("stipple", *made, "--reverse-from", "0.7", "--report", "r.json") == 0
    assert sorted(path.name for path in Path("films").iterdir()) == ["a-Black.pdf", "a-Night.pdf", "a-Sun.pdf"]
    with pikepdf.open("a.pdf") as pdf:
        spaces = pdf.pages[0].Resources.ColorSpace
        assert sorted(str(space[1]) for space in spaces.values()) == ["/Night", "/Sun"]
    assert run("redo", "a.svg", "b.svg", "b.pdf", "--quiet") == 0
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes() and Path("a.pdf").read_bytes() == Path("b.pdf").read_bytes()
    assert formats.load("a.svg").recipe["inks"] == {"inks": "Sun=#f0b020,Night=#1c2a5e,K", "reverse_from": 0.7}
    assert [told["ink"] for told in json.loads(Path("r.json").read_text())["inks"]] == ["Sun", "Night", "black"]


def test_a_recipe_without_inks_says_nothing_of_them():
    assert run("stipple", "grey.png", "a.svg", *QUICK) == 0
    assert "inks" not in formats.load("a.svg").recipe


def test_a_plotter_has_a_pen_an_ink():
    assert run("stipple", "colours.png", "a.svg", "--inks", "C,M,Y,K", "--for", "plotter", "--nib", "0.5mm", *QUICK) == 0
    assert [layer.name for layer in formats.load("a.svg").layers] == ["1 yellow 0.5", "2 cyan 0.5", "3 magenta 0.5", "4 black 0.5"]


def test_options_of_light_change_colours():
    def light(**options: Any) -> np.ndarray[Any, Any]:
        tone = layout.lit(Path("colours.png"), True, True, **options)
        assert tone.rgb is not None
        return linear(tone.rgb / 255)

    plain, own = light(), linear(colours() / 255)
    assert plain == pytest.approx(own, abs=1e-9) and (light(tone="linear") == plain).all(), "colours are asked for as they are"
    step = 0.005  # of light: half a code value, where it is steepest
    assert light(gamma=2.0) == pytest.approx(1 - (1 - own) ** 2, abs=step)
    assert light(invert=True) == pytest.approx(1 - own, abs=step)
    assert light(tone="grey") == pytest.approx(colours() / 255, abs=step)
    white = linear(np.array(200 / 255))
    assert light(white_point=200 / 255) == pytest.approx(np.minimum(own / white, 1), abs=step)


def test_a_curve_of_the_press_is_put_on_each_ink():
    def asked(*more: str) -> float:
        assert run("stipple", "grey.png", "a.svg", "--inks", "K", *QUICK, *more, "--report", "r.json") == 0
        return float(json.loads(Path("r.json").read_text())["inks"][0]["ink_asked_mm2"])

    Path("gain.csv").write_text("0,0\n0.5,0.7\n1,1\n")
    plain, gained = asked(), asked("--tone-curve", "gain.csv")
    ink = 1 - linear(np.tile(np.linspace(255, 30, 40), 1).astype(np.uint8) / 255)
    assert gained / plain == pytest.approx(np.interp(ink, [0, 0.7, 1], [0, 0.5, 1]).sum() / ink.sum(), rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--inks", ""), "names none"),
        (("--inks", "C,M,puce"), "'puce' is not understood"),
        (("--inks", "a=#c8922b,b=#c8922b"), "of one colour"),
        (("--inks", ",".join(f"i{k}=#{k}0{k}000" for k in range(1, 10))), "over the limit of 8"),
        (("--inks", "C,K", "--ink", "cyan"), "both given"),
        (("--ink-limit", "2"), "for no inks"),
        (("--black-for", "greys"), "for no inks"),
        (("--ink-match", "lightness"), "for no inks"),
        (("--inks", "C,K", "--ink-limit", "9"), "from 0.5 to 8"),
        (("--inks", "C,K", "--ink-match", "hue"), "no --ink-match 'hue'"),
        (("--inks", "C,K", "--ink-match", "lightness", "--black-for", "greys"), "for colours"),
        (("--reverse-from", "0.1"), "from 0.2 to 1"),
        (("--inks", "C,K", "--dots", "0"), "dots"),
    ],
    ids=lambda part: " ".join(part) if isinstance(part, tuple) else "",
)
def test_what_cannot_be_is_refused_in_one_line_and_writes_nothing(
    arguments: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
):
    assert run("stipple", "colours.png", "x.svg", *QUICK, *arguments) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line, line
    assert said in line
    assert not Path("x.svg").exists()
