"""What can be submitted: algorithms and environments, their settings and limits."""

from fastapi import APIRouter
from pydantic import BaseModel

import physics
from service.algorithm import algorithm_facts, algorithm_names
from service.environment import environment_facts
from service.palette import colour
from service.schemas.sweep_request import (
    MAX_LISTED,
    MAX_NAME,
    MAX_RUNS,
    MAX_SEED,
    MAX_TIMESTEPS,
    MAX_WEIGHT,
)

router = APIRouter(tags=["catalogue"])


class AlgorithmAnswer(BaseModel):
    """An algorithm."""

    name: str
    uses_weights: bool
    needs_reward_gradient: bool
    colour: str


class EnvironmentAnswer(BaseModel):
    """An environment."""

    name: str
    version: int
    state_size: int
    action_size: int
    feature_size: int
    horizon: int
    max_reward: float
    reward_is_differentiable: bool


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

    algorithms: list[AlgorithmAnswer]
    environments: list[EnvironmentAnswer]
    limits: LimitsAnswer


@router.get("/catalogue")
def get_catalogue() -> CatalogueAnswer:
    """List algorithms and environments."""
    algorithms = [algorithm_facts(name) for name in algorithm_names()]
    environments = [environment_facts(name) for name in physics.names()]
    return CatalogueAnswer(
        algorithms=[
            AlgorithmAnswer(
                name=facts.name,
                uses_weights=facts.uses_weights,
                needs_reward_gradient=facts.needs_reward_gradient,
                colour=colour(facts.name),
            )
            for facts in algorithms
        ],
        environments=[EnvironmentAnswer(**vars(facts)) for facts in environments],
        limits=LimitsAnswer(),
    )
