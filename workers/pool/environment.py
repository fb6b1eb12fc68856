"""The environment of the process that drives Ray, which its workers inherit."""

import os
import secrets
from collections.abc import Mapping
from pathlib import Path

SECRETIVE = ("D3PG_", "PG")
"""Prefixes of variables for the service and its database only: they may hold secrets."""
TOKEN_VARIABLES = ("RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH")


def without_secrets(variables: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without the variables of the service and its database."""
    return {name: value for name, value in variables.items() if not name.startswith(SECRETIVE)}


def without_ray_token(variables: Mapping[str, str]) -> dict[str, str]:
    """Return an environment that names no token of Ray's."""
    return {name: value for name, value in variables.items() if name not in TOKEN_VARIABLES}


def pool_environment(ray_address: str, data_dir: Path) -> dict[str, str]:
    """Return the environment of the process: ours, less the service's settings, plus Ray's needs.

    Holders of Ray's token, and the code of every task, can read it. It has neither the service's
    token nor the database's address or password.

    Ray turns its authentication on by itself in some processes only, and the others then fail, so
    it is set for all of them; the token is the data directory's, or for a cluster to join the one
    that the variables name. A local Ray binds to loopback alone, and counts a raylet as dead that
    has not answered for about 20 s (its default: over a minute). One thread a worker: the thread
    count of a library changes the bits, and is read as it loads.
    """
    environment = without_secrets(os.environ)
    environment.update(
        RAY_AUTH_MODE="token",
        RAY_USAGE_STATS_ENABLED="0",
        RAY_ENABLE_UV_RUN_RUNTIME_ENV="0",
        RAY_ENABLE_AUTO_CONNECT="0",
        OMP_NUM_THREADS="1",
        MKL_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
        NUMBA_NUM_THREADS="1",
    )
    if not ray_address:
        environment = without_ray_token(environment)
        environment["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"
        environment["RAY_health_check_period_ms"] = "1000"
        environment["RAY_health_check_timeout_ms"] = "3000"
        environment["RAY_health_check_failure_threshold"] = "5"
    if not set(TOKEN_VARIABLES) & set(environment):
        environment["RAY_AUTH_TOKEN_PATH"] = str(_token_file(data_dir))
    source = Path(__file__).resolve().parents[2]
    if source.name not in {"site-packages", "dist-packages"}:  # not installed, but run in place
        paths = [str(source), environment.get("PYTHONPATH", "")]
        environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
    return environment


def _token_file(data_dir: Path) -> Path:
    """Return the file with the token of the local cluster, made at first use, ours alone."""
    path = data_dir.resolve() / "ray-token"
    if not path.exists():
        descriptor = os.open(path, os.O_CREAT | os.O_WRONLY | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w") as file:
            file.write(secrets.token_hex(32))
    return path
