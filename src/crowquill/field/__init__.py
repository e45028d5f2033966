"""Directions, edges, lines and distances of a picture, in millimetres: what marks turn by, and what rows of dots and tiles follow."""

from crowquill.field.directions import Field, along, strokes
from crowquill.field.finding import contrast, edges, isophotes
from crowquill.field.flow import Sight, lines, tangents
from crowquill.field.grids import between
from crowquill.field.reach import Distances, distances
from crowquill.field.rows import Rows, weighed

__all__ = [
    "Distances",
    "Field",
    "Rows",
    "Sight",
    "along",
    "between",
    "contrast",
    "distances",
    "edges",
    "isophotes",
    "lines",
    "strokes",
    "tangents",
    "weighed",
]
