"""A plotter's sheet is strokes alone that put down the ink of the drawing, in layers a pen, with the time they take."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from drawings import everything, marks, same

from crowquill import formats, lettering, plotting
from crowquill.marks import Glyph, Marks
from crowquill.paths import Paths
from crowquill.plotting import Machine, dots_for, expected, plotted
from crowquill.sheet import Ink, Layer, Sheet, check_bar

Array = npt.NDArray[np.float64]
DISC = Glyph.of(Paths.of([[(np.cos(t), np.sin(t)) for t in np.linspace(0, 2 * np.pi, 64, endpoint=False)]]))
RED = Ink("red", (0.0, 1.0, 1.0, 0.0))


def lines(*strokes: list[tuple[float, float]]) -> Paths:
    return Paths.of(strokes, closed=False)


def sheet(*layers: Layer, size: tuple[float, float] = (100, 80), **more: object) -> Sheet:
    return Sheet(size, layers, **more)  # type: ignore[arg-type]


def row(n: int, width: float = 0.3) -> Marks:
    """Dots 10 mm apart from (10, 10)."""
    return Marks.of(np.stack([10 + 10 * np.arange(n), np.full(n, 10.0)], axis=1), (DISC,), scale=width * np.sqrt(np.pi) / 2)


def lengths(paths: Paths) -> Array:
    return np.array([np.hypot(*np.diff(path, axis=0).T).sum() for path in paths])


def check_strokes(plot: Sheet) -> None:
    """Raises AssertionError unless every layer is open straight strokes of a pen, none too short for plotting programs."""
    for layer in plot.layers:
        assert layer.ink.pen is not None, f"{layer.label} fills"
        assert isinstance(layer.art, Paths) and not layer.art.closed and not layer.art.cubic, layer.label
        # a tick of 0.02 mm whose ends are rounded to whole micrometres
        assert len(layer.art) == 0 or lengths(layer.art).min() > 0.018, f"{layer.label} has a stroke of no length"


@pytest.mark.parametrize("dot", plotting.FORMS)
def test_all_that_a_sheet_can_hold_becomes_strokes(dot: str) -> None:
    drawing = everything()
    plot = plotted(drawing, dot=dot)
    check_strokes(plot)
    assert plot.size == drawing.size and plot.recipe == drawing.recipe
    assert plot.report["plot"]["dots"] == len(drawing.layers[0].art) + len(drawing.layers[1].art)


def test_the_check_of_strokes_sees_a_fill_and_a_stroke_of_no_length() -> None:
    with pytest.raises(AssertionError, match="fills"):
        check_strokes(sheet(Layer(Ink(), lines([(1, 1), (2, 2)]))))
    with pytest.raises(AssertionError, match="no length"):
        check_strokes(sheet(Layer(Ink(pen=0.3), lines([(1, 1), (1, 1)]))))


def test_the_same_sheet_gives_the_same_bytes_and_comes_back_from_svg() -> None:
    plots = [plotted(everything(), dot="spiral", codes="axidraw") for _ in range(2)]
    data = [formats.to_bytes(plot, "svg") for plot in plots]
    assert data[0] == data[1]
    same(formats.load(io.BytesIO(data[0])), plots[0])


def test_a_plotted_sheet_plots_to_itself_but_for_its_order() -> None:
    once = plotted(sheet(Layer(Ink(), row(5))))
    again = plotted(once)
    assert [layer.ink for layer in again.layers] == [layer.ink for layer in once.layers]
    assert sorted(lengths(once.layers[0].art)) == pytest.approx(sorted(lengths(again.layers[0].art)))


def test_strokes_keep_their_pen_and_fills_take_the_finest_of_their_ink() -> None:
    line = lines([(1, 1), (9, 9)])
    drawn = sheet(
        Layer(Ink(pen=0.5), line), Layer(Ink(pen=0.2), line), check_bar(10, 70), Layer(RED, row(3)), Layer(Ink(), row(2), "0.7 mm"),
        Layer(Ink(), row(2)),
    )  # fmt: skip
    names = [layer.name for layer in plotted(drawn).layers]
    assert names == ["1 black 0.5", "2 black 0.2", "3 red 0.3", "4 black 0.7"]
    assert [layer.name for layer in plotted(drawn, nib=0.35).layers] == ["1 black 0.35", "2 red 0.35"]


def test_layers_of_one_pen_become_one_and_keep_all_their_strokes() -> None:
    plot = plotted(sheet(Layer(Ink(), row(3)), Layer(Ink(pen=0.3), lines([(1, 50), (9, 50)])), Layer(Ink(), row(2).moved((0, 20)))))
    assert [(layer.name, len(layer.art)) for layer in plot.layers] == [("1 black 0.3", 6)]
    assert plot.report["plot"]["dots"] == 5


def test_axidraw_codes_follow_the_number_and_pause_before_each_pen() -> None:
    plot = plotted(sheet(Layer(Ink(), row(4)), Layer(RED, row(2))), codes="axidraw", split_dots=3, speed_down=55.225)
    assert [layer.name for layer in plot.layers] == ["1+S25 black 0.3", "!2+S25 black 0.3 part 2", "!3+S25 red 0.3"]


def test_documentation_layers_are_strokes_that_are_not_counted() -> None:
    note = Layer(Ink(), lettering.text("front", 10, 70), "% note")
    plot = plotted(sheet(note, Layer(Ink(), row(2))))
    check_strokes(plot)
    assert [layer.name for layer in plot.layers] == ["% note", "1 black 0.3"]
    assert plot.report["plot"]["strokes"] == 2


def test_splits_keep_to_their_limits_and_lose_nothing() -> None:
    whole = plotted(sheet(Layer(Ink(), marks(300)), size=(210, 297)))
    total = whole.report["plot"]
    for limit, key, most in (("split_dots", "dots", 50), ("split_distance", "pen_down_mm", 7.0), ("split_time", "seconds", 30.0)):
        plot = plotted(sheet(Layer(Ink(), marks(300)), size=(210, 297)), **{limit: most})  # type: ignore[arg-type]
        parts = plot.report["plot"]["layers"]
        # a part's own figures hold the ways from the corner and back, which are drawn in the pauses
        ways = [2 * 364 / 100 if key == "seconds" else 0] * len(parts)
        assert all(part[key] <= most + way + 1e-6 for part, way in zip(parts, ways, strict=True))
        assert len(parts) >= total[key] / most - 1 and len(parts) > 3
        np.testing.assert_array_equal(np.concatenate([layer.art.xy for layer in plot.layers]), whole.layers[0].art.xy)
        assert [part["name"].split(" ", 1)[1] for part in parts[:2]] == ["black 0.3", "black 0.3 part 2"]


def test_a_stroke_longer_than_a_split_is_cut_in_equal_pieces() -> None:
    plot = plotted(sheet(Layer(Ink(pen=0.3), lines([(0, 0), (60, 0), (60, 40)]))), split_distance=30)
    assert [part["pen_down_mm"] for part in plot.report["plot"]["layers"]] == pytest.approx([25] * 4)


def test_figures_are_those_of_a_small_drawing_by_hand() -> None:
    art = lines([(30, 40), (60, 40)])
    tick = Layer(Ink(), row(1), "")
    machine = {"speed_down": 10.0, "speed_up": 50.0, "lift": 0.5, "dwell": 2.0}
    told = plotted(sheet(Layer(Ink(pen=0.3), art)), **machine).report["plot"]  # type: ignore[arg-type]
    assert (told["strokes"], told["dots"], told["lifts"], told["pen_down_mm"]) == (1, 0, 1, 30)
    assert told["pen_up_mm"] == pytest.approx(50 + np.hypot(60, 40))
    assert told["seconds"] == pytest.approx(3 + told["pen_up_mm"] / 50 + 0.5)
    told = plotted(sheet(tick), dot="tick", **machine).report["plot"]  # type: ignore[arg-type]
    assert told["pen_down_mm"] == pytest.approx(0.02)
    assert told["seconds"] == pytest.approx(0.002 + 2 * np.hypot(10, 10) / 50 + 0.5 + 2, abs=1e-4)


def test_totals_are_sums_of_the_layers() -> None:
    plot = plotted(everything()).report["plot"]
    for key in ("strokes", "dots", "lifts", "pen_down_mm", "pen_up_mm", "seconds"):
        assert plot[key] == pytest.approx(sum(layer[key] for layer in plot["layers"]))


def test_lines_that_meet_are_drawn_in_as_few_strokes_as_there_are_pairs_of_odd_ends() -> None:
    """A net of squares 4 by 4: 8 odd corners a trail begins or ends at, hence 4 and more trails, and each line once."""
    step = np.arange(4.0)
    level = [[(x, y), (x + 1, y)] for y in step for x in step[:-1]]
    upright = [[(x, y), (x, y + 1)] for y in step[:-1] for x in step]
    chance = np.random.default_rng(2)
    shuffled = [[*line][:: chance.choice([-1, 1])] for line in np.array(level + upright)[chance.permutation(24)].tolist()]
    plot = plotted(sheet(Layer(Ink(pen=0.1), lines(*[[(10 * x + 20, 10 * y + 20) for x, y in line] for line in shuffled]))))
    art = plot.layers[0].art
    assert 4 <= len(art) <= 6
    sides = {tuple(sorted(map(tuple, pair))) for path in art for pair in np.stack([path[:-1], path[1:]], axis=1).tolist()}
    assert len(sides) == 24 and lengths(art).sum() == pytest.approx(240)


def test_strokes_are_ordered_for_less_travel_than_they_came_with() -> None:
    chance = np.random.default_rng(3)
    art = Marks.of(chance.uniform(10, 70, (2000, 2)), (DISC,), scale=0.26)
    told = plotted(sheet(Layer(Ink(), art))).report["plot"]
    given = np.hypot(*np.diff(art.xy, axis=0).T).sum()
    assert told["pen_up_mm"] < given / 15
    # expected() says what routes through even chance take, within some percent, and leaves out the way from the corner and back
    assert told["pen_up_mm"] - 2 * np.hypot(10, 10) == pytest.approx(plotting.TOUR * np.sqrt(2000 * 60**2), rel=0.1)
    assert told["seconds"] == pytest.approx(expected(2000, 60**2), rel=0.02)


def test_dots_for_a_time_are_the_most_that_are_expected_to_fit_in_it() -> None:
    slow = Machine(10, 20, 0.6, 0.3)
    for seconds in (0.0, 1.0, 59.0, 7200.0, 1e6):
        for nib, dot, machine in ((0.3, "circle", Machine()), (0.7, "tick", slow)):
            n = dots_for(seconds, 5e4, nib=nib, dot=dot, machine=machine)
            assert expected(n, 5e4, nib=nib, dot=dot, machine=machine) <= seconds * (1 + 1e-9)
            assert expected(n + 1, 5e4, nib=nib, dot=dot, machine=machine) > seconds


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"speed_down": 0}, "speed_down is 0; it takes a number from 0.1 to 5000 mm/s"),
        ({"speed_up": 0}, "speed_up is 0; "),
        ({"lift": -1}, "lift is -1; "),
        ({"nib": 0.004}, "nib is 0.004; it takes a number from 0.01 to 20 mm"),
        ({"nib": 15}, "nib 15 mm is wider than the page of 12 x 12 mm"),
        ({"nib": float("nan")}, "nib is nan; "),
        ({"dot": "cross"}, "no dot 'cross'; there are circle, tick, spiral, hatch"),
        ({"codes": "saxi"}, "no codes 'saxi'; there are plain, axidraw"),
        ({"split_distance": 0}, "split_distance is 0; "),
        ({"split_dots": 1.5}, "split_dots is 1.5; it takes a whole number"),
        ({"split_time": 0}, "split_time is 0; "),
    ],
)
def test_bad_settings_are_refused_in_one_line(given: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError) as caught:
        plotted(sheet(Layer(Ink(), row(1)), size=(12, 12)), **given)  # type: ignore[arg-type]
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)


def test_a_layer_finer_than_the_machine_and_too_many_layers_are_refused() -> None:
    with pytest.raises(ValueError, match=r"nib 0\.005 mm of layer 'hair' is finer than a plotter's step; "):
        plotted(sheet(Layer(Ink(pen=0.005), lines([(1, 1), (2, 2)]), "hair")))
    crowd = Marks.of(np.random.default_rng(1).uniform(5, 75, (1001, 2)), (DISC,), scale=0.26)
    with pytest.raises(ValueError, match="1001 layers, over the limit of 1000"):
        plotted(sheet(Layer(Ink(), crowd)), split_dots=1)


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf")])
def test_no_dots_are_planned_for_a_time_that_is_none(seconds: float) -> None:
    with pytest.raises(ValueError, match="time for plotting is"):
        dots_for(seconds, 100)


def test_dots_of_another_width_than_the_nib_are_said() -> None:
    odd = sheet(Layer(Ink(), row(3, 0.1)), Layer(RED, row(2, 2.0)), report={"warnings": ["before"]})
    said = plotted(odd).report["warnings"]
    assert [words.split(" ", 4)[:4] for words in said[1:]] == [["3", "dots", "of", "'black'"], ["2", "dots", "of", "'red'"]]
    assert said[0] == "before" and "finer" in said[1] and "spiral or hatch" in said[2]
    assert len(plotted(odd, dot="hatch").report["warnings"]) == 2


def test_awkward_art_has_an_answer() -> None:
    nothing = plotted(sheet(Layer(Ink(), Paths.of([])), Layer(Ink(), row(3, 0.0))))
    assert nothing.layers == () and nothing.report["plot"]["seconds"] == 0
    points = [[(5, 5)], [(6, 6), (6, 6)], [(7, 7), (8, 7), (9, 7)], []]
    for ink in (Ink(), Ink(pen=0.3)):
        for closed in (False, True):
            plot = plotted(sheet(Layer(ink, Paths.of(points, closed=closed))))
            check_strokes(plot)
            # a filled line of no area draws nothing; a closed point is a disc, an open one nothing, as on paper
            assert plot.report["plot"]["strokes"] == (0 if ink.pen is None else 3 if closed else 2)


def test_inks_of_one_name_and_two_colours_stay_apart() -> None:
    other = replace(RED, name="black")
    names = [layer.name for layer in plotted(sheet(Layer(Ink(), row(2)), Layer(other, row(2)))).layers]
    assert names == ["1 black 0.3", "2 black 0.3"]
