"""The settings of DDPG and its hybrids, with their ranges."""

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass


@dataclass(frozen=True, config=ConfigDict(extra="forbid", strict=True, allow_inf_nan=False))
class DDPGConfig:
    """Defaults are those of OpenAI Baselines; a value outside its range is refused by name."""

    hidden_units: int = Field(64, ge=4, le=512, description="units of each of two hidden layers")
    batch_size: int = Field(64, ge=1, le=1024, description="transitions an update")
    actor_rate: float = Field(1e-4, gt=0, le=1, description="Adam's step size for the actor")
    critic_rate: float = Field(1e-3, gt=0, le=1, description="Adam's step size for the critic")
    critic_decay: float = Field(1e-2, ge=0, le=1, description="weight decay of the critic")
    tau: float = Field(0.01, gt=0, le=1, description="share that targets follow an update")
    gamma: float = Field(0.99, ge=0, le=1, description="discount a step")
    rollout_steps: int = Field(100, ge=1, le=800, description="environment steps a cycle")
    cycle_updates: int = Field(50, ge=1, le=800, description="updates a cycle")
    replay_size: int = Field(10**6, ge=100, le=10**7, description="transitions remembered")
    noise: float = Field(0.2, ge=0, le=1, description="action distance that parameter noise seeks")
    time_limit_is_terminal: bool = Field(
        False, description="whether running out of time stops the bootstrap, as in Baselines"
    )
