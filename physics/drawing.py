"""Drawing: a state as shapes, the shapes as data, and the data as an image.

A task draws a state with two shapes, in metres, y up, painted in order:

    Capsule   all points within `radius` of the segment from `start` to `end`; if equal, a disc
    Polygon   the inside of a closed line

Colours are roles, so that a viewer can have its own palette. `rgb_array` paints by signed distance:
a pixel is covered by `1/2 - d / pixel`, which smooths every edge.
"""

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Role = Literal["ground", "body", "link", "joint", "target"]

_BACKGROUND = (255, 255, 255)
_PALETTE: dict[Role, tuple[int, int, int]] = {
    "ground": (190, 190, 190),
    "body": (60, 70, 90),
    "link": (204, 120, 50),
    "joint": (90, 110, 190),
    "target": (60, 150, 90),
}


def _check_role(role: str) -> None:
    if role not in _PALETTE:
        raise ValueError(f"a shape's role must be one of {', '.join(_PALETTE)}, not {role!r}")


@dataclass(frozen=True, slots=True)
class Capsule:
    """A thick segment with round ends."""

    start: Point
    end: Point
    radius: float
    role: Role

    def __post_init__(self) -> None:
        """Refuse an unknown role."""
        _check_role(self.role)


@dataclass(frozen=True, slots=True)
class Polygon:
    """The inside of a closed line through `points`."""

    points: tuple[Point, ...]
    role: Role

    def __post_init__(self) -> None:
        """Refuse an unknown role."""
        _check_role(self.role)


@dataclass(frozen=True, slots=True)
class Drawing:
    """Shapes, and the part of the plane to show: (left, bottom, right, top) in metres."""

    view: tuple[float, float, float, float]
    shapes: tuple[Capsule | Polygon, ...]

    def as_data(self) -> dict[str, Any]:
        """The drawing for JSON: `{"view": [...], "shapes": [{"shape": "capsule", ...}, ...]}`."""
        shapes = [{"shape": type(shape).__name__.lower(), **asdict(shape)} for shape in self.shapes]
        return {"view": list(self.view), "shapes": shapes}

    def rgb_array(self, width: int = 480) -> NDArray[np.uint8]:
        """The drawing as an image [height, width, 3], of the view's proportions.

        The height is even, and the width should be even too: video codecs require it. All frames of
        a moving view have the same height, although the view's size is constant only to rounding.
        """
        left, bottom, right, top = self.view
        pixel = (right - left) / width
        height = 2 * round(round((top - bottom) / (2.0 * pixel), 6))
        x = left + pixel * (np.arange(width) + 0.5)
        y = top - pixel * (np.arange(height) + 0.5)
        image = np.broadcast_to(np.array(_BACKGROUND, float), (height, width, 3)).copy()
        for shape in self.shapes:
            distance = _distance(shape, x[None, :], y[:, None])
            cover = np.clip(0.5 - distance / pixel, 0.0, 1.0)[..., None]
            image += cover * (np.array(_PALETTE[shape.role]) - image)
        pixels: NDArray[np.uint8] = np.rint(image).astype(np.uint8)
        return pixels


def disc(centre: Point, radius: float, role: Role) -> Capsule:
    """A disc around `centre`."""
    return Capsule(centre, centre, radius, role)


def box(centre: Point, width: float, height: float, role: Role, angle: float = 0.0) -> Polygon:
    """A rectangle around `centre`, turned by `angle` (radians, anticlockwise)."""
    cos, sin = np.cos(angle), np.sin(angle)
    corners = [(sx * width / 2, sy * height / 2) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return Polygon(
        tuple(
            (float(centre[0] + cos * dx - sin * dy), float(centre[1] + sin * dx + cos * dy))
            for dx, dy in corners
        ),
        role,
    )


def _distance(
    shape: Capsule | Polygon, x: NDArray[np.floating[Any]], y: NDArray[np.floating[Any]]
) -> NDArray[np.floating[Any]]:
    """The signed distance of the points (x, y) from a shape's edge, negative inside."""
    if isinstance(shape, Capsule):
        return _segment_distance(shape.start, shape.end, x, y) - shape.radius
    nearest = np.full(np.broadcast_shapes(x.shape, y.shape), np.inf)
    inside = np.zeros(nearest.shape, bool)
    for start, end in zip(shape.points, shape.points[1:] + shape.points[:1], strict=True):
        nearest = np.minimum(nearest, _segment_distance(start, end, x, y))
        if start[1] != end[1]:
            # Even-odd rule: whether a ray to the right crosses this edge.
            crossing = start[0] + (y - start[1]) / (end[1] - start[1]) * (end[0] - start[0])
            inside ^= ((start[1] > y) != (end[1] > y)) & (x < crossing)
    return np.where(inside, -nearest, nearest)


def _segment_distance(
    start: Point, end: Point, x: NDArray[np.floating[Any]], y: NDArray[np.floating[Any]]
) -> NDArray[np.floating[Any]]:
    """The distance of the points (x, y) from a segment."""
    along = (end[0] - start[0], end[1] - start[1])
    squared = along[0] ** 2 + along[1] ** 2
    offset_x, offset_y = x - start[0], y - start[1]
    # A segment of no length is its start: any fraction will do.
    fraction = np.clip((offset_x * along[0] + offset_y * along[1]) / (squared or 1.0), 0.0, 1.0)
    distance: NDArray[np.floating[Any]] = np.hypot(
        offset_x - fraction * along[0], offset_y - fraction * along[1]
    )
    return distance
