"""The motion of a square die over flat ground in one step: exact and event-driven.

    flight       until a corner touches the ground, gap <= 0 and v < 0
    touch        an impact (Poisson's restitution, Coulomb friction) if it comes with -v >= vs,
                 else lying flat if E < Er, else settled contact
    settled      the corner stops its approach without rebound, for the time that is left or until
                 another corner lands
    lying flat   only sliding to rest

    E = vy^2 / 2 + omega^2 / 12 + g (y - 1/2)       excess energy over lying still

Energy never grows without torque, no corner sinks, no impulse leaves its cone. The derivative is
that of this map: the time of a touch changes by dt = -(d gap) / v, and its impulse depends on
angle, slip and rate. At an equality the derivative is that of the branch that the inequality
selects as written.

Glossary: gap height of a corner (m), v its rate, u its slip (m/s); vs settling speed; Er rest
energy; tau time left of the step (s); alpha angular acceleration (rad/s^2). Corner i lies at
theta + pi/4 + i pi/2. The die's mass is 1 kg, so impulses (N s) are changes of velocity.
"""

import math
from typing import NamedTuple

import numpy as np

from physics.impacts.first_touch import NO_TOUCH, first_touch
from physics.impacts.flying_body import (
    ANGLE,
    LAPSE,
    SPIN,
    TIME,
    VX,
    VY,
    BodyTangent,
    FlyingBody,
    X,
    Y,
    accelerate,
    coast,
    contact_at,
    end_with_gap,
    end_with_time,
    fly,
    push,
)
from physics.impacts.impulse import STICK, Impulse, routh_impulse, settling_impulse, sign
from physics.impacts.trace import IMPACT, LYING, SETTLED, Event, Trace, note
from physics.kernels.compiled import compiled

INERTIA = 1.0 / 6.0  # kg m^2, a square of side 1 m and mass 1 kg
CORNERS = np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]])
REACH = math.sqrt(0.5)
REST_HEIGHT = 0.5
QUARTER_TURN = math.pi / 2.0

GRAVITY = 9.81
FRICTION = 0.5
RESTITUTION = 0.6
SETTLING_SPEED = 0.05  # vs
REST_ENERGY = 0.01  # Er


class Laws(NamedTuple):
    """The constants of a die's fall that may be changed."""

    gravity: float
    """m/s^2"""
    friction: float
    restitution: float


USUAL = Laws(GRAVITY, FRICTION, RESTITUTION)

MAX_TOUCHES = 64
BISECTIONS = 64  # of at most 0.02 s: down to 1e-21 s

MAX_CONTACTS = MAX_TOUCHES + 2  # one settled from the start, one lying
SUNK_DEPTH = 1e-12  # m: a deeper corner was placed below the ground; its depth is not rounding


@compiled
def excess_energy(body: FlyingBody, laws: Laws) -> float:
    """The excess energy E (J) over that of a die lying still."""
    turning = 0.5 * INERTIA * body.spin * body.spin
    return 0.5 * body.vy * body.vy + turning + laws.gravity * (body.y - REST_HEIGHT)


