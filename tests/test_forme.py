"""Plates and furniture: what an ink prints on, what the plates leave out, and marks that end before the bleed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from printing import GOLD, SILVER, black, inked, square
from rendering import Window, pdfium

from crowquill import formats, forme
from crowquill.forme import LONG, OFFSET, PAPER, REGISTRATION, STEPS, Forme, Tint, inks, locked, separated, shares
from crowquill.lettering import Words
from crowquill.paths import Array, Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet, outlined

SKY = Ink("sky", (0.7, 0.2, 0, 0))
DPMM = 50.0  # pixels to the mm, 1270 dpi: sides in whole millimetres are whole pixels


def bounds(layer: Layer) -> Array:
    """Left, top, right and bottom of what a layer draws, mm."""
    xy = outlined(layer.art).xy
    return np.concatenate([xy.min(axis=0), xy.max(axis=0)])


def check_outside(made: Forme) -> None:
    """Raises AssertionError where a ring around the sheet reaches into the trim, the bleed, or over the paper's edge."""
    width, height = made.sheet.size
    for layer in made.around:
        for ring in outlined(layer.art):
            (left, top), (right, bottom) = ring.min(axis=0), ring.max(axis=0)
            out = max(-right, left - width, -bottom, top - height)
            assert out >= made.bleed - 1e-9, f"{layer.label} is {out} mm out of the trim"
            edge = min(left, top, width - right, height - bottom) + made.slug
            assert edge > 0, f"{layer.label} is cut off"


@pytest.mark.parametrize("size", [(210, 297), (100, 80), (24, 300), (12, 9), (3, 3)], ids=str)
@pytest.mark.parametrize("bleed", [0, 3, 12.5])
def test_all_furniture_is_between_the_bleed_and_the_edge_of_the_paper(size: tuple[float, float], bleed: float) -> None:
    every = Layer(SKY, square(0, 0, 1, 1)), Layer(SILVER, square(0, 0, 1, 1)), Layer(Ink(), square(0, 0, 1, 1))
    for marks, bar in ((True, True), (True, False), (False, True)):
        check_outside(locked(Sheet(size, every), bleed=bleed, marks=marks, colour_bar=bar))


def test_the_check_of_furniture_finds_a_mark_in_the_bleed() -> None:
    made = locked(black(), bleed=3, marks=True)
    with pytest.raises(AssertionError, match="crop marks is 3"):
        check_outside(replace(made, bleed=3.01))
    with pytest.raises(AssertionError, match="cut off"):
        check_outside(replace(made, slug=9))


@pytest.mark.parametrize("bleed", [0, 2, 5])
def test_crop_marks_are_six_millimetres_long_and_point_at_the_corners(bleed: float) -> None:
    made = locked(black(), bleed=bleed, marks=True)
    rings = list(outlined(made.around[0].art))
    off = max(OFFSET, bleed)
    assert len(rings) == 8
    for ring in rings:
        assert sorted(np.ptp(ring, axis=0).tolist()) == pytest.approx([forme.THIN, LONG])
        middle = ring.mean(axis=0)
        corner = np.array([[x, y] for x in (0, 100) for y in (0, 80)])
        away = np.abs(corner - middle).round(9)
        assert [0, off + LONG / 2] in np.sort(away, axis=1).tolist()


def test_crop_marks_in_pixels_do_not_touch_the_trim() -> None:
    sheet = Sheet((30, 20), (Layer(Ink(), square(10, 5, 5, 5)),))
    data = formats.to_bytes(sheet, "pdf", marks=True)
    slug = round(locked(sheet, marks=True).slug)
    ink = pdfium(data, Window(0, 0, 30 + 2 * slug, 20 + 2 * slug), DPMM)
    trim = ink[round(slug * DPMM) : round((slug + 20) * DPMM), round(slug * DPMM) : round((slug + 30) * DPMM)]
    assert trim.sum() == pytest.approx(25 * DPMM**2, rel=1e-3)  # the square, and nothing else
    around = ink.sum() - trim.sum()
    assert around / DPMM**2 > 8 * LONG * forme.THIN * 0.99
    low, below, right = (round((side + slug) * DPMM) for side in (0.02 - OFFSET, 20 + OFFSET - 0.02, 30 + OFFSET - 0.02))
    assert ink[low:below, low:right].sum() == pytest.approx(trim.sum())  # all marks are further off than OFFSET


def test_a_short_side_has_no_registration_mark_and_crop_marks_all_the_same() -> None:
    def found(size: tuple[float, float]) -> dict[str, int]:
        made = locked(Sheet(size, (Layer(Ink(), square(0, 0, 1, 1)),)), marks=True)
        return {layer.name: len(outlined(layer.art)) for layer in made.around if layer.ink == REGISTRATION}

    assert found((100, 80)) == {"crop marks": 8, "registration marks": 16}  # four targets of four rings
    assert found((100, 10)) == {"crop marks": 8, "registration marks": 8}
    assert found((10, 10)) == {"crop marks": 8}


def test_the_colour_bar_has_each_ink_in_full_and_in_three_tints() -> None:
    made = locked(inked(), colour_bar=True)
    patches = {(tuple(shares(layer.ink).items()), tuple(np.ptp(outlined(layer.art).xy, axis=0))) for layer in made.around}
    expected = {(((plate, step),), (5.0, 5.0)) for plate in ("Black", SILVER.name, GOLD.name) for step in STEPS}
    assert patches == expected and len(made.around) == 12
    assert {type(layer.ink) for layer in made.around if layer.ink.spot} == {Tint}


