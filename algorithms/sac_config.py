"""The settings of soft actor-critic and its hybrid, with their ranges."""

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass


@dataclass(frozen=True, config=ConfigDict(extra="forbid", strict=True, allow_inf_nan=False))
class SACConfig:
    """Defaults are the authors' but for the network's and the batch's size, which are DDPG's."""

    hidden_units: int = Field(64, ge=4, le=512, description="units of each of two hidden layers")
    batch_size: int = Field(64, ge=1, le=1024, description="transitions an update")
    rate: float = Field(3e-4, gt=0, le=1, description="Adam's step size, of every network")
    tau: float = Field(0.005, gt=0, le=1, description="share that V's target follows an update")
    gamma: float = Field(0.99, ge=0, le=1, description="discount a step")
    reward_scale: float = Field(
        5.0, gt=0, le=10**6, description="factor of rewards, the inverse of the temperature"
    )
    rollout_steps: int = Field(100, ge=1, le=800, description="environment steps a cycle")
    cycle_updates: int = Field(100, ge=1, le=800, description="updates a cycle")
    replay_size: int = Field(10**6, ge=100, le=10**7, description="transitions remembered")
