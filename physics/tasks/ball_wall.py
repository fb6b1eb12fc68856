"""BallWall: throw a ball over a wall, with contact of any stiffness: where exact gradients mislead.

After the ball and the wall of Suh, Simchowitz, Zhang and Tedrake (Do Differentiable Simulators Give
Better Policy Gradients?, 2022): the return jumps where a throw just clears the wall, and the
stiffer the contact, the fewer throws have derivatives that tell of the jump, exact as they are.

    s = (x, y, vx, vy)
    x'' = F g clip(a_x) + contact,    y'' = F g clip(a_y) - 9.81 + contact
    r = -sqrt((x' - 2)^2 + (y' - 0.15)^2 + 1e-4)

A hand at (-2.5, 1) m pushes the ball by up to F = 40 N in each direction while it reaches it: at
the distance rho, g = 1 / (1 + exp((rho^2 - 1) / 0.2)). The ball (1 kg, radius 0.15 m) starts in it,
the wall stands at x = 0, 1.2 m high with a round top and 0.2 m thick, and the target lies behind.

Contact is a spring with damping, `stiffness` (N/m) times how deep the ball is in ground or wall:

    normal k d max(0, 1 - 0.3 v.n)        n the unit vector away from what is touched, d the depth
    along the ground -0.5 k d vx

A step is 0.04 s: of as many substeps as its stiffness needs (40 at the usual 1e4 N/m), each a drift
of half its length, a kick, and another drift. Free flight is exact.

Glossary:
    x, y, vx, vy   place (m) and velocity (m/s) of the ball's centre
    a              push of the hand, as a share of F
"""

import math

import numpy as np

from physics.drawing import Capsule, Drawing, box, disc
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    IntArray,
    Pieces,
    clip_sides,
)
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
TARGET = 2.0
SOFTNESS = 1e-4  # m^2, rounds the tip of the distance to the target

SOFTEST, STIFFEST = 2e3, 1e6
"""N/m. A softer wall would let the ball through; a stiffer one needs more than 400 substeps."""
USUAL = 1e4

VIEW = (-3.4, -0.3, 3.4, 3.0)
CLEARANCE = 0.4  # m from the ball's centre to the edge of the view, which moves along to keep it

# What a contact does in a substep, as `pieces` has it; and the regimes of a step.
OFF, PUSHES, LETS_GO = 0, 1, 2
WALL_TOP = 3
FLIGHT, CLIPPED, GROUND, SIDE, TOP = 0, 1, 2, 3, 4


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
    """Add a contact's force and its derivatives; return what it does.

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
    """Add the wall's force; return what it does, plus WALL_TOP where its round top does."""
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
    """Add the ground's force; return what it does."""
    depth = RADIUS - y
    if depth > 0.0:
        force[0] -= FRICTION * stiffness * depth * v[0]
        by_q[0, 1] += FRICTION * stiffness * v[0]
        by_v[0, 0] -= FRICTION * stiffness * depth
    return _push(depth, (0.0, 1.0), 0.0, stiffness, v, force, by_q, by_v)


@compiled
def _carry(tangent: FloatArray, h: float, grip: float, by_q: FloatArray, by_v: FloatArray) -> None:
    """Carry the tangent [4, 6] over the kick of a substep of h; q is at the half."""
    for column in range(6):
        change_0, change_1 = 0.0, 0.0
        if column == 4:
            change_0 = grip
        elif column == 5:
            change_1 = grip
        for j in range(2):
            change_0 += by_q[0, j] * tangent[j, column] + by_v[0, j] * tangent[2 + j, column]
            change_1 += by_q[1, j] * tangent[j, column] + by_v[1, j] * tangent[2 + j, column]
        tangent[2, column] += h * change_0
        tangent[3, column] += h * change_1


@compiled
def _drift(tangent: FloatArray, h: float) -> None:
    """Carry the tangent over a drift of h."""
    for column in range(6):
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
        tangent: derivatives [4, 6] in state and push, identity before; unused if [0, 6].
        touches: [substeps, 2], filled with what wall and ground do; unused if [0, 2].
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
            _drift(tangent, half)
            _carry(tangent, h, grip, by_q, by_v)
            _drift(tangent, half)
        if touches.shape[0] > 0:
            touches[substep, 0], touches[substep, 1] = wall, ground
        vx += h * force[0]
        vy += h * force[1]
        x += half * vx
        y += half * vy
    next_state[0], next_state[1], next_state[2], next_state[3] = x, y, vx, vy


@compiled
def target_distance(x: float, y: float) -> float:
    """Distance from the target, rounded at its tip."""
    return math.sqrt((x - TARGET) ** 2 + (y - RADIUS) ** 2 + SOFTNESS)


@compiled
def step_rows(
    stiffness: float,
    substeps: int,
    states: FloatArray,
    pushes: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    tangents: FloatArray,
    touches: IntArray,
) -> None:
    """Step every row.

    Args:
        stiffness: of all contacts (N/m).
        substeps: of a step.
        states: [batch, 4].
        pushes: [batch, 2], within the box.
        next_states: [batch, 4], filled.
        rewards: [batch], filled.
        tangents: [batch, 4, 6], filled with the derivatives; or [0, 4, 6].
        touches: [batch, substeps, 2], filled with what wall and ground do; or [0, substeps, 2].
    """
    nothing, nowhere = np.empty((0, 6)), np.empty((0, 2), np.int64)
    for row in range(states.shape[0]):
        tangent = tangents[row] if tangents.shape[0] > 0 else nothing
        touched = touches[row] if touches.shape[0] > 0 else nowhere
        for i in range(tangent.shape[0]):
            for j in range(6):
                tangent[i, j] = 1.0 if i == j else 0.0
        move(stiffness, substeps, states[row], pushes[row], next_states[row], tangent, touched)
        rewards[row] = -target_distance(next_states[row, 0], next_states[row, 1])


