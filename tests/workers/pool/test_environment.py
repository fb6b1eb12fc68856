"""What the process that drives Ray is told, and what it is not."""

from pathlib import Path

import pytest

from service.settings import Settings, variable_of
from workers.pool.environment import pool_environment

VALUE = "a-secret-of-the-service"


@pytest.mark.parametrize("address", ["", "head:6379"])
def test_it_has_no_secret_of_the_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    for name in map(variable_of, Settings.model_fields):
        monkeypatch.setenv(name, VALUE)
    for name in ("PGPASSWORD", "PGPASSFILE", "PGSERVICEFILE"):
        monkeypatch.setenv(name, VALUE)
    monkeypatch.setenv("AWS_ENDPOINT_URL", "https://storage.example")
    environment = pool_environment(address, tmp_path)
    assert VALUE not in environment.values()
    assert environment["AWS_ENDPOINT_URL"] == "https://storage.example", "checkpoints may need it"
