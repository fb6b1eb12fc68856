"""The name of a run: its sweep, and its place among the sweep's runs (`3f9a0c51b7de-17`)."""

from typing import NamedTuple, Self

SEPARATOR = "-"
NO_PLACE = -1
LARGEST_PLACE = 2**31 - 1


class RunName(NamedTuple):
    """A run's name in its two parts: `str` writes it, `parse` reads it."""

    sweep_id: str
    ordinal: int

    def __str__(self) -> str:
        """Write the name."""
        return f"{self.sweep_id}{SEPARATOR}{self.ordinal}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read a name. A malformed one has `NO_PLACE`, which no run has."""
        sweep_id, _, digits = text.partition(SEPARATOR)
        is_canonical = digits.isascii() and digits.isdigit() and digits == str(int(digits[:10]))
        is_place = is_canonical and int(digits) <= LARGEST_PLACE
        return cls(sweep_id, int(digits) if is_place else NO_PLACE)


def is_run(identifier: str) -> bool:
    """Whether an identifier is a run's and not a sweep's."""
    return SEPARATOR in identifier
