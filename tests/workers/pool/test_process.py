"""The pool on a real local Ray: real training, real kills, nothing left behind."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.workers.heard import ENDLESS, Heard
from tests.workers.processes import listening_beyond_loopback, processes_with
from workers.checkpoints.checkpoint import find_snapshot
from workers.messages.report import Busy, Ended, Failed, Lost, News, Ready
from workers.messages.run_spec import RunSpec
from workers.pool.environment import pool_environment
from workers.pool.pool import PoolUnavailableError
from workers.pool.process import PoolProcess, PoolSettings

pytestmark = pytest.mark.cluster

SPECS = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(4)]


KEPT_BACK = "what-the-service-alone-may-know"


@pytest.fixture(scope="module")
def heard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Heard]:
    """A pool that was started by one who has secrets: in its environment, and in an open file."""
    heard = Heard(tmp_path_factory.mktemp("pool"))
    file = heard.settings.data_dir / "token"
    file.write_text(KEPT_BACK)
    with pytest.MonkeyPatch.context() as patch, file.open() as held:
        os.set_inheritable(held.fileno(), True)
        for name in ("D3PG_TOKEN", "D3PG_DATABASE_URL", "PGPASSWORD"):
            patch.setenv(name, KEPT_BACK)
        heard.pool.start()
    yield heard
    heard.pool.close()


@pytest.fixture(scope="module")
def workers(heard: Heard) -> list[Ready]:
    """The two workers; the tests below use them in their order."""
    return [heard.idle_worker(), heard.idle_worker()]


def test_no_port_is_open_to_other_machines(heard: Heard, workers: list[Ready]) -> None:
    started = processes_with(str(heard.settings.data_dir / "ray-token"))
    assert {worker.pid for worker in workers} < started
    assert {process: listening_beyond_loopback(process) for process in started} == {
        process: set() for process in started
    }


def test_every_process_has_the_token_and_one_thread(heard: Heard, workers: list[Ready]) -> None:
    token = heard.settings.data_dir / "ray-token"
    assert token.stat().st_mode & 0o777 == 0o600
    for worker in workers:
        variables = Path(f"/proc/{worker.pid}/environ").read_text().split("\0")
        assert {
            "RAY_AUTH_MODE=token",
            f"RAY_AUTH_TOKEN_PATH={token}",
            "RAY_USAGE_STATS_ENABLED=0",
            "OMP_NUM_THREADS=1",
            "NUMBA_NUM_THREADS=1",
        } <= set(variables)


def test_no_process_inherits_a_secret_of_the_service(heard: Heard, workers: list[Ready]) -> None:
    started = processes_with(str(heard.settings.data_dir / "ray-token"))
    assert {worker.pid for worker in workers} < started
    for process in started:
        folder = Path(f"/proc/{process}")
        assert KEPT_BACK not in (folder / "environ").read_text()
        opened = {each.resolve() for each in (folder / "fd").iterdir() if each.exists()}
        assert heard.settings.data_dir / "token" not in opened


def test_trains_a_cohort(heard: Heard, workers: list[Ready]) -> None:
    worker = workers[0].worker
    cohort = heard.train(worker, SPECS, measure=True)
    heard.wait_for(lambda report: report == Ended(worker, cohort))
    assert Busy(worker, heard.work) in heard.reports
    news = [r.progress for r in heard.reports if isinstance(r, News) and r.worker == worker]
    points = [(m.seed, m.timestep) for progress in news for m in progress.measurements]
    assert sorted(points) == [(seed, step) for seed in range(4) for step in (800, 1600)]
    assert [seed for progress in news for seed in progress.finished] == [0, 1, 2, 3]
    assert [p.fingerprint["threads"] for p in news if p.fingerprint] == ["1"]
    learned = [find_snapshot(heard.settings.checkpoints, f"run-{seed}") for seed in range(4)]
    assert [snapshot and snapshot.timestep for snapshot in learned] == 4 * [1600]
    assert [p.random_return.environment for p in news if p.random_return] == ["Pendulum"]


def test_an_error_in_code_leaves_the_worker_alive(heard: Heard, workers: list[Ready]) -> None:
    worker = workers[0].worker
    heard.train(worker, [RunSpec("no such learner", "Pendulum", 0)])
    failed = heard.wait_for(lambda report: isinstance(report, Failed))
    assert isinstance(failed, Failed)
    assert "no such learner" in failed.error
    assert failed.error.startswith("Traceback (most recent call last)")
    cohort = heard.train(worker, SPECS[:1])
    heard.wait_for(lambda report: report == Ended(worker, cohort))


def test_drops_seeds_while_it_trains(heard: Heard, workers: list[Ready]) -> None:
    worker = workers[0].worker
    cohort = heard.train(worker, ENDLESS)
    heard.wait_for_training(worker)
    begun = time.monotonic()
    heard.pool.drop(worker, [1])
    heard.wait_for(lambda report: isinstance(report, News) and report.progress.dropped == (1,))
    assert time.monotonic() - begun < 5.0
    heard.pool.drop(worker, [0])
    heard.wait_for(lambda report: report == Ended(worker, cohort))


def test_a_killed_worker_is_told_and_replaced(heard: Heard, workers: list[Ready]) -> None:
    victim = workers[1]
    heard.train(victim.worker, ENDLESS)
    heard.wait_for_training(victim.worker)
    os.kill(victim.pid, signal.SIGKILL)
    begun = time.monotonic()
    lost = heard.wait_for(lambda report: isinstance(report, Lost))
    assert isinstance(lost, Lost)
    assert lost.worker == victim.worker
    assert time.monotonic() - begun < 5.0
    workers[1] = heard.idle_worker()
    assert workers[1].pid != victim.pid


def test_a_worker_that_is_to_be_ended_is(heard: Heard, workers: list[Ready]) -> None:
    victim = workers[1]
    heard.train(victim.worker, ENDLESS)
    heard.wait_for_training(victim.worker)
    heard.pool.kill(victim.worker)
    heard.wait_for(lambda report: isinstance(report, Lost) and report.worker == victim.worker)
    workers[1] = heard.idle_worker()
    assert not Path(f"/proc/{victim.pid}").exists()


def test_nothing_is_left_after_closing(heard: Heard, workers: list[Ready]) -> None:
    heard.train(workers[0].worker, ENDLESS)
    heard.wait_for_training(workers[0].worker)
    begun = time.monotonic()
    heard.pool.close()
    assert time.monotonic() - begun < 5.0
    wait_until_gone(heard)


def test_the_end_of_its_process_is_told_and_it_can_be_started_again(heard: Heard) -> None:
    heard.pool.start()
    ready = heard.idle_worker()
    heard.train(ready.worker, ENDLESS)
    assert heard.pool.process_id is not None
    os.kill(heard.pool.process_id, signal.SIGKILL)
    with pytest.raises(PoolUnavailableError, match="exit code -9"):
        heard.wait_for(lambda _: False)
    wait_until_gone(heard)
    heard.pool.start()
    heard.idle_worker()
    heard.pool.close()


def test_says_why_it_cannot_be_had(tmp_path: Path) -> None:
    pool = PoolProcess(PoolSettings(2, "127.0.0.1:1", tmp_path, tmp_path))
    pool.start()
    with pytest.raises(PoolUnavailableError, match=r"Ray at 127\.0\.0\.1:1 did not answer in 20 s"):
        pool.reports(120.0)


def wait_until_gone(heard: Heard) -> None:
    """Wait until no process of the pool is left, workers that are orphans included."""
    deadline = time.monotonic() + 10
    while left := processes_with(str(heard.settings.data_dir / "ray-token")):
        assert time.monotonic() < deadline, left
        time.sleep(0.1)


def test_the_token_for_another_cluster_is_the_one_that_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_AUTH_TOKEN_PATH", "/elsewhere/token")
    joined = pool_environment("10.0.0.1:6379", tmp_path)
    assert (joined["RAY_AUTH_MODE"], joined["RAY_AUTH_TOKEN_PATH"]) == ("token", "/elsewhere/token")
    own = pool_environment("", tmp_path)
    assert own["RAY_AUTH_TOKEN_PATH"] == str(tmp_path / "ray-token")
