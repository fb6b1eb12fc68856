"""Film: the drawings of an episode's states as data, small enough to send.

    styles  the distinct looks of shapes: shape, role, radius (of a capsule)
    frames  one per state, its shapes in the order of painting: [style, x, y, x, y, ...]
    views   (left, bottom, right, top) of each frame; a single one where all are the same

Coordinates are in metres, rounded to tenths of a millimetre.
"""

from collections.abc import Sequence
from typing import Any

from physics.drawing import Capsule, Drawing, Polygon

DECIMALS = 4


def film(drawings: Sequence[Drawing]) -> dict[str, Any]:
    """The film of one or more drawings, as data for JSON."""
    styles: dict[tuple[str, str, float], int] = {}
    frames = [
        [
            [styles.setdefault(_style(shape), len(styles)), *_rounded(_points(shape))]
            for shape in drawing.shapes
        ]
        for drawing in drawings
    ]
    views = [_rounded([drawing.view]) for drawing in drawings]
    return {
        "styles": [
            {"shape": shape, "role": role, "radius": radius} for shape, role, radius in styles
        ],
        "frames": frames,
        "views": views if any(view != views[0] for view in views) else views[:1],
    }


def _style(shape: Capsule | Polygon) -> tuple[str, str, float]:
    radius = round(shape.radius, DECIMALS) if isinstance(shape, Capsule) else 0.0
    return type(shape).__name__.lower(), shape.role, radius


def _points(shape: Capsule | Polygon) -> Sequence[Sequence[float]]:
    return (shape.start, shape.end) if isinstance(shape, Capsule) else shape.points


def _rounded(points: Sequence[Sequence[float]]) -> list[float]:
    return [round(number, DECIMALS) for point in points for number in point]
