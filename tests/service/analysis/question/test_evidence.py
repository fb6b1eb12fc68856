"""Evidence: against the reference library, against integrals, and as the martingale it is."""

from itertools import product

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import nct, norm
from scipy.stats import t as student

from service.analysis.curves import Floats
from service.analysis.question.evidence import EFFECT_PRECISION, log_evidence
from service.model.inquiry.question import Method

METHODS: tuple[Method, ...] = ("bounded", "normal")
CONFSEQ_DATA = np.array([0.6, 0.55, 0.7, 0.5, 0.62, 0.4, 0.66, 0.58])
"""In [0, 1]; what follows is confseq 0.0.11's `diversified_betting_mart` of it for two means, with
the same constant bets."""
CONFSEQ_VALUES = {
    0.5: [1.12, 1.1894, 1.488968, 1.488968, 1.725893504, 1.49016394496, 1.80581286631424,
          2.0044132427256627],
    0.45: [1.2, 1.3681481481481481, 1.8628395061728393, 2.005941929583905, 2.5367326108824875,
           2.3321545496677896, 3.112062010472432, 3.781285070647175],
}  # fmt: skip


def evidence(d: Floats, value: float, method: Method, clip: float = 1.0) -> Floats:
    n = range(1, d.shape[-1] + 1)
    return np.exp(log_evidence(d, value, n, method, clip))


@pytest.mark.parametrize("mean", CONFSEQ_VALUES)
@pytest.mark.parametrize("clip", [1.0, 0.25])
def test_the_bets_are_those_of_confseq(mean: float, clip: float) -> None:
    found = evidence(clip * (2 * CONFSEQ_DATA - 1), clip * (2 * mean - 1), "bounded", clip)
    assert found == pytest.approx(CONFSEQ_VALUES[mean], rel=1e-12)


@pytest.mark.parametrize("chance", [0.5, 0.1])
def test_bets_gain_nothing_on_average_where_the_mean_is_the_value(chance: float) -> None:
    """All paths of five pairs that are -1 or a value, each with its probability."""
    paths = np.array(list(product([-1.0, 0.5], repeat=5)))
    weights = np.where(paths < 0, chance, 1 - chance).prod(axis=1)
    mean = -chance + 0.5 * (1 - chance)
    for value, expected in ((mean, 1.0), (mean + 0.1, None)):
        average = weights @ evidence(paths, value, "bounded")[:, -1]
        assert average == pytest.approx(1.0) if expected else average < 1.0


@pytest.mark.parametrize("n", [2, 3, 8, 40])
def test_the_t_statistics_ratio_is_that_of_its_densities(n: int) -> None:
    """Mixed over effects ~ N(0, 1 / g), noncentral over central t."""
    d = np.random.default_rng(n).normal(0.3, 1.0, n)
    statistic = np.sqrt(n) * d.mean() / d.std(ddof=1)

    def weighted(effect: float) -> float:
        prior = norm.pdf(effect, scale=1 / np.sqrt(EFFECT_PRECISION))
        return float(nct.pdf(statistic, n - 1, np.sqrt(n) * effect) * prior)

    mixed, _ = quad(weighted, -6, 6, points=[0, 0.3], limit=200)
    sign = 1.0 if d.mean() > 0 else -1.0
    found = evidence(sign * d, 0.0, "normal")[-1]
    assert found == pytest.approx(mixed / student.pdf(statistic, n - 1), rel=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_evidence_falls_as_the_value_rises(method: Method) -> None:
    d = np.random.default_rng(0).uniform(-0.5, 0.7, 20)
    found = [log_evidence(d, value, (20,), method, 1.0)[0] for value in np.linspace(-0.9, 1, 50)]
    with np.errstate(invalid="ignore"):  # -inf - -inf
        assert not (np.diff(found) > 0).any()


@pytest.mark.parametrize("method", METHODS)
def test_before_the_first_pair_there_is_no_evidence(method: Method) -> None:
    found = log_evidence(np.array([0.5, 0.5]), 0.0, (0, 0, 2), method, 1.0)
    assert found[:2].tolist() == [0.0, 0.0]
    assert found[2] > 0
    assert log_evidence(np.empty(0), 0.0, (0,), method, 1.0).tolist() == [0.0]


@pytest.mark.parametrize("method", METHODS)
def test_pairs_without_any_difference_refute_no_equality(method: Method) -> None:
    assert not (log_evidence(np.zeros(30), 0.0, range(31), method, 1.0) > 0).any()


def test_a_single_pair_says_nothing_of_a_normal_mean() -> None:
    assert log_evidence(np.array([0.4]), 0.0, (1,), "normal", 1.0) == pytest.approx(0.0)
