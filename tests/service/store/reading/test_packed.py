"""Floats of measurements as bytes: whatever they are, and wherever they stand."""

import math
import struct
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.store.reading.packed import OWN, Layout, own, pack, unpack
from tests.service.store.conftest import measured

SETS = {1: ["a", "b"], 2: [], 3: ["b"]}


@given(st.lists(st.floats(), min_size=len(OWN), max_size=8))
def test_every_float_is_read_as_it_was_written(values: list[float]) -> None:
    names = [f"diagnostic {k}" for k in range(len(values) - len(OWN))]
    diagnostics = dict(zip(names, values[len(OWN) :], strict=True))
    floats: dict[str, Any] = dict(zip(OWN, values, strict=False))
    measurement = replace(measured(0, 800), **floats, diagnostics=diagnostics)
    packed = pack(measurement)
    assert packed == struct.pack(f"<{len(values)}d", *values)
    np.testing.assert_array_equal(list(own(packed).values()), values[: len(OWN)])
    found = unpack(names, packed)
    np.testing.assert_array_equal([found[name] for name in OWN], values[: len(OWN)])
    assert list(found["diagnostics"]) == names
    np.testing.assert_array_equal(list(found["diagnostics"].values()), values[len(OWN) :])


def test_other_names_than_were_written_are_refused() -> None:
    packed = pack(replace(measured(0, 800), diagnostics={"a": math.pi}))
    with pytest.raises(ValueError, match="zip"):
        unpack(["a", "b"], packed)


@pytest.mark.parametrize(
    ("name", "rows", "at"),
    [
        ("return_mean", [0, 1, 2, 3], [0, 6, 10, 16]),
        ("seconds", [0, 1, 2, 3], [2, 8, 12, 18]),
        ("a", [0, 2], [4, 14]),
        ("b", [0, 2, 3], [5, 15, 20]),
        ("c", [], []),
    ],
)
def test_names_are_found_in_measurements_of_different_sets(
    name: str, rows: list[int], at: list[int]
) -> None:
    where = Layout(SETS).where(name, "1,2,1,3")
    assert where.rows.tolist() == rows
    assert where.at.tolist() == at
