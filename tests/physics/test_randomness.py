"""The generators: named, stable, unrelated."""

import numpy as np
import pytest

from physics.randomness import generator


def test_the_same_name_gives_the_same_numbers() -> None:
    np.testing.assert_array_equal(
        generator(3, "noise", 1).normal(size=100), generator(3, "noise", 1).normal(size=100)
    )


def test_each_part_of_the_name_matters() -> None:
    first = {
        generator(seed, purpose, index).integers(2**62)
        for seed in (0, 1, 11)
        for purpose in ("noise", "noise\x001", "replay")
        for index in (0, 1, 10)
    }
    assert len(first) == 27


def test_the_numbers_never_change() -> None:
    """Stored results rest on these bits."""
    drawn = generator(7, "initial state").integers(2**62, size=2)
    assert drawn.tolist() == [3664936472786523055, 2286492939876342584]


def test_numpy_integers_are_integers() -> None:
    assert generator(np.arange(5)[4], "x").random() == generator(4, "x").random()


@pytest.mark.parametrize(("seed", "index"), [(-1, 0), (0, -1), (1.0, 0), ("1", 0)])
def test_other_names_are_refused(seed: int, index: int) -> None:
    with pytest.raises(ValueError, match="must be an integer from 0 on"):
        generator(seed, "x", index)
