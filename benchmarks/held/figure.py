"""A figure to hold: which command prints it, where in what it prints, and its limit."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

NUMBER = r"(-?[\d,.]+(?:e[+-]?\d+)?)"


@dataclass(frozen=True)
class Figure:
    """What one line of the table says.

    name     what must hold, as docs/figures-to-hold.md says it
    command  words after `python -m`, which measures it
    place    regular expression of what it prints, with `#` where the number stands
    limit    in the unit of what is printed; None: the command fails where it does not hold
    unit     of the number
    is_least whether it is the least, not the most
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
        """Return the worst of the numbers in what was printed; None where there is none."""
        found = re.findall(self.place.replace("#", NUMBER), printed)
        numbers = [float(number.replace(",", "")) for number in found]
        return (min if self.is_least else max)(numbers, default=None)

    def holds(self, number: float) -> bool:
        """Whether a number is within the limit."""
        assert self.limit is not None
        return number >= self.limit if self.is_least else number <= self.limit


@dataclass(frozen=True)
class Measured:
    """A figure and what came of measuring it."""

    figure: Figure
    measured: str
    held: str

    @classmethod
    def of(cls, figure: Figure, printed: str, code: int) -> "Measured":
        """Read a figure off what its command printed before it ended with that code."""
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
