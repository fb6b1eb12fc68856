"""Confidence sequences: the values that the evidence has not refuted."""

import numpy as np
import pytest

from service.analysis.question.confidence_sequence import confidence_sequence
from service.analysis.question.evidence import log_evidence
from service.model.inquiry.question import Method

LOOKS = (0, 4, 8, 30)
DIFFERENCES = np.random.default_rng(1).uniform(-0.1, 0.2, 30)
METHODS: tuple[Method, ...] = ("bounded", "normal")


@pytest.mark.parametrize("method", METHODS)
def test_bounds_are_where_the_evidence_crosses_the_level(method: Method) -> None:
    found = confidence_sequence(DIFFERENCES, (30,), 0.025, method, 1.0)
    crossing = log_evidence(DIFFERENCES, found.low[0], (30,), method, 1.0)
    assert crossing == pytest.approx(np.log(40), abs=1e-3)
    crossing = log_evidence(-DIFFERENCES, -found.high[0], (30,), method, 1.0)
    assert crossing == pytest.approx(np.log(40), abs=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_it_never_widens_and_holds_its_mean(method: Method) -> None:
    found = confidence_sequence(DIFFERENCES, LOOKS, 0.025, method, 0.5)
    assert (np.diff(found.low) >= 0).all()
    assert (np.diff(found.high) <= 0).all()
    assert (found.low[0], found.high[0]) == (-0.5, 0.5)
    assert np.isnan(found.mean[0])
    assert found.mean[1:] == pytest.approx([DIFFERENCES[:n].mean() for n in LOOKS[1:]])
    assert ((found.low < found.mean) & (found.mean < found.high))[1:].all()


@pytest.mark.parametrize("method", METHODS)
def test_a_stricter_level_is_wider(method: Method) -> None:
    loose, strict = (
        confidence_sequence(DIFFERENCES, LOOKS, level, method, 1.0) for level in (0.05, 0.005)
    )
    assert (strict.low <= loose.low).all()
    assert (strict.high >= loose.high).all()
    assert strict.low[-1] < loose.low[-1]
    assert strict.high[-1] > loose.high[-1]


def test_without_a_look_it_is_empty() -> None:
    found = confidence_sequence(np.empty(0), (), 0.025, "bounded", 1.0)
    assert len(found.low) == len(found.high) == len(found.mean) == 0
