"""The settings of gradient descent through the simulator, with their ranges."""

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass


@dataclass(frozen=True, config=ConfigDict(extra="forbid", strict=True, allow_inf_nan=False))
class GDConfig:
    """A value outside its range is refused by name."""

    hidden_units: int = Field(
        default=64, ge=4, le=512, description="units of each of two hidden layers"
    )
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
