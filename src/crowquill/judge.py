"""The judge: every measure of one drawing, by itself and against its picture, as plain numbers with names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from crowquill import layout, likeness, measure, recipe, spacing, texture
from crowquill.likeness import ToneError
from crowquill.paths import Array
from crowquill.seen import Seen
from crowquill.tone import Tone

ACROSS = 4.0  # pixels to a mean dot, for tone and texture
PIXELS = 12_000_000  # of a drawing looked at; larger ones are looked at more coarsely, and a note says so
ASPECT = 0.01  # by which the shapes of a picture and a drawing may differ
RATIOS = (0.5, 1.0, 1.5, 2.0, 3.0)  # spacings at which texture is reported
CLASSES = 24  # of diameters


@dataclass(frozen=True, eq=False)
class Judged:
    """What was found of a drawing; what cannot be said is None, and `notes` say why.

    box       left, top, width, height in mm of the part of the page that counts
    facts     every figure, as JSON has them
    errors    of tone, one for each blur, where there is a picture
    radial    frequency in cycles a spacing, and power; `pairs` are distance in spacings, and pair correlation
    curves    of texture, against distance in mm
    """

    seen: Seen
    box: tuple[float, float, float, float]
    facts: Mapping[str, Any]
    errors: tuple[ToneError, ...]
    radial: tuple[Array, Array] | None
    pairs: tuple[Array, Array] | None
    curves: texture.Curves


def asked(seen: Seen, picture: Path, settings: Mapping[str, Any]) -> Tone:
    """The tone that a picture asks of a drawing, in the drawing's own size.

    settings  keywords of layout.lit; those left out are the drawing's own where it has a recipe, else the defaults
    Raises ValueError for a picture of another shape than the drawing.
    """
    own = recipe.parsed(seen.recipe, seen.name) if "tone" in seen.recipe else None
    light = dict(own.tone) if own else {}
    named = {key: name for key, name in (recipe.files_of(own) if own else {}).items() if key in light}
    light |= {key: str(Path(seen.name).parent / name) for key, name in named.items()}
    tone = layout.lit(picture, **{**light, **{key: value for key, value in settings.items() if value is not None}})
    _, _, width, height = where(seen)
    if own:
        tone = layout.placed(tone, **own.paper)[1]
    if abs(tone.size[0] / tone.size[1] * height / width - 1) > ASPECT:
        h, w = tone.coverage.shape
        raise ValueError(
            f"{picture}: is {w} x {h} pixels, of another shape than the drawing's {width:.4g} x {height:.4g} mm; "
            "give the picture it was drawn from, or crop it"
        )
    return tone.fitted(width, height, "stretch")


def where(seen: Seen) -> tuple[float, float, float, float]:
    """The part of the page that is drawn on, left, top, width, height in mm: what the recipe says, else all of it."""
    art, at = seen.recipe.get("art_mm"), seen.recipe.get("art_at_mm", (0.0, 0.0))
    return (float(at[0]), float(at[1]), float(art[0]), float(art[1])) if art else (0.0, 0.0, *seen.size)


def of(seen: Seen, tone: Tone | None = None) -> Judged:
    """Every measure of what is seen, against a tone of its size where one is given.

    Without a tone dots are judged as if they should lie evenly on the rectangle around them. Raises ValueError
    for a drawing of fewer than two dots, of which nothing can be said.
    """
    if len(seen.sites) < 2:
        raise ValueError(f"{seen.name}: has {'no dots' if not len(seen.sites) else 'one dot'}; give a drawing of two dots or more")
    box = where(seen) if tone is not None or "art_mm" in seen.recipe else _around(seen)
    sites = np.clip(seen.sites - box[:2], 0, box[2:])
    canvas = Tone(np.ones((1, 1)), (box[2], box[3])) if tone is None else tone
    notes = [*seen.notes]
    pitch = max(float(seen.diameters.mean()) / ACROSS, float(np.sqrt(box[2] * box[3] / PIXELS)))
    if pitch > 1.01 * seen.diameters.mean() / ACROSS:
        notes.append(f"the drawing is large for its dots: it was looked at with pixels of {pitch:.3g} mm")
    dark, pixel = seen.coverage(pitch, box)
    marks = None if seen.marks is None else seen.marks.moved((-box[0], -box[1]))
    found = spacing.of(sites, canvas, marks=marks, weights=seen.areas)
    apart = float(np.sqrt(shapely.area(canvas.canvas) / len(sites)))
    facts: dict[str, Any] = {
        "file": seen.name,
        "size_mm": list(seen.size),
        "box_mm": list(box),
        "dots": len(sites),
        "diameters": _diameters(seen.diameters),
        "ink": _ink(seen, dark, pixel),
        "spacing": found.figures(),
    }
    wanted = None if tone is None else likeness.asked(tone, dark.shape)
    curves, facts["texture"] = _texture(dark, pixel, apart, wanted, sites)
    errors: tuple[ToneError, ...] = ()
    if tone is not None and wanted is not None:
        errors, facts["tone"] = _tone(dark, wanted, pixel, apart, tone)
    facts["notes"] = [*notes, *found.notes]
    return Judged(
        seen,
        box,
        _plain(facts),
        errors,
        None if found.radial is None else (found.radial.frequency, found.radial.power),
        found.pair_curve,
        curves,
    )


def _around(seen: Seen) -> tuple[float, float, float, float]:
    """The rectangle around the dots and half a spacing more, on the page."""
    low, high = seen.sites.min(axis=0), seen.sites.max(axis=0)
    half = float(np.sqrt(np.prod(np.maximum(high - low, 1e-3)) / len(seen.sites))) / 2
    low, high = np.maximum(low - half, 0), np.minimum(high + half, seen.size)
    return (float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1]))


def _diameters(diameters: Array) -> dict[str, Any]:
    """Mean, spread and histogram of dots' diameters in mm."""
    low, high = float(diameters.min()), float(diameters.max())
    counts, edges = np.histogram(diameters, CLASSES, (low, high) if high - low > 1e-6 else (low - 0.005, high + 0.005))
    mean = float(diameters.mean())
    return {"mean_mm": mean, "least_mm": low, "most_mm": high, "cv": float(diameters.std()) / mean if mean else None,
            "edges_mm": edges.tolist(), "counts": counts.tolist()}  # fmt: skip


