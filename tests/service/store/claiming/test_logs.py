"""What workers print: kept with the attempts of their cohort, and told."""

from service.model.claim import Claim
from service.store.store import Store
from tests.service.store.conftest import Submit
from workers.messages.progress import Progress


def claimed(store: Store) -> Claim:
    claim = store.claim_cohort("worker-1", 60.0)
    assert claim is not None
    return claim


def logs_of(store: Store, claim: Claim) -> list[str]:
    return [store.attempts(run.run_id)[-1].log_tail for run in claim.runs]


def test_every_run_of_the_cohort_has_the_log(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3, environments=("Pendulum", "MassPoint"))
    claim, other = claimed(store), claimed(store)
    last = store.last_event_id()
    store.record(claim, Progress(800, log_tail="one\n"))
    store.record(claim, Progress(1600))
    assert logs_of(store, claim) == 3 * ["one\n"]
    assert logs_of(store, other) == 3 * [""]
    [told] = store.events_after(last)
    assert (told.kind, told.payload) == (
        "log",
        {"sweep_id": sweep.id, "run_ids": [run.run_id for run in claim.runs]},
    )


def test_what_the_database_cannot_hold_is_escaped(store: Store, submit: Submit) -> None:
    submit(seeds=1)
    claim = claimed(store)
    store.record(claim, Progress(800, log_tail="a\0b \ud800\n"))
    assert logs_of(store, claim) == ["a\\x00b \\ud800\n"]


def test_the_end_keeps_the_log_unless_there_is_a_later_one(store: Store, submit: Submit) -> None:
    submit(seeds=3)
    claim = claimed(store)
    store.record(claim, Progress(800, log_tail="one\n", finished=(0,)))
    by_seed = {run.spec.seed: run.run_id for run in claim.runs}
    store.lose(claim.only({by_seed[1]}), "its worker was lost")
    store.fail(claim.only({by_seed[2]}), "ValueError: no", "one\ntwo\n")
    assert logs_of(store, claim) == ["one\n", "one\n", "one\ntwo\n"]


def test_an_attempt_that_was_given_up_has_no_say(store: Store, submit: Submit) -> None:
    submit(seeds=1)
    claim = claimed(store)
    store.release(claim, "the service was stopped")
    last = store.last_event_id()
    store.record(claim, Progress(800, log_tail="too late\n"))
    assert logs_of(store, claim) == [""]
    assert store.events_after(last) == []
