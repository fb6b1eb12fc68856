"""A sweep's file: numbers as people write them, and what is wrong with a file."""

from pathlib import Path
from typing import Any

import pytest
import typer

from service.cli.sweep_file import read_request
from service.client import Client
from tests.service.cli.conftest import Command


def read(tmp_path: Path, content: str) -> dict[str, Any]:
    file = tmp_path / "sweep.yaml"
    file.write_text(content, encoding="utf-8")
    return read_request(file)


def test_a_request_is_read_as_it_stands(tmp_path: Path) -> None:
    assert read(tmp_path, "name: é [b]\nseeds: [1, 2]\n") == {"name": "é [b]", "seeds": [1, 2]}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-4", 1e-4),
        ("1E4", 10_000),
        ("-2e3", -2000),
        ("1e300", 1e300),
        ("1e-400", 0),
        ("2.0e4", 20_000.0),
        ("-2.5e3", -2500.0),
        ("+1.e+2", 100.0),
        (".5", 0.5),
        ("-.inf", float("-inf")),
        ("1_000.5", 1000.5),
        ("20_000", 20_000),
        ("-3", -3),
        ("010", 10),
        ("0x1F", 31),
        ("0o17", 15),
        ("true", True),
        ("null", None),
        ("", None),
        ("1:30", "1:30"),
        ("2026-11-29", "2026-11-29"),
        ("no", "no"),
        ("e4", "e4"),
        ("1e", "1e"),
        ("'1e-4'", "1e-4"),
    ],
)
def test_a_scalar_is_what_it_looks_like(tmp_path: Path, text: str, value: object) -> None:
    found = read(tmp_path, f"a: {text}\n")["a"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    "content", ["seeds: 1\nname: x\nseeds: 2\n", "a: [{w1: 1,\n w1: 2}]", "a: 1\n'a': 2"]
)
def test_a_key_that_is_there_twice_is_refused(tmp_path: Path, content: str) -> None:
    with pytest.raises(typer.BadParameter, match=r"appears twice, first in line 1"):
        read(tmp_path, content)


def test_what_stands_twice_may_be_named(tmp_path: Path) -> None:
    found = read(tmp_path, "a: &usual {noise: 1e-1}\nb: {<<: *usual, gamma: 0.9}\n")
    assert found["b"] == {"noise": 0.1, "gamma": 0.9}


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("a: [", "not YAML"),
        (f"a: {'9' * 5000}", "not YAML"),
        ("- 1\n", "must hold a mapping"),
    ],
)
def test_a_bad_file_is_refused_by_name(tmp_path: Path, content: str, reason: str) -> None:
    with pytest.raises(typer.BadParameter, match=f"sweep.yaml.*{reason}"):
        read(tmp_path, content)


def test_a_missing_file_is_refused() -> None:
    with pytest.raises(typer.BadParameter, match=r"cannot read nowhere\.yaml"):
        read_request(Path("nowhere.yaml"))


def test_a_small_number_reaches_the_service(d3pg: Command, service: Client) -> None:
    content = (
        "algorithms: [{name: hybrid-ddpg, weights: {w1: 1e-3, w2: 0}, config: {noise: 2e-1}}]\n"
        "environments: [Pendulum]\nseeds: 1\ntimesteps: 8e2\n"
    )
    d3pg("submit", "-", stdin=content)
    [sweep] = service.sweeps()
    [run] = service.runs(sweep.id)
    assert (run.weights.w1, run.config["noise"], run.timesteps) == (1e-3, 0.2, 800)


def test_a_request_that_contains_itself_is_refused(d3pg: Command, service: Client) -> None:
    said = d3pg("submit", "-", code=1, stdin="algorithms: &all [*all]\n")
    assert str(said.exception) == "The request contains itself."
    assert list(service.sweeps()) == []


def test_what_json_cannot_say_is_told_all_at_once(d3pg: Command, service: Client) -> None:
    content = (
        "algorithms: [{name: ddpg, config: {noise: .nan}}]\nenvironments: [Pendulum]\n"
        "seeds: 1\ntimesteps: .inf\n"
    )
    said = str(d3pg("submit", "-", code=1, stdin=content).exception)
    assert said.splitlines() == [
        "2 things are wrong:",
        "  algorithms[0].config.noise: is nan, where a finite number is expected",
        "  timesteps: is inf, where a finite number is expected",
    ]
    flag = d3pg("submit", "-a", "hybrid-ddpg:nan,0", "-e", "Pendulum", code=1)
    assert str(flag.exception) == (
        "algorithms[0].weights.w1: is nan, where a finite number is expected"
    )
    assert list(service.sweeps()) == []
