"""Tables in Markdown, line by line."""

from collections.abc import Iterable, Iterator


def head(*names: str) -> Iterator[str]:
    """Yield the two lines that a table of these columns begins with."""
    yield line(names)
    yield "|---" * len(names) + "|"


def line(cells: Iterable[str]) -> str:
    """Return a row of a table."""
    return f"| {' | '.join(cells)} |"
