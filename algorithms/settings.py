"""The settings of every learner: their defaults and their allowed ranges."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class SettingsError(ValueError):
    """Settings that an algorithm does not take; the message names each of them."""


HiddenUnits = Annotated[int, Field(ge=4, le=512, description="units of each hidden layer")]
HiddenLayers = Annotated[int, Field(ge=1, le=4, description="hidden layers of each network")]
ActivationName = Annotated[
    Literal["tanh", "elu", "silu", "relu"],
    Field(description="activation of hidden units; a hybrid needs a smooth one"),
]
Placebo = Annotated[
    Literal["none", "shuffled", "untargeted"],
    Field(description="of a hybrid: use the derivatives of other transitions, or 0 as the target"),
]
MatchEvery = Annotated[
    int, Field(ge=1, le=1000, description="of a hybrid: one of this many updates matches gradients")
]
BatchSize = Annotated[int, Field(ge=1, le=1024, description="transitions per update")]
Gamma = Annotated[float, Field(ge=0, le=1, description="discount per step")]
RolloutSteps = Annotated[int, Field(ge=1, le=800, description="environment steps per cycle")]
CycleUpdates = Annotated[int, Field(ge=1, le=800, description="updates per cycle")]
UniformSteps = Annotated[
    int, Field(ge=0, le=10**7, description="first environment steps, whose actions are uniform")
]
ReplaySize = Annotated[int, Field(ge=100, le=10**7, description="transitions remembered")]
Environments = Annotated[
    int, Field(ge=1, le=256, description="environments that a run steps at once")
]
Window = Annotated[
    int, Field(ge=1, le=2048, description="steps of each environment between two updates")
]
Trace = Annotated[
    float, Field(ge=0, le=1, description="lambda of the returns that values are fitted to")
]
Noise = Annotated[
    float, Field(gt=0, le=7, description="standard deviation of exploration at first, before tanh")
]


@dataclass(frozen=True, config=STRICT)
class DDPGConfig:
    """Settings of DDPG and its hybrids. Defaults are those of OpenAI Baselines."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    placebo: Placebo = "none"
    match_every: MatchEvery = 1
    batch_size: BatchSize = 64
    actor_rate: float = Field(
        default=1e-4, gt=0, le=1, description="Adam's step size for the actor"
    )
    critic_rate: float = Field(
        default=1e-3, gt=0, le=1, description="Adam's step size for the critic"
    )
    critic_decay: float = Field(default=1e-2, ge=0, le=1, description="weight decay of the critic")
    tau: float = Field(default=0.01, gt=0, le=1, description="share that targets move per update")
    gamma: Gamma = 0.99
    rollout_steps: RolloutSteps = 100
    cycle_updates: CycleUpdates = 50
    replay_size: ReplaySize = 10**6
    noise: float = Field(
        default=0.2, ge=0, le=1, description="action distance that parameter noise aims at"
    )
    time_limit_is_terminal: bool = Field(
        default=False,
        description="whether a time limit stops the bootstrap, as in Baselines",
    )


