"""The containers of `docker/compose.yml`, as far as they can be judged without an engine."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from service.settings import Settings

DOCKER = Path(__file__).parents[2] / "docker"
COMPOSE: dict[str, Any] = yaml.safe_load((DOCKER / "compose.yml").read_text())
CONTAINERS: dict[str, dict[str, Any]] = COMPOSE["services"]
RAY_NODES = ["head", "worker", "driver"]
SETTINGS = {f"D3PG_{name.upper()}" for name in Settings.model_fields}


@pytest.mark.parametrize("name", CONTAINERS)
def test_a_container_is_reaped_watched_restarted_and_not_root(name: str) -> None:
    container = CONTAINERS[name]
    assert container["init"] is True
    assert container["healthcheck"]["test"][0] == "CMD"
    assert container["restart"] == "unless-stopped"
    assert str(container["user"]).split(":")[0] not in {"0", "root"}
    assert container["cap_drop"] == ["ALL"]
    assert container["shm_size"]


def test_the_service_alone_is_published_and_on_loopback_alone() -> None:
    published = {
        name: container["ports"] for name, container in CONTAINERS.items() if "ports" in container
    }
    assert published == {"service": ["127.0.0.1:${PORT:-8000}:8000"]}
    assert not any("network_mode" in container for container in CONTAINERS.values())


def test_no_node_of_ray_shares_a_network_with_the_service_or_the_database() -> None:
    assert COMPOSE["networks"]["storage"] == {"internal": True}
    networks = {name: set(container["networks"]) for name, container in CONTAINERS.items()}
    assert all(networks[name] == {"cluster"} for name in RAY_NODES)
    assert networks["service"] == {"outside", "storage"}
    assert networks["database"] == {"storage"}


@pytest.mark.parametrize("name", RAY_NODES)
def test_every_ray_process_is_told_to_authenticate(name: str) -> None:
    container = CONTAINERS[name]
    assert container["environment"]["RAY_AUTH_MODE"] == "token"
    file = Path(container["environment"]["RAY_AUTH_TOKEN_PATH"])
    assert file.parent == Path("/run/secrets")
    assert file.name in container["secrets"]


def test_secrets_are_files_and_no_environment_has_one() -> None:
    assert set(COMPOSE["secrets"]) == {"token", "ray_token", "database_password"}
    assert all(set(secret) == {"file"} for secret in COMPOSE["secrets"].values())
    variables = {variable for each in CONTAINERS.values() for variable in each["environment"]}
    assert not variables & {"D3PG_TOKEN", "RAY_AUTH_TOKEN", "POSTGRES_PASSWORD", "PGPASSWORD"}
    assert "docker/secrets/" in (DOCKER.parent / ".gitignore").read_text().splitlines()


def test_ray_s_token_and_the_service_s_secrets_are_in_no_container_together() -> None:
    secrets = {name: set(container["secrets"]) for name, container in CONTAINERS.items()}
    assert all(secrets[name] == {"ray_token"} for name in RAY_NODES)
    assert secrets["service"] == {"token", "database_password"}
    assert secrets["database"] == {"database_password"}
    assert not any(variable.startswith("RAY_") for variable in CONTAINERS["service"]["environment"])


def test_the_variables_named_are_settings_and_make_a_valid_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = {
        name: value
        for name, value in CONTAINERS["service"]["environment"].items()
        if name.startswith("D3PG_")
    }
    assert own.keys() <= SETTINGS
    for name, value in own.items():
        monkeypatch.setenv(name, interpolated(value, {}))
    settings = Settings()
    assert settings.public.url == "http://localhost:8000"
    assert settings.ray_address == "head:6379"
    assert settings.worker_memory == 2_000_000_000


@pytest.mark.parametrize(
    ("said", "url"),
    [
        ({"PORT": "9000"}, "http://localhost:9000"),
        ({"PUBLIC_URL": "https://lab.example/d3pg"}, "https://lab.example/d3pg"),
        ({"PUBLIC_URL": ""}, "http://localhost:8000"),
    ],
)
def test_the_service_knows_where_people_find_it(said: dict[str, str], url: str) -> None:
    value = CONTAINERS["service"]["environment"]["D3PG_PUBLIC_URL"]
    settings = Settings(public_url=interpolated(value, said))
    assert settings.public.url == url
    assert settings.public.host in settings.allowed_hosts


def interpolated(value: str, said: Mapping[str, str]) -> str:
    """What Compose makes of a value with `${NAME:-default}` in it, from the innermost outwards."""
    while found := re.search(r"\$\{(\w+):-([^${}]*)\}", value):
        name, default = found.groups()
        value = f"{value[: found.start()]}{said.get(name) or default}{value[found.end() :]}"
    return value


def test_containers_share_what_they_have_to_and_nothing_else() -> None:
    volumes = {name: set(container.get("volumes", ())) for name, container in CONTAINERS.items()}
    checkpoints, logs = "checkpoints:/data/checkpoints", "logs:/data/logs"
    assert volumes["worker"] == {checkpoints, logs}
    assert volumes["driver"] == {logs, "driver:/run/d3pg"}
    assert volumes["service"] == {"data:/data", checkpoints, "driver:/run/d3pg:ro"}
    assert not volumes["head"]


def test_the_service_finds_the_driver_where_it_listens() -> None:
    script, head, folder = CONTAINERS["driver"]["command"]
    assert script == "drive-ray"
    environment = CONTAINERS["service"]["environment"]
    assert environment["D3PG_RAY_ADDRESS"] == head
    assert environment["D3PG_DRIVER"] == f"{folder}/pool.sock"
