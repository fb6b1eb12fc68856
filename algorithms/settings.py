"""The settings of every learner: defaults, and ranges outside which a value is refused by name."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

HiddenUnits = Annotated[int, Field(ge=4, le=512, description="units of each hidden layer")]
HiddenLayers = Annotated[int, Field(ge=1, le=4, description="hidden layers of each network")]
ActivationName = Annotated[
    Literal["tanh", "elu", "silu", "relu"],
    Field(description="activation of hidden units; a hybrid wants a smooth one"),
]


@dataclass(frozen=True, config=STRICT)
class DDPGConfig:
    """Of DDPG and its hybrids. Defaults are those of OpenAI Baselines."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    batch_size: int = Field(default=64, ge=1, le=1024, description="transitions an update")
    actor_rate: float = Field(
        default=1e-4, gt=0, le=1, description="Adam's step size for the actor"
    )
    critic_rate: float = Field(
        default=1e-3, gt=0, le=1, description="Adam's step size for the critic"
    )
    critic_decay: float = Field(default=1e-2, ge=0, le=1, description="weight decay of the critic")
    tau: float = Field(default=0.01, gt=0, le=1, description="share that targets follow an update")
    gamma: float = Field(default=0.99, ge=0, le=1, description="discount a step")
    rollout_steps: int = Field(default=100, ge=1, le=800, description="environment steps a cycle")
    cycle_updates: int = Field(default=50, ge=1, le=800, description="updates a cycle")
    replay_size: int = Field(default=10**6, ge=100, le=10**7, description="transitions remembered")
    noise: float = Field(
        default=0.2, ge=0, le=1, description="action distance that parameter noise seeks"
    )
    time_limit_is_terminal: bool = Field(
        default=False,
        description="whether running out of time stops the bootstrap, as in Baselines",
    )


@dataclass(frozen=True, config=STRICT)
class SACConfig:
    """Of SAC and its hybrid. Defaults are the authors', or DDPG's for network and batch."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    batch_size: int = Field(default=64, ge=1, le=1024, description="transitions an update")
    rate: float = Field(default=3e-4, gt=0, le=1, description="Adam's step size, of every network")
    tau: float = Field(
        default=0.005, gt=0, le=1, description="share that V's target follows an update"
    )
    gamma: float = Field(default=0.99, ge=0, le=1, description="discount a step")
    reward_scale: float = Field(
        default=5.0, gt=0, le=10**6, description="factor of rewards, the inverse of the temperature"
    )
    rollout_steps: int = Field(default=100, ge=1, le=800, description="environment steps a cycle")
    cycle_updates: int = Field(default=100, ge=1, le=800, description="updates a cycle")
    replay_size: int = Field(default=10**6, ge=100, le=10**7, description="transitions remembered")


@dataclass(frozen=True, config=STRICT)
class GDConfig:
    """Of gradient ascent through the simulator."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    rate: float = Field(default=1e-3, gt=0, le=1, description="Adam's step size")
    episodes: int = Field(
        default=1, ge=1, le=16, description="episodes an update, all from new starts"
    )
    clip: float = Field(default=1.0, gt=0, le=1e9, description="largest norm of a gradient")
    patience: int = Field(
        default=25,
        ge=1,
        le=10_000,
        description="measurements without a better mean of ten that end a run",
    )


@dataclass(frozen=True, config=STRICT)
class MPCConfig:
    """Of planning."""

    horizon: int = Field(default=50, ge=1, le=1000, description="steps that a plan looks ahead")
    iterations: int = Field(
        default=5, ge=1, le=500, description="iLQR iterations an action, at most"
    )
    hidden_units: int = Field(
        default=64,
        ge=4,
        le=512,
        description="units of the actor that makes the first plan, as in DDPG",
    )
