"""Picture: a state of a model as shapes in a plane, and as an image by MuJoCo's own renderer.

Capsules, cylinders and spheres are drawn as capsules, boxes and meshes as the hull of their
corners, and a ground seen from the side as a line. The view follows a model that is not fixed in
place.
"""

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from physics.drawing import Capsule, Drawing, Point, Polygon, Role, disc
from physics.environment import FloatArray
from physics.mujoco.engine import mujoco

Plane = Literal["xz", "xy", "yz"]
AXES: dict[Plane, tuple[int, int]] = {"xz": (0, 2), "xy": (0, 1), "yz": (1, 2)}
"""Plane -> the axes that point right and up."""
ROOM = 0.85
"""Half the width of the view, in widths of the model."""
NARROWEST = 0.1
"""The least width of a model (m) for its view."""
SHAPE = 0.6
"""The height of the view, in its widths."""
LAST_SHOWN_GROUP = 2
"""The last group of geoms that is drawn, as in MuJoCo's viewers."""
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_GEOM = mujoco.mjtGeom


class Frame(NamedTuple):
    """The view of a model at rest, in its plane: its middle and half its size, each [2]."""

    centre: FloatArray
    half: FloatArray


def frame_of(model: Any, data: Any, plane: Plane) -> Frame:
    """The frame of a model whose data is at rest: all of it but grounds, with a margin."""
    axes, solid = list(AXES[plane]), model.geom_type != _GEOM.mjGEOM_PLANE
    # Bodies too: a body may have no geoms.
    places = np.concatenate([data.geom_xpos[solid], data.xpos])[:, axes]
    reach = np.concatenate([model.geom_rbound[solid], np.zeros(model.nbody)])[:, None]
    low, high = (places - reach).min(axis=0), (places + reach).max(axis=0)
    width = max(*((high - low) / (1.0, SHAPE)), NARROWEST)
    return Frame((low + high) / 2, ROOM * width * np.array([1.0, SHAPE]))


def drawing(model: Any, data: Any, plane: Plane, frame: Frame) -> Drawing:
    """A drawing of data whose positions are up to date."""
    view = _view(model, data, plane, frame)
    shapes = (
        _shape(model, data, geom, plane, view)
        for geom in range(model.ngeom)
        if model.geom_group[geom] <= LAST_SHOWN_GROUP and model.geom_rgba[geom, 3] > 0
    )
    return Drawing(view, tuple(shape for shape in shapes if shape is not None))


def photograph(
    model: Any, data: Any, width: int, height: int, camera: str | int
) -> NDArray[np.uint8]:
    """An image [height, width, 3] by MuJoCo's renderer.

    Raises:
        RuntimeError: where there is no OpenGL to render with.
        ValueError: for a camera that the model does not have.
    """
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    try:
        renderer = mujoco.Renderer(model, height, width)
    except Exception as error:  # the error depends on the platform's library
        raise RuntimeError(
            "MuJoCo's renderer needs OpenGL, and found none it can use: without a screen, set the "
            "environment variable MUJOCO_GL=egl (or osmesa) before Python starts, and install "
            f"libegl1 (or libosmesa6); draw() needs none ({type(error).__name__}: {error})"
        ) from error
    try:
        renderer.update_scene(data, camera)
        image: NDArray[np.uint8] = renderer.render().copy()
    finally:
        renderer.close()
    return image


def _view(model: Any, data: Any, plane: Plane, frame: Frame) -> tuple[float, float, float, float]:
    """Left, bottom, right and top of what is shown."""
    centre, half = frame
    away = data.subtree_com[_first_moving_body(model)][list(AXES[plane])] - centre
    # Along the ground the view moves at once; up and down, when the middle comes near its edge.
    slack = np.where(_moves_along(model), [0.0, half[1] / 2 if plane != "xy" else 0.0], half / 2)
    centre = centre + away - np.clip(away, -slack, slack)
    left, bottom = (centre - half).tolist()
    right, top = (centre + half).tolist()
    return left, bottom, right, top


def _first_moving_body(model: Any) -> int:
    return int(np.flatnonzero(model.body_weldid)[0])


def _moves_along(model: Any) -> bool:
    """Whether the model can leave its place, by a free joint or a slide without limits."""
    slides = (model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE) & (model.jnt_limited == 0)
    return bool((slides | (model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)).any())


def _shape(
    model: Any, data: Any, geom: int, plane: Plane, view: tuple[float, float, float, float]
) -> Capsule | Polygon | None:
    """A geom in the plane; None if it is not drawn."""
    kind, size, role = int(model.geom_type[geom]), model.geom_size[geom], _role(model, geom)
    place, turn = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    axes = list(AXES[plane])
    if kind == _GEOM.mjGEOM_PLANE:
        return _ground(place[axes], turn[axes, 2], view)
    if kind in (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_ELLIPSOID):
        return disc(_point(place[axes]), float(size.max()), role)
    if kind in (_GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER):
        along = size[1] * turn[axes, 2]
        return Capsule(
            _point(place[axes] - along), _point(place[axes] + along), float(size[0]), role
        )
    corners = _corners(model, geom, kind, size)
    return None if corners is None else Polygon(_hull((place + corners @ turn.T)[:, axes]), role)


def _corners(model: Any, geom: int, kind: int, size: FloatArray) -> FloatArray | None:
    """The corners [k, 3] of a box or a mesh in the geom's frame; None of anything else."""
    if kind == _GEOM.mjGEOM_BOX:
        return _CORNERS * size
    if kind == _GEOM.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return np.asarray(model.mesh_vert[first : first + count], np.float64)
    return None


def _ground(
    place: FloatArray, normal: FloatArray, view: tuple[float, float, float, float]
) -> Capsule | None:
    """A ground seen from the side, as wide as the view; None if it is seen from above."""
    if np.hypot(*normal) < 1e-6:
        return None
    left, bottom, right, top = view
    along = np.array([normal[1], -normal[0]]) / np.hypot(*normal)
    middle = place + along * ((np.array([left + right, bottom + top]) / 2 - place) @ along)
    radius = 0.01 * (right - left)
    sunk = middle - radius * normal / np.hypot(*normal)
    reach = (right - left) * along
    return Capsule(_point(sunk - reach), _point(sunk + reach), radius, "ground")


def _role(model: Any, geom: int) -> Role:
    """The role of a geom in the viewer's palette."""
    body = int(model.geom_bodyid[geom])
    if "target" in f"{model.geom(geom).name} {model.body(body).name}":
        return "target"
    if not model.body_weldid[body]:
        return "ground"
    return "body" if body == _first_moving_body(model) else "link"


def _hull(points: FloatArray) -> tuple[Point, ...]:
    """The convex hull of points [k, 2], anticlockwise (Andrew's monotone chain)."""
    ordered = [_point(point) for point in np.unique(np.round(points, 9), axis=0)]
    return (*_chain(ordered), *_chain(ordered[::-1]))


def _chain(points: list[Point]) -> Iterator[Point]:
    """One side of the hull, without its last point."""
    side: list[Point] = []
    for point in points:
        while len(side) > 1 and _turn(side[-2], side[-1], point) <= 0.0:
            side.pop()
        side.append(point)
    return iter(side[:-1])


def _turn(a: Point, b: Point, c: Point) -> float:
    """A number above 0 if a, b, c turn left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _point(place: FloatArray) -> Point:
    return float(place[0]), float(place[1])
