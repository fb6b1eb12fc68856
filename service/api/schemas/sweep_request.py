"""What `POST /sweeps` takes: a product of algorithms, weights, environments and seeds."""

import math
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    WithJsonSchema,
)

from algorithms.presets import SMALLEST_WEIGHT
from physics.parameter import label, relabelled

MAX_RUNS = 20_000
MAX_NAME = 200
MAX_LISTED = 100
MAX_TIMESTEPS = 100_000_000
MAX_SEED = 2**53 - 1  # the largest whole number that every JSON reader keeps
MAX_WEIGHT = 1e6
MAX_CONFIG_TEXT = 1_000


class Request(BaseModel):
    """A strict request body."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


def storable(text: str) -> str:
    """Return text that databases can hold exactly; raises ValueError for what they cannot."""
    if "\0" in text:
        raise ValueError("holds the character NUL, which databases cannot store")
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise ValueError("is not valid Unicode: it holds half of a surrogate pair")
    return text


def weight(value: float) -> float:
    """Return the number, -0.0 as 0.0: they are equal, but do not look so.

    Raises ValueError for what is 0 to a learner, but does not look so.
    """
    if 0 < value < SMALLEST_WEIGHT:
        raise ValueError(f"is 0 to a learner: give 0, or at least {SMALLEST_WEIGHT}")
    return value + 0.0


def config_value(value: object) -> object:
    """Return a setting of a learner: a scalar, or a list of scalars; its config says which."""
    if isinstance(value, list) and len(value) <= MAX_LISTED:
        return [_scalar(each) for each in value]
    return _scalar(value)


def _scalar(value: object) -> object:
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int) and abs(value) <= MAX_SEED:
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    if isinstance(value, str) and len(value) <= MAX_CONFIG_TEXT:
        return storable(value)
    raise ValueError(
        "a setting is null, true, false, a finite number, a short text, or a list of those"
    )


def _one_or_list(value: object) -> str:
    return "<list>" if isinstance(value, list) else "<one>"


Text = Annotated[str, AfterValidator(storable)]
Name = Annotated[Text, Field(min_length=1, max_length=MAX_NAME)]
Weight = Annotated[float, Field(ge=0, le=MAX_WEIGHT), AfterValidator(weight)]
Seed = Annotated[int, Field(ge=0, le=MAX_SEED)]
ConfigValue = Annotated[
    Any,
    PlainValidator(config_value),
    WithJsonSchema({"description": "null, boolean, number, text, or a list of those"}),
]


class Weights(Request):
    """Weights of the critic's gradient terms: w1 for dQ/da, w2 for dQ/ds."""

    w1: Weight = 0.0
    w2: Weight = 0.0


class EnvironmentRequest(Request):
    """An environment with values of its physical parameters; lists of values are a grid."""

    name: Name
    parameters: dict[
        Name,
        Annotated[
            Annotated[float, Tag("<one>")]
            | Annotated[list[float], Field(min_length=1, max_length=MAX_LISTED), Tag("<list>")],
            Discriminator(_one_or_list),
        ],
    ] = Field(
        default_factory=dict,
        max_length=MAX_LISTED,
        description="By name; `GET /catalogue` has the unit, the default and the range of each.",
    )

    @property
    def axes(self) -> dict[str, list[float]]:
        """The values of each parameter."""
        return {
            name: value if isinstance(value, list) else [value]
            for name, value in self.parameters.items()
        }


def expanded(environments: list[str | EnvironmentRequest]) -> list[str]:
    """Return each environment with its values written after its name: `Pendulum(gravity=8)`.

    Raises ValueError for grids of too many points.
    """
    points = sum(
        1 if isinstance(each, str) else math.prod(map(len, each.axes.values()))
        for each in environments
    )
    if points > MAX_LISTED:
        raise ValueError(f"with their grids they are {points}; there may be {MAX_LISTED}")
    return [text for each in environments for text in _texts(each)]


def _texts(environment: str | EnvironmentRequest) -> list[str]:
    if isinstance(environment, str):
        return [relabelled(environment)]
    names, values = list(environment.axes), environment.axes.values()
    return [
        label(environment.name, dict(zip(names, point, strict=True))) for point in product(*values)
    ]


def _name_or_grid(value: object) -> str:
    return "<grid>" if isinstance(value, dict | EnvironmentRequest) else "<name>"


if TYPE_CHECKING:
    Environments = list[str]
else:
    Environments = Annotated[
        list[
            Annotated[
                Annotated[Name, Tag("<name>")] | Annotated[EnvironmentRequest, Tag("<grid>")],
                Discriminator(_name_or_grid),
            ]
        ],
        Field(min_length=1, max_length=MAX_LISTED),
        AfterValidator(expanded),
    ]


class AlgorithmRequest(Request):
    """An algorithm of the sweep, with one or several pairs of weights, and settings of its own."""

    name: Name
    weights: (
        Annotated[
            Annotated[Weights, Tag("<one>")]
            | Annotated[list[Weights], Field(min_length=1, max_length=MAX_LISTED), Tag("<list>")],
            Discriminator(_one_or_list),
        ]
        | None
    ) = Field(default=None, description="One pair, or a list of pairs; left out: the preset's.")
    config: dict[Name, ConfigValue] = Field(
        default_factory=dict,
        max_length=MAX_LISTED,
        description="Settings that differ from the preset; `GET /catalogue` has their schema.",
    )
    environments: Environments | None = Field(
        default=None,
        description="Those of the sweep's environments that it runs in; left out: all of them.",
    )

    def runs_in(self, environment: str) -> bool:
        """Whether it runs in that one of the sweep's environments."""
        return self.environments is None or environment in self.environments


class SweepRequest(Request):
    """A sweep: every algorithm (and pair of weights) in every environment with every seed."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "weights on Pendulum",
                    "algorithms": [
                        {"name": "ddpg"},
                        {
                            "name": "hybrid-ddpg",
                            "weights": [{"w1": 0.1, "w2": 0.1}, {"w1": 0.01, "w2": 0}],
                        },
                    ],
                    "environments": ["Pendulum"],
                    "seeds": 16,
                    "timesteps": 20_000,
                }
            ]
        }
    )

    name: Name = Field(default="sweep", description="Any text; shown and stored exactly as it is.")
    algorithms: list[AlgorithmRequest] = Field(min_length=1, max_length=MAX_LISTED)
    environments: Environments = Field(
        description="Names, or names with values of physical parameters, of which lists are a grid."
    )
    seeds: Annotated[
        Annotated[Seed, Field(ge=1), Tag("<one>")]
        | Annotated[list[Seed], Field(min_length=1, max_length=MAX_RUNS), Tag("<list>")],
        Discriminator(_one_or_list),
    ] = Field(description="n for the seeds 0 to n - 1, or a list of distinct ones.")
    timesteps: int | None = Field(
        default=None,
        ge=1,
        le=MAX_TIMESTEPS,
        description="Environment steps of each run; else the preset's.",
    )
    scale: float = Field(
        default=1.0,
        gt=0,
        le=1,
        description="Share of those timesteps to run, for a quick look; at least one measurement.",
    )
    priority: int = Field(default=0, ge=-1000, le=1000, description="Higher goes first.")
