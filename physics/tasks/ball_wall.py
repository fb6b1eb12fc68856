"""BallWall: throw a ball over a wall, with contact of any stiffness: where exact gradients mislead.

After the ball and the wall of Suh, Simchowitz, Zhang and Tedrake (Do Differentiable Simulators Give
Better Policy Gradients?, 2022): the return jumps where a throw just clears the wall, and the
stiffer the contact, the fewer throws have derivatives that show the jump, although they are exact.

    s = (x, y, vx, vy)
    x'' = F g clip(a_x) + contact,    y'' = F g clip(a_y) - 9.81 + contact
    r = -sqrt((x' - 2)^2 + (y' - 0.15)^2 + 1e-4)

A hand at (-2.5, 1) m pushes the ball by up to F = 40 N in each direction while it reaches the ball:
at the distance rho, g = 1 / (1 + exp((rho^2 - 1) / 0.2)). The ball (1 kg, radius 0.15 m) starts in
the hand, the wall stands at x = 0, 1.2 m high with a round top and 0.2 m thick, and the target lies
behind it.

Contact is a spring with damping, `stiffness` (N/m) times how deep the ball is in ground or wall:

    normal k d max(0, 1 - 0.3 v.n)        n the unit vector away from what is touched, d the depth
    along the ground -0.5 k d vx

A step is 0.04 s. The number of its substeps depends on the stiffness (40 at the usual 1e4 N/m).
Each substep is a drift of half its length, a kick, and another drift. Free flight is exact.

Glossary:
    x, y, vx, vy   place (m) and velocity (m/s) of the ball's centre
    a              push of the hand, as a share of F
"""

import math
from functools import cached_property

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
from physics.parameter import Parameter
from physics.tasks.ball_motion import (
    DT,
    HAND_X,
    HAND_Y,
    HEIGHT,
    OFF,
    RADIUS,
    TOUCH,
    WALL_TOP,
    move,
)

TARGET = 2.0
SOFTNESS = 1e-4  # m^2, rounds the tip of the distance to the target

SOFTEST, STIFFEST = 2e3, 1e6
"""N/m. A softer wall would let the ball through; a stiffer one needs more than 400 substeps."""
USUAL = 1e4

VIEW = (-3.4, -0.3, 3.4, 3.0)
CLEARANCE = 0.4  # m from the ball's centre to the edge of the view, which moves to keep this

# Indices into BallWall.regimes.
FLIGHT, CLIPPED, GROUND, SIDE, TOP = 0, 1, 2, 3, 4


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
        substeps: their number in a step.
        states: [batch, 4].
        pushes: [batch, 2], within the box.
        next_states: [batch, 4], filled.
        rewards: [batch], filled.
        tangents: [batch, 4, 6] or [batch, 4, 7], filled with the derivatives in state, push and
            stiffness; or [0, 4, 6].
        touches: [batch, substeps, 2], filled with the contacts of wall and ground, or [0, ...].
    """
    nothing, nowhere = np.empty((0, 6)), np.empty((0, 2), np.int64)
    for row in range(states.shape[0]):
        tangent = tangents[row] if tangents.shape[0] > 0 else nothing
        touched = touches[row] if touches.shape[0] > 0 else nowhere
        for i in range(tangent.shape[0]):
            for j in range(tangent.shape[1]):
                tangent[i, j] = 1.0 if i == j else 0.0
        move(stiffness, substeps, states[row], pushes[row], next_states[row], tangent, touched)
        rewards[row] = -target_distance(next_states[row, 0], next_states[row, 1])


class BallWall(Environment):
    """A ball that must be thrown over a wall and come to rest behind it."""

    name = "BallWall"
    version = 1
    state_size = 4
    action_size = 2
    horizon = 60
    max_reward = 0.0
    step_seconds = DT
    rounding = 4e-15  # contact multiplies the rounding of a place by about a hundred
    regimes = ("flight", "clipped", "ground", "wall", "top of the wall")

    stiffness = Parameter(
        USUAL, "N/m", least=SOFTEST, greatest=STIFFEST, meaning="of ball against ground and wall"
    )

    @cached_property
    def substeps(self) -> int:
        """The number of substeps of a step, which depends on the stiffness."""
        return math.ceil(DT * math.sqrt(self.stiffness) / 0.1)

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

    def parameter_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_by_parameter: FloatArray,
        reward_by_parameter: FloatArray,
    ) -> None:
        """Differentiate every row in the stiffness, with the number of substeps held constant."""
        del reward_by_parameter  # the stiffness affects only the ball's motion
        tangents = np.empty((len(states), 4, 7))
        self._move(states, actions, np.empty_like(states), np.empty(len(states)), tangents)
        next_by_parameter[:, :, 0] = tangents[:, :, 6]

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
        """The contacts of wall and ground in each substep, and the clip of the push."""
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
        """The ball, the wall, the hand, and the ball's target; the view follows."""
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
