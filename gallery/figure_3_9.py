"""Objects, their Voronoi regions, and the axes of both, an object's solid and a region's dashed: at the start, and at rest.

Size on paper: 180 x 92 mm, two panels of 80 x 80 mm.
Source: S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003.
"""

from pathlib import Path

import numpy as np
import shapely

from crowquill import Ink, Layer, Paths, Sheet, save
from crowquill.objects import Objects
from crowquill.relax import settle

OUTLINES = ([(0, 0), (16, 0), (16, 6), (0, 6)], [(0, 0), (18, 0), (4, 9)], [(0, 0), (16, 0), (16, 4), (5, 4), (5, 10), (0, 10)])
CORNERS = [(9, 5), (42, 8), (16, 50), (34, 34), (56, 24), (54, 54)]  # mm, where they start


def make() -> Sheet:
    objects = Objects.of_paths(Paths.of(np.array(OUTLINES[k % 3]) + corner for k, corner in enumerate(CORNERS)))
    states = settle(objects, shapely.box(0, 0, 80, 80), sampling=0.1)
    first, last = next(states), next(state for state in states if state.at_rest or state.done == 300)

    dash = np.arange(0, 1, 0.06)[:, None, None] + np.array([0, 0.036])[:, None]  # of an axis
    layers = []
    for state, right in ((first, 0), (last, 88)):
        begin, end = np.moveaxis(state.axes().xy.reshape(-1, 2, 1, 1, 2), 1, 0)
        dashes = Paths.of((begin + dash * (end - begin)).reshape(-1, 2, 2), closed=False)
        regions, _ = Paths.of_polygons(state.regions())
        drawn = ((0.12, regions), (0.35, state.objects.rings()[0]), (0.25, state.objects.axes()), (0.25, dashes))
        layers += [Layer(Ink(pen=pen), paths.moved(np.eye(2), (right, 0)), "lines") for pen, paths in drawn]
    return Sheet((168, 80), tuple(layers)).on((180, 92), margin=6)


if __name__ == "__main__":
    out = Path(__file__).parent / "out" / Path(__file__).stem
    out.parent.mkdir(exist_ok=True)
    save(make(), out.with_suffix(".pdf"), out.with_suffix(".svg"))
