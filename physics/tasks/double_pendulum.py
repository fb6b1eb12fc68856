"""The double pendulum: two links hanging from an axle, with a motor at the joint between them.

    d1     = m lc^2 + m (l^2 + lc^2 + 2 l lc cos theta2) + 2 I
    d2     = m (lc^2 + l lc cos theta2) + I
    phi2   = m lc g sin(theta1 + theta2)
    phi1   = -m l lc omega2 (omega2 + 2 omega1) sin theta2 + m (lc + l) g sin theta1 + phi2
    alpha2 = (u + d2/d1 phi1 - m l lc omega1^2 sin theta2 - phi2) / (m lc^2 + I - d2^2/d1)
    alpha1 = -(d2 alpha2 + phi1) / d1

and one step of 0.2 s by the classical Runge-Kutta method,

    k_i = f(s + c_i dt k_(i-1)),    s' = s + dt sum_i b_i k_i
    c = (0, 1/2, 1/2, 1),           b = (1, 2, 2, 1) / 6

Glossary:
    theta1, theta2   angle of the first link from hanging, of the second from the first (rad)
    omega, alpha     their rates (rad/s) and accelerations
    u                torque at the joint (N m)
    m, l, lc, I      each link's mass 1 kg, length 1 m, half length, inertia 1 kg m^2; g = 9.8 m/s^2
    s                (theta1, theta2, omega1, omega2)
    p                the parameters (g, l, m, I)

The book form of Sutton and Barto (2018), as in Gymnasium's Acrobot-v1.
"""

import math
from typing import NamedTuple

from physics.environment import FloatArray
from physics.kernels.compiled import compiled

MASS = 1.0
LENGTH = 1.0
INERTIA = 1.0
GRAVITY = 9.8
DT = 0.2

# (c_i dt, 6 b_i) of each stage
STAGES = ((0.0, 1.0), (DT / 2.0, 2.0), (DT / 2.0, 2.0), (DT, 1.0))

State = tuple[float, float, float, float]


class Links(NamedTuple):
    """The constants of the motion, from the parameters."""

    mass: float
    inertia: float
    """About the middle of a link."""
    squares: float
    """l^2 + lc^2"""
    product: float
    """l lc"""
    half_square: float
    """lc^2"""
    coupling: float
    """m l lc"""
    end_inertia: float
    """m lc^2 + I"""
    weight1: float
    """(m lc + m l) g"""
    weight2: float
    """m lc g"""


def links(gravity: float, length: float, mass: float, inertia: float) -> Links:
    """The links with these parameters."""
    half = 0.5 * length
    return Links(
        mass,
        inertia,
        length**2 + half**2,
        length * half,
        half**2,
        mass * length * half,
        mass * half**2 + inertia,
        (mass * half + mass * length) * gravity,
        mass * half * gravity,
    )


links_of = compiled(links)
USUAL = links(GRAVITY, LENGTH, MASS, INERTIA)
D2, WEIGHT1, WEIGHT2 = USUAL.end_inertia, USUAL.weight1, USUAL.weight2


@compiled
def inertias(cos2: float, links: Links = USUAL) -> tuple[float, float]:
    """d1 and d2."""
    mass, inertia = links.mass, links.inertia
    reach = links.squares + 2.0 * links.product * cos2
    d1 = mass * links.half_square + mass * reach + inertia + inertia
    d2 = mass * (links.half_square + links.product * cos2) + inertia
    return d1, d2


@compiled
def loads(s: State, sin2: float, links: Links) -> tuple[float, float]:
    """phi1 and phi2."""
    theta1, theta2, omega1, omega2 = s
    phi2 = links.weight2 * math.cos(theta1 + theta2 - math.pi / 2.0)
    phi1 = (
        -links.coupling * omega2**2 * sin2
        - 2.0 * links.coupling * omega2 * omega1 * sin2
        + links.weight1 * math.cos(theta1 - math.pi / 2.0)
        + phi2
    )
    return phi1, phi2


@compiled
def accelerations(s: State, torque: float, links: Links = USUAL) -> tuple[float, float]:
    """alpha1 and alpha2."""
    sin2 = math.sin(s[1])
    d1, d2 = inertias(math.cos(s[1]), links)
    phi1, phi2 = loads(s, sin2, links)
    driving = torque + d2 / d1 * phi1 - links.coupling * s[2] ** 2 * sin2 - phi2
    alpha2 = driving / (links.end_inertia - d2**2 / d1)
    return -(d2 * alpha2 + phi1) / d1, alpha2


