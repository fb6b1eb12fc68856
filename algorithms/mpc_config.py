"""The settings of MPC, with their ranges."""

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass


@dataclass(frozen=True, config=ConfigDict(extra="forbid", strict=True, allow_inf_nan=False))
class MPCConfig:
    """A value outside its range is refused by name."""

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
