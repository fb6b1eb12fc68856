"""`docker/Dockerfile` agrees with the project: versions, environment, and what is sent to it."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from service.settings import Settings
from workers.pool.environment import pool_environment

ROOT = Path(__file__).parents[2]
DOCKERFILE = (ROOT / "docker" / "Dockerfile").read_text()
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
DEPENDENCIES = {Requirement(each).name: each for each in PROJECT["project"]["dependencies"]}


def environment() -> dict[str, str]:
    """Return what the image's ENV instruction sets."""
    block = re.search(r"^ENV ((?:.*\\\n)*.*)$", DOCKERFILE, re.MULTILINE)
    assert block is not None
    return dict(re.findall(r"(\w+)=(\S+)", block[1]))


def test_python_and_torch_are_the_project_s() -> None:
    python = re.search(r"^ARG PYTHON=python:([\d.]+)-", DOCKERFILE, re.MULTILINE)
    assert python is not None
    assert python[1] in SpecifierSet(PROJECT["project"]["requires-python"])
    assert f"'{DEPENDENCIES['torch']}'" in DOCKERFILE


def test_ray_of_the_manifest_is_the_project_s() -> None:
    documents = yaml.safe_load_all((ROOT / "docker" / "kuberay.yaml").read_text())
    cluster = next(each for each in documents if each["kind"] == "RayCluster")
    assert cluster["spec"]["rayVersion"] in Requirement(DEPENDENCIES["ray"]).specifier


def test_nodes_get_what_the_workers_of_a_local_ray_get(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.environ", {})
    wanted = pool_environment("head:6379", tmp_path)
    of_each_deployment = {"RAY_AUTH_MODE", "RAY_AUTH_TOKEN_PATH", "PYTHONPATH"}
    wanted = {name: value for name, value in wanted.items() if name not in of_each_deployment}
    assert len(wanted) >= 7
    assert wanted.items() <= environment().items()


def test_its_settings_are_valid(monkeypatch: pytest.MonkeyPatch) -> None:
    own = {name: value for name, value in environment().items() if name.startswith("D3PG_")}
    assert own.keys() <= {f"D3PG_{name.upper()}" for name in Settings.model_fields}
    for name, value in own.items():
        monkeypatch.setenv(name, value)
    assert Settings().allowed_hosts >= {"localhost"}


def test_it_ends_as_a_user_other_than_root_with_a_health_check_and_a_volume() -> None:
    lines = DOCKERFILE.splitlines()
    assert [line for line in lines if line.startswith("USER")] == ["USER d3pg"]
    assert "VOLUME /data" in lines
    assert "/healthz" in DOCKERFILE
    assert lines[-1] == 'CMD ["d3pg", "serve"]'


def test_what_the_wheel_is_built_from_is_sent_and_nothing_unnamed() -> None:
    lines = (ROOT / ".dockerignore").read_text().splitlines()
    rules = [line for line in lines if not line.startswith("#")]
    assert rules[0] == "*"
    sent = {rule[1:] for rule in rules if rule.startswith("!")}
    packages = set(PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"])
    assert sent == packages | {
        "pyproject.toml",
        PROJECT["project"]["readme"],
        "hatch_build.py",
        "docker/drive-ray",
        "docker/serve-d3pg",
    }
    assert all((ROOT / name).exists() for name in sent)
