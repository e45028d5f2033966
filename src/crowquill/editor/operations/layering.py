"""Operations on layers and their inks."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

import numpy as np

from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.items import Items
from crowquill.editor.operations import operation
from crowquill.knobs import Flag, Numbers, Range, Text
from crowquill.sheet import Ink

MOST = 200  # layers

Of = Annotated[int, Range(1, 10**6, "", "its number")]
LONGEST = 100  # letters of a name
Name = Annotated[str | None, Text("shown in editors")]
Cmyk = Annotated[tuple[float, ...] | None, Numbers(0, 1, "", "shares of cyan, magenta, yellow and black", 4)]
Pen = Annotated[float | None, Range(0, 50, "mm", "width of strokes; 0 fills")]
Spot = Annotated[str | None, Text("a spot ink by its name in the swatch book, whose look the mix is; an empty one: a process ink")]


@operation("layer")
def layer_add(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    name: Name = None,
    cmyk: Cmyk = None,
    pen: Pen = None,
    spot: Spot = None,
) -> Drawing:
    """Add a layer at the top; black and filled where nothing else is said."""
    if len(drawing.layers) >= MOST:
        raise ValueError(f"there are {MOST} layers, as many as there may be; remove one")
    new = Layer(drawing.next_layer, _plain(name or ""), _inked(Ink(), cmyk, pen, spot), Items.none())
    return replace(drawing, layers=(*drawing.layers, new), next_layer=drawing.next_layer + 1, facts={"layer": new.id})


@operation("layer")
def layer_edit(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    layer: Of = 1,
    name: Name = None,
    cmyk: Cmyk = None,
    pen: Pen = None,
    spot: Spot = None,
    hidden: Annotated[bool | None, Flag("neither shown nor written")] = None,
    locked: Annotated[bool | None, Flag("shown, and not changed")] = None,
) -> Drawing:
    """Change a layer: its name, ink or pen, whether it is hidden or locked. What is left out stays.

    A mix alone makes a process ink of a spot ink.
    """
    found = drawing.layer(layer)
    changes: dict[str, Any] = {key: value for key, value in (("hidden", hidden), ("locked", locked)) if value is not None}
    if name is not None:
        changes["name"] = _plain(name)
    ink = _inked(found.ink, cmyk, pen, spot)
    if found.still and ink != found.ink:
        raise ValueError(f"layer {found.name!r} is not edited here; only its name, place and whether it is hidden can change")
    return drawing.with_layers(replace(found, ink=ink, **changes))


@operation("layer")
def layer_remove(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    layer: Of = 1,
) -> Drawing:
    """Remove a layer and all that is in it."""
    found = drawing.layer(layer)
    return replace(drawing, layers=tuple(one for one in drawing.layers if one.id != found.id))


@operation("layer")
def layer_order(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    layer: Of = 1,
    to: Annotated[int, Range(0, MOST, "", "its place from the bottom, which is 0")] = 0,
) -> Drawing:
    """Bring a layer to another place among the others."""
    found = drawing.layer(layer)
    rest = [one for one in drawing.layers if one.id != found.id]
    return replace(drawing, layers=(*rest[:to], found, *rest[to:]))


@operation("layer")
def layer_take(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    layer: Of = 1,
) -> Drawing:
    """Bring the selection into a layer."""
    (target,) = drawing.free(layer)
    parts = [target.items]
    for other in list(drawing.free()):
        mask = other.items.selected & ~other.items.frozen
        if other.id != target.id and mask.any():
            parts.append(other.items.take(mask))
            drawing = drawing.with_items({other.id: other.items.take(~mask)})
    return drawing.with_items({target.id: Items.joined(parts)}) if len(parts) > 1 else drawing


def _plain(name: str) -> str:
    """A name without letters that files cannot hold."""
    return "".join(letter if letter.isprintable() else "?" for letter in name[:LONGEST])


def _inked(ink: Ink, cmyk: tuple[float, ...] | None, pen: float | None, spot: str | None) -> Ink:
    """The ink with another mix, pen or name; a process ink is named by its mix. Raises ValueError for what is no name of a spot ink."""
    cyan, magenta, yellow, black = mix = ink.cmyk if cmyk is None else cmyk
    if spot:
        ink = replace(ink, name=spot.strip(), cmyk=(cyan, magenta, yellow, black), spot=True)
    elif cmyk is not None or (spot is not None and ink.spot):
        name = "black" if mix == (0.0, 0.0, 0.0, 1.0) else "c{:.0f} m{:.0f} y{:.0f} k{:.0f}".format(*(100 * share for share in mix))
        ink = replace(ink, name=name, cmyk=(cyan, magenta, yellow, black), spot=False)
    return ink if pen is None else replace(ink, pen=pen or None)
