"""A planar rigid body of unit mass in free flight and under impulses, with its tangent.

    x(t) = x + vx t                 vx(t) = vx
    y(t) = y + vy t - g t^2 / 2     vy(t) = vy - g t
    theta(t) = theta + omega t + alpha t^2 / 2      omega(t) = omega + alpha t

The tangent of a body is an array `[7, 8]`, a row for each of its numbers: column k < 7 is the
derivative in input k (the six coordinates it started from, then alpha), and column LAPSE is the
derivative in the duration of the last motion. The caller that ends a motion calls `end_with_time`
or `end_with_gap`, which turn the lapse into derivatives: a moment that depends on the state changes
with the state. With an impact in between, this is the saltation matrix (Kong and others, equation
5): the time by which the flight before it is longer is lost to the flight after it.

Every motion returns the moved body and moves the tangent in place, unless it is None. This is
decided when the kernel is compiled, so that a step without derivatives has no extra cost and uses
the same code.

Glossary: g gravity (m/s^2, downwards); alpha angular acceleration (rad/s^2); (rx, ry) a point of
the body seen from its centre; gap = y + ry its height; inertia per unit mass (m^2).
Source: Kong, Payne, Zhu and Johnson, "Saltation matrices", Proc. IEEE 112(6), 2024.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from physics.impacts.impulse import Contact, Impulse, impulse_derivative
from physics.kernels.compiled import compiled


class FlyingBody(NamedTuple):
    """Pose (m, m, rad), velocity (m/s, m/s, rad/s), and the remaining time of its motion (s)."""

    x: float
    y: float
    angle: float
    vx: float
    vy: float
    spin: float
    time: float


BodyTangent = NDArray[np.float64]

# Rows of a tangent.
X = 0
Y = 1
ANGLE = 2
VX = 3
VY = 4
SPIN = 5
TIME = 6
ROWS = 7

# Columns of a tangent that are not coordinates.
ALPHA = 6
LAPSE = 7
COLUMNS = 8


@compiled
def start_tangent(tangent: BodyTangent) -> None:
    """Set the tangent of a body that has not moved: it is its own input."""
    tangent[:] = 0.0
    for coordinate in range(TIME):
        tangent[coordinate, coordinate] = 1.0


@compiled
def fly(
    body: FlyingBody, tangent: BodyTangent | None, duration: float, gravity: float, alpha: float
) -> FlyingBody:
    """Fly for a duration."""
    vy = body.vy - gravity * duration
    spin = body.spin + alpha * duration
    if tangent is not None:
        _coast(tangent, duration)
        tangent[ANGLE, ALPHA] += 0.5 * duration * duration
        tangent[SPIN, ALPHA] += duration
        _set_lapse(tangent, body.vx, vy, spin, gravity, alpha)
    return FlyingBody(
        body.x + body.vx * duration,
        body.y + body.vy * duration - 0.5 * gravity * duration * duration,
        body.angle + body.spin * duration + 0.5 * alpha * duration * duration,
        body.vx,
        vy,
        spin,
        body.time - duration,
    )


@compiled
def accelerate(
    body: FlyingBody, tangent: BodyTangent | None, duration: float, gravity: float, alpha: float
) -> FlyingBody:
    """Change the velocity as a flight of this duration does, and leave the pose."""
    if tangent is not None:
        tangent[SPIN, ALPHA] += duration
        _set_lapse(tangent, 0.0, 0.0, 0.0, gravity, alpha)
    return FlyingBody(
        body.x,
        body.y,
        body.angle,
        body.vx,
        body.vy - gravity * duration,
        body.spin + alpha * duration,
        body.time,
    )


@compiled
def coast(body: FlyingBody, tangent: BodyTangent | None, duration: float) -> FlyingBody:
    """Move the pose for a duration at constant velocity."""
    if tangent is not None:
        _coast(tangent, duration)
        for row in range(VX):
            tangent[row, LAPSE] += duration * tangent[row + VX, LAPSE]
        tangent[X, LAPSE] += body.vx
        tangent[Y, LAPSE] += body.vy
        tangent[ANGLE, LAPSE] += body.spin
    return FlyingBody(
        body.x + duration * body.vx,
        body.y + duration * body.vy,
        body.angle + duration * body.spin,
        body.vx,
        body.vy,
        body.spin,
        body.time - duration,
    )


@compiled
def _coast(tangent: BodyTangent, duration: float) -> None:
    for row in range(VX):
        for k in range(LAPSE):
            tangent[row, k] += duration * tangent[row + VX, k]


@compiled
def _set_lapse(
    tangent: BodyTangent, vx: float, vy: float, spin: float, gravity: float, alpha: float
) -> None:
    """Set column LAPSE: the pose changes by this velocity, the velocity by this acceleration."""
    tangent[X, LAPSE] = vx
    tangent[Y, LAPSE] = vy
    tangent[ANGLE, LAPSE] = spin
    tangent[VX, LAPSE] = 0.0
    tangent[VY, LAPSE] = -gravity
    tangent[SPIN, LAPSE] = alpha
    tangent[TIME, LAPSE] = -1.0


@compiled
def end_with_time(tangent: BodyTangent) -> None:
    """Let the last motion end with the remaining time: dt = d time."""
    for k in range(LAPSE):
        delay = tangent[TIME, k]
        for row in range(ROWS):
            tangent[row, k] += delay * tangent[row, LAPSE]


@compiled
def end_with_gap(tangent: BodyTangent, rx: float) -> None:
    """Let the last motion end as a point meets the ground: dt = -d gap / (d gap / d lapse)."""
    rate = tangent[Y, LAPSE] + rx * tangent[ANGLE, LAPSE]
    for k in range(LAPSE):
        delay = -(tangent[Y, k] + rx * tangent[ANGLE, k]) / rate
        for row in range(ROWS):
            tangent[row, k] += delay * tangent[row, LAPSE]


@compiled
def contact_at(body: FlyingBody, rx: float, ry: float, inertia: float) -> Contact:
    """The contact of a point with the ground."""
    return Contact(
        1.0 + ry * ry / inertia,
        1.0 + rx * rx / inertia,
        -rx * ry / inertia,
        body.vx - body.spin * ry,
        body.vy + body.spin * rx,
    )


@compiled
def push(
    body: FlyingBody,
    tangent: BodyTangent | None,
    rx: float,
    ry: float,
    inertia: float,
    impulse: Impulse,
) -> FlyingBody:
    """Apply an impulse at a point."""
    if tangent is not None:
        _push(tangent, body, rx, ry, inertia, impulse)
    return FlyingBody(
        body.x,
        body.y,
        body.angle,
        body.vx + impulse.tangential,
        body.vy + impulse.normal,
        body.spin + (rx * impulse.normal - ry * impulse.tangential) / inertia,
        body.time,
    )


@compiled
def _push(
    tangent: BodyTangent, body: FlyingBody, rx: float, ry: float, inertia: float, impulse: Impulse
) -> None:
    """Push the tangent: the impulse depends on the angle, the slip and the rate at the point."""
    contact = contact_at(body, rx, ry, inertia)
    pt_u, pn_u = impulse_derivative(contact, impulse, Contact(0.0, 0.0, 0.0, 1.0, 0.0))
    pt_v, pn_v = impulse_derivative(contact, impulse, Contact(0.0, 0.0, 0.0, 0.0, 1.0))
    # Turning the body moves the point, d(rx, ry) = (-ry, rx), and with it the whole contact.
    AB = 2.0 * rx * ry / inertia
    turned = Contact(AB, -AB, (ry * ry - rx * rx) / inertia, -body.spin * rx, -body.spin * ry)
    pt_angle, pn_angle = impulse_derivative(contact, impulse, turned)
    moment_angle = -(ry * impulse.normal + rx * impulse.tangential)
    for k in range(COLUMNS):
        angle = tangent[ANGLE, k]
        u = tangent[VX, k] - ry * tangent[SPIN, k]
        v = tangent[VY, k] + rx * tangent[SPIN, k]
        pt = pt_angle * angle + pt_u * u + pt_v * v
        pn = pn_angle * angle + pn_u * u + pn_v * v
        tangent[VX, k] += pt
        tangent[VY, k] += pn
        tangent[SPIN, k] += (rx * pn - ry * pt + moment_angle * angle) / inertia
