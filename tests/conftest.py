"""How tests are run; places for checkpoints: a folder, and a bucket of a store that speaks S3."""

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.object_store import ObjectStore, forget_clients
from workers.checkpoints.place import Place

FOLDERS = {"browser": ("web/",), "cluster": ("end_to_end/", "workers/")}
"""Where `make test` looks for the tests of a mark, so that it need not collect all others."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Refuse a test that `make test` would not find."""
    for item in items:
        for mark, folders in FOLDERS.items():
            place = str(item.path.relative_to(Path(__file__).parent))
            if item.get_closest_marker(mark) and not place.startswith(folders):
                known = " or ".join(f"tests/{folder}" for folder in folders)
                raise pytest.UsageError(f"{item.nodeid} is marked {mark}: move it to {known}")


def pytest_collection_finish() -> None:
    """One thread for torch, as in the workers: more of them wait for each other on busy cores."""
    if (torch := sys.modules.get("torch")) is not None:
        torch.set_num_threads(1)


def pytest_configure() -> None:
    """Undo what a shell does to a background job: it, and all that it starts, ignores Ctrl-C."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def object_store() -> Iterator[ObjectStore]:
    store = ObjectStore()
    store.start()
    yield store
    store.stop()


@pytest.fixture
def bucket(object_store: ObjectStore, monkeypatch: pytest.MonkeyPatch) -> str:
    """The URL of an empty bucket; the environment has the way to it."""
    for name, value in object_store.environment.items():
        monkeypatch.setenv(name, value)
    return object_store.new_bucket()


@pytest.fixture
def fresh_clients() -> Iterator[None]:
    """For tests of another environment."""
    forget_clients()
    yield
    forget_clients()


@pytest.fixture(params=["disk", "bucket"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Place:
    """Either, empty."""
    if request.param == "disk":
        return tmp_path / "checkpoints"
    url: str = request.getfixturevalue("bucket")
    return f"{url}/checkpoints"
