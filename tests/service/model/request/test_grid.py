"""Grids: products, and lists that advance together."""

import pytest

from service.model.request.grid import expand, size


def test_every_combination_the_last_axis_fastest() -> None:
    axes = {"a": [1, 2], "b": [3], "c": [4, 5]}
    points = [tuple(point.values()) for point in expand(axes)]
    assert points == [(1, 3, 4), (1, 3, 5), (2, 3, 4), (2, 3, 5)]
    assert size(axes) == 4


def test_axes_that_advance_together_keep_their_places() -> None:
    axes = {"a": [1, 2], "b": [3, 4], "c": [5, 6]}
    points = list(expand(axes, together=("c", "a")))
    assert [list(point) for point in points] == [["a", "b", "c"]] * 4
    assert [tuple(p.values()) for p in points] == [(1, 3, 5), (1, 4, 5), (2, 3, 6), (2, 4, 6)]
    assert size(axes, ("c", "a")) == 4


def test_no_axes_are_one_point() -> None:
    assert list(expand({})) == [{}]
    assert size({}) == 1


def test_axes_of_different_lengths_do_not_advance_together() -> None:
    with pytest.raises(ValueError, match="shorter"):
        list(expand({"a": [1, 2], "b": [3]}, ("a", "b")))


def test_a_size_is_not_counted_by_expanding() -> None:
    assert size({str(i): range(100) for i in range(50)}) == 100**50