@compiled
def lever(angle: float, corner: int) -> tuple[float, float]:
    """A corner seen from the centre (rx, ry)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = CORNERS[corner, 0], CORNERS[corner, 1]
    return cosine * x - sine * y, sine * x + cosine * y


@compiled
def gap(body: FlyingBody, corner: int) -> float:
    """Height of a corner above the ground."""
    return body.y + lever(body.angle, corner)[1]


@compiled
def move(
    body: FlyingBody,
    tangent: BodyTangent | None,
    trace: Trace | None,
    alpha: float,
    laws: Laws = USUAL,
) -> FlyingBody:
    """Move a die for the time it has left.

    Args:
        body: the die.
        tangent: its tangent, moved in place; None for a motion without derivatives.
        trace: all 0 on entry, filled with a row for each contact; None for none.
        alpha: angular acceleration.
        laws: the constants of gravity and contact.
    """
    if excess_energy(body, laws) < REST_ENERGY:
        return lie(body, tangent, trace, False, laws)
    corner = settled_corner(body, laws)
    if corner != NO_TOUCH:
        body, landing = settle(body, tangent, trace, corner, alpha, False, laws)
        if landing == NO_TOUCH:
            return body
    for _ in range(MAX_TOUCHES):
        corner, moment = first_touch(body, CORNERS, REACH, laws.gravity, alpha)
        body = fly(body, tangent, moment, laws.gravity, alpha)
        if corner == NO_TOUCH:
            if tangent is not None:
                end_with_time(tangent)
            return body
        rx, _ = lever(body.angle, corner)
        if tangent is not None:
            end_with_gap(tangent, rx)
        if -(body.vy + body.spin * rx) >= SETTLING_SPEED:
            body = bounce(body, tangent, trace, corner, laws)
        elif excess_energy(body, laws) < REST_ENERGY:
            return lie(body, tangent, trace, True, laws)
        else:
            body, landing = settle(body, tangent, trace, corner, alpha, True, laws)
            if landing == NO_TOUCH:
                return body
    return body


@compiled
def bounce(
    body: FlyingBody, tangent: BodyTangent | None, trace: Trace | None, corner: int, laws: Laws
) -> FlyingBody:
    """Impact of a corner."""
    rx, ry = lever(body.angle, corner)
    contact = contact_at(body, rx, ry, INERTIA)
    impulse = routh_impulse(contact, laws.friction, laws.restitution)
    if trace is not None:
        note(trace, contact_event(IMPACT, body, corner, impulse, True, NO_TOUCH))
    return push(body, tangent, rx, ry, INERTIA, impulse)


@compiled
def settled_corner(body: FlyingBody, laws: Laws) -> int:
    """The lowest corner that counts as settled, v^2 + 2 g gap < vs^2, or NO_TOUCH."""
    if 2.0 * laws.gravity * (body.y - REACH) >= SETTLING_SPEED * SETTLING_SPEED:
        return NO_TOUCH
    settled, lowest = NO_TOUCH, math.inf
    for corner in range(4):
        rx, ry = lever(body.angle, corner)
        height, v = body.y + ry, body.vy + body.spin * rx
        if (
            v * v + 2.0 * laws.gravity * height < SETTLING_SPEED * SETTLING_SPEED
            and height < lowest
        ):
            settled, lowest = corner, height
    return settled


@compiled
def settle(
    body: FlyingBody,
    tangent: BodyTangent | None,
    trace: Trace | None,
    corner: int,
    alpha: float,
    touched: bool,
    laws: Laws,
) -> tuple[FlyingBody, int]:
    """Settled contact of a corner until the time is up (NO_TOUCH), or until another one lands.

    `touched` says whether it comes from a touch within the step; only the trace records this.
    """
    duration, landing = body.time, NO_TOUCH
    after, _ = glide(body, None, corner, duration, alpha, laws)
    for other in range(4):
        if landing == NO_TOUCH and other != corner and gap(after, other) < 0.0:
            landing = other
    if landing != NO_TOUCH:
        duration = landing_time(body, corner, landing, alpha, laws)
    after, impulse = glide(body, tangent, corner, duration, alpha, laws)
    if tangent is not None:
        if landing == NO_TOUCH:
            end_with_time(tangent)
        else:
            end_with_gap(tangent, lever(after.angle, landing)[0])
    if trace is not None:
        note(trace, contact_event(SETTLED, body, corner, impulse, touched, landing))
    return after, landing


@compiled
def glide(
    body: FlyingBody,
    tangent: BodyTangent | None,
    corner: int,
    duration: float,
    alpha: float,
    laws: Laws,
) -> tuple[FlyingBody, Impulse]:
    """Settled contact of a corner for a duration: one impulse, then motion at constant velocity."""
    rx, ry = lever(body.angle, corner)
    body = accelerate(body, tangent, duration, laws.gravity, alpha)
    impulse = settling_impulse(contact_at(body, rx, ry, INERTIA), laws.friction)
    body = push(body, tangent, rx, ry, INERTIA, impulse)
    return coast(body, tangent, duration), impulse


@compiled
def landing_time(body: FlyingBody, corner: int, landing: int, alpha: float, laws: Laws) -> float:
    """How long a corner can settle until `landing` lands, by bisection; `landing` is above then."""
    clear, sunk = 0.0, body.time
    for _ in range(BISECTIONS):
        middle = 0.5 * (clear + sunk)
        if gap(glide(body, None, corner, middle, alpha, laws)[0], landing) >= 0.0:
            clear = middle
        else:
            sunk = middle
    return clear


@compiled
def lie(
    body: FlyingBody, tangent: BodyTangent | None, trace: Trace | None, touched: bool, laws: Laws
) -> FlyingBody:
    """Lie flat for the remaining time, sliding to rest; `touched` as in `settle`."""
    braking = laws.gravity * laws.friction
    stops = abs(body.vx) <= braking * body.time
    deceleration = math.copysign(braking, body.vx)
    duration = body.vx / deceleration if stops else body.time
    vx = 0.0 if stops else body.vx - deceleration * duration
    if tangent is not None:
        for k in range(LAPSE):
            delay = 0.0 if stops else tangent[TIME, k]
            tangent[X, k] += duration * tangent[VX, k] + vx * delay
            tangent[VX, k] = 0.0 if stops else tangent[VX, k] - deceleration * delay
            tangent[Y, k] = tangent[ANGLE, k] = tangent[VY, k] = tangent[SPIN, k] = 0.0
    if trace is not None:
        note(trace, lying_event(body, stops, touched))
    return FlyingBody(
        body.x + duration * (body.vx - 0.5 * deceleration * duration),
        REST_HEIGHT,
        QUARTER_TURN * np.rint(body.angle / QUARTER_TURN),
        vx,
        0.0,
        0.0,
        0.0,
    )


@compiled
def contact_event(
    kind: float, body: FlyingBody, corner: int, impulse: Impulse, touched: bool, landing: int
) -> Event:
    """The event of an impulse at a corner, from the die before it."""
    rx, ry = lever(body.angle, corner)
    return Event(
        kind=kind,
        corner=float(corner),
        path=float(impulse.path),
        # Sticking in the compression is smooth across u = 0: it has no side.
        side=0.0 if impulse.path == STICK else -sign(impulse.k),
        touched=1.0 if touched else 0.0,
        landing=float(landing),
        sunk=1.0 if body.y + ry < -SUNK_DEPTH else 0.0,
        time_left=body.time,
        x=body.x + rx,
        y=body.y + ry,
        tangential=impulse.tangential,
        normal=impulse.normal,
    )


@compiled
def lying_event(body: FlyingBody, stops: bool, touched: bool) -> Event:
    """The event of lying flat, from the die before it."""
    return Event(
        kind=LYING,
        corner=float(NO_TOUCH),
        path=0.0 if stops else 1.0,
        side=sign(body.vx),
        touched=1.0 if touched else 0.0,
        landing=float(NO_TOUCH),
        sunk=0.0,
        time_left=body.time,
        x=body.x,
        y=0.0,
        tangential=0.0,
        normal=0.0,
    )
