"""One suite for every database: `store` is an empty one of each backend in turn."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from algorithms.measurement import Measurement
from service.model.sweep import Sweep
from service.store.claiming.retry import RetryPolicy
from service.store.store import Store
from service.store.tables import metadata
from tests.service.store.postgresql import PostgreSQL, running_postgresql
from workers.messages.run_spec import RunSpec

BACKENDS = ("sqlite", "postgresql")
AT_ONCE = RetryPolicy(losses=3, first_wait_seconds=0.0)

Submit = Callable[..., Sweep]
Fresh = Callable[..., str]
"""`fresh(n)` empties the n-th database, the first one if unsaid, and returns its address."""


@pytest.fixture(scope="session")
def migrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty SQLite database at this version's tables; copied, for migrating takes longer."""
    path = tmp_path_factory.mktemp("store") / "empty.sqlite"
    Store.open(f"sqlite:///{path}").close()
    return path


@pytest.fixture(scope="session")
def postgresql() -> Iterator[PostgreSQL]:
    """A server for the whole session."""
    with running_postgresql() as server:
        yield server


@pytest.fixture
def fresh_sqlite(migrated: Path, tmp_path: Path) -> Fresh:
    """Empty SQLite databases."""

    def empty(number: int = 0) -> str:
        path = tmp_path / f"d3pg-{number}.sqlite"
        for leftover in tmp_path.glob(f"{path.name}-*"):
            leftover.unlink()
        shutil.copy(migrated, path)
        return f"sqlite:///{path}"

    return empty


@pytest.fixture
def fresh_postgresql(postgresql: PostgreSQL) -> Fresh:
    """Empty databases of the server, which keeps them: making one takes longer."""

    def empty(number: int = 0) -> str:
        name = f"d3pg_{number}"
        if name not in postgresql.databases:
            Store.open(postgresql.create(name)).close()
        postgresql.execute(f"TRUNCATE {', '.join(metadata.tables)} RESTART IDENTITY", name)
        return postgresql.url(name)

    return empty


@pytest.fixture(params=BACKENDS)
def fresh(request: pytest.FixtureRequest) -> Fresh:
    """Empty databases of each backend in turn."""
    make: Fresh = request.getfixturevalue(f"fresh_{request.param}")
    return make


@pytest.fixture
def url(fresh: Fresh) -> str:
    """The address of an empty database."""
    return fresh()


@pytest.fixture
def store(url: str) -> Iterator[Store]:
    """An empty store that tries runs again without a wait, thrice."""
    opened = Store.open(url, AT_ONCE)
    yield opened
    opened.close()


@pytest.fixture
def submit(store: Store) -> Submit:
    """Make a sweep of ddpg runs: `submit(seeds=4, environments=("Pendulum",), priority=0)`."""

    def create(
        seeds: int = 4,
        environments: tuple[str, ...] = ("Pendulum",),
        priority: int = 0,
        timesteps: int = 1600,
    ) -> Sweep:
        specs = [
            RunSpec("ddpg", environment, seed, timesteps=timesteps)
            for environment in environments
            for seed in range(seeds)
        ]
        versions = dict.fromkeys(environments, 1)
        return store.create_sweep("a sweep", priority, {}, specs, environment_versions=versions)

    return create


def measured(seed: int, timestep: int, value: float = -1.0) -> Measurement:
    """A measurement with two diagnostics."""
    return Measurement(
        seed=seed,
        timestep=timestep,
        return_mean=value,
        return_history=value / 2,
        updates=timestep // 2,
        jacobians=3 * timestep,
        seconds=timestep / 1000,
        diagnostics={"critic_loss": value * value, "mean_q": value},
        compile_seconds=0.25,
    )
