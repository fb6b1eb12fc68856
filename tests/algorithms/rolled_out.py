"""Episodes in which nothing fails."""

from collections.abc import Callable

from algorithms.planning import episodes as ilqr_episode
from algorithms.planning.episodes import Episodes
from physics.environment import Environment, FloatArray


def roll_out(
    environment: Environment, starts: FloatArray, act: Callable[[FloatArray], FloatArray]
) -> Episodes:
    episodes, failures = ilqr_episode.roll_out(environment, starts, act)
    assert not failures
    return episodes
