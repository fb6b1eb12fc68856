"""docs/add-a-learner.md, done: its module, its entry point, and what every learner must keep."""

from pathlib import Path

import pytest

import algorithms
from algorithms.early_end import FailedRunsError
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.memory import bytes_per_run
from algorithms.state import Saved
from physics.tasks.pendulum import Pendulum
from tests.docs.pages import ROOT, blocks
from tests.installed_package import install

NAME, TASK, TIMESTEPS = "random-search", "Pendulum", 2_500
PAGE = ROOT / "docs" / "add-a-learner.md"
Point = tuple[int, int, float, float]


@pytest.fixture(autouse=True)
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (code,), (project,) = blocks(PAGE, "python"), blocks(PAGE, "toml")
    return install(tmp_path, "random_search", code, project, monkeypatch)


def build(*seeds: int) -> Learner:
    return algorithms.build(NAME, TASK, seeds, timesteps=TIMESTEPS)


def point(m: Measurement) -> Point:
    """What must have the same bits."""
    return m.seed, m.timestep, m.return_mean, m.return_history


def curve(learner: Learner) -> list[Point]:
    """Every measurement to the end."""
    points = []
    while not learner.finished:
        points += [point(m) for m in learner.advance() if isinstance(m, Measurement)]
    return points


def test_it_is_listed_after_our_own() -> None:
    assert algorithms.names()[-1] == NAME
    assert bytes_per_run(NAME, TASK, (0.0, 0.0), TIMESTEPS, {}) == 0


def test_it_measures_on_the_common_grid_what_never_falls() -> None:
    measured = list(algorithms.train(NAME, TASK, range(3), timesteps=TIMESTEPS))
    for seed in range(3):
        own = [m for m in measured if m.seed == seed]
        assert [m.timestep for m in own] == [800, 1600, 2400, 2500]
        best = [m.diagnostics["best_return"] for m in own]
        assert best == sorted(best)
        assert best[-1] > best[0]


def test_alone_and_in_a_cohort_the_same_bits() -> None:
    together = curve(build(0, 1, 2))
    assert [each for each in together if each[0] == 1] == curve(build(1))


def test_interrupted_it_goes_on_to_the_same_bits() -> None:
    learner, again = build(0, 1), build(0, 1)
    for _ in range(5):
        learner.advance()
    again.restore({s: Saved(learner.state(s), learner.journal(s, 0)) for s in learner.seeds})
    assert again.timestep == learner.timestep == 1000
    assert curve(again) == curve(learner) != []


def test_an_error_ends_its_run_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    step, calls = Pendulum.step, iter(range(1_000_000))

    def failing_once(self: Pendulum, *arrays: object) -> object:
        if next(calls) == 300:  # in the second run's first episode
            raise RuntimeError("broken")
        return step(self, *arrays)  # type: ignore[arg-type]

    monkeypatch.setattr(Pendulum, "step", failing_once)
    seen: list[int] = []
    measurements = algorithms.train(NAME, TASK, range(3), timesteps=1600)
    with pytest.raises(FailedRunsError, match="seed 1 failed at timestep 0: RuntimeError: broken"):
        seen.extend(m.seed for m in measurements)
    assert seen == [0, 2] * 2


def test_settings_are_checked_by_name() -> None:
    with pytest.raises(ValueError, match="scale"):
        algorithms.build(NAME, TASK, [0], config={"scale": 0.0})
