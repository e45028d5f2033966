"""Words become outlines of known size at a known place, inside out nowhere, and in the letters that were asked for."""

from __future__ import annotations

import io

import numpy as np
import pytest
import resvg_py
from PIL import Image

from crowquill import Ink, Layer, Sheet, to_bytes
from crowquill.lettering import FACES, Words, text, width


def test_a_capital_stands_on_its_line_and_is_as_high_as_the_font_says():
    letter = text("H", 10, 20, size=10)
    low, high = letter.flat(1e-3).xy.min(axis=0), letter.flat(1e-3).xy.max(axis=0)
    assert high[1] == pytest.approx(20, abs=1e-9) and high[1] - low[1] == pytest.approx(7.29, abs=0.01)  # Vera's capitals
    assert low[0] > 10


def test_bodies_turn_from_x_to_y_and_their_holes_back():
    areas = text("oO08", 0, 0).areas
    assert (areas > 0).sum() == 4 and (areas < 0).sum() == 5


@pytest.mark.parametrize(("anchor", "share"), [("start", 0.0), ("middle", 0.5), ("end", 1.0)])
def test_an_anchor_is_where_the_line_is_held(anchor: str, share: float):
    free, held = text("nib-03", 0, 0, size=4), text("nib-03", 50, 0, size=4, anchor=anchor)
    wide = 4 * (text("nib-03n", 0, 0, size=1).xy[:, 0].max() - text("n", 0, 0, size=1).xy[:, 0].max())  # what the next letter stands at
    assert held.xy[:, 0] - free.xy[:, 0] == pytest.approx(np.full(len(free.xy), 50 - share * wide))


def test_words_grow_with_their_size_and_none_are_none():
    one, two = text("aß漢", 0, 0, size=1), text("aß漢", 0, 0, size=2)
    assert two.xy == pytest.approx(2 * one.xy) and len(text("", 0, 0)) == len(text("  ", 0, 0)) == 0
    with pytest.raises(ValueError, match="size of text is 0 mm"):
        text("a", 0, 0, size=0)


def test_a_word_looks_as_the_same_font_draws_it():
    """The outline against the letters that the renderer draws from the font itself."""
    import reportlab

    font = f"{reportlab.__path__[0]}/fonts/Vera.ttf"
    ours = to_bytes(Sheet((60, 12), (Layer(Ink(), text("Quill 0.3 mm", 2, 9, size=7)),)), "svg").decode()
    theirs = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="12mm" viewBox="0 0 60 12">'
        '<text x="2" y="9" font-size="7" font-family="Bitstream Vera Sans">Quill 0.3 mm</text></svg>'
    )
    pictures = []
    for svg in (ours, theirs):
        data = resvg_py.svg_to_bytes(svg_string=svg, dpi=254, font_files=[font], skip_system_fonts=True)
        pictures.append(np.asarray(Image.open(io.BytesIO(bytes(data))).split()[-1], float) / 255)
    assert pictures[1].sum() > 1000
    # kerning would move letters apart by more than this; a pixel is a tenth of a millimetre
    assert np.abs(pictures[0] - pictures[1]).mean() < 0.01


def test_words_stand_where_their_anchors_say():
    words = Words.of([("scale", 10, 5), ("bar", 10, 9)], size=3, anchor="end")
    assert np.allclose(words.xy[:, 0] + [width("scale", 3), width("bar", 3)], 10, atol=1e-9)
    ends = [text(line, 10, y, size=3, anchor="end").xy for line, y in (("scale", 5), ("bar", 9))]
    assert np.allclose(words.outlines().xy, np.concatenate(ends), atol=1e-9)


def test_faces_differ():
    widths = {face: width("Ammonites", 3, face) for face in FACES}
    assert widths["bold"] > widths["regular"]
    assert not np.array_equal(text("a", 0, 0, font="italic").xy, text("a", 0, 0).xy)


def test_a_font_that_is_none_is_refused(tmp_path):
    with pytest.raises(ValueError, match="no font 'heavy'; there are regular, bold, italic"):
        width("a", 3, "heavy")
    (tmp_path / "bad.ttf").write_bytes(b"no font at all")
    with pytest.raises(ValueError, match=r"bad\.ttf: not a font"):
        width("a", 3, str(tmp_path / "bad.ttf"))


def test_words_without_size_are_refused():
    with pytest.raises(ValueError, match="size of text is 0"):
        Words.of([("a", 0, 0)], size=0)
