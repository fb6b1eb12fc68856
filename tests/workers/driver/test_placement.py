"""Placement: each worker on a core, no more than are wanted, and few nodes for few workers."""

import pytest

from workers.driver.placement import Bounds, Node, room, vacancies

ONE, TWO, SIX = Node("one", 1), Node("two", 2), Node("six", 6)


@pytest.mark.parametrize(
    ("nodes", "slots", "wanted", "made"),
    [
        ([], {}, 9, []),
        ([ONE, TWO], {}, 9, ["one", "two", "two"]),
        ([ONE, TWO], {}, 2, ["one", "two"]),
        ([ONE, TWO], {}, 0, []),
        ([ONE, TWO], {"two": 1}, 9, ["two", "one"]),
        ([ONE, TWO, SIX], {"six": 3, "two": 1}, 8, ["six", "six", "six", "two"]),
        ([ONE, TWO], {"one": 1, "two": 2}, 9, []),
        ([TWO], {"two": 3}, 9, []),
    ],
)
def test_each_slot_has_a_core_on_the_fullest_node(
    nodes: list[Node], slots: dict[str, int], wanted: int, made: list[str]
) -> None:
    assert [node.name for node in vacancies(nodes, slots, wanted)] == made


@pytest.mark.parametrize(
    ("resources", "worker_bytes", "workers"),
    [
        ({"CPU": 4.0, "memory": 10e9}, 0, 4),
        ({"CPU": 4.0, "memory": 10e9}, 2 * 10**9, 4),
        ({"CPU": 4.0, "memory": 10e9}, 3 * 10**9, 3),
        ({"CPU": 4.0, "memory": 10e9}, 11 * 10**9, 0),
        ({"CPU": 4.0}, 1, 0),
        ({"memory": 10e9}, 1, 0),
        ({}, 0, 0),
    ],
)
def test_a_node_has_room_for_as_many_as_its_cores_and_its_memory_hold(
    resources: dict[str, float], worker_bytes: int, workers: int
) -> None:
    assert room(resources, worker_bytes) == workers


def test_as_many_are_wanted_as_there_is_work_for_within_bounds() -> None:
    assert [Bounds(2, 5).wanted(demand) for demand in (0, 2, 4, 5, 1000)] == [2, 2, 4, 5, 5]
