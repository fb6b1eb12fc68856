"""A figure to hold: the command that prints it, its place in the output, and its limit."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

NUMBER = r"(-?[\d,.]+(?:e[+-]?\d+)?)"


@dataclass(frozen=True)
class Figure:
    """One line of the table.

    name     what must hold, in the words of docs/figures-to-hold.md
    command  the words after `python -m` that measure it
    place    regular expression for the output, with `#` in place of the number
    limit    in the unit of the output; None if the command itself fails when it does not hold
    unit     unit of the number
    is_least whether the limit is a minimum, not a maximum
    """

    name: str
    command: tuple[str, ...]
    place: str = ""
    limit: float | None = None
    unit: str = ""
    is_least: bool = False

    @property
    def goal(self) -> str:
        """The limit in words."""
        if self.limit is None:
            return "passes"
        return f"{'>=' if self.is_least else '<='} {self.limit:,g} {self.unit}".rstrip()

    def worst(self, printed: str) -> float | None:
        """Return the worst of the numbers in the output; None if there are none."""
        found = re.findall(self.place.replace("#", NUMBER), printed)
        numbers = [float(number.replace(",", "")) for number in found]
        return (min if self.is_least else max)(numbers, default=None)

    def holds(self, number: float) -> bool:
        """Whether a number is within the limit."""
        assert self.limit is not None
        return number >= self.limit if self.is_least else number <= self.limit


@dataclass(frozen=True)
class Measured:
    """A figure and its measured result."""

    figure: Figure
    measured: str
    held: str

    @classmethod
    def of(cls, figure: Figure, printed: str, code: int) -> "Measured":
        """Read a figure from the output and the exit code of its command."""
        if figure.limit is None:
            return cls(figure, *(("passed", "yes") if code == 0 else ("failed", "no")))
        number = figure.worst(printed)
        if number is None:
            return cls(figure, f"nothing (exit code {code})", "not measured")
        held = "yes" if figure.holds(number) else "no"
        return cls(figure, f"{number:,g} {figure.unit}".rstrip(), held)


def table(rows: Sequence[Measured]) -> str:
    """Return a Markdown table of all figures."""
    lines = [("figure", "goal", "measured", "held"), ("---",) * 4]
    lines += [(row.figure.name, row.figure.goal, row.measured, row.held) for row in rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
