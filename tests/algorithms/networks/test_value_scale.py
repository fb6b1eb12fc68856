"""A change of the unit of Q changes neither Q nor what Adam does next."""

import numpy as np
import pytest
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.networks import network
from algorithms.networks.network import Parameters, Shape
from algorithms.networks.optimizer import Learned, adam, corrected, learned
from algorithms.networks.scaling import Statistics
from algorithms.networks.value_scale import (
    UnitChange,
    move_value_scale,
    rescale_moments,
    rewrite_fit,
)
from physics.kernels.compiled import compiled_fast
from physics.randomness import generator
from tests.algorithms.plain import not_small, setting

SHAPE = Shape(3, (8, 8), 1)
Floats = NDArray[np.float32]


@compiled_fast
def fit(fitted: Learned, shape: Shape, x: Floats, target: Floats, step: float) -> None:
    """One step of Adam down `(out - target)^2`."""
    p, work = Parameters(fitted.theta, shape), network.new_pass(fitted.theta, len(x), shape)
    network.receive(work, x)
    network.forward(p, work)
    for row in range(len(x)):
        work.out_bar[row, 0] = 2 * (work.out[row, 0] - target[row])
    network.backward(p, work)
    gradient = np.empty_like(fitted.theta)
    network.gradient(p, work, Parameters(gradient, shape))
    adam(fitted, gradient, step)


@compiled_fast
def outputs(theta: Floats, shape: Shape, x: Floats) -> Floats:
    work = network.new_pass(theta, len(x), shape)
    network.receive(work, x)
    network.forward(Parameters(theta, shape), work)
    return work.out


def batches(random: np.random.Generator, count: int) -> list[tuple[Floats, Floats]]:
    """Inputs and targets in the task's unit."""
    return [
        (
            random.standard_normal((16, 3), np.float32),
            random.normal(40.0, 30.0, 16).astype(np.float32),
        )
        for _ in range(count)
    ]


def trained(seed: int) -> tuple[Learned, np.random.Generator]:
    random = generator(seed, "value scale")
    fitted = learned(not_small(SHAPE, random))
    for i, (x, y) in enumerate(batches(random, 20)):
        fit(fitted, SHAPE, x, ((y - 10.0) / 0.5).astype(np.float32), corrected(1e-3, i + 1))
    return fitted, random


@pytest.mark.parametrize("ratio", [1e-3, 0.5, 30.0])
def test_q_is_the_same_and_so_is_its_target_network(ratio: float) -> None:
    fitted, random = trained(1)
    fitted.target[:] = not_small(SHAPE, random)
    x = random.standard_normal((50, 3), np.float32)
    before = [10.0 + 0.5 * outputs(theta, SHAPE, x) for theta in (fitted.theta, fitted.target)]
    mean, std = 25.0, 0.5 / ratio
    rewrite_fit(fitted, SHAPE, UnitChange(ratio, (10.0 - mean) / std))
    after = [mean + std * outputs(theta, SHAPE, x) for theta in (fitted.theta, fitted.target)]
    np.testing.assert_allclose(after, before, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("ratio", [1e-3, 0.5, 30.0])
def test_adam_remembers_what_it_would_had_the_unit_been_the_new_one_all_along(
    ratio: float,
) -> None:
    """The same gradients of the same Q, in the one unit and in the other."""
    random = generator(2, "value scale")
    std, first = 0.5, not_small(SHAPE, random)
    changed, always = learned(first.copy()), learned(first.copy())
    rewrite_fit(always, SHAPE, UnitChange(ratio, 0.0))
    for x, y in batches(random, 20):
        fit(changed, SHAPE, x, (y / std).astype(np.float32), 0.0)
        fit(always, SHAPE, x, (y / std * ratio).astype(np.float32), 0.0)
    rewrite_fit(changed, SHAPE, UnitChange(ratio, 0.0))
    for ours, theirs in zip(changed, always, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=1e-6 * np.abs(theirs).max())

    x, y = batches(random, 1)[0]
    before = changed.theta.copy(), always.theta.copy()
    for fitted in (changed, always):
        fit(fitted, SHAPE, x, (y / std * ratio).astype(np.float32), 1e-3)
    steps = [fitted.theta - old for fitted, old in zip((changed, always), before, strict=True)]
    np.testing.assert_allclose(steps[0], steps[1], rtol=1e-2, atol=1e-3 * np.abs(steps[1]).max())


def test_without_the_moments_the_next_steps_are_a_thousand_times_too_small() -> None:
    """What the moments are changed for: a unit that grows by 1,000."""
    still, moving = trained(3)[0], trained(3)[0]
    rewrite_fit(moving, SHAPE, UnitChange(1e-3, 0.0))
    kept = still.m.copy(), still.v.copy()
    rewrite_fit(still, SHAPE, UnitChange(1e-3, 0.0))
    still.m[:], still.v[:] = kept
    x, y = batches(generator(3, "next"), 1)[0]
    gone = []
    for fitted in (still, moving):
        fitted.m[:] = 0
        before = fitted.theta.copy()
        fit(fitted, SHAPE, x, (y / 500.0).astype(np.float32), 1e-3)
        gone.append(np.abs(fitted.theta - before)[: network.decayed_size(SHAPE)].mean())
    assert gone[1] > 1e4 * gone[0]


def test_moments_beyond_float32_are_told() -> None:
    fitted, _ = trained(4)
    with pytest.raises(NotFiniteQuantityError, match="moments of Adam not finite"):
        rescale_moments(fitted, np.float32(1e30))


def statistics() -> Statistics:
    where = setting("Pendulum")
    return Statistics(where.coordinates, where.task.action_size)


@pytest.mark.parametrize(
    ("rewards", "mean", "std"),
    [
        ([-1.0, -1.0, -1.0, -1.0], -1.0, 1.0),
        ([-1.0, 1.0], 0.0, 1.0),
        ([0.002, 0.004], 0.003, 0.003),
        ([0.0, 0.0, 0.0, 4.0], 1.0, np.sqrt(3.0)),
        ([1e30, 1e30], 1e30, 1e30),
    ],
)
def test_the_first_unit_is_the_spread_or_the_mean_whichever_is_larger(
    rewards: list[float], mean: float, std: float
) -> None:
    seen = statistics()
    seen.observe_rewards(np.array(rewards))
    assert (seen.value_mean, seen.value_std) == pytest.approx((mean, std))


def test_rewards_of_nothing_but_0_set_no_unit_and_the_first_other_does() -> None:
    seen = statistics()
    seen.observe_rewards(np.zeros(3))
    assert not seen.has_unit
    assert move_value_scale(seen, 0.001, 1e-6) == UnitChange(1.0, 0.0)
    assert (seen.value_mean, seen.value_std) == (0.0, 1.0)
    seen.observe_rewards(np.array([0.02]))
    assert (seen.value_mean, seen.value_std) == pytest.approx((0.005, np.sqrt(7.5e-5)))


def test_the_unit_follows_the_targets_and_never_falls_below_the_rewards() -> None:
    seen = statistics()
    seen.observe_rewards(np.full(100, -2.0))
    change = move_value_scale(seen, target_mean=-3.0, target_square=25.0)
    assert (seen.value_mean, seen.value_std) == (-8.0, 10.0)
    assert change == UnitChange(0.2, 0.6)
    move_value_scale(seen, target_mean=0.0, target_square=1e-12)
    assert (seen.value_mean, seen.value_std) == (-8.0, 2.0)
