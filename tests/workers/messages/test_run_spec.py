"""Run specs: values that survive a trip, and what makes a cohort."""

import json
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workers.messages.run_spec import COHORT_LIMIT, RunSpec, Weights, shared_cell

SPEC = RunSpec("hybrid-ddpg", "Pendulum", 3, Weights(0.1, 0.01), 4000, {"batch": 64, "gamma": 0.99})
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(
    seed=st.integers(0, 2**53),
    weights=st.builds(Weights, FINITE, FINITE),
    config=st.dictionaries(st.text(), st.one_of(FINITE, st.booleans(), st.integers(), st.text())),
)
def test_survives_json(seed: int, weights: Weights, config: dict[str, Any]) -> None:
    spec = RunSpec("ddpg", "MassPoint", seed, weights, 800, config)
    again = RunSpec.from_json(json.loads(json.dumps(spec.to_json())))
    assert again == spec
    assert again.cell == spec.cell


def test_the_cell_is_all_but_the_seed() -> None:
    assert replace(SPEC, seed=4).cell == SPEC.cell
    assert replace(SPEC, config={"gamma": 0.99, "batch": 64}).cell == SPEC.cell
    for other in (
        replace(SPEC, algorithm="ddpg"),
        replace(SPEC, environment="MassPoint"),
        replace(SPEC, weights=Weights(0.01, 0.1)),
        replace(SPEC, timesteps=8000),
        replace(SPEC, config={"batch": 32, "gamma": 0.99}),
    ):
        assert other.cell != SPEC.cell


def test_a_cohort_shares_its_cell() -> None:
    assert shared_cell([replace(SPEC, seed=seed) for seed in range(COHORT_LIMIT)]) == SPEC.cell


@pytest.mark.parametrize(
    ("specs", "what"),
    [
        ([], "1 to 16 runs, got 0"),
        ([replace(SPEC, seed=seed) for seed in range(17)], "1 to 16 runs, got 17"),
        ([SPEC, replace(SPEC, seed=4, timesteps=8000)], "differ only in their seed"),
        ([SPEC, SPEC], r"distinct, got \[3, 3\]"),
    ],
)
def test_refuses_what_is_no_cohort(specs: list[RunSpec], what: str) -> None:
    with pytest.raises(ValueError, match=what):
        shared_cell(specs)
