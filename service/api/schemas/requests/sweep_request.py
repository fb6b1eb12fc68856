"""What `POST /sweeps` takes: a product of algorithms, weights, environments and seeds."""

import math
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    AfterValidator,
    ConfigDict,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    WithJsonSchema,
)

from algorithms.presets import SMALLEST_WEIGHT
from physics.parameter import label, relabelled
from service.api.schemas.question.question_request import QuestionRequest
from service.api.schemas.requests.sweep_edit import (
    MAX_WORKERS_TEXT,
    NAME_TEXT,
    NOTES_TEXT,
    PRIORITY_TEXT,
    TAGS_TEXT,
    WEBHOOK_TEXT,
    MaxWorkers,
    Notes,
    Priority,
    Tags,
    WebhookURL,
)
from service.api.schemas.requests.texts import Name, Request, label_text, storable
from service.api.schemas.search.search_request import SearchRequest

MAX_RUNS = 20_000
MAX_LISTED = 100
MAX_TIMESTEPS = 100_000_000
MAX_SEED = 2**53 - 1  # the largest whole number that every JSON reader keeps
MAX_WEIGHT = 1e6
MAX_CONFIG_TEXT = 1_000


def weight(value: float) -> float:
    """Return the number, -0.0 as 0.0: they are equal, but print differently.

    Raises ValueError for a positive number that learners round to 0.
    """
    if 0 < value < SMALLEST_WEIGHT:
        raise ValueError(f"is 0 in float32: give 0, or at least {SMALLEST_WEIGHT}")
    return value + 0.0


def config_value(value: object) -> object:
    """Return a setting of a learner, or a list of them: a grid."""
    if isinstance(value, list):
        return [_setting(each) for each in _counted(value)]
    return _scalar(value)


def _setting(value: object) -> object:
    """Return a value of a setting: a scalar, or a list of scalars where its config takes one."""
    return (
        [_scalar(each) for each in _counted(value)] if isinstance(value, list) else _scalar(value)
    )


def _counted(values: list[object]) -> list[object]:
    if not 1 <= len(values) <= MAX_LISTED:
        raise ValueError(f"a list has 1 to {MAX_LISTED} values, this one has {len(values)}")
    return values


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
        "a setting is null, true, false, a finite number or a short text; a list of them is a grid"
    )


def _one_or_list(value: object) -> str:
    return "<list>" if isinstance(value, list) else "<one>"


Label = Annotated[Name, AfterValidator(label_text)]
Listed = Field(min_length=1, max_length=MAX_LISTED)
Weight = Annotated[float, Field(ge=0, le=MAX_WEIGHT), AfterValidator(weight)]
Weighed = Annotated[
    Annotated[Weight, Tag("<one>")] | Annotated[list[Weight], Listed, Tag("<list>")],
    Discriminator(_one_or_list),
]
Share = Annotated[float, Field(gt=0, le=1)]
Seed = Annotated[int, Field(ge=0, le=MAX_SEED)]
ConfigValue = Annotated[
    Any,
    PlainValidator(config_value),
    WithJsonSchema({"description": "null, boolean, number, text; a list of them is a grid"}),
]


class Weights(Request):
    """Weights of the critic's gradient terms: w1 for dQ/da, w2 for dQ/ds; lists are a grid."""

    w1: Weighed = 0.0
    w2: Weighed = 0.0


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
        description="Values by name; `GET /catalogue` has the unit, default and range of each.",
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
        raise ValueError(f"are {points} with their grids; at most {MAX_LISTED} are allowed")
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
    """An algorithm of the sweep, with weights and settings of its own.

    A list in the place of a weight or a setting is a grid: every combination is an entry.
    """

    name: Name
    label: Label | None = Field(
        default=None,
        description="Name of its entries instead of its own; what tells them apart follows.",
    )
    weights: (
        Annotated[
            Annotated[Weights, Tag("<one>")] | Annotated[list[Weights], Listed, Tag("<list>")],
            Discriminator(_one_or_list),
        ]
        | None
    ) = Field(default=None, description="One pair, or a list of pairs; by default the preset's.")
    config: dict[Name, ConfigValue] = Field(
        default_factory=dict,
        max_length=MAX_LISTED,
        description="Settings that differ from the preset; `GET /catalogue` has their schema.",
    )
    zip: list[Name] | None = Field(
        default=None,
        min_length=2,
        max_length=MAX_LISTED,
        description="Weights and settings whose lists, equally long, advance together; the others "
        "are multiplied.",
    )
    environments: Environments | None = Field(
        default=None,
        description="Environments of the sweep that it runs in; by default all of them.",
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
                            "label": "matched",
                            "weights": {"w1": [0.1, 0.01], "w2": 0.1},
                        },
                    ],
                    "environments": ["Pendulum"],
                    "seeds": 16,
                    "timesteps": 20_000,
                },
                {
                    "name": "does it help?",
                    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}],
                    "environments": ["Pendulum", "CartPole"],
                    "seeds": 8,
                    "question": {
                        "compare": ["hybrid-ddpg"],
                        "with": "ddpg",
                        "score": "area",
                        "until": "decided",
                        "margin": 0.02,
                        "confidence": 0.95,
                        "max_seeds": 128,
                        "batch": 8,
                    },
                },
                {
                    "name": "how much noise?",
                    "algorithms": [{"name": "ddpg", "config": {"noise": [0.1, 0.2, 0.4, 0.8]}}],
                    "environments": ["Pendulum"],
                    "seeds": 2,
                    "timesteps": 20_000,
                    "search": {"budget": 300_000, "reduction": 3, "score": "area"},
                },
            ]
        }
    )

    name: Name = Field(default="sweep", description=NAME_TEXT)
    notes: Notes = Field(default="", description=NOTES_TEXT)
    tags: Tags = Field(default=[], description=TAGS_TEXT)
    algorithms: list[AlgorithmRequest] = Field(min_length=1, max_length=MAX_LISTED)
    environments: Environments = Field(
        description="Names, or names with values of physical parameters, of which lists are a grid."
    )
    seeds: Annotated[
        Annotated[Seed, Field(ge=1), Tag("<one>")]
        | Annotated[list[Seed], Field(min_length=1, max_length=MAX_RUNS), Tag("<list>")],
        Discriminator(_one_or_list),
    ] = Field(
        description="n for the seeds 0 to n - 1, or a list of distinct ones. For a search, the "
        "least number of seeds of each entry, or a list of those reserved for choosing settings."
    )
    timesteps: int | None = Field(
        default=None,
        ge=1,
        le=MAX_TIMESTEPS,
        description="Environment steps of each run; by default the preset's.",
    )
    scale: Annotated[
        Annotated[Share, Tag("<one>")] | Annotated[list[Share], Listed, Tag("<list>")],
        Discriminator(_one_or_list),
    ] = Field(
        default=1.0,
        description="Share of those timesteps to run, for a quick look; at least one measurement. "
        "A list is a grid.",
    )
    priority: Priority = Field(default=0, description=PRIORITY_TEXT)
    max_workers: MaxWorkers | None = Field(default=None, description=MAX_WORKERS_TEXT)
    question: QuestionRequest | None = Field(
        default=None,
        description="A question of the sweep: the service adds seeds until it is decided.",
    )
    search: SearchRequest | None = Field(
        default=None,
        description="A search for the best entry in each task, by successive halving, on `seeds` "
        "or more seeds of its own.",
    )
    webhook: WebhookURL | None = Field(default=None, description=WEBHOOK_TEXT)
