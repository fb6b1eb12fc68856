"""The cart and pole: the system that CartPole and CartPoleSwingUp share (Barto and others, 1983).

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
    p          the parameters (g, M - m, m, l, greatest F)

Constants and equations are those of Gymnasium's CartPole-v1.
"""

import math

from physics.drawing import Capsule, Drawing, box, disc
from physics.environment import Environment, FloatArray
from physics.kernels.compiled import compiled
from physics.parameter import Parameter

GRAVITY = 9.8
CART_MASS = 1.0
POLE_MASS = 0.1
HALF_LENGTH = 0.5
MAX_FORCE = 10.0
DT = 0.02
TRACK = 2.4

Machine = tuple[float, float, float, float]


@compiled
def machine_of(p: FloatArray) -> Machine:
    """(g, M, m, l)."""
    return p[0], p[1] + p[2], p[2], p[3]


@compiled
def force_of(p: FloatArray, a: float) -> float:
    """F, the clipped and scaled action."""
    max_force: float = p[4]
    return max_force * min(max(a, -1.0), 1.0)


@compiled
def force_slope(p: FloatArray, a: float) -> float:
    """dF/da: 0 beyond the box, the interior slope at its edge."""
    return p[4] if abs(a) <= 1.0 else 0.0


@compiled
def accelerations(
    machine: Machine, theta: float, omega: float, force: float
) -> tuple[float, float]:
    """x'' and alpha."""
    g, M, m, half = machine
    sin, cos = math.sin(theta), math.cos(theta)
    moment = m * half
    w = (force + moment * omega**2 * sin) / M
    lever = half * (4.0 / 3.0 - m * cos**2 / M)
    alpha = (g * sin - cos * w) / lever
    return w - moment * alpha * cos / M, alpha


@compiled
def acceleration_slopes(
    machine: Machine, theta: float, omega: float, force: float
) -> tuple[float, float, float, float, float, float]:
    """The derivatives of x'' in (theta, omega, F), then those of alpha."""
    g, M, m, half = machine
    sin, cos = math.sin(theta), math.cos(theta)
    ratio = m * half / M
    w = force / M + ratio * omega**2 * sin
    w_theta, w_omega, w_force = ratio * omega**2 * cos, 2.0 * ratio * omega * sin, 1.0 / M
    lever = half * (4.0 / 3.0 - m * cos**2 / M)
    lever_theta = 2.0 * ratio * cos * sin
    alpha = (g * sin - cos * w) / lever
    alpha_theta = (g * cos + sin * w - cos * w_theta - alpha * lever_theta) / lever
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


@compiled
def parameter_slopes(
    p: FloatArray, theta: float, omega: float, a: float, slopes: FloatArray
) -> None:
    """Fill `slopes [2, 5]` with the derivatives of (x'', alpha) in p."""
    g, M, m, half = machine_of(p)
    sin, cos = math.sin(theta), math.cos(theta)
    moment = m * half
    w = (force_of(p, a) + moment * omega**2 * sin) / M
    lever = half * (4.0 / 3.0 - m * cos**2 / M)
    alpha = (g * sin - cos * w) / lever
    for j in range(5):
        dg = 1.0 if j == 0 else 0.0
        dm = 1.0 if j == 2 else 0.0
        dM = 1.0 if 1 <= j <= 2 else 0.0
        dhalf = 1.0 if j == 3 else 0.0
        dF = min(max(a, -1.0), 1.0) if j == 4 else 0.0
        dmoment = dm * half + m * dhalf
        dw = (dF + dmoment * omega**2 * sin - w * dM) / M
        dlever = dhalf * (4.0 / 3.0 - m * cos**2 / M) - half * cos**2 * (dm - m * dM / M) / M
        dalpha = (dg * sin - cos * dw - alpha * dlever) / lever
        dswing = dmoment * alpha + moment * (dalpha - alpha * dM / M)
        slopes[0, j] = dw - cos * dswing / M
        slopes[1, j] = dalpha


class CartAndPole(Environment):
    """The cart and pole of a task: its parameters and its drawing."""

    gravity = Parameter(GRAVITY, "m/s^2", least=0.0, greatest=100.0, meaning="gravity")
    cart_mass = Parameter(CART_MASS, "kg", least=0.01, greatest=100.0, meaning="mass of the cart")
    pole_mass = Parameter(POLE_MASS, "kg", least=0.001, greatest=100.0, meaning="mass of the pole")
    half_length = Parameter(
        HALF_LENGTH, "m", least=0.05, greatest=10.0, meaning="half the length of the pole"
    )
    max_force = Parameter(
        MAX_FORCE, "N", least=0.0, greatest=1000.0, meaning="the greatest force on the cart"
    )

    def draw(self, state: FloatArray) -> Drawing:
        """The cart on its track, with the pole."""
        x, theta, length = float(state[0]), float(state[2]), 2 * self.half_length
        height = max(1.3, 1.3 * length)
        return Drawing(
            view=(-TRACK - 0.6, -height, TRACK + 0.6, height),
            shapes=(
                Capsule((-TRACK, 0.0), (TRACK, 0.0), 0.02, "ground"),
                box((x, 0.0), 0.5, 0.3, "body"),
                Capsule(
                    (x, 0.0), (x + length * math.sin(theta), length * math.cos(theta)), 0.05, "link"
                ),
                disc((x, 0.0), 0.05, "joint"),
            ),
        )
