"""Memory: what is worked out beforehand is what the learner has."""

from typing import Any

import pytest

from algorithms import catalogue, memory
from algorithms.training import build
from service.model.environment import environment_facts

SETTINGS: dict[str, list[dict[str, Any]]] = {
    "gd": [{}, {"episodes": 3, "hidden_units": 16}],
    "mpc": [{}, {"horizon": 20}],
    "shac": [{}, {"environments": 3, "window": 9, "hidden_units": 16}],
    "ppo": [{}, {"environments": 3, "window": 9, "hidden_layers": 1}],
}


@pytest.mark.filterwarnings("ignore:.*matches no gradients")
@pytest.mark.parametrize("environment", ["Pendulum", "HalfCheetah"])
@pytest.mark.parametrize("algorithm", catalogue.OWN)
def test_what_is_worked_out_is_what_the_learner_has(algorithm: str, environment: str) -> None:
    for config in SETTINGS.get(algorithm, [{}, {"replay_size": 700}]):
        for weights in [(0.0, 0.0), (0.0, 0.1)]:
            if any(weights) and not catalogue.find(algorithm).uses_weights:
                continue
            learner = build(algorithm, environment, [0], weights, 900, config)
            told = memory.bytes_per_run(algorithm, environment, weights, 900, config)
            assert told == learner.bytes_per_run > 0


@pytest.mark.parametrize("algorithm", ["ddpg", "mpc"])
def test_the_place_in_the_noise_is_counted(algorithm: str) -> None:
    environment = "Pendulum(process_noise=0.1)"
    learner = build(algorithm, environment, [0], (0.0, 0.0), 900, {})
    told = memory.bytes_per_run(algorithm, environment_facts(environment), (0.0, 0.0), 900, {})
    assert told == learner.bytes_per_run > 0


def test_an_algorithm_that_does_not_say_counts_as_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    own = catalogue.OWN["ddpg"]
    silent = catalogue.Algorithm(own.name, own.summary, own.builder, own.config, False, False)
    monkeypatch.setitem(catalogue.OWN, "ddpg", silent)
    assert memory.bytes_per_run("ddpg", "Pendulum", (0.0, 0.0), 900, {}) == 0
