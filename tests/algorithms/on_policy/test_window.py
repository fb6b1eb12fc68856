"""Windows: episodes begin, end and go on within them and from one to the next."""

import numpy as np
import pytest

import physics
from algorithms.early_end import NotFiniteQuantityError
from algorithms.experience.rollout import start_states
from algorithms.on_policy.window import Episodes, Window, check_finite, live, of_run
from physics.environment import FloatArray
from physics.randomness import generator

STEPS, ENVIRONMENTS = 30, 3
TASK = physics.make("CartPole")


def pushing(features: FloatArray, t: int) -> FloatArray:
    """Poles fall within some ten steps."""
    del t
    return np.where(features[:, :1] > 0, 1.0, 0.5)


def lived(episodes: list[Episodes], *, linearized: bool = False, steps: int = STEPS) -> Window:
    noise = np.zeros((steps, len(episodes) * ENVIRONMENTS, 1), np.float32)
    windows, failures = live(TASK, episodes, pushing, noise, linearized=linearized)
    assert windows is not None
    assert failures == {}
    return windows


def of_seeds(*seeds: int) -> list[Episodes]:
    return [Episodes(seed, ENVIRONMENTS, TASK.state_size) for seed in seeds]


def test_an_episode_goes_on_until_it_ends_and_the_next_in_number_begins() -> None:
    window, drawn = lived(of_seeds(5)), 0
    starts, _ = start_states(TASK, [(5, "episode", i) for i in range(40)])
    begins = np.ones(ENVIRONMENTS, bool)
    for t in range(STEPS):
        for e in range(ENVIRONMENTS):
            expected = window.next_features[t - 1, e]
            if begins[e]:
                expected = TASK.features(starts[drawn : drawn + 1])[0]
                drawn += 1
            np.testing.assert_array_equal(window.features[t, e], expected)
        begins = window.terminated[t]
    assert drawn > 2 * ENVIRONMENTS
    np.testing.assert_array_equal(window.is_last[:-1], window.terminated[:-1])
    assert window.is_last[-1].all()


def test_time_ends_episodes_but_not_the_task() -> None:
    [episodes] = runs = of_seeds(5)
    lived(runs, steps=1)
    episodes.elapsed[1] = TASK.horizon - 2
    window = lived(runs)
    assert window.is_last[1, 1]
    assert not window.terminated[1, 1]
    assert not np.array_equal(window.next_features[1, 1], window.features[2, 1])


def test_two_windows_are_one_of_their_length() -> None:
    whole, runs = lived(of_seeds(2)), of_seeds(2)
    parts = [lived(runs, steps=11), lived(runs, steps=STEPS - 11)]
    for name in ("features", "rewards", "next_features", "terminated"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name))


def test_a_run_lives_what_it_lives_alone_and_goes_on_from_where_it_was_left() -> None:
    runs = of_seeds(7, 2)
    lived(runs)
    left = {name: array.copy() for name, array in runs[1].state().items()}
    beside = of_run(lived(runs, linearized=True), 1, ENVIRONMENTS)
    [again] = of_seeds(2)
    again.restore(left)
    alone = lived([again], linearized=True)
    assert len(alone.derivatives) == 5
    for one, other in zip(beside.derivatives, alone.derivatives, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(beside.features, alone.features)
    np.testing.assert_array_equal(beside.is_last, alone.is_last)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1e300])
@pytest.mark.parametrize("name", ["rewards", "features"])
def test_what_is_no_float32_is_refused_by_name(name: str, value: float) -> None:
    window = lived(of_seeds(0))
    check_finite(window)
    part = getattr(window, name)
    part[tuple(generator(0, name).integers(part.shape))] = value
    with pytest.raises(NotFiniteQuantityError, match=f"{name} not finite"):
        check_finite(window)
