"""Large pictures are read, planned and placed by bands, and large drawings written piece by piece, to the same numbers and bytes."""

from __future__ import annotations

import hashlib
import io
import zlib
from pathlib import Path

import drawings
import memory
import numpy as np
import pikepdf
import pytest
from PIL import Image

from crowquill import expense, formats, levels, relax
from crowquill.formats import _content, _text
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.stippling import planned
from crowquill.tone import Tone

SHOWN = "int((peak() - before) / 1024)"
# writes a drawing of so many dots in a format, and prints by how many MB the peak rose
WRITING = f"""
import sys
from crowquill import formats
from test_large import dotted
sheet = dotted(int(sys.argv[1]))
formats.save(dotted(100), "small." + sys.argv[2], **dict.fromkeys(sys.argv[3:], True))
before = peak()
formats.save(sheet, "large." + sys.argv[2], **dict.fromkeys(sys.argv[3:], True))
print({SHOWN})
"""
# reads a picture, plans so many dots on it and places them, and prints by how many MB the peak rose
PLACING = f"""
import sys
import numpy as np
import scipy.ndimage
from pathlib import Path
from crowquill import layout, relax
from crowquill.stippling import planned
before = peak()
size, tone = layout.placed(layout.lit(Path(sys.argv[1]), max_pixels=10**9), paper="1000x1000mm")
plan = planned(tone, pen=0.24, dots=int(sys.argv[2]), white=0.02, white_rule="before", min_gap=0.0, max_dots=10**8)
assert len(relax.scatter(plan.demand, plan.dots, np.random.default_rng(0))) == int(sys.argv[2])
for top in range(0, tone.shape[0], 100):
    plan.demand.prefix_of(top, top + 100)
print({SHOWN})
"""


class Pipe(io.RawIOBase):
    """An open file that only takes what is written, one piece behind the other."""

    def __init__(self) -> None:
        self.data = b""

    def writable(self) -> bool:
        return True

    def write(self, data: object) -> int:
        piece = bytes(data)  # type: ignore[call-overload]
        self.data += piece
        return len(piece)


def dotted(n: int) -> Sheet:
    return Sheet((210, 297), (Layer(Ink(), drawings.marks(n)),), {"style": "stipple"})


def wave(h: int, w: int) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(0, 1, w), np.linspace(0, 1, h))
    return np.clip(0.5 + 0.5 * np.sin(9 * x) * np.cos(7 * y), 0, 1)


@pytest.mark.parametrize(
    "options", [{}, {"white_rule": "after", "white": 0.3}, {"min_gap": 0.2}, {"span": (0.6, 1.6)}, {"dots": 5000, "pen": None}]
)
def test_a_plan_made_by_bands_is_that_of_the_whole_bit_for_bit(options: dict[str, object], monkeypatch: pytest.MonkeyPatch) -> None:
    asked = {"pen": 0.5, "dots": None, "white": 0.02, "white_rule": "before", "min_gap": 0.0, "max_dots": 10**6, **options}
    whole = planned(Tone(wave(131, 97), (97, 131)), **asked)
    monkeypatch.setattr(levels, "BAND", 500)
    bands = planned(Tone(wave(131, 97), (97, 131)), **asked)
    assert (bands.dots, bands.pen, bands.ink, bands.largest) == (whole.dots, whole.pen, whole.ink, whole.largest)
    for name in ("demand", "nominal"):
        assert getattr(bands, name).coverage.tobytes() == getattr(whole, name).coverage.tobytes()
    assert bands.white.tobytes() == whole.white.tobytes()


def test_a_picture_kept_as_codes_takes_as_many_dots_at_the_same_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Image.fromarray((255 * wave(160, 200)).astype(np.uint8)).save(tmp_path / "wave.png")
    found = []
    for large in (levels.LARGE, 1000):
        monkeypatch.setattr(levels, "LARGE", large)
        monkeypatch.setattr(levels, "BAND", 3000)
        tone = Tone.load(tmp_path / "wave.png", width=100)
        plan = planned(tone, pen=0.5, dots=None, white=0.02, white_rule="before", min_gap=0.0, max_dots=10**6)
        found.append((tone, plan, relax.scatter(plan.demand, 4000, np.random.default_rng(1))))
    (tone, plan, sites), (coded, coarse, near) = found
    assert tone.levels.table is None and coded.levels.codes.dtype == np.uint8 and coarse.demand.levels.codes.dtype == np.uint16
    assert coded.coverage.tobytes() == tone.coverage.tobytes() and coded.ink == pytest.approx(tone.ink, rel=1e-12)
    assert coarse.white.tobytes() == plan.white.tobytes()
    assert coarse.dots == pytest.approx(plan.dots, rel=1e-4)
    # half a code of 65535 moves a place along the curve by a pixel now and then, and no further
    assert np.quantile(np.hypot(*(near - sites).T), 0.99) < 2 * max(tone.pixel)


