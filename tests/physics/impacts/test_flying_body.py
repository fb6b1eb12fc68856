"""The tangent of a flying and bouncing body against closed forms and differences."""

from collections.abc import Callable

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.impacts.flying_body import (
    ALPHA,
    COLUMNS,
    ROWS,
    TIME,
    VY,
    BodyTangent,
    FlyingBody,
    Y,
    accelerate,
    coast,
    contact_at,
    end_with_gap,
    end_with_time,
    fly,
    push,
    start_tangent,
)
from physics.impacts.impulse import routh_impulse

G = 9.81


def ball(y: float, vy: float, restitution: float, seconds: float) -> tuple[FlyingBody, BodyTangent]:
    """A ball, a body whose one point lies at its centre, through its first bounce."""
    tangent = np.empty((ROWS, COLUMNS))
    start_tangent(tangent)
    body = FlyingBody(0.0, y, 0.0, 0.0, vy, 0.0, seconds)
    moment = (vy + np.sqrt(vy**2 + 2 * G * y)) / G
    body = fly(body, tangent, moment, G, 0.0)
    end_with_gap(tangent, 0.0)
    impulse = routh_impulse(contact_at(body, 0.0, 0.0, 1.0), 0.5, restitution)
    body = push(body, tangent, 0.0, 0.0, 1.0, impulse)
    body = fly(body, tangent, body.time, G, 0.0)
    end_with_time(tangent)
    return body, tangent


def test_a_bouncing_ball_has_the_saltation_matrix() -> None:
    """The step Jacobian that time stepping misses at every step size (Kong and others, 2024)."""
    y, vy, e, seconds = 1.0, 0.0, 0.8, 0.7
    body, tangent = ball(y, vy, e, seconds)
    moment = np.sqrt(2 * y / G)
    speed = -G * moment
    saltation = np.array([[-e, 0.0], [-(1 + e) * G / speed, -e]])
    before, then = (np.array([[1.0, t], [0.0, 1.0]]) for t in (moment, seconds - moment))
    exact = then @ saltation @ before
    np.testing.assert_allclose(tangent[np.ix_([Y, VY], [Y, VY])], exact, rtol=1e-12)
    np.testing.assert_allclose(exact, [[0.1906, -0.1127], [3.9865, 1.0]], atol=1e-4)
    assert body.time == 0.0
    assert body.vy == pytest.approx(-e * speed - G * (seconds - moment))


def glide(
    body: FlyingBody, tangent: BodyTangent | None, duration: float, alpha: float
) -> FlyingBody:
    return coast(accelerate(body, tangent, duration, G, alpha), tangent, duration)


def flight(
    body: FlyingBody, tangent: BodyTangent | None, duration: float, alpha: float
) -> FlyingBody:
    return fly(body, tangent, duration, G, alpha)


@pytest.mark.parametrize("motion", [flight, glide])
def test_a_motion_in_all_the_time_that_is_left(
    motion: Callable[[FlyingBody, BodyTangent | None, float, float], FlyingBody],
) -> None:
    """All columns at once, the time itself being the input that no state has."""
    start = np.array([0.3, 2.0, 0.4, 1.5, -0.7, 3.0, 0.13])
    alpha = -2.5

    def end(inputs: FloatArray, acceleration: float) -> FloatArray:
        body = FlyingBody(*inputs.tolist())
        return np.array(motion(body, None, body.time, acceleration))

    tangent = np.empty((ROWS, COLUMNS))
    start_tangent(tangent)
    tangent[TIME, Y] = 0.6  # as if the time left had come from an earlier touch
    motion(FlyingBody(*start.tolist()), tangent, float(start[TIME]), alpha)
    end_with_time(tangent)
    h = 1e-6
    for k in range(ALPHA):
        change = h * np.eye(ROWS)[k] + h * (0.6 if k == Y else 0.0) * np.eye(ROWS)[TIME]
        slope = (end(start + change, alpha) - end(start - change, alpha)) / (2 * h)
        np.testing.assert_allclose(tangent[:TIME, k], slope[:TIME], atol=1e-8)
    slope = (end(start, alpha + h) - end(start, alpha - h)) / (2 * h)
    np.testing.assert_allclose(tangent[:TIME, ALPHA], slope[:TIME], atol=1e-8)
    assert not tangent[TIME, :ALPHA].any()