def test_a_narrow_page_breaks_the_colour_bar_and_names_inks_smaller() -> None:
    sheet = Sheet((12, 60), (*inked().layers[:2], Layer(SKY, square(0, 0, 1, 1))))
    made = locked(sheet, marks=True, colour_bar=True)
    patches = np.array([bounds(layer) for layer in made.around if layer.name.endswith("%")])
    assert len(patches) == 16 and patches[:, 2].max() <= 12 and len(np.unique(patches[:, 1])) == 8
    (size,) = {float(layer.art.size[0]) for layer in made.around if isinstance(layer.art, Words)}
    assert 0 < size < forme.LETTERS
    check_outside(made)


def test_inks_are_the_process_plates_in_order_then_spots_from_the_bottom() -> None:
    assert list(inks(inked().layers)) == ["Black", SILVER.name, GOLD.name]
    assert list(inks((Layer(GOLD, square(0, 0, 1, 1)), Layer(SKY, square(0, 0, 1, 1)), Layer(PAPER, square(0, 0, 1, 1))))) == [
        "Cyan", "Magenta", GOLD.name,
    ]  # fmt: skip
    assert inks((Layer(SKY, Paths.of([])),)) == {} and separated(Sheet((9, 9))) == {}
    fill = [(0, 0, 0.5, 0), (0, 0, 0, 0)]
    rings = Paths.of([square(0, 0, 1, 1)[0], square(1, 1, 1, 1)[0]])
    assert list(inks((Layer(Ink(), rings, fill=np.array(fill)),))) == ["Yellow"]


def test_a_spot_ink_of_two_looks_and_paper_that_overprints_are_refused() -> None:
    other = replace(SILVER, cmyk=(0, 0, 0, 0.5))
    with pytest.raises(ValueError, match=r"spot ink 'PANTONE 877 C' is cmyk .* and .*; give it one look"):
        inks((Layer(SILVER, square(0, 0, 1, 1)), Layer(other, square(0, 0, 1, 1))))
    with pytest.raises(ValueError, match="'paper' is paper and would overprint"):
        inks((Layer(replace(PAPER, overprint=True), square(0, 0, 1, 1)),))


def told(plate: Forme) -> list[tuple[str, float]]:
    return [(layer.ink.name, layer.ink.cmyk[3]) for layer in plate.sheet.layers]


def test_plates_leave_paper_under_what_lies_above_unless_it_overprints() -> None:
    plates = separated(inked())
    assert told(plates[SILVER.name]) == [(SILVER.name, 1.0), *[("paper", 0.0)] * 4]  # gold overprints, black does not
    assert told(plates[GOLD.name]) == [(GOLD.name, 1.0), *[("paper", 0.0)] * 4]
    assert told(plates["Black"]) == [("Black", 1.0), ("Black", 0.3), ("Black", 1.0), ("Black", 1.0)]
    assert all(plate.plate == name for name, plate in plates.items())


def test_each_plate_has_the_registration_marks_and_its_own_name_alone() -> None:
    for name, plate in separated(inked(), colour_bar=True).items():
        words = [line for layer in plate.around if isinstance(layer.art, Words) for line in layer.art.text]
        assert words == [name]
        assert [layer.name for layer in plate.around][:2] == ["crop marks", "registration marks"]
        assert [layer.ink.cmyk[3] for layer in plate.around if layer.name.endswith("%")] == list(STEPS)
        assert {layer.ink.cmyk[:3] for layer in plate.layers} == {(0, 0, 0)}


def test_rings_coloured_by_themselves_are_on_the_plates_of_their_shares() -> None:
    rings = Paths.of([square(0, 0, 2, 2)[0], square(1, 1, 2, 2)[0], square(5, 5, 1, 1)[0]])
    fill = np.array([(1, 0, 0, 0), (0, 0.5, 0, 0), (0.25, 0, 0, 1)])
    for over, kept in ((False, 3), (True, 2)):
        plates = separated(Sheet((9, 9), (Layer(Ink(overprint=over), rings, fill=fill),)))
        assert list(plates) == ["Cyan", "Magenta", "Black"]
        (layer,) = plates["Cyan"].sheet.layers
        assert layer.fill is not None and len(outlined(layer.art)) == kept
        assert layer.fill[:, 3].tolist() == ([1, 0, 0.25] if kept == 3 else [1, 0.25]) and not layer.fill[:, :3].any()


def test_a_forme_laid_flat_is_a_sheet_of_the_paper_with_the_art_cut_at_the_bleed() -> None:
    sheet = Sheet((20, 20), (Layer(Ink(), square(-15, -15, 50, 50)), Layer(Ink(), Bitmap.of([[True]], 300, (1, 1)))))
    made = locked(sheet, bleed=2, marks=True)
    flat = made.flat()
    assert flat.size == (20 + 2 * made.slug, 20 + 2 * made.slug)
    paper = next(layer for layer in flat.layers if layer.ink == PAPER)
    hole = outlined(paper.art)[1]
    assert (hole.min(axis=0), hole.max(axis=0)) == (pytest.approx(made.slug - 2), pytest.approx(made.slug + 22))
    assert locked(sheet).flat().layers[0].ink == Ink() and len(locked(sheet).flat().layers) == 2
