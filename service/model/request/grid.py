"""Grids: every combination of lists of values, of which some may advance together."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import chain, product
from typing import TypeVar

Value = TypeVar("Value")
Axes = Mapping[str, Sequence[Value]]


def expand(axes: Axes[Value], together: Collection[str] = ()) -> Iterator[dict[str, Value]]:
    """Yield each point of a grid, the last axis fastest; names stay in the order of the axes.

    The axes named in `together` advance as one. Raises ValueError where those differ in length.
    """
    for point in product(*(_steps(axes, group) for group in _groups(axes, together))):
        values = dict(chain.from_iterable(each.items() for each in point))
        yield {name: values[name] for name in axes}


def size(axes: Axes[Value], together: Collection[str] = ()) -> int:
    """Return how many points `expand` yields, without expanding anything."""
    return math.prod(len(axes[group[0]]) for group in _groups(axes, together))


def _groups(axes: Axes[Value], together: Collection[str]) -> list[list[str]]:
    """The names of the axes, those that advance as one in a group at the place of their first."""
    joined = [name for name in axes if name in together]
    others = [[name] for name in axes if name not in joined[1:]]
    return [joined if group == joined[:1] else group for group in others]


def _steps(axes: Axes[Value], group: Sequence[str]) -> list[dict[str, Value]]:
    columns = [axes[name] for name in group]
    return [dict(zip(group, row, strict=True)) for row in zip(*columns, strict=True)]
