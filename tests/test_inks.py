"""Inks are understood by name, letter, mix and colour; lists of them are put in order, and what is no list is refused in one line."""

from __future__ import annotations

import numpy as np
import pytest

from crowquill import inks
from crowquill.sheet import Ink


def test_process_inks_go_by_letters_and_names_whatever_their_case():
    assert [ink.name for ink in inks.several("K, c,Magenta,YELLOW")] == ["yellow", "cyan", "magenta", "black"]
    assert not any(ink.spot for ink in inks.several("C,M,Y,K"))


@pytest.mark.parametrize("text", ["ochre=#c8922b, black", "black,ochre=#C8922B", "spot:ochre=#c8922b ,K", "ochre=0,0.27,0.785,0.2157,k"])
def test_an_ink_with_a_colour_of_its_own_is_a_spot_ink_below_the_darker_one(text: str):
    ochre, black = inks.several(text)
    assert ochre == Ink("ochre", (0.0, 0.27, 0.785, 0.2157), spot=True) and black == Ink()
    assert ochre.rgb == (0xC8, 0x92, 0x2B)


def test_a_mix_among_others_keeps_its_four_shares():
    names = [(ink.name, ink.cmyk) for ink in inks.several("sand = .1,.2, 0.3,.0 ,PANTONE 124 C=0,0.3,0.9,0,K")]
    assert names == [("sand", (0.1, 0.2, 0.3, 0.0)), ("PANTONE 124 C", (0.0, 0.3, 0.9, 0.0)), ("black", (0.0, 0.0, 0.0, 1.0))]


def test_inks_look_as_files_show_them():
    cyan, black = inks.looks(inks.several("C,K"))
    assert cyan.tolist() == [0, 1, 1] and black.tolist() == [0, 0, 0]
    assert inks.looks([Ink("grey", (0, 0, 0, 0.5))])[0] == pytest.approx([0.2158] * 3, abs=1e-3)  # code 128 of sRGB


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "names none"),
        (" , ,", "names none"),
        ("ochre", "'ochre' is not understood"),
        ("ochre=#c8922", "is not understood"),
        ("ochre=#c8922bb", "is not understood"),
        ("C;M", "is not understood"),
        ("a=0.1,0.2,0.3", "is not understood"),
        ("a=0.1,0.2,0.3,0.4,0.5", "'0.5' is not understood"),
        ("a=0,0,0,2", "is not understood"),
        ("a=nan,0,0,1", "is not understood"),
        ("Ä=#c8922b", "plain letters"),
        ("cyan=#00aeef,K", "may not be a process ink's"),
        ("C,M,C", "'cyan' is named twice"),
        ("a=#c8922b,A=#102030", "'A' is named twice|'a' is named twice"),
        ("a=#c8922b,b=#c8922b", "of one colour"),
        ("a=#c8922b,b=#c9912c", "of one colour"),
        ("a=#000000,K", "of one colour"),
        ("white=#ffffff,K", "prints nothing"),
        ("spot:white=0,0,0,0,K", "prints nothing"),
        ("snow=#fefefe,K", "prints nothing"),
        (",".join(f"i{k}=#{k}0{k}000" for k in range(1, 10)), "9, over the limit of 8"),
    ],
)
def test_what_is_no_list_of_inks_is_refused_with_a_remedy(text: str, said: str):
    with pytest.raises(ValueError, match=said) as error:
        inks.several(text)
    assert "; " in str(error.value) and "\n" not in str(error.value)


def test_eight_inks_are_taken_from_the_lightest_to_the_darkest():
    found = inks.several(",".join(f"i{k}=#{k}0{k}000" for k in range(8, 0, -1)))
    light = inks.looks(found) @ inks.LUMINANCE
    assert len(found) == 8 and (np.diff(light) < 0).all()
