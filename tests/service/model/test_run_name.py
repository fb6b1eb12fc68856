"""Names of runs: written and read, and what is none is nobody's."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.model.run_name import LARGEST_PLACE, NO_PLACE, RunName, is_run


@given(st.text("0123456789abcdef", min_size=1), st.integers(0, LARGEST_PLACE))
def test_a_name_is_read_as_it_was_written(sweep_id: str, ordinal: int) -> None:
    name = RunName(sweep_id, ordinal)
    assert RunName.parse(str(name)) == name
    assert is_run(str(name))
    assert not is_run(sweep_id)


@pytest.mark.parametrize(
    "text", ["3f9a", "3f9a-", "3f9a-01", "3f9a--1", "3f9a-x", "3f9a-²", "3f9a-0-0", f"3f9a-{2**31}"]
)
def test_a_malformed_name_has_a_place_that_no_run_has(text: str) -> None:
    assert RunName.parse(text) == ("3f9a", NO_PLACE)
