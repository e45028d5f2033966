"""Extended graphics states and transparency groups: what they change, and what is noted of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pikepdf

from crowquill.preflight import operators as op
from crowquill.preflight.document import Met
from crowquill.preflight.values import real, text

if TYPE_CHECKING:
    from crowquill.preflight.walker import Walker

BLENDS = ("/Normal", "/Compatible")


def applied(walk: Walker, state: Any, name: str) -> None:
    """Puts an extended graphics state into the state, and notes what not every kind of file may have."""
    now, met = walk.canvas.now, walk.met
    for key, at in (("/LW", op.WIDTH), ("/LC", op.CAP), ("/ca", op.FILL_ALPHA), ("/CA", op.STROKE_ALPHA)):
        if key in state:
            now[at] = float(state[key])
    if "/OP" in state:
        now[op.STROKE_OVER] = bool(state.OP)
    if "/op" in state or "/OP" in state:
        now[op.FILL_OVER] = bool(state.get("/op", state.get("/OP")))
    for key in ("/ca", "/CA"):
        if float(state.get(key, 1)) < 1:
            met.note("transparency", f"{key[1:]} {float(state[key]):g} in state {name}")
    if state.get("/SMask", pikepdf.Name("/None")) != pikepdf.Name("/None"):
        met.note("transparency", f"a soft mask in state {name}")
    blend = state.get("/BM")
    modes = [text(mode) for mode in blend] if isinstance(blend, pikepdf.Array) else [text(blend)] if blend is not None else []
    if any(mode not in BLENDS for mode in modes[:1]):
        met.note("transparency", f"blend mode {modes[0][1:]} in state {name}")
    if "/TR" in state or state.get("/TR2", pikepdf.Name.Default) != pikepdf.Name.Default:
        met.note("transfer", f"a transfer function in state {name}")
    if "/HTP" in state:
        met.note("halftones", f"a halftone phase in state {name}")
    halftone = state.get("/HT")
    if isinstance(halftone, (pikepdf.Dictionary, pikepdf.Stream)):
        if "/HalftoneName" in halftone or int(halftone.get("/HalftoneType", 1)) not in (1, 5):
            met.note("halftones", f"a named halftone, or one of a type that is not 1 or 5, in state {name}")
        if "/TransferFunction" in halftone:
            met.note("transfer", f"a halftone's transfer function in state {name}")
    if "/Font" in state:
        walk.font(state.Font[0])
        now[op.SIZE] = float(state.Font[1])


def group(met: Met, found: Any) -> None:
    """Notes a page's or a form's transparency group, and the space that it blends in."""
    made = found.get("/Group")
    if isinstance(made, pikepdf.Dictionary) and made.get("/S") == pikepdf.Name.Transparency:
        met.note("transparency", "a transparency group")
        blends = made.get("/CS")
        if blends is not None:
            kind = text(blends[0] if isinstance(blends, pikepdf.Array) else blends)[1:]
            n = f"{real(blends[1].get('/N'), 0):g}" if kind == "ICCBased" and isinstance(blends[1], pikepdf.Stream) else ""
            met.note("blends", {"ICCBased3": "DeviceRGB", "ICCBased4": "DeviceCMYK", "ICCBased1": "DeviceGray"}.get(kind + n, kind))
