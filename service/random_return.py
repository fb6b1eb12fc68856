"""The zero of the normalised scale: what uniform random actions earn."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RandomReturn:
    """Mean undiscounted return of uniform random actions, with its 95 % interval."""

    environment: str
    version: int
    mean: float
    low: float
    high: float
    episodes: int
