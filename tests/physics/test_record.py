"""Records: layouts become structured types."""

from typing import Annotated, Protocol

import numpy as np

from physics.record import Floats, Integers, dtype


class Inner(Protocol):
    count: int
    pairs: Annotated[Floats, "2 * k", "n"]


class Outer(Protocol):
    weight: float
    order: Annotated[Integers, "n"]
    inner: Inner


def test_a_layout_becomes_a_type_with_its_sizes() -> None:
    record = np.zeros(1, dtype(Outer, n=3, k=4))[0]
    assert record.weight.dtype == np.float64
    assert record.order.dtype == np.int64
    assert record.order.shape == (3,)
    assert record.inner.pairs.shape == (8, 3)
    record.inner.count = 5
    record.inner.pairs[7, 2] = 1.5
    assert record.inner.count == 5
    assert record.inner.pairs.sum() == 1.5


def test_fields_are_aligned_for_the_compiler() -> None:
    assert dtype(Outer, n=3, k=4).isalignedstruct
