"""Finding: one number of a diagnosis, and what it is the number of."""

from typing import NamedTuple


class Finding(NamedTuple):
    """One number.

    A horizon or a noise that does not apply is None.
    """

    diagnostic: str
    """"smoothing", "growth", "kinks", "critic", "target" or "loss"."""
    quantity: str
    horizon: int | None
    """Steps."""
    noise: float | None
    """Standard deviation of each action's."""
    value: float
