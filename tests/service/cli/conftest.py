"""The command line against a real server."""

import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from typer.testing import CliRunner, Result

from service.cli.app import app as commands
from service.client import Client
from tests.service.conftest import TOKEN
from tests.service.served import served

Command = Callable[..., Result]


@pytest.fixture
def url(app: FastAPI, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A running service that the commands will find."""
    monkeypatch.setenv("D3PG_TOKEN", TOKEN)
    with served(app) as url:
        monkeypatch.setenv("D3PG_URL", url)
        yield url


@pytest.fixture
def service(url: str) -> Iterator[Client]:
    """A client of it."""
    with Client() as client:
        yield client


@pytest.fixture
def d3pg(url: str) -> Command:
    """Run a command; it must end well, unless another exit code is named."""
    runner = CliRunner()

    def run(*arguments: str, code: int = 0, stdin: str | None = None) -> Result:
        result = runner.invoke(commands, arguments, input=stdin)
        assert result.exit_code == code, (result.output, result.exception)
        return result

    return run


def as_json(result: Result) -> Any:
    return json.loads(result.stdout)
