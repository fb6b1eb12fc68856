"""Features in another order and clipped: values, slopes, and what a learner makes of them."""

import numpy as np
import pytest
import torch

from algorithms.networks.scaling import (
    Statistics,
    coordinate_slopes,
    coordinates_of,
    forget_clipped,
)
from physics.features import FeatureMap
from physics.gym.spaces import observation_space
from tests.physics.small_tasks import Plain

STATES = np.array([[0.3, 0.7, -9.0, 4.0], [2.0, -0.1, 10.0, -4.0], [-1.0, 3.0, 12.0, 0.0]])
FEATURES = FeatureMap(4, {1: 2}, (0,), {2: 10.0}, order=(1, 3, 0, 2))


def test_a_feature_is_clipped_and_in_its_place() -> None:
    cos, sin = np.cos(2 * STATES[:, 1]), np.sin(2 * STATES[:, 1])
    clipped = np.array([-9.0, 10.0, 10.0])
    expected = np.stack([sin, STATES[:, 3], cos, clipped], axis=1)
    np.testing.assert_allclose(FEATURES.features(STATES), expected, rtol=1e-15)
    np.testing.assert_allclose(FEATURES.features(torch.from_numpy(STATES)), expected, rtol=1e-15)
    assert FEATURES.sources.tolist() == [1, 3, 1, 2]


@pytest.mark.parametrize("array", [np.asarray, torch.from_numpy])
def test_slopes_are_the_derivatives_and_0_where_clipped(array: object) -> None:
    assert callable(array)
    slopes = np.asarray(FEATURES.slopes(array(FEATURES.features(STATES))))
    cos, sin = np.cos(2 * STATES[:, 1]), np.sin(2 * STATES[:, 1])
    expected = np.stack([2 * cos, np.ones(3), -2 * sin, [1.0, 0.0, 0.0]], axis=1)
    np.testing.assert_allclose(slopes, expected, rtol=1e-14)


class Clipped(Plain):
    """A task whose speed networks see clipped."""

    clipped = {1: 0.5}  # noqa: RUF012
    feature_order = (1, 0)


def test_a_learner_has_no_slope_where_a_feature_is_clipped() -> None:
    task = Clipped()
    coordinates = coordinates_of(task)
    scaling = Statistics(coordinates, 1).scaling()
    for speed, slope in ((0.4, 1.0), (0.6, 0.0), (-0.6, 0.0)):
        features = task.features(np.array([[0.1, speed]]))[0].astype(np.float32)
        found = np.empty(2, np.float32)
        coordinate_slopes(features, features, coordinates, scaling, found)
        forget_clipped(features, coordinates, found)
        np.testing.assert_allclose(found, [slope, 1.0], rtol=1e-6)


def test_gymnasium_is_told_the_limits() -> None:
    space = observation_space(Clipped())
    assert space.low.tolist() == [-0.5, -np.inf]
    assert space.high.tolist() == [0.5, np.inf]


@pytest.mark.parametrize(
    ("attributes", "complaint"),
    [
        ({"clipped": {1: 0.0}}, r"clipped\[1\] must be a number above 0, not 0.0"),
        ({"clipped": {2: 1.0}}, "clipped names coordinate 2"),
        ({"clipped": {1: 1.0}, "hidden": (1,)}, "coordinate 1 is clipped, and an angle or hidden"),
        ({"feature_order": (0,)}, r"feature_order must hold each of 0 to 1 once, not \(0,\)"),
        ({"feature_order": [0, 1]}, r"feature_order must be a tuple of places, not \[0, 1\]"),
        ({"tolerance": 0.0}, "tolerance must be a number above 0, not 0.0"),
    ],
)
def test_mistakes_in_them_are_told(attributes: dict[str, object], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        type("Mistaken", (Plain,), attributes)()
