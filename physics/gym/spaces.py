"""Gymnasium's spaces of a task.

observation   Box of the features, float64: the exact bits that a network sees. Its bounds are
              finite where the task guarantees them: cosines and sines, `Environment.bounds` where
              coordinates are observed without noise, clipped features
action        Box(-1, 1), float32, as policies return them; float64 actions are used unrounded
"""

import numpy as np
from gymnasium.spaces import Box

from physics.environment import Environment

UNBOUNDED = (-np.inf, np.inf)
SINE = (-1.0, 1.0)


def observation_space(task: Environment) -> Box[np.float64]:
    """The space of the features [F]."""
    promised = {} if task.observation_noise else task.bounds
    bounds = [
        SINE if source in task.angles else promised.get(source, UNBOUNDED)
        for source in task.feature_sources.tolist()
    ]
    low, high = np.array(bounds).T
    limits = task.feature_map.limits
    return Box(np.maximum(low, -limits), np.minimum(high, limits), dtype=np.float64)


def action_space(task: Environment) -> Box[np.float32]:
    """The space of the actions [m]; actions outside are clipped."""
    return Box(-1.0, 1.0, (task.action_size,), np.float32)
