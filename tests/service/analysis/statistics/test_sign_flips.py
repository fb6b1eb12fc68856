"""The sign-flip test, against scipy and by hand."""

import numpy as np
import pytest
import scipy.stats

from service.analysis.curves import Floats
from service.analysis.statistics.sign_flips import sign_flip_p


def scipys(d: Floats) -> float:
    """The p of all choices of signs."""
    found = scipy.stats.permutation_test(
        (d,), lambda x, axis: np.mean(x, axis=axis), permutation_type="samples",
        n_resamples=10**6, vectorized=True,
    )  # fmt: skip
    return float(found.pvalue)


@pytest.mark.parametrize("pairs", [2, 3, 7, 12])
@pytest.mark.parametrize("mean", [0.0, 0.4])
def test_it_is_scipys(pairs: int, mean: float) -> None:
    d = np.random.default_rng(pairs).normal(mean, 1.0, pairs)
    assert sign_flip_p(d) == pytest.approx(scipys(d), rel=1e-12)


def test_equal_sums_are_equal_whatever_their_rounding() -> None:
    """0.1 + 0.2 - 0.3 is not 0: of the 16 choices, 8 sum to 0.7 or 0.1 at most by rounding."""
    d = np.array([0.1, 0.2, 0.3, -0.1])
    assert sign_flip_p(d) == pytest.approx(scipys(d), rel=1e-12)


def test_by_hand() -> None:
    """Of 1, 2, 3 the sums are 6, 4, 2, 0 and their opposites: two of eight reach 6."""
    assert sign_flip_p(np.array([1.0, 2.0, 3.0])) == 2 / 8
    assert sign_flip_p(np.array([-1.0, 2.0, 3.0])) == 4 / 8


def test_all_wins_have_the_least_p() -> None:
    assert sign_flip_p(np.linspace(1.0, 2.0, 32)) == 2 / 2**32


@pytest.mark.parametrize("d", [[], [3.0], [0.0, 0.0], [1.0, -1.0]])
def test_what_says_nothing(d: list[float]) -> None:
    assert sign_flip_p(np.array(d)) == 1.0


def test_beyond_32_pairs_signs_are_drawn() -> None:
    """Other draws of signs, a hundred thousand of them, find the same p."""
    draws = np.random.default_rng(0)
    d = draws.normal(0.2, 1.0, 60)
    reached = np.abs(draws.choice((-1.0, 1.0), (100_000, 60)) @ d) >= abs(d.sum())
    assert sign_flip_p(d) == pytest.approx(reached.mean(), rel=0.1)
    assert sign_flip_p(d) == sign_flip_p(d)


def test_where_nothing_is_to_be_found_it_finds_as_often_as_it_says() -> None:
    draws = np.random.default_rng(0).standard_t(3, (2000, 10))
    rejected = np.mean([sign_flip_p(d) <= 0.05 for d in draws])
    assert rejected == pytest.approx(0.05, abs=0.015)