@dataclass(frozen=True, config=STRICT)
class TD3Config:
    """Settings of TD3 and its hybrid: the authors' defaults, or DDPG's for network and batch."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    placebo: Placebo = "none"
    match_every: MatchEvery = 1
    batch_size: BatchSize = 64
    actor_rate: float = Field(
        default=1e-3, gt=0, le=1, description="Adam's step size for the actor"
    )
    critic_rate: float = Field(
        default=1e-3, gt=0, le=1, description="Adam's step size for the critics"
    )
    tau: float = Field(
        default=0.005, gt=0, le=1, description="share that targets move when the actor steps"
    )
    gamma: Gamma = 0.99
    uniform_steps: UniformSteps = 1_000
    noise: float = Field(
        default=0.1, ge=0, le=1, description="standard deviation of exploration, of each action"
    )
    target_noise: float = Field(
        default=0.2, ge=0, le=1, description="standard deviation of noise on the target's actions"
    )
    noise_bound: float = Field(
        default=0.5, ge=0, le=2, description="largest noise on the target's actions"
    )
    delay: int = Field(
        default=2, ge=1, le=100, description="updates of the critics per update of the actor"
    )
    rollout_steps: RolloutSteps = 100
    cycle_updates: CycleUpdates = 100
    replay_size: ReplaySize = 10**6


@dataclass(frozen=True, config=STRICT)
class SACConfig:
    """Settings of SAC and its hybrid: the authors' defaults, or DDPG's for network and batch."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    placebo: Placebo = "none"
    match_every: MatchEvery = 1
    batch_size: BatchSize = 64
    rate: float = Field(default=3e-4, gt=0, le=1, description="Adam's step size, of every network")
    tau: float = Field(
        default=0.005, gt=0, le=1, description="share that V's target moves per update"
    )
    gamma: Gamma = 0.99
    reward_scale: float = Field(
        default=5.0,
        gt=0,
        le=10**6,
        description="factor of rewards, the inverse of a fixed temperature",
    )
    uniform_steps: UniformSteps = 1_000
    temperature: Literal["fixed", "learned"] = Field(
        default="fixed", description="fixed as in 2018, or learned for an entropy of -m as in 2019"
    )
    rollout_steps: RolloutSteps = 100
    cycle_updates: CycleUpdates = 100
    replay_size: ReplaySize = 10**6


@dataclass(frozen=True, config=STRICT)
class GDConfig:
    """Settings of gradient ascent through the simulator."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    rate: float = Field(default=1e-3, gt=0, le=1, description="Adam's step size")
    episodes: int = Field(
        default=1, ge=1, le=16, description="episodes per update, all from new starts"
    )
    clip: float = Field(default=1.0, gt=0, le=1e9, description="largest norm of a gradient")
    patience: int = Field(
        default=25,
        ge=1,
        le=10_000,
        description="measurements without a new best mean of ten before a run ends",
    )


@dataclass(frozen=True, config=STRICT)
class SHACConfig:
    """Settings of short-horizon actor-critic: the authors' defaults except for hidden units."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "elu"
    environments: Environments = 64
    window: Window = 32
    actor_rate: float = Field(
        default=2e-3, gt=0, le=1, description="Adam's step size for the actor, at first"
    )
    critic_rate: float = Field(
        default=2e-3, gt=0, le=1, description="Adam's step size for the critic, at first"
    )
    gamma: Gamma = 0.99
    trace: Trace = 0.95
    target_share: float = Field(
        default=0.2, ge=0, le=1, description="share of itself that the critic's target keeps"
    )
    critic_epochs: int = Field(
        default=16, ge=1, le=100, description="passes of the critic through a window"
    )
    critic_batches: int = Field(default=4, ge=1, le=64, description="critic's batches per window")
    noise: Noise = 0.37
    clip: float = Field(default=1.0, gt=0, le=1e9, description="largest norm of a gradient")


@dataclass(frozen=True, config=STRICT)
class PPOConfig:
    """Settings of proximal policy optimisation. Defaults are those for continuous control."""

    hidden_units: HiddenUnits = 64
    hidden_layers: HiddenLayers = 2
    activation: ActivationName = "tanh"
    environments: Environments = 8
    window: Window = 256
    rate: float = Field(
        default=3e-4, gt=0, le=1, description="Adam's step size, at first, of both networks"
    )
    gamma: Gamma = 0.99
    trace: Trace = 0.95
    ratio_bound: float = Field(
        default=0.2, gt=0, le=10, description="largest rewarded change of an action's probability"
    )
    epochs: int = Field(default=10, ge=1, le=100, description="passes through a window")
    batches: int = Field(default=32, ge=1, le=256, description="batches per window")
    noise: Noise = 1.0
    clip: float = Field(default=0.5, gt=0, le=1e9, description="largest norm of a gradient")


@dataclass(frozen=True, config=STRICT)
class MPCConfig:
    """Of planning."""

    horizon: int = Field(default=50, ge=1, le=1000, description="steps that a plan looks ahead")
    iterations: int = Field(
        default=5, ge=1, le=500, description="largest number of iLQR iterations per action"
    )
    hidden_units: int = Field(
        default=64,
        ge=4,
        le=512,
        description="units of the actor that makes the first plan, as in DDPG",
    )
