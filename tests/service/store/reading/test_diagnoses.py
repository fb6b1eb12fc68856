"""Diagnoses: asked for once, made once, of the last attempt of runs that have ended."""

import math

import pytest

from algorithms.diagnostics.finding import Finding
from service.model.diagnosis import Diagnosis
from service.model.run import Run
from service.store.refusal import NotFoundError, TooManyAskedError
from service.store.store import Store
from tests.service.store.conftest import Submit
from workers.messages.progress import Progress

FOUND = (
    Finding("smoothing", "norm", 4, 0.05, 0.1 + 0.2),
    Finding("critic", "action_cosine", 1, None, math.nan),
    Finding("kinks", "crossing", None, None, 0.0),
)


def finish(store: Store) -> None:
    """Let every queued run reach its end."""
    while (claim := store.claim_cohort("worker", 60.0)) is not None:
        store.record(claim, Progress(1600, finished=tuple(spec.seed for spec in claim.specs)))


def ended(store: Store, submit: Submit, seeds: int = 2) -> list[Run]:
    """The runs of a sweep that have ended."""
    sweep = submit(seeds=seeds)
    finish(store)
    return store.list_runs(sweep.id)


def told(store: Store) -> list[str | None]:
    """The runs of the events of diagnoses."""
    events = store.events_after(0)
    return [event.payload.get("run_id") for event in events if event.kind == "diagnosis"]


def test_what_was_found_comes_back_as_it_was(store: Store, submit: Submit) -> None:
    first, second = ended(store, submit)
    assert store.find_diagnosis(first.id) == Diagnosis(first)
    store.ask_diagnoses([first, second], 10)
    assert store.find_diagnosis(first.id).is_waiting
    assert store.next_waiting_diagnosis() == first
    store.record_diagnosis(first, FOUND)
    assert store.next_waiting_diagnosis() == second
    made = store.find_diagnosis(first.id)
    assert made.findings is not None
    assert [repr(each) for each in made.findings] == [repr(each) for each in FOUND]
    assert not made.is_waiting
    assert told(store) == [None, first.id]


def test_asked_for_again_nothing_changes(store: Store, submit: Submit) -> None:
    [run] = ended(store, submit, seeds=1)
    store.ask_diagnoses([run], 1)
    store.ask_diagnoses([run], 1)
    store.record_diagnosis(run, FOUND)
    store.ask_diagnoses([run], 1)
    assert store.next_waiting_diagnosis() is None
    assert told(store) == [None, run.id]


def test_what_failed_can_be_asked_for_again(store: Store, submit: Submit) -> None:
    [run] = ended(store, submit, seeds=1)
    store.ask_diagnoses([run], 1)
    store.record_diagnosis(run, None, "It was ended.")
    assert store.find_diagnosis(run.id) == Diagnosis(run, problem="It was ended.")
    store.ask_diagnoses([run], 1)
    assert store.find_diagnosis(run.id) == Diagnosis(run, is_waiting=True)


def test_no_more_wait_than_may(store: Store, submit: Submit) -> None:
    runs = ended(store, submit, seeds=3)
    store.ask_diagnoses(runs[:2], 2)
    with pytest.raises(TooManyAskedError, match="2 diagnoses wait already, and 1 more"):
        store.ask_diagnoses(runs, 2)
    assert not store.find_diagnosis(runs[2].id).is_waiting
    store.record_diagnosis(runs[0], FOUND)
    store.ask_diagnoses(runs, 2)
    assert store.find_diagnosis(runs[2].id).is_waiting


def test_one_of_an_earlier_attempt_is_none(store: Store, submit: Submit) -> None:
    """A run that failed is diagnosed, is retried, and learns something else."""
    sweep = submit(seeds=1)
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    store.fail(claim, "an error")
    [failed] = store.list_runs(sweep.id)
    store.ask_diagnoses([failed], 1)
    store.move_run(failed.id, "retry")
    assert store.next_waiting_diagnosis() is None, "it may be running"
    finish(store)
    [again] = store.list_runs(sweep.id)
    store.record_diagnosis(failed, FOUND)
    assert store.find_diagnosis(again.id) == Diagnosis(again)
    store.ask_diagnoses([again], 1)
    store.record_diagnosis(failed, FOUND)
    assert store.find_diagnosis(again.id) == Diagnosis(again, is_waiting=True)


def test_of_a_sweep_the_first_of_each_cell_that_reached_their_end(
    store: Store, submit: Submit
) -> None:
    sweep = submit(seeds=3, environments=("Pendulum", "CartPole"))
    store.move_run(f"{sweep.id}-0", "cancel")
    finish(store)

    def listed(most: int, environment: str | None = None) -> list[str]:
        found = store.list_diagnoses(sweep.id, most_of_cell=most, environment=environment)
        return [each.run.id.removeprefix(f"{sweep.id}-") for each in found]

    assert listed(most=1) == ["1", "3"]
    assert listed(most=2) == ["1", "2", "3", "4"]
    assert listed(most=16) == ["1", "2", "3", "4", "5"]
    assert listed(most=2, environment="CartPole") == ["3", "4"]


def test_of_no_run_there_is_none(store: Store) -> None:
    with pytest.raises(NotFoundError):
        store.find_diagnosis("nobody-1")
