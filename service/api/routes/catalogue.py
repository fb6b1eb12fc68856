"""What can be submitted: algorithms and environments, their settings and limits."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from itertools import chain
from typing import Any

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from algorithms import catalogue
from algorithms.presets import Preset, preset
from physics.audit.record import audited
from physics.noise import PARAMETERS
from physics.parameter import name_of
from service.api.access.authority import MAY_SEE_SHARED
from service.api.context import TheCaller, TheStore
from service.api.schemas.requests.sweep_request import (
    MAX_LISTED,
    MAX_RUNS,
    MAX_SEED,
    MAX_TIMESTEPS,
    MAX_WEIGHT,
)
from service.api.schemas.requests.texts import MAX_NAME
from service.api.schemas.run_answer import WeightsAnswer
from service.model.environment import EnvironmentFacts, known_environments
from service.store.store import Store
from workers.messages.run_spec import Weights

router = APIRouter(tags=["catalogue"], dependencies=[MAY_SEE_SHARED])


class PresetAnswer(BaseModel):
    """The settings of a submission that names none."""

    weights: WeightsAnswer
    timesteps: int
    config: dict[str, Any]


class AlgorithmAnswer(BaseModel):
    """An algorithm; `config_schema` is the JSON schema of its settings."""

    name: str
    summary: str
    description: str = Field(description="Markdown: the docstring of its learner's module.")
    uses_weights: bool
    needs_reward_gradient: bool
    config_schema: dict[str, Any]
    presets: dict[str, PresetAnswer] = Field(
        description="By environment, for those that it can learn in."
    )


class AuditAnswer(BaseModel):
    """What the gradient audit found in one regime of an environment (`python -m physics audit`)."""

    regime: str
    states: int = Field(description="How many states were compared with central differences.")
    kinks: int = Field(
        description="How many more states were at a kink, where no derivative exists."
    )
    worst: float = Field(description="The worst relative error of the states compared.")
    median: float
    passed: bool = Field(description="At least 2,000 states, and the worst error at most 1e-6.")


class ParameterAnswer(BaseModel):
    """A physical parameter of an environment, or a deviation of its noise."""

    name: str
    unit: str = Field(description='"1" for a dimensionless number.')
    default: float
    least: float
    greatest: float
    meaning: str


class EnvironmentAnswer(BaseModel):
    """An environment."""

    name: str
    description: str = Field(description="Markdown: the docstrings of its class and its module.")
    version: int
    state_size: int
    action_size: int
    feature_size: int
    horizon: int
    max_reward: float
    reward_is_differentiable: bool
    regimes: list[str] = Field(description="The kinds of step that its audit reports separately.")
    parameters: list[ParameterAnswer] = Field(description="Parameters that a sweep may set.")
    file: str = Field(description="The task file it comes from; empty for an installed task.")
    audit: list[AuditAnswer] = Field(
        description="Empty if this version of the environment was never audited."
    )


class LimitsAnswer(BaseModel):
    """Limits of a submission."""

    runs: int = MAX_RUNS
    timesteps: int = MAX_TIMESTEPS
    seed: int = MAX_SEED
    weight: float = MAX_WEIGHT
    name_characters: int = MAX_NAME
    listed: int = MAX_LISTED


class CatalogueAnswer(BaseModel):
    """The catalogue."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "algorithms": [
                        {
                            "name": "ddpg",
                            "summary": "Deterministic policy gradients.",
                            "description": "DDPG: deterministic policy gradients.",
                            "uses_weights": False,
                            "needs_reward_gradient": False,
                            "config_schema": {"type": "object"},
                            "presets": {
                                "Pendulum": {
                                    "weights": {"w1": 0.0, "w2": 0.0},
                                    "timesteps": 20_000,
                                    "config": {},
                                }
                            },
                        }
                    ],
                    "environments": [
                        {
                            "name": "Pendulum",
                            "description": "A rod to be swung up.\n\n    r = -theta^2",
                            "version": 1,
                            "state_size": 2,
                            "action_size": 1,
                            "feature_size": 3,
                            "horizon": 200,
                            "max_reward": 0.0,
                            "reward_is_differentiable": True,
                            "regimes": ["swing"],
                            "parameters": [],
                            "file": "",
                            "audit": [],
                        }
                    ],
                    "parameters": [
                        {
                            "name": "process_noise",
                            "unit": "1",
                            "default": 0.0,
                            "least": 0.0,
                            "greatest": 1000.0,
                            "meaning": "deviation of what moves each coordinate before a step",
                        }
                    ],
                    "limits": {
                        "runs": MAX_RUNS,
                        "timesteps": MAX_TIMESTEPS,
                        "seed": MAX_SEED,
                        "weight": MAX_WEIGHT,
                        "name_characters": MAX_NAME,
                        "listed": MAX_LISTED,
                    },
                }
            ]
        }
    )

    algorithms: list[AlgorithmAnswer]
    environments: list[EnvironmentAnswer]
    parameters: list[ParameterAnswer] = Field(
        description="Parameters that every environment has beside its own: noise."
    )
    limits: LimitsAnswer


@router.get("/catalogue")
def get_catalogue(caller: TheCaller, store: TheStore) -> CatalogueAnswer:
    """List everything that a submission can use: algorithms, environments and limits."""
    environments, algorithms = known_environments(), catalogue.names()
    if caller.sweeps is not None:
        shown = names_in(caller.sweeps, store)
        environments = [facts for facts in environments if facts.name in shown]
        algorithms = [name for name in algorithms if name in shown]
    return CatalogueAnswer(
        algorithms=[_algorithm(name, environments) for name in algorithms],
        environments=[_environment(facts) for facts in environments],
        parameters=[ParameterAnswer(**asdict(parameter)) for parameter in PARAMETERS],
        limits=LimitsAnswer(),
    )


def names_in(sweeps: Iterable[str], store: Store) -> set[str]:
    """Return the names of the algorithms and environments of sweeps."""
    found = [store.find_sweep(each) for each in sweeps]
    requests = [sweep.request for sweep in found if sweep is not None]
    named = [[each["name"] for each in request["algorithms"]] for request in requests]
    tasks = chain(*(request["environments"] for request in requests))
    return set(chain(*named, map(name_of, tasks)))


def _environment(facts: EnvironmentFacts) -> EnvironmentAnswer:
    return EnvironmentAnswer(
        **asdict(facts),
        audit=[
            AuditAnswer(**asdict(row), passed=row.passed())
            for row in audited(facts.name, facts.version)
        ],
    )


def _algorithm(name: str, environments: Sequence[EnvironmentFacts]) -> AlgorithmAnswer:
    algorithm = catalogue.find(name)
    able = [
        facts.name
        for facts in environments
        if facts.reward_is_differentiable or not algorithm.needs_reward_gradient
    ]
    return AlgorithmAnswer(
        name=algorithm.name,
        summary=algorithm.summary,
        description=algorithm.description(),
        uses_weights=algorithm.uses_weights,
        needs_reward_gradient=algorithm.needs_reward_gradient,
        config_schema=TypeAdapter(algorithm.config_class()).json_schema(),
        presets={environment: _preset(preset(name, environment)) for environment in able},
    )


def _preset(usual: Preset) -> PresetAnswer:
    return PresetAnswer(
        weights=WeightsAnswer.of(Weights(*usual.weights)),
        timesteps=usual.timesteps,
        config=dict(usual.config),
    )
