"""What goes wrong in one run ends that run alone, under its own name, at its own update."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import algorithms
from algorithms import catalogue
from algorithms.early_end import DivergedError, Divergence, EarlyEnd, FailedRunsError, Failure
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.networks import finite
from physics.environment import Environment, FloatArray
from physics.kernels.compiled import compiled_fast
from tests.algorithms.other_rewards import OtherRewards

Events = list[Measurement | EarlyEnd]
LEARNERS = ["ddpg", "hybrid-ddpg", "hybrid-ddpg-cosine", "hybrid-ddpg-robust", "td3",
            "hybrid-td3", "sac", "hybrid-sac", "gd", "shac", "ppo", "mpc"]  # fmt: skip
SMALL = {"hidden_units": 8}
OF_WINDOWS: dict[str, dict[str, Any]] = {
    name: {"environments": 2, "window": 40} for name in ("shac", "ppo")
}


def build(
    name: str,
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float] = (0.0, 0.0),
    timesteps: int = 800,
    **config: Any,
) -> Learner:
    algorithm = catalogue.find(name)
    chosen = algorithm.config_class()(**{**SMALL, **OF_WINDOWS.get(name, {}), **config})
    learner: Learner = algorithm.load()(environment, list(seeds), weights, timesteps, chosen)
    return learner


def events(learner: Learner) -> Events:
    said: Events = []
    while not learner.finished:
        said += learner.advance()
    return said


def told(said: Events, seed: int) -> list[Any]:
    """What was said of one seed, but for the time it took and the lines of a traceback."""
    return [
        (e.timestep, e.return_mean, e.return_history, str(e.diagnostics))
        if isinstance(e, Measurement)
        else e.reason
        for e in said
        if e.seed == seed
    ]


def ends(said: Events) -> dict[int, EarlyEnd]:
    return {e.seed: e for e in said if not isinstance(e, Measurement)}


def telling(said: Events, seeds: Sequence[int]) -> list[int]:
    """Those that ended early, and two of those that did not: others would prove nothing more."""
    early = ends(said)
    return [*early, *[seed for seed in seeds if seed not in early][:2]]


def weights_of(name: str) -> tuple[float, float]:
    return (0.1, 0.1) if name.startswith("hybrid") else (0.0, 0.0)


# ---- the check itself


@compiled_fast
def sums(parts: FloatArray) -> tuple[int, bool]:
    total = parts[0] + parts[1] + parts[2]
    return finite.first_not_finite((parts[0], total, total * total)), finite.is_finite(total)


@pytest.mark.parametrize(
    ("parts", "first"),
    [([1, 2, 3], -1), ([np.nan, 2, 3], 0), ([1, np.nan, 3], 1), ([1, 2, np.inf], 1),
     ([1e308, 1e308, 0], 1), ([1e200, 0, 0], 2)],
)  # fmt: skip
def test_a_sum_that_is_not_finite_is_seen_where_sums_may_be_reordered(
    parts: list[float], first: int
) -> None:
    with np.errstate(over="ignore"):
        expected = first, bool(np.isfinite(np.array(parts, np.float64).sum()))
    assert sums(np.array(parts, np.float64)) == expected


def test_no_reordered_kernel_asks_numpy_whether_a_number_is_finite() -> None:
    """There, `isfinite` is compiled to True."""
    package = Path(algorithms.__file__).parent
    kernel = re.compile(r"@compiled_fast\ndef (\w+)(?:.|\n)*?(?=\n\n\n|\Z)")
    asking = [
        f"{path.name}: {found[1]}"
        for folder in (package, package.parent / "physics")
        for path in folder.rglob("*.py")
        for found in kernel.finditer(path.read_text())
        if re.search(r"\b(isfinite|isnan|isinf)\(", found[0])
    ]
    assert asking == []


# ---- divergence


def test_a_weight_beyond_all_measure_ends_each_run_at_its_first_update() -> None:
    measured = algorithms.train("hybrid-ddpg", "Pendulum", [0, 1], (1e30, 0.0), 800)
    with pytest.raises(
        DivergedError, match=r"seed 1 diverged: critic gradient not finite"
    ) as raised:
        list(measured)
    assert raised.value.divergences == [
        Divergence(seed, 100, 1, "critic gradient") for seed in (0, 1)
    ]


def test_whoever_is_left_goes_on_to_the_bits_it_has_alone() -> None:
    wild: dict[str, Any] = {"rate": 1.0, "reward_scale": 1e6, "gamma": 1.0, "tau": 1.0}
    task, seeds = OtherRewards("Pendulum", lambda s, r: r), range(6)
    together = events(build("sac", task, seeds, timesteps=2_400, **wild))
    for seed in telling(together, seeds):
        alone = events(build("sac", task, [seed], timesteps=2_400, **wild))
        assert told(together, seed) == told(alone, seed) != []
    assert all(isinstance(end, Divergence) for end in ends(together).values())


def spoiled(value: float, above: float) -> OtherRewards:
    """Pendulum with that reward where it turns faster than `above` rad/s."""
    return OtherRewards("Pendulum", lambda s, r: np.where(s[:, 1] > above, value, r))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("name", ["ddpg", "hybrid-ddpg", "sac", "hybrid-sac", "shac", "ppo"])
def test_a_reward_that_is_no_float32_ends_the_run_that_met_it(name: str, value: float) -> None:
    task, seeds = spoiled(value, above=7.9), range(8)
    said = events(build(name, task, seeds, weights_of(name)))
    met = ends(said)
    assert 0 < len(met) < len(seeds)
    for end in met.values():
        assert isinstance(end, Divergence)
        assert end.quantity in ("reward", "rewards", "return")
    for seed in telling(said, seeds):
        alone = events(build(name, task, [seed], weights_of(name)))
        assert told(said, seed) == told(alone, seed)


@pytest.mark.parametrize("value", [np.nan, -np.inf])
@pytest.mark.parametrize("name", ["gd", "shac", "ppo", "mpc"])
def test_so_it_does_for_learners_without_a_replay(name: str, value: float) -> None:
    task, seeds = spoiled(value, above=7.0), range(6)
    said = events(build(name, task, seeds, timesteps=1_600))
    met = ends(said)
    assert met
    assert {type(end) for end in met.values()} == {Divergence}
    for seed in telling(said, seeds):
        assert told(said, seed) == told(events(build(name, task, [seed], timesteps=1_600)), seed)


# ---- failures


class Tripping(OtherRewards):
    """Code that raises in some episodes: `where` says in which call, of episodes that draw low."""

    def __init__(self, where: str, above: float = 7.9) -> None:
        super().__init__("Pendulum", lambda s, r: r)
        self._where = where
        self._above = above

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        state = super().initial_state(generator)
        if self._where == "start" and generator.uniform() < 0.2:
            raise KeyError("no such start")
        return state

    def step_kernel(self, states: FloatArray, actions: FloatArray, *step: Any) -> int:
        self._trip(states)
        return super().step_kernel(states, actions, *step)

    def differentiate_kernel(self, states: FloatArray, actions: FloatArray, *outputs: Any) -> int:
        self._trip(states)
        return super().differentiate_kernel(states, actions, *outputs)

    def _trip(self, states: FloatArray) -> None:
        if self._where == "step" and (states[:, 1] > self._above).any():
            raise RuntimeError("tripped over a cable")


@pytest.mark.parametrize("where", ["start", "step"])
@pytest.mark.parametrize("name", LEARNERS)
def test_code_that_raises_in_one_run_fails_that_run(name: str, where: str) -> None:
    task, seeds = Tripping(where, above=5.0 if name == "mpc" else 7.9), range(8)

    def trained(chosen: Sequence[int]) -> Events:
        return events(build(name, task, chosen, weights_of(name), timesteps=1_600))

    said = trained(seeds)
    failed = ends(said)
    assert failed
    wanted = {"start": "KeyError: 'no such start'", "step": "RuntimeError: tripped over a cable"}
    for end in failed.values():
        assert isinstance(end, Failure)
        assert end.error.strip().endswith(wanted[where])
    for seed in telling(said, seeds):
        assert told(said, seed) == told(trained([seed]), seed) != []


class WithoutDerivatives(OtherRewards):
    """A task whose derivatives leave the numbers where it turns fast, and whose steps do not."""

    def __init__(self) -> None:
        super().__init__("Pendulum", lambda s, r: r)

    def differentiate_kernel(self, states: FloatArray, actions: FloatArray, *outputs: Any) -> int:
        unsolved = super().differentiate_kernel(states, actions, *outputs)
        outputs[3][states[:, 1] > 5.0] = np.nan
        return unsolved


@pytest.mark.parametrize("name", ["ddpg", "sac"])
def test_who_matches_no_gradients_needs_no_derivatives(name: str) -> None:
    said = events(build(name, WithoutDerivatives(), range(6)))
    assert ends(said) == {}
    cosines = [e.diagnostics["state_gradient_cosine"] for e in said if isinstance(e, Measurement)]
    assert np.isnan(cosines).any()
    assert [e.return_mean for e in said if isinstance(e, Measurement)] == [
        e.return_mean
        for e in events(build(name, OtherRewards("Pendulum", lambda s, r: r), range(6)))
        if isinstance(e, Measurement)
    ]


def test_train_tells_at_the_end_what_failed_and_what_diverged() -> None:
    task = OtherRewards("Pendulum", lambda s, r: np.where(s[:, 1] > 7.9, np.nan, r))
    tripping = Tripping("step")
    with pytest.raises(DivergedError, match=r"seed \d diverged: reward not finite at update"):
        list(algorithms.train("ddpg", task, range(8), timesteps=800, config=SMALL))
    with pytest.raises(FailedRunsError, match=r"tripped over a cable\n\nThe first") as raised:
        list(algorithms.train("ddpg", tripping, range(8), timesteps=800, config=SMALL))
    assert raised.value.failures
    assert "Traceback" in str(raised.value)


# ---- whatever the settings

RATE = st.floats(1e-6, 1.0)
SHARE = st.floats(0.0, 1.0)
WEIGHT = st.sampled_from([0.0, 1e-30, 0.1, 1e6, 1e30])
SETTINGS: dict[str, dict[str, st.SearchStrategy[Any]]] = {
    "ddpg": {
        "hidden_units": st.integers(4, 16), "batch_size": st.integers(1, 32),
        "actor_rate": RATE, "critic_rate": RATE, "critic_decay": SHARE,
        "tau": st.floats(1e-6, 1.0), "gamma": SHARE, "rollout_steps": st.integers(1, 200),
        "cycle_updates": st.integers(1, 20), "replay_size": st.integers(100, 400),
        "noise": SHARE, "time_limit_is_terminal": st.booleans(),
    },
    "td3": {
        "hidden_units": st.integers(4, 16), "batch_size": st.integers(1, 32),
        "actor_rate": RATE, "critic_rate": RATE, "tau": st.floats(1e-6, 1.0), "gamma": SHARE,
        "rollout_steps": st.integers(1, 200), "cycle_updates": st.integers(1, 20),
        "replay_size": st.integers(100, 400), "noise": SHARE, "target_noise": SHARE,
        "noise_bound": SHARE, "delay": st.integers(1, 3),
    },
    "sac": {
        "hidden_units": st.integers(4, 16), "batch_size": st.integers(1, 32), "rate": RATE,
        "tau": st.floats(1e-6, 1.0), "gamma": SHARE, "reward_scale": st.floats(1e-6, 1e6),
        "temperature": st.sampled_from(["fixed", "learned"]),
        "rollout_steps": st.integers(1, 200), "cycle_updates": st.integers(1, 20),
        "replay_size": st.integers(100, 400),
    },
    "gd": {
        "hidden_units": st.integers(4, 16), "rate": RATE, "episodes": st.integers(1, 3),
        "clip": st.floats(1e-6, 1e9), "patience": st.integers(1, 3),
    },
    "shac": {
        "hidden_units": st.integers(4, 16), "environments": st.integers(1, 4),
        "window": st.integers(1, 40), "actor_rate": RATE, "critic_rate": RATE, "gamma": SHARE,
        "trace": SHARE, "target_share": SHARE, "critic_epochs": st.integers(1, 3),
        "critic_batches": st.integers(1, 4), "noise": st.floats(1e-6, 7.0),
        "clip": st.floats(1e-6, 1e9),
    },
    "ppo": {
        "hidden_units": st.integers(4, 16), "environments": st.integers(1, 4),
        "window": st.integers(1, 40), "rate": RATE, "gamma": SHARE, "trace": SHARE,
        "ratio_bound": st.floats(1e-6, 10.0), "epochs": st.integers(1, 3),
        "batches": st.integers(1, 8), "noise": st.floats(1e-6, 7.0),
        "clip": st.floats(1e-6, 1e9),
    },
    "mpc": {"hidden_units": st.integers(4, 16), "horizon": st.integers(1, 8),
            "iterations": st.integers(1, 3)},
}  # fmt: skip
REWARDS: list[Callable[[FloatArray, FloatArray], FloatArray]] = [
    lambda s, r: r,
    lambda s, r: 0.0 * r,
    lambda s, r: np.where(s[:, 1] > 3.0, np.nan, r),
    lambda s, r: np.where(s[:, 1] > 3.0, -np.inf, r),
    lambda s, r: np.where(s[:, 1] > 3.0, 1e300, r),
    lambda s, r: np.where(s[:, 1] > 3.0, 1e30, r),
    lambda s, r: np.where(s[:, 1] > 3.0, 1e-300, -1e-300),
]


@pytest.mark.parametrize("name", LEARNERS)
def test_a_run_ends_at_its_timesteps_or_as_diverged_whatever_the_settings(name: str) -> None:
    base = catalogue.baseline(name) or name

    @settings(max_examples=20, deadline=None, database=None, derandomize=True,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(
        config=st.fixed_dictionaries(SETTINGS[base]),
        rewards=st.sampled_from(REWARDS),
        weights=st.tuples(WEIGHT, WEIGHT) if name.startswith("hybrid") else st.just((0.0, 0.0)),
        timesteps=st.integers(1, 900),
    )
    def check(config: dict[str, Any], rewards: Any, weights: Any, timesteps: int) -> None:
        task, seeds = OtherRewards("Pendulum", rewards), [0, 1, 2]
        said = events(build(name, task, seeds, weights, timesteps, **config))
        for seed in seeds:
            mine = [e for e in said if e.seed == seed]
            early = [e for e in mine if not isinstance(e, Measurement)]
            assert all(isinstance(e, Divergence) for e in early), early
            assert len(early) <= 1
            assert all(np.isfinite(e.return_mean) for e in mine if isinstance(e, Measurement))
            if not early and base in ("ddpg", "sac"):
                assert mine[-1].timestep == timesteps
        alone = events(build(name, task, [1], weights, timesteps, **config))
        assert told(said, 1) == told(alone, 1) != []

    check()
