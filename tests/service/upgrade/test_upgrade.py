"""An upgrade from the data directory of a release keeps sweeps, checkpoints and policies.

Each archive beside this file was made by the version whose tables it names (`make.py`). A version
whose learners keep another state makes its archive anew: it takes up no checkpoint of other code.
"""

import json
import tarfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from service.api.event_feed import coalesce
from service.model.run import Run, RunStatus
from service.settings import Settings
from service.store.claiming.retry import RetryPolicy
from service.store.store import Store
from service.store.upkeep.integrity import check
from tests.service.upgrade.make import played
from workers.training import execute as executing
from workers.training.execute import execute
from workers.training.fingerprint import fingerprint

ARCHIVES = sorted(Path(__file__).parent.glob("*.tar.xz"))
LEASE_SECONDS = 60.0
POINTS = [800, 1600, 2400]
TAKEN_UP = 1700


class Upgraded:
    """A data directory with its store, which the present code has opened."""

    def __init__(self, folder: Path) -> None:
        self.settings = Settings(data_dir=folder / "data")
        self.expected: dict[str, Any] = json.loads((folder / "expected.json").read_text())
        self.store = Store.open(self.settings.store_url, RetryPolicy(3, 0.0))

    @property
    def half(self) -> Run:
        """The run that was half trained."""
        [run] = self.store.list_runs(self.expected["half"])
        return run

    def train_on(self) -> None:
        """Take the half-trained run from its worker, which is lost, and train it to its end."""
        assert self.store.lose_expired() == 1
        claim = self.store.claim_cohort("worker-2", LEASE_SECONDS)
        assert claim is not None
        for each in execute(claim.runs, self.settings.checkpoint_place, tuple, lambda: None):
            self.store.record(claim, each)

    def points(self, run_id: str) -> list[dict[str, Any]]:
        return [asdict(point) for point in self.store.measurements(run_id)]


@pytest.fixture(params=ARCHIVES, ids=lambda path: str(path.name).partition(".")[0])
def upgraded(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Upgraded]:
    with tarfile.open(request.param) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # since Python 3.11.4
        archive.extractall(tmp_path)  # noqa: S202 - our own
    opened = Upgraded(tmp_path)
    yield opened
    opened.store.close()


def pretend(monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    """Have training believe that its code has this hash."""
    own: Mapping[str, Any] = {**fingerprint(), "code": code}
    monkeypatch.setattr(executing, "fingerprint", lambda: own)


def test_every_sweep_is_there_with_all_that_it_measured(upgraded: Upgraded) -> None:
    store, expected = upgraded.store, upgraded.expected
    assert [sweep.id for sweep in store.list_sweeps()] == [expected["half"], expected["ended"]]
    assert {sweep.owner for sweep in store.list_sweeps()} == {"admin"}
    runs = [*store.list_runs(expected["ended"]), upgraded.half]
    assert {run.id: run.status for run in runs} == expected["statuses"]
    assert {run.id: upgraded.points(run.id) for run in runs} == expected["measurements"]
    assert not [each for each in store.read(check) if each.faults]


def test_what_happened_before_can_be_told(upgraded: Upgraded) -> None:
    messages = coalesce(upgraded.store.events_after(0))
    told = {m.payload["run_id"]: m.payload for m in messages if m.kind == "measurements"}
    assert {run_id: (each["from"], each["to"]) for run_id, each in told.items()} == {
        run_id: (points[0]["timestep"], points[-1]["timestep"])
        for run_id, points in upgraded.expected["measurements"].items()
    }


def test_what_was_learned_is_played_as_before(upgraded: Upgraded) -> None:
    for run in [*upgraded.store.list_runs(upgraded.expected["ended"]), upgraded.half]:
        rewards = upgraded.expected["rewards"][run.id]
        assert played(upgraded.settings, run) == pytest.approx(rewards, rel=1e-6)


def test_training_goes_on_from_the_checkpoint(
    upgraded: Upgraded, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = upgraded.half.id
    before = upgraded.points(run_id)
    [first] = upgraded.store.attempts(run_id)
    assert first.fingerprint is not None
    pretend(monkeypatch, first.fingerprint["code"])
    upgraded.train_on()
    attempts = upgraded.store.attempts(run_id)
    assert [each.resumed_timestep for each in attempts] == [0, TAKEN_UP]
    assert upgraded.half.status is RunStatus.SUCCEEDED
    after = upgraded.points(run_id)
    assert [point["timestep"] for point in after] == POINTS
    assert after[: len(before)] == before


def test_a_checkpoint_of_other_code_is_told_of_and_not_used(
    upgraded: Upgraded, monkeypatch: pytest.MonkeyPatch
) -> None:
    pretend(monkeypatch, "another version's")
    upgraded.train_on()
    _, second = upgraded.store.attempts(upgraded.half.id)
    assert second.resumed_timestep == 0
    assert "its checkpoint was made by other code" in second.note
    assert upgraded.half.status is RunStatus.SUCCEEDED
    assert [point["timestep"] for point in upgraded.points(upgraded.half.id)] == POINTS


def test_there_is_an_archive() -> None:
    assert ARCHIVES