@pytest.mark.parametrize(("format", "knobs"), [("svg", {}), ("svg", {"separate": True}), ("pdf", {}), ("pdf", {"compact": True})])
def test_a_file_is_the_same_by_pieces_of_any_size_and_wherever_it_goes(
    format: str, knobs: dict[str, bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sheet, pipe = dotted(3000), Pipe()
    data = formats.to_bytes(sheet, format, **knobs)
    monkeypatch.setattr(_content, "HELD", 1000)  # bytes packed before a file is taken
    monkeypatch.setattr(_content, "WAITING", 0)
    formats.save(sheet, tmp_path / f"a.{format}", **knobs)
    formats.save(sheet, pipe, format=format, **knobs)
    assert (tmp_path / f"a.{format}").read_bytes() == data == pipe.data
    assert [path.name for path in tmp_path.iterdir()] == [f"a.{format}"]


def test_a_page_s_operators_are_those_of_all_its_outlines_and_nothing_else() -> None:
    sheet = dotted(40_000)  # some elements
    with pikepdf.open(io.BytesIO(formats.to_bytes(sheet, "pdf"))) as pdf:
        stream = pdf.pages[0].Contents
        content, raw = stream.read_bytes(), stream.read_raw_bytes()
        assert bytes(pdf.trailer["/ID"][0]) == hashlib.md5(content, usedforsecurity=False).digest()
    want = [f"q\n{_text.pdf_path(paths)}f\nQ" for paths in _text.chunks(sheet.marks)]
    assert len(want) > 2 and "\n".join(want).encode() in content
    assert raw == zlib.compress(content, _content.LEVEL)


def test_an_error_in_the_middle_of_a_page_leaves_no_thread_and_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: object) -> str:
        raise ValueError("no such dot")

    monkeypatch.setattr("crowquill.formats._page.pdf_path", broken)
    with pytest.raises(ValueError, match="no such dot"):
        formats.save(dotted(100), tmp_path / "a.pdf")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("arguments", "most"), [(("svg",), 45), (("pdf",), 85), (("pdf", "compact"), 75)])
def test_two_hundred_thousand_dots_are_written_in_little_memory(
    arguments: tuple[str, ...], most: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    numbers, _ = memory.taken(WRITING, "200000", *arguments)
    assert numbers[0] < most, numbers  # as outlines they are 22 MB of SVG and 50 MB of operators


def test_nine_million_pixels_are_planned_and_placed_in_thirty_bytes_each(tmp_path: Path) -> None:
    Image.fromarray((255 * wave(3000, 3000)).astype(np.uint8)).save(tmp_path / "wave.png")
    code = "from crowquill import levels\nlevels.LARGE = 1_000_000\n" + PLACING
    numbers, _ = memory.taken(code, str(tmp_path / "wave.png"), "100000")
    assert numbers[0] < 270, numbers  # a byte for the picture, two for the plan, one for white; the rest is bands under way


@pytest.mark.soak
def test_four_hundred_million_pixels_and_ten_million_dots_are_placed_and_written_in_three_gigabytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.tile((255 * wave(1000, 1000)).astype(np.uint8), (20, 20))).save("large.png", compress_level=1)
    numbers, kilobytes = memory.taken(PLACING, "large.png", "10000000")
    assert numbers[0] < 2600 and kilobytes < 2_800_000, numbers
    for arguments in (("svg",), ("pdf", "compact"), ("pdf",)):
        _, kilobytes = memory.taken(WRITING, "10000000", *arguments)
        assert kilobytes < 4_000_000, (arguments, kilobytes)


def test_what_is_foretold_is_no_less_than_what_is_taken(tmp_path: Path) -> None:
    Image.fromarray((255 * wave(800, 1000)).astype(np.uint8)).save(tmp_path / "wave.png")
    code = """
import sys
from crowquill.__main__ import main
common = ["stipple", sys.argv[1], sys.argv[1] + ".svg", "--quiet", "--iterations", "2", "--paper", "420x420mm"]
main([*common, "--dots", "500"])
before = peak()
main([*common, "--dots", "150000"])
print(int((peak() - before) / 1024))
"""
    numbers, _ = memory.taken(code, str(tmp_path / "wave.png"))
    foretold = expense.relaxed(150_000, (800, 1000)) / 1e6
    assert 0.4 * foretold < numbers[0] < foretold, (numbers, foretold)


def test_a_start_leaves_no_sums_with_the_tone() -> None:
    tone = Tone(wave(200, 200), (100, 100))
    assert len(relax.scatter(tone, 6000, np.random.default_rng(0), "levels")) == 6000
    assert "prefix" not in vars(tone)
