"""TD3 and SAC act uniformly for their first steps, then as their policy says."""

from typing import Any

import numpy as np
import pytest

import algorithms
from algorithms.settings import SettingsError
from physics.environment import FloatArray


def acted(name: str, config: dict[str, Any]) -> FloatArray:
    """The actions [800] of one seed on the pendulum."""
    learner = algorithms.build(name, "Pendulum", [3], (0.0, 0.0), 800, config)
    while not learner.finished:
        learner.advance()
    return np.asarray(learner.journal(3, 0)["actions"]).ravel()


@pytest.mark.parametrize("name", ["td3", "sac"])
def test_what_is_learned_acts_only_after_them(name: str) -> None:
    small, large = (acted(name, {"uniform_steps": 250, "hidden_units": n}) for n in (8, 16))
    at_once = acted(name, {"uniform_steps": 0, "hidden_units": 8})
    assert (small[:300] == large[:300]).all(), "in whole cycles of 100 steps"
    assert (small[300:] != large[300:]).mean() > 0.8
    assert (small[:300] != at_once[:300]).mean() > 0.9
    assert np.quantile(small[:300], [0.25, 0.5, 0.75]) == pytest.approx([-0.5, 0, 0.5], abs=0.12)
    assert len(np.unique(small[:300])) == 300, "an episode's end draws anew"


def test_ddpg_has_none() -> None:
    with pytest.raises(SettingsError, match="uniform_steps"):
        algorithms.build("ddpg", "Pendulum", [3], (0.0, 0.0), 800, {"uniform_steps": 100})
