"""SHAC learns, also where only its values can teach it, and ends by what is not finite."""

import numpy as np

import algorithms
import physics
from algorithms.ascent.shac import build, discounts
from algorithms.early_end import Divergence, EarlyEnd
from algorithms.measurement import Measurement
from algorithms.settings import SHACConfig
from tests.algorithms.ascent.test_gd import Steep

FEW = {"environments": 8, "window": 16, "actor_rate": 5e-3}


def test_it_learns_to_balance_a_pole() -> None:
    measured = algorithms.train("shac", "CartPole", [0], None, 16_000, FEW)
    curve = [m.return_mean for m in measured]
    assert np.mean(curve[-5:]) > 190.0


def test_a_task_whose_reward_has_no_gradient_is_learned_by_its_values() -> None:
    """All that Acrobot's actor climbs is the value at a window's end; one that idles earns -500."""
    assert not physics.make("Acrobot").reward_is_differentiable
    measured = algorithms.train("shac", "Acrobot", [0], None, 24_000, FEW)
    curve = [m.return_mean for m in measured]
    assert np.mean(curve[-10:]) > -120.0


def test_discounts_begin_anew_with_every_stretch() -> None:
    is_last = np.array([[0, 1], [0, 0], [1, 0], [0, 1]], bool)
    expected = [[1.0, 1.0], [0.5, 1.0], [0.25, 0.5], [1.0, 0.25]]
    np.testing.assert_array_equal(discounts(is_last, 0.5), expected)


def test_a_gradient_that_is_not_finite_ends_its_run_alone() -> None:
    """Some runs of one environment begin on the cliff, and some do not."""
    config = SHACConfig(environments=1, window=5, hidden_units=8)
    learner = build(Steep(), range(8), (0.0, 0.0), 5, config)
    said: list[Measurement | EarlyEnd] = learner.advance()
    ends = [e for e in said if not isinstance(e, Measurement)]
    assert 0 < len(ends) < 8
    assert ends == [Divergence(end.seed, 5, 1, "actor gradient") for end in ends]
    measured = [e.seed for e in said if isinstance(e, Measurement)]
    assert measured == list(range(8))
