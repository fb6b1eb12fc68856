"""Finding: one number of a diagnosis, with its meaning."""

from typing import NamedTuple


class Finding(NamedTuple):
    """One number.

    The horizon or the noise is None where it does not apply.
    """

    diagnostic: str
    """"smoothing", "growth", "kinks", "critic", "target" or "loss"."""
    quantity: str
    horizon: int | None
    """Steps."""
    noise: float | None
    """Standard deviation of the noise of each action."""
    value: float
