"""The ball of BallWall in motion: the hand, gravity, and contact with ground and wall.

The equations and their letters are those of ball_wall.py. A substep is a drift of half
its length, a kick by the forces there, and another drift; derivatives are carried along.
"""

import math

import numpy as np

from physics.environment import FloatArray, IntArray
from physics.kernels.compiled import compiled

DT = 0.04
GRAVITY = 9.81
FORCE = 40.0  # N, over 1 kg
HAND_X, HAND_Y = -2.5, 1.0
REACH, FADING = 1.0, 0.2  # m^2
RADIUS = 0.15
HEIGHT = 1.2  # of the centre of the wall's round top
TOUCH = RADIUS + 0.1  # m between the ball's centre and the wall's middle when they touch
DAMPING = 0.3  # s/m
FRICTION = 0.5  # s/m

OFF, PUSHES, LETS_GO = 0, 1, 2
"""The states of a contact in a substep."""
WALL_TOP = 3
"""Added to the state of the wall's contact where the ball touches the round top."""


@compiled
def _push(
    depth: float,
    n: tuple[float, float],
    curvature: float,
    stiffness: float,
    v: tuple[float, float],
    force: FloatArray,
    by_q: FloatArray,
    by_v: FloatArray,
) -> int:
    """Add a contact's force and its derivatives; return the contact's state.

    `curvature` is that of the surface at the contact: d n / d q = curvature (1 - n n^T).
    """
    if depth <= 0.0:
        return OFF
    factor = 1.0 - DAMPING * (v[0] * n[0] + v[1] * n[1])
    if factor <= 0.0:
        return LETS_GO
    speed_along = (v[0] - n[0] * (1.0 - factor) / DAMPING, v[1] - n[1] * (1.0 - factor) / DAMPING)
    for i in range(2):
        force[i] += stiffness * depth * factor * n[i]
        for j in range(2):
            turn = curvature * ((1.0 if i == j else 0.0) - n[i] * n[j])
            slower = -DAMPING * curvature * speed_along[j]
            by_q[i, j] += stiffness * (
                factor * (depth * turn - n[i] * n[j]) + depth * n[i] * slower
            )
            by_v[i, j] -= stiffness * depth * DAMPING * n[i] * n[j]
    return PUSHES


@compiled
def _touch_wall(
    q: tuple[float, float],
    v: tuple[float, float],
    stiffness: float,
    force: FloatArray,
    by_q: FloatArray,
    by_v: FloatArray,
) -> int:
    """Add the wall's force; return the contact's state, plus WALL_TOP at the round top."""
    x, y = q
    if y < HEIGHT:
        n, distance, curvature, where = (1.0 if x > 0.0 else -1.0, 0.0), abs(x), 0.0, 0
    else:
        distance = math.sqrt(x * x + (y - HEIGHT) ** 2)
        curvature, where = 1.0 / max(distance, 1e-9), WALL_TOP
        n = (x * curvature, (y - HEIGHT) * curvature)
    does = _push(TOUCH - distance, n, curvature, stiffness, v, force, by_q, by_v)
    return does + where if does != OFF else OFF


@compiled
def _touch_ground(
    y: float,
    v: tuple[float, float],
    stiffness: float,
    force: FloatArray,
    by_q: FloatArray,
    by_v: FloatArray,
) -> int:
    """Add the ground's force; return the contact's state."""
    depth = RADIUS - y
    if depth > 0.0:
        force[0] -= FRICTION * stiffness * depth * v[0]
        by_q[0, 1] += FRICTION * stiffness * v[0]
        by_v[0, 0] -= FRICTION * stiffness * depth
    return _push(depth, (0.0, 1.0), 0.0, stiffness, v, force, by_q, by_v)


@compiled
def _carry(
    tangent: FloatArray,
    h: float,
    grip: float,
    by_stiffness: tuple[float, float],
    by_q: FloatArray,
    by_v: FloatArray,
) -> None:
    """Carry the tangent over the kick of a substep of length h; q is at its middle."""
    for column in range(tangent.shape[1]):
        change_0, change_1 = 0.0, 0.0
        if column == 4:
            change_0 = grip
        elif column == 5:
            change_1 = grip
        elif column == 6:
            change_0, change_1 = by_stiffness
        for j in range(2):
            change_0 += by_q[0, j] * tangent[j, column] + by_v[0, j] * tangent[2 + j, column]
            change_1 += by_q[1, j] * tangent[j, column] + by_v[1, j] * tangent[2 + j, column]
        tangent[2, column] += h * change_0
        tangent[3, column] += h * change_1


@compiled
def _drift(tangent: FloatArray, h: float) -> None:
    """Carry the tangent over a drift of h."""
    for column in range(tangent.shape[1]):
        for i in range(2):
            tangent[i, column] += h * tangent[2 + i, column]


@compiled
def move(
    stiffness: float,
    substeps: int,
    state: FloatArray,
    push: FloatArray,
    next_state: FloatArray,
    tangent: FloatArray,
    touches: IntArray,
) -> None:
    """Move one ball [4] over a step, pushed by `push` [2] within the box.

    Args:
        stiffness: of all contacts (N/m).
        substeps: of the step.
        state: [4].
        push: [2], clipped.
        next_state: [4], filled.
        tangent: derivatives [4, 6] in state and push, identity before, or [4, 7] in the stiffness
            as well; unused if [0, 6].
        touches: [substeps, 2], filled with the contacts of wall and ground; unused if [0, 2].
    """
    h, half = DT / substeps, 0.5 * DT / substeps
    x, y, vx, vy = state[0], state[1], state[2], state[3]
    force, by_q, by_v = np.empty(2), np.empty((2, 2)), np.empty((2, 2))
    for substep in range(substeps):
        x += half * vx
        y += half * vy
        from_hand = (x - HAND_X, y - HAND_Y)
        far = from_hand[0] ** 2 + from_hand[1] ** 2 - REACH
        grip = FORCE / (1.0 + math.exp(far / FADING))
        slope = -2.0 * grip * (1.0 - grip / FORCE) / FADING
        force[0], force[1] = grip * push[0], grip * push[1] - GRAVITY
        for i in range(2):
            for j in range(2):
                by_q[i, j] = slope * push[i] * from_hand[j]
                by_v[i, j] = 0.0
        wall = _touch_wall((x, y), (vx, vy), stiffness, force, by_q, by_v)
        ground = _touch_ground(y, (vx, vy), stiffness, force, by_q, by_v)
        if tangent.shape[0] > 0:
            contact = (
                (force[0] - grip * push[0]) / stiffness,
                (force[1] - (grip * push[1] - GRAVITY)) / stiffness,
            )
            _drift(tangent, half)
            _carry(tangent, h, grip, contact, by_q, by_v)
            _drift(tangent, half)
        if touches.shape[0] > 0:
            touches[substep, 0], touches[substep, 1] = wall, ground
        vx += h * force[0]
        vy += h * force[1]
        x += half * vx
        y += half * vy
    next_state[0], next_state[1], next_state[2], next_state[3] = x, y, vx, vy