class BallWall(Environment):
    """A ball to be thrown over a wall, and to come to lie behind it."""

    name = "BallWall"
    version = 1
    state_size = 4
    action_size = 2
    horizon = 60
    max_reward = 0.0
    step_seconds = DT
    rounding = 4e-15  # contact multiplies that of a place by some hundred
    regimes = ("flight", "clipped", "ground", "wall", "top of the wall")

    def __init__(self, stiffness: float = USUAL) -> None:
        """Make it of some stiffness.

        Args:
            stiffness: of ball against ground and wall (N/m), from SOFTEST to STIFFEST.

        Raises:
            ValueError: for another stiffness.
        """
        if not SOFTEST <= stiffness <= STIFFEST:
            raise ValueError(
                f"stiffness must be from {SOFTEST:g} to {STIFFEST:g} N/m, not {stiffness!r}"
            )
        self.stiffness = float(stiffness)
        self.substeps = math.ceil(DT * math.sqrt(stiffness) / 0.1)

    def step_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
    ) -> int:
        """Step every row; see `Environment.step_kernel`."""
        self._move(states, actions, next_states, rewards, np.empty((0, 4, 6)))
        terminated[:] = False
        return -1

    def differentiate_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
        state_jacobians: FloatArray,
        action_jacobians: FloatArray,
        reward_state_gradients: FloatArray,
        reward_action_gradients: FloatArray,
        reward_next_state_gradients: FloatArray,
    ) -> int:
        """Step and differentiate every row; see `Environment.differentiate_kernel`."""
        tangents = np.empty((len(states), 4, 6))
        self._move(states, actions, next_states, rewards, tangents)
        terminated[:] = False
        state_jacobians[:] = tangents[:, :, :4]
        action_jacobians[:] = (
            np.where(np.abs(actions) <= 1.0, 1.0, 0.0)[:, None] * tangents[:, :, 4:]
        )
        reward_state_gradients[:] = 0.0
        reward_action_gradients[:] = 0.0
        reward_next_state_gradients[:] = 0.0
        from_target = next_states[:, :2] - [TARGET, RADIUS]
        reward_next_state_gradients[:, :2] = from_target / rewards[:, None]
        return -1

    def _move(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        tangents: FloatArray,
        touches: IntArray | None = None,
    ) -> None:
        if touches is None:
            touches = np.empty((0, self.substeps, 2), np.int64)
        pushes = np.clip(actions, -1.0, 1.0)
        step_rows(
            self.stiffness, self.substeps, states, pushes, next_states, rewards, tangents, touches
        )

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """In the hand, nearly at rest."""
        return generator.uniform([-2.6, 0.9, -0.1, -0.1], [-2.4, 1.1, 0.1, 0.1])

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """What wall and ground do in each substep, and the clip of the push."""
        states, actions = self._checked(states, actions)
        touches = np.empty((len(states), self.substeps, 2), np.int64)
        rewards = np.empty(len(states))
        self._move(states, actions, np.empty_like(states), rewards, np.empty((0, 4, 6)), touches)
        beyond = clip_sides(actions)
        wall, ground = touches[..., 0], touches[..., 1]
        regime = np.select(
            [
                (wall >= WALL_TOP).any(axis=1),
                (wall != OFF).any(axis=1),
                (ground != OFF).any(axis=1),
                beyond.any(axis=1),
            ],
            [TOP, SIDE, GROUND, CLIPPED],
            FLIGHT,
        )
        return Pieces(regime, np.concatenate([touches.reshape(len(states), -1), beyond], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """A quarter each: anywhere in the air, on the ground, against the wall, on its top."""
        kind = np.arange(count) % 4
        x, y = generator.uniform(-2.8, 2.8, count), generator.uniform(0.2, 2.8, count)
        speed = np.where(kind == 1, 2.0, 5.0)
        vx, vy = generator.uniform(-speed, speed), generator.uniform(-speed, speed)
        y[kind == 1] = generator.uniform(0.14, 0.17, np.count_nonzero(kind == 1))
        side = np.where(x > 0.0, 1.0, -1.0)
        x[kind == 2] = (side * generator.uniform(0.22, 0.3, count))[kind == 2]
        angle = generator.uniform(0.0, math.pi, count)
        reach = generator.uniform(TOUCH - 0.03, TOUCH + 0.05, count)
        x[kind == 3] = (reach * np.cos(angle))[kind == 3]
        y[kind == 3] = (HEIGHT + reach * np.sin(angle))[kind == 3]
        return np.stack([x, y, vx, vy], axis=1), generator.uniform(-1.2, 1.2, (count, 2))

    def draw(self, state: FloatArray) -> Drawing:
        """The ball, the wall, the hand, and where the ball should come to lie; the view follows."""
        x, y = float(state[0]), float(state[1])
        left, bottom, right, top = VIEW
        aside = min(x - CLEARANCE - left, 0.0) + max(x + CLEARANCE - right, 0.0)
        up = max(y + CLEARANCE - top, 0.0)
        left, bottom, right, top = left + aside, bottom + up, right + aside, top + up
        return Drawing(
            (left, bottom, right, top),
            (
                box(((left + right) / 2, VIEW[1] / 2), right - left, -VIEW[1], "ground"),
                disc((HAND_X, HAND_Y), 0.05, "joint"),
                disc((TARGET, RADIUS), RADIUS, "target"),
                Capsule((0.0, 0.0), (0.0, HEIGHT), TOUCH - RADIUS, "ground"),
                disc((x, y), RADIUS, "body"),
            ),
        )
