"""The cart and pole: the machine that CartPole and CartPoleSwingUp share (Barto and others, 1983).

    w        = (F + m l omega^2 sin theta) / M
    alpha    = (g sin theta - w cos theta) / (l (4/3 - m cos^2 theta / M))
    x''      = w - m l alpha cos theta / M

which solve the two equations of motion

    M x'' + m l (alpha cos theta - omega^2 sin theta) = F          (horizontal momentum)
    4/3 l alpha + x'' cos theta                       = g sin theta    (angular momentum)

Glossary:
    x, theta   the cart's position (m), the pole's angle from upright (rad, clockwise, unwrapped)
    omega      the angle's rate (rad/s); alpha its acceleration, x'' the cart's
    F          force on the cart (N)
    M, m       mass of both together, mass of the pole (kg); l half the pole's length (m)

Constants and equations are those of Gymnasium's CartPole-v1.
"""

import math

from physics.drawing import Capsule, Drawing, box, disc
from physics.environment import FloatArray
from physics.kernels.compiled import compiled

GRAVITY = 9.8
POLE_MASS = 0.1
TOTAL_MASS = 1.0 + POLE_MASS
HALF_LENGTH = 0.5
POLE_MOMENT = POLE_MASS * HALF_LENGTH
MAX_FORCE = 10.0
DT = 0.02
TRACK = 2.4


@compiled
def force_of(a: float) -> float:
    """F, the clipped and scaled action."""
    return MAX_FORCE * min(max(a, -1.0), 1.0)


@compiled
def force_slope(a: float) -> float:
    """dF/da: 0 beyond the box, the interior slope at its edge."""
    return MAX_FORCE if abs(a) <= 1.0 else 0.0


@compiled
def accelerations(theta: float, omega: float, force: float) -> tuple[float, float]:
    """x'' and alpha."""
    sin, cos = math.sin(theta), math.cos(theta)
    w = (force + POLE_MOMENT * omega**2 * sin) / TOTAL_MASS
    lever = HALF_LENGTH * (4.0 / 3.0 - POLE_MASS * cos**2 / TOTAL_MASS)
    alpha = (GRAVITY * sin - cos * w) / lever
    return w - POLE_MOMENT * alpha * cos / TOTAL_MASS, alpha


@compiled
def acceleration_slopes(
    theta: float, omega: float, force: float
) -> tuple[float, float, float, float, float, float]:
    """The derivatives of x'' in (theta, omega, F), then those of alpha."""
    sin, cos = math.sin(theta), math.cos(theta)
    ratio = POLE_MOMENT / TOTAL_MASS
    w = force / TOTAL_MASS + ratio * omega**2 * sin
    w_theta, w_omega, w_force = ratio * omega**2 * cos, 2.0 * ratio * omega * sin, 1.0 / TOTAL_MASS
    lever = HALF_LENGTH * (4.0 / 3.0 - POLE_MASS * cos**2 / TOTAL_MASS)
    lever_theta = 2.0 * ratio * cos * sin
    alpha = (GRAVITY * sin - cos * w) / lever
    alpha_theta = (GRAVITY * cos + sin * w - cos * w_theta - alpha * lever_theta) / lever
    alpha_omega = -cos * w_omega / lever
    alpha_force = -cos * w_force / lever
    return (
        w_theta - ratio * (alpha_theta * cos - alpha * sin),
        w_omega - ratio * alpha_omega * cos,
        w_force - ratio * alpha_force * cos,
        alpha_theta,
        alpha_omega,
        alpha_force,
    )


def draw_cart_and_pole(state: FloatArray) -> Drawing:
    """The cart on its track, with the pole."""
    x, theta = float(state[0]), float(state[2])
    tip = (x + 2 * HALF_LENGTH * math.sin(theta), 2 * HALF_LENGTH * math.cos(theta))
    return Drawing(
        view=(-TRACK - 0.6, -1.3, TRACK + 0.6, 1.3),
        shapes=(
            Capsule((-TRACK, 0.0), (TRACK, 0.0), 0.02, "ground"),
            box((x, 0.0), 0.5, 0.3, "body"),
            Capsule((x, 0.0), tip, 0.05, "link"),
            disc((x, 0.0), 0.05, "joint"),
        ),
    )
