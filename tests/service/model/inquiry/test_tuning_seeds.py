"""Seeds that choose settings."""

from service.model.inquiry.tuning_seeds import PRESETS, SEARCHES, chooses, seeds_text
from service.paper import evaluation
from service.paper.search import tuning


def test_what_chose_the_presets_is_kept_and_what_is_evaluated_is_not() -> None:
    assert set(tuning.SEEDS) <= set(PRESETS)
    assert not any(map(chooses, range(evaluation.SEEDS)))
    assert chooses(SEARCHES[0])
    assert chooses(SEARCHES[-1])


def test_seeds_in_words() -> None:
    assert seeds_text((1_000_000_000, 1_000_000_001)) == "1,000,000,000 to 1,000,000,001"
    assert seeds_text([100, 101, 103]) == "100; 101; 103"
    assert seeds_text((7,)) == "7"