@compiled
def acceleration_slopes(
    s: State, torque: float, slopes: FloatArray, links: Links
) -> tuple[float, float]:
    """Fill `slopes [2, 5]` with the derivatives of (alpha1, alpha2) in (s, u); return both."""
    theta1, theta2, omega1, omega2 = s
    sin2, cos2 = math.sin(theta2), math.cos(theta2)
    d1, d2 = inertias(cos2, links)
    phi1, _ = loads(s, sin2, links)
    alpha1, alpha2 = accelerations(s, torque, links)
    share = d2 / d1
    lever = links.end_inertia - d2**2 / d1

    # The inertias depend on theta2 alone.
    d1_slope, d2_slope = -2.0 * links.coupling * sin2, -links.coupling * sin2
    share_slope = (d2_slope - share * d1_slope) / d1
    lever_slope = -(d2_slope * share + d2 * share_slope)

    phi2_slope = links.weight2 * math.cos(theta1 + theta2)
    phi1_slopes = (
        links.weight1 * math.cos(theta1) + phi2_slope,
        -links.coupling * omega2 * (omega2 + 2.0 * omega1) * cos2 + phi2_slope,
        -2.0 * links.coupling * omega2 * sin2,
        -2.0 * links.coupling * (omega1 + omega2) * sin2,
        0.0,
    )
    other_slopes = (
        -phi2_slope,
        share_slope * phi1 - links.coupling * omega1**2 * cos2 - phi2_slope - alpha2 * lever_slope,
        -2.0 * links.coupling * omega1 * sin2,
        0.0,
        1.0,
    )
    for column in range(5):
        slopes[1, column] = (other_slopes[column] + share * phi1_slopes[column]) / lever
        slopes[0, column] = -(d2 * slopes[1, column] + phi1_slopes[column]) / d1
    slopes[0, 1] -= (d2_slope * alpha2 + d1_slope * alpha1) / d1
    return alpha1, alpha2


@compiled
def moved(s: State, rate: State, time: float) -> State:
    """`s + time * rate`."""
    return (
        s[0] + time * rate[0],
        s[1] + time * rate[1],
        s[2] + time * rate[2],
        s[3] + time * rate[3],
    )


@compiled
def advance(s: State, torque: float, links: Links = USUAL) -> State:
    """The state one Runge-Kutta step later."""
    k, total = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    for reach, weight in STAGES:
        here = moved(s, k, reach)
        alpha1, alpha2 = accelerations(here, torque, links)
        k = (here[2], here[3], alpha1, alpha2)
        total = moved(total, k, weight)
    return moved(s, total, DT / 6.0)


@compiled
def advance_slopes(
    s: State,
    torque: float,
    slopes: FloatArray,
    stage: FloatArray,
    jacobian: FloatArray,
    links: Links,
) -> State:
    """`advance`, to the same bits, with its derivatives in (s, u) in `jacobian [4, 5]`.

    `stage [4, 5]` holds the derivatives of k_i; `slopes [2, 5]` is for `acceleration_slopes`.
    """
    stage[:] = 0.0
    jacobian[:] = 0.0
    for i in range(4):
        jacobian[i, i] = 1.0
    k, total = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    for reach, weight in STAGES:
        here = moved(s, k, reach)
        alpha1, alpha2 = acceleration_slopes(here, torque, slopes, links)
        k = (here[2], here[3], alpha1, alpha2)
        total = moved(total, k, weight)
        for column in range(5):
            stage_slopes(slopes, reach, column, stage)
            for i in range(4):
                jacobian[i, column] += DT / 6.0 * weight * stage[i, column]
    return moved(s, total, DT / 6.0)


@compiled
def stage_slopes(slopes: FloatArray, reach: float, column: int, stage: FloatArray) -> None:
    """Take one column of `stage` from k_(i-1) to k_i = f(s + reach k_(i-1))."""
    # The derivatives of s + reach k_(i-1) in this column's number.
    h0 = reach * stage[0, column] + (column == 0)
    h1 = reach * stage[1, column] + (column == 1)
    h2 = reach * stage[2, column] + (column == 2)
    h3 = reach * stage[3, column] + (column == 3)
    stage[0, column], stage[1, column] = h2, h3
    for i in range(2):
        stage[2 + i, column] = (
            slopes[i, 0] * h0
            + slopes[i, 1] * h1
            + slopes[i, 2] * h2
            + slopes[i, 3] * h3
            + slopes[i, 4] * (column == 4)
        )