def _ink(seen: Seen, dark: Array, pixel: tuple[float, float]) -> dict[str, Any]:
    """How much paper is covered, and how much of the dots' own areas lies on one another."""
    marks = seen.marks
    covered = float(dark.sum() * pixel[0] * pixel[1]) if marks is None else measure.ink(marks)
    own = float(seen.areas.sum())
    area = dark.size * pixel[0] * pixel[1]
    alike = marks is not None or seen.pixels is None
    return {
        "coverage": covered / area,
        "ink_mm2": covered,
        "dots_mm2": own,
        "overlap": max(0.0, 1 - covered / own) if own and alike else None,
    }


def _texture(
    dark: Array, pixel: tuple[float, float], apart: float, wanted: Array | None, sites: Array
) -> tuple[texture.Curves, dict[str, Any]]:
    """Curves of texture over the whole, their values at some distances, and the reading of even patches."""
    reading = texture.read(dark, pixel, asked=wanted, dots=sites)
    if reading.patches:
        best = max(reading.patches, key=lambda patch: patch.dots)
        part = dark[best.row : best.row + best.side, best.column : best.column + best.side]
        curves = texture.curves(part, pixel, best.spacing)
    else:
        curves = texture.curves(dark, pixel, apart)
    figures = {
        name: {"mean": curves.mean(RATIOS, name).tolist(), "anisotropy": curves.anisotropy(RATIOS, name).tolist()}
        for name in texture.FEATURES
    }
    read = {"near": reading.near, "far": reading.far, "peak": reading.peak}
    said = {"verdict": reading.verdict, "reasons": list(reading.reasons), **(read if reading.patches else dict.fromkeys(read))}
    return curves, {**said, "patches": len(reading.patches), "distances": list(RATIOS), **figures}


def _tone(dark: Array, wanted: Array, pixel: tuple[float, float], apart: float, tone: Tone) -> tuple[tuple[ToneError, ...], dict[str, Any]]:
    """How near the drawing comes to its picture, after blurs of several widths."""
    share = None if tone.is_rectangle else likeness.asked(replace(tone, values=np.ones_like(tone.coverage)), dark.shape)
    errors = tuple(likeness.tone_error(dark, wanted, pixel, width, within=share) for width in likeness.widths(apart))
    similar, noise = likeness.similarity(dark, wanted, pixel, apart)
    moved = likeness.shift(dark, wanted, pixel, apart)
    rows = []
    for error in errors:
        worst = error.worst
        band = None if worst is None else {"asked": [worst.low, worst.high], "bias": worst.bias, "share": worst.share}
        rows.append({"width_mm": error.width, "bias": error.bias, "rmse": error.rmse, "worst_band": band})
    return errors, {
        "blurs": rows,
        "scored": likeness.scored(dark, wanted),
        "ssim": similar,
        "psnr_db": noise,
        "edges_kept": likeness.edges_kept(dark, wanted, pixel, apart, within=share),
        "shift_mm": [moved.x, moved.y],
        "shift_error_mm": [moved.x_error, moved.y_error],
    }


def _plain(value: Any) -> Any:
    """The value as JSON has it: no infinities, no arrays, no tuples."""
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value
