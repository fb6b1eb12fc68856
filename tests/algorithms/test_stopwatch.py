"""The stopwatch: processor time of training alone, each kernel's compiling and loading apart."""

import json
import subprocess
import sys
import threading
import time
from typing import Any

import numba
import pytest

import algorithms
from algorithms.actor_critic.learner import OffPolicyLearner
from algorithms.experience.evaluation import episode_returns
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.stopwatch import Cost, Stopwatch

LEARNERS = ["ddpg", "hybrid-ddpg", "hybrid-ddpg-cosine", "hybrid-ddpg-robust", "td3",
            "hybrid-td3", "sac", "hybrid-sac", "gd", "mpc"]  # fmt: skip
BUSY = 0.05
"""Seconds of work in these tests."""


def work(seconds: float = BUSY) -> None:
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def new_kernel() -> Any:
    """A kernel that its first call compiles, and another one within it."""
    inner: Any = numba.njit(lambda x: x * x)
    return numba.njit(lambda x: inner(x) + 1.0)


@pytest.fixture
def costs() -> dict[int, Cost]:
    return {seed: Cost() for seed in (3, 5)}


def test_training_is_shared_by_those_it_is_of(costs: dict[int, Cost]) -> None:
    stopwatch = Stopwatch(costs)
    with stopwatch.training([3, 5]):
        work()
    with stopwatch.training([5]):
        work()
    assert costs[3].seconds == pytest.approx(BUSY / 2, rel=0.1)
    assert costs[5].seconds == pytest.approx(3 * BUSY / 2, rel=0.1)
    assert costs[3].compile_seconds == costs[5].compile_seconds == 0.0


def test_waiting_and_what_stands_aside_cost_nothing(costs: dict[int, Cost]) -> None:
    stopwatch = Stopwatch(costs)
    with stopwatch.training([3]):
        threading.Event().wait(4 * BUSY)
    with stopwatch.aside():
        work()
    assert costs[3].seconds < BUSY / 2
    assert costs[5].seconds == 0.0


def test_other_threads_cost_nothing(costs: dict[int, Cost]) -> None:
    def work_and_compile() -> None:
        work()
        new_kernel()(1.0)

    other = threading.Thread(target=work_and_compile)
    with Stopwatch(costs).training([3]):
        other.start()
        other.join()
    assert costs[3].seconds < BUSY / 2
    assert costs[3].compile_seconds == 0.0


def test_compiling_is_apart_and_serves_all(costs: dict[int, Cost]) -> None:
    """Once for the kernel and the one it compiles within itself; the next call compiles nothing."""
    kernel, stopwatch = new_kernel(), Stopwatch(costs)
    begun = time.thread_time()
    with stopwatch.training([3]):
        kernel(1.0)
    spent = time.thread_time() - begun
    compiled = [cost.compile_seconds for cost in costs.values()]
    assert compiled[0] == compiled[1] > 0.0
    assert sum(compiled) + costs[3].seconds == pytest.approx(spent, rel=0.05)
    assert costs[3].seconds < 0.2 * spent
    with stopwatch.training([3]):
        kernel(2.0)
    assert [cost.compile_seconds for cost in costs.values()] == compiled


def test_time_counts_also_where_something_is_raised(costs: dict[int, Cost]) -> None:
    def fail() -> None:
        with Stopwatch(costs).training([3]):
            work()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert costs[3].seconds >= BUSY


def test_who_has_left_pays_nothing_more(costs: dict[int, Cost]) -> None:
    stopwatch = Stopwatch(costs)
    stopwatch.keep([5])
    with stopwatch.aside():
        new_kernel()(1.0)
    assert costs[3].compile_seconds == 0.0 < costs[5].compile_seconds


def next_measured(learner: Learner) -> list[Measurement]:
    found: list[Measurement] = []
    while not found and not learner.finished:
        found = [m for m in learner.advance() if isinstance(m, Measurement)]
    return found


@pytest.mark.parametrize("name", LEARNERS)
def test_every_learner_counts_its_training_and_nothing_else(name: str) -> None:
    """What both runs have cost is most of what the thread has done, and the rest is evaluation."""
    for _ in range(2):  # once for kernels that are not loaded yet
        begun = time.thread_time()
        found = list(algorithms.train(name, "Pendulum", [0, 1], timesteps=2_400))
        spent = time.thread_time() - begun
    last = {m.seed: m for m in found}
    assert sorted(last) == [0, 1]
    assert all(m.compile_seconds == 0.0 for m in last.values())
    assert 0.2 * spent < sum(m.seconds for m in last.values()) < spent
    for seed in last:
        own = [m.seconds for m in found if m.seed == seed]
        assert own == sorted(own)
        assert own[0] > 0.0


def test_evaluation_and_diagnostics_are_not_training(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow_returns(*arguments: Any) -> Any:
        work(1.0)
        return episode_returns(*arguments)

    def slow_diagnosis(timestep: int) -> dict[str, float]:
        del timestep
        work(1.0)
        return {}

    learner = algorithms.build("ddpg", "CartPole", [0], timesteps=1_600)
    assert isinstance(learner, OffPolicyLearner)
    [usual] = next_measured(learner)
    monkeypatch.setattr("algorithms.actor_critic.learner.episode_returns", slow_returns)
    monkeypatch.setattr(learner._agents[0], "diagnose", slow_diagnosis)
    [slowed] = next_measured(learner)
    assert slowed.seconds - usual.seconds < 1.0


def test_what_a_run_cost_before_it_was_left_counts_on() -> None:
    cost = Cost()
    cost.seconds, cost.compile_seconds = 1.0, 2.0
    again = Cost()
    again.seconds, again.compile_seconds = 0.25, 0.5  # of building the learner anew
    again.restore(cost.state())
    assert (again.seconds, again.compile_seconds) == (1.0, 2.5)


ALONE = """
import json, sys
import algorithms
first = next(algorithms.train("gd", "Pendulum", [0], timesteps=1600))
print(json.dumps([first.seconds, first.compile_seconds]))
"""


def test_loading_kernels_from_the_cache_is_apart_too() -> None:
    """A process that finds all kernels compiled loads them, within their first calls."""
    begun = [sys.executable, "-c", ALONE]
    subprocess.run(begun, check=True, capture_output=True)  # they are in the cache now
    said = subprocess.run(begun, check=True, capture_output=True, text=True)
    seconds, compile_seconds = json.loads(said.stdout)
    assert 0.0 < seconds < compile_seconds < 5.0


def test_the_thread_that_listens_is_the_one_that_compiles() -> None:
    """Two cohorts may compile at once: each pays for its own kernels."""
    costs = [Cost(), Cost()]
    apart = threading.Barrier(2)

    def train(place: int) -> None:
        kernel = new_kernel()
        apart.wait()
        with Stopwatch({0: costs[place]}).training([0]):
            if place:
                kernel(1.0)

    threads = [threading.Thread(target=train, args=(place,)) for place in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert costs[0].compile_seconds == 0.0 < costs[1].compile_seconds
