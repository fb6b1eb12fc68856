"""The regimes of a robot's steps for the gradient audit, from the contact modes."""

import numpy as np

from physics.environment import FloatArray, IntArray
from physics.robots.dynamics.motion import Modes
from physics.robots.lcp.contact_mode import OPEN, SLIDE_AHEAD

REGIMES = ("free", "clipped", "sticking", "sliding", "resting", "opening", "joint limit")
"""From the lowest priority to the highest: a step has the last regime that applies."""
RESTING_SPEED = 0.1
"""Below this speed (m/s, rad/s) in all coordinates, a step in steady contact counts as resting."""


def regime_of(states: FloatArray, spheres: Modes, stops: Modes, beyond: IntArray) -> IntArray:
    """Index into REGIMES [batch], of the last that applies.

    Args:
        states: [batch, 2n], before the step.
        spheres: modes [batch, substeps, c] of the spheres.
        stops: modes [batch, substeps, any] of the stops.
        beyond: the side at which actions are clipped [batch, m], 0 for none.
    """
    closed = spheres != OPEN
    touches = closed.any(axis=(1, 2))
    slides = (spheres >= SLIDE_AHEAD).any(axis=(1, 2))
    opens = (closed[:, :-1] & ~closed[:, 1:]).any(axis=(1, 2))
    speeds = np.abs(states[:, states.shape[1] // 2 :])
    slow = speeds.max(axis=1, initial=0.0) < RESTING_SPEED
    rests = touches & slow & (closed == closed[:, :1]).all(axis=(1, 2))
    stopped = (stops != OPEN).any(axis=(1, 2))
    claims = [beyond.any(axis=1), touches, slides, rests, opens, stopped]
    return np.select(claims[::-1], list(range(len(claims), 0, -1)), 0)
