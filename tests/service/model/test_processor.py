"""Which processor trained a run, and whether seconds can be compared."""

from service.model.processor import UNKNOWN, are_comparable, processor_of


def test_a_run_has_the_processor_that_trained_all_of_it() -> None:
    whole = {"processor": "znver5", "code": "a"}
    assert processor_of(whole) == "znver5"
    assert processor_of({**whole, "mixed_with": ["processor was znver3, now znver5"]}) == UNKNOWN
    assert processor_of({"code": "a"}) == UNKNOWN
    assert processor_of(None) == UNKNOWN


def test_seconds_are_compared_on_equal_processors_that_are_known() -> None:
    assert are_comparable("znver5", "znver5")
    assert not are_comparable("znver5", "znver3")
    assert not are_comparable(UNKNOWN, UNKNOWN)
