"""Contact sheets: a glyph library as a page to look at, and a scan with what was found on it and what was not."""

from __future__ import annotations

from textwrap import wrap

import numpy as np

from crowquill.glyphs import Library
from crowquill.glyphs.scanning import Scan
from crowquill.lettering import text
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.plots import joined
from crowquill.sheet import Ink, Layer, Sheet

PAGE = (210.0, 297.0)  # mm, A4
MARGIN = 15.0
COLUMNS, PITCH = 8, 22.5  # of enlarged dots
LARGE = 15.0  # mm, about the length of the largest when enlarged
MOST = 80  # dots that a page shows
WIDE = 105  # letters to a line
GREY = Ink("grey", (0.0, 0.0, 0.0, 0.55))
REASONS = {
    "dust": (0.0, 0.3, 1.0, 0.0),
    "merged": (0.0, 1.0, 1.0, 0.0),
    "giant": (0.7, 0.0, 1.0, 0.1),
    "cut by the border": (1.0, 0.4, 0.0, 0.0),
    "ruler": (0.6, 0.0, 0.2, 0.3),
}
OTHER = (0.3, 0.9, 0.0, 0.1)


def of_library(library: Library) -> Sheet:
    """A page of A4: what is known of a library, its dots enlarged and numbered with their diameters, and a row at true size."""
    sizes = np.array([glyph.size for glyph in library.glyphs])
    shown = min(len(sizes), MOST)
    about, pen = library.about, library.about.get("pen_mm")
    made = "SIMULATED, not scanned" if about.get("simulated") else "scanned" if "simulated" in about else "of unknown making"
    reach = max(glyph.reach * glyph.size for glyph in library.glyphs[:shown]) * np.sqrt(np.pi) / 2
    times = max(1, int(LARGE / 2 / reach))
    facts = [
        f"{len(sizes)} dots, {made}; " + (f"pen {pen:g} mm" if isinstance(pen, (int, float)) else "pen not stated"),
        f"diameters {sizes.min():.3f} to {sizes.max():.3f} mm, mean {sizes.mean():.3f}, spread {sizes.std() / sizes.mean():.1%}",
        f"enlarged {times} times{f'; the first {MOST} of them' if shown < len(sizes) else ''}; below, at true size",
    ]
    for key in ("made", "source", "licence"):
        facts += wrap(f"{key}: {about[key]}"[:500], WIDE) if isinstance(about.get(key), str) else []
    words = [text(library.name, MARGIN, MARGIN + 6, size=7)]
    words += [text(line, MARGIN, MARGIN + 12 + 4.2 * k, size=2.8) for k, line in enumerate(facts)]
    top = MARGIN + 20 + 4.2 * len(facts)
    at = _grid(shown, (MARGIN, top))
    numbers = [text(f"{k + 1}", x - 9, y - 7, size=2.2) for k, (x, y) in enumerate(at.tolist())]
    widths = [text(f"{size:.3f}", x, y + 10, size=2.2, anchor="middle") for size, (x, y) in zip(sizes, at.tolist(), strict=False)]
    rows = -(-shown // COLUMNS)
    true = np.stack([MARGIN + 2 + (np.arange(shown) % 60) * 3.0, top + rows * PITCH + 4 + np.arange(shown) // 60 * 3.0], axis=1)
    which = np.arange(shown)
    scale = sizes[:shown] * np.sqrt(np.pi) / 2
    layers = (
        Layer(Ink(), joined(words), "words"),
        Layer(GREY, joined([*numbers, *widths]), "numbers"),
        Layer(Ink(), Marks.of(at, library.glyphs, scale=scale * times, glyph=which), f"enlarged {times} times"),
        Layer(Ink(), Marks.of(true, library.glyphs, scale=scale, glyph=which), "true size"),
    )
    return Sheet((PAGE[0], max(PAGE[1], true[:, 1].max() + MARGIN)), layers)


def of_scan(scan: Scan) -> Sheet:
    """The scanned page at true size: dots found in black, what was rejected in a box of its reason's colour, and a legend."""
    width, height = scan.size
    legend = [f"{len(scan.outlines)} dots", *(f"{count} {reason}" for reason, count in sorted(scan.counts.items()))]
    size = min(4.0, max(1.0, width / 40))
    room = size * 1.5 * (len(legend) + 0.5)
    layers = [
        Layer(Ink(), scan.outlines.moved(np.eye(2), (0, room)), legend[0]),
        Layer(Ink(), text(legend[0], size / 2, 1.5 * size, size=size)),
    ]
    for k, reason in enumerate(sorted(scan.counts), 1):
        ink = Ink(reason, REASONS.get(reason, OTHER))
        around = np.array([-0.1, room - 0.1, 0.1, room + 0.1])
        boxes = around + [box for why, box in scan.rejected if why == reason]
        rings = boxes[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
        layers.append(Layer(Ink(reason, ink.cmyk, 0.05), Paths.of(rings), legend[k]))
        layers.append(Layer(ink, text(legend[k], size / 2, 1.5 * size * (k + 1), size=size)))
    return Sheet((width, height + room), tuple(layers))


def _grid(n: int, corner: tuple[float, float]) -> Array:
    """The middles of n squares in rows, (n, 2) mm."""
    row, column = np.divmod(np.arange(n), COLUMNS)
    return (np.stack([column, row], axis=1) + 0.5) * PITCH + corner
