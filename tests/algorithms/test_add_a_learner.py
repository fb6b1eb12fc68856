"""docs/add-a-learner.md, done: its module, its entry point, and what every learner must keep."""

from pathlib import Path
from typing import Any

import numpy as np
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

NAME, TASK, TIMESTEPS = "cem", "Pendulum", 2_500
SMALL = {"population": 3, "best": 2}
PAGE = ROOT / "docs" / "add-a-learner.md"
Point = tuple[int, int, float, float]


@pytest.fixture(autouse=True)
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (code, _), (project,) = blocks(PAGE, "python"), blocks(PAGE, "toml")
    return install(tmp_path, "cem", code, project, monkeypatch)


def build(*seeds: int) -> Learner:
    return algorithms.build(NAME, TASK, seeds, timesteps=TIMESTEPS, config=SMALL)


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


def test_it_measures_on_the_common_grid_and_finds_better_actors() -> None:
    trainer = algorithms.train(NAME, "MassPoint", range(3), timesteps=20_000)
    measured = trainer.run()
    for seed in range(3):
        own = [m for m in measured if m.seed == seed]
        assert [m.timestep for m in own] == list(range(800, 20_001, 800))
        spreads = [m.diagnostics["spread"] for m in own]
        assert spreads[-1] < spreads[0] / 2
        assert np.mean([m.return_mean for m in own[-5:]]) > own[0].return_mean
        assert trainer.policy(seed).header.origin["algorithm"] == NAME


def test_alone_and_in_a_cohort_the_same_bits() -> None:
    together = curve(build(0, 1, 2))
    assert [each for each in together if each[0] == 1] == curve(build(1))


def test_interrupted_it_goes_on_to_the_same_bits() -> None:
    learner, again = build(0, 1), build(0, 1)
    for _ in range(2):
        learner.advance()
    again.restore({s: Saved(learner.state(s), learner.journal(s, 0)) for s in learner.seeds})
    assert again.timestep == learner.timestep == 2 * 3 * Pendulum.horizon
    assert curve(again) == curve(learner) != []


def test_an_error_ends_its_run_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, calls = Pendulum.initial_states, iter(range(1_000_000))

    def failing_once(self: Pendulum, seeds: Any) -> Any:
        if next(calls) in (1, 2):  # the second run's first episodes, and once more alone
            raise RuntimeError("broken")
        return begun(self, seeds)

    monkeypatch.setattr(Pendulum, "initial_states", failing_once)
    seen: list[int] = []
    measurements = algorithms.train(NAME, TASK, range(3), timesteps=1600, config=SMALL)
    with pytest.raises(FailedRunsError, match="seed 1 failed at timestep 0: RuntimeError: broken"):
        seen.extend(m.seed for m in measurements)
    assert sorted(seen) == [0, 0, 2, 2]


def test_settings_are_checked_by_name() -> None:
    with pytest.raises(ValueError, match="spread"):
        algorithms.build(NAME, TASK, [0], config={"spread": 0.0})


def test_what_the_page_trains_runs_without_a_package(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    train = algorithms.train

    def shortened(algorithm: algorithms.Algorithm, environment: str, **options: Any) -> Any:
        chosen = {**options, "seeds": [0], "timesteps": 800, "config": SMALL}
        return train(algorithm, environment, **chosen)

    monkeypatch.setattr(algorithms, "train", shortened)
    names: dict[str, Any] = {}
    exec(compile(blocks(PAGE, "python")[1], PAGE, "exec"), names)  # noqa: S102
    assert capsys.readouterr().out.startswith("0 800 ")
    assert names["policy"].act_in([0.0, 0.0]).shape == (1,)
