"""How patiently runs that lost their worker are tried again."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RetryPolicy:
    """How often a run may lose its worker in a row, and how long it waits after each loss.

    "In a row" ends when a measurement is recorded that no earlier attempt had reached.
    """

    losses: int = 5
    first_wait_seconds: float = 1.0
    longest_wait_seconds: float = 60.0

    def wait_seconds(self, losses: int) -> float:
        """Return the wait after that many losses: doubled each time."""
        return min(self.first_wait_seconds * 2.0 ** (losses - 1), self.longest_wait_seconds)
