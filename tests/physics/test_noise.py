"""Noise: normal numbers by seed and step."""

import numpy as np
import pytest

from physics import noise
from physics.noise import first_place, next_places, normal
from physics.randomness import generator


def places_of(streams: int, steps: int) -> noise.FloatArray:
    """Places [streams, steps, 2] from the first step of each stream on."""
    return np.stack(
        np.meshgrid(np.arange(float(streams)), np.arange(float(steps)), indexing="ij"), axis=-1
    )


def test_the_numbers_are_normal_and_independent() -> None:
    numbers = normal("process_noise", places_of(200, 100), 3)
    assert numbers.shape == (200, 100, 3)
    assert abs(numbers.mean()) < 4 / np.sqrt(numbers.size)
    assert abs(numbers.std() - 1.0) < 4 / np.sqrt(2 * numbers.size)
    others = normal("observation_noise", places_of(200, 100), 3)
    for one, other in (
        (numbers[1:], numbers[:-1]),
        (numbers[:, 1:], numbers[:, :-1]),
        (numbers[..., 1:], numbers[..., :-1]),
        (numbers, others),
    ):
        assert abs((one * other).mean()) < 4 / np.sqrt(one.size)


def test_a_place_has_its_numbers_whoever_else_asks() -> None:
    places = places_of(7, 150)
    together = normal("process_noise", places, 2)
    noise._block.cache_clear()
    for stream, step in ((6, 149), (0, 0), (3, 64), (3, 63)):
        alone = normal("process_noise", places[stream, step], 2)
        np.testing.assert_array_equal(alone, together[stream, step])


def test_the_numbers_are_those_of_the_one_source_of_randomness() -> None:
    drawn = generator(5, "process_noise", 1).standard_normal((64, 2))
    np.testing.assert_array_equal(
        normal("process_noise", np.array([[5.0, 64.0], [5.0, 66.0]]), 2), drawn[[0, 2]]
    )


def test_an_episode_begins_in_a_stream_of_its_own_and_goes_on_step_by_step() -> None:
    first = np.stack([first_place(generator(seed, "start")) for seed in range(50)])
    assert len(set(first[:, 0])) == 50
    assert (first[:, 1] == 0).all()
    assert (first == first.astype(np.float32)).all()
    np.testing.assert_array_equal(next_places(first + 1e-3), first + [0, 1])  # noqa: RUF005


def test_a_place_before_the_first_is_refused() -> None:
    with pytest.raises(ValueError, match="seed must be an integer from 0 on, not -3"):
        normal("process_noise", np.array([[-3.0, 0.0]]), 2)
