"""Searches: rungs and what they cost."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.model.inquiry.search import (
    Rung,
    Search,
    cost_of_a_seed,
    rungs_of,
    search_seeds,
)
from service.model.inquiry.tuning_seeds import chooses


@pytest.mark.parametrize(
    ("entries", "timesteps", "reduction", "rungs"),
    [
        (2, 20_000, 3, [(2, 20_000)]),
        (3, 20_001, 3, [(3, 20_001)]),
        (6, 20_000, 3, [(6, 6400), (2, 20_000)]),
        (10, 20_000, 3, [(10, 2400), (4, 6400), (2, 20_000)]),
        (8, 20_000, 2, [(8, 4800), (4, 9600), (2, 20_000)]),
        (9, 900, 2, [(9, 800), (5, 800), (3, 800), (2, 900)]),
        (4, 500, 3, [(4, 500), (2, 500)]),
    ],
)
def test_rungs(entries: int, timesteps: int, reduction: int, rungs: list[tuple[int, int]]) -> None:
    assert [(r.entries, r.timesteps) for r in rungs_of(entries, timesteps, reduction)] == rungs


@given(st.integers(2, 300), st.integers(1, 10**6), st.integers(2, 10))
def test_rungs_lead_to_the_whole_run_and_one_entry(
    entries: int, timesteps: int, reduction: int
) -> None:
    rungs = rungs_of(entries, timesteps, reduction)
    assert (rungs[0].entries, rungs[-1].timesteps) == (entries, timesteps)
    assert 2 <= rungs[-1].entries <= reduction
    counts, lengths = ([getattr(r, name) for r in rungs] for name in ("entries", "timesteps"))
    assert counts == sorted(set(counts), reverse=True)
    assert lengths == sorted(lengths)
    assert all(length % 800 == 0 or length == timesteps for length in lengths)
    assert cost_of_a_seed({"Pendulum": rungs}) <= entries * timesteps


def test_the_cost_is_what_is_trained_anew() -> None:
    rungs = {"Pendulum": rungs_of(6, 20_000, 3), "MassPoint": rungs_of(2, 8000, 3)}
    assert cost_of_a_seed(rungs) == 6 * 6400 + 2 * (20_000 - 6400) + 2 * 8000


def test_what_was_planned_is_read_back() -> None:
    search = Search(10**6, 3, "area", search_seeds(3), {"Pendulum": (Rung(6, 6400), Rung(2, 800))})
    assert Search.of(json.loads(json.dumps(search.document))) == search
    assert Search.of(None) is None
    assert all(map(chooses, search.seeds))
