"""Submitting from files and flags."""

import pytest
import typer

from service.cli.algorithm_option import algorithm_of
from service.cli.submitting import duration
from service.client import Client
from tests.service.cli.conftest import Command, as_json

YAML = (
    "name: é [b]\nalgorithms: [{name: ddpg}]\nenvironments: [Pendulum]\nseeds: 2\ntimesteps: 800\n"
)


def test_weights_stand_behind_a_colon() -> None:
    assert algorithm_of("ddpg") == {"name": "ddpg"}
    assert algorithm_of("hybrid-ddpg:0.1,0") == {
        "name": "hybrid-ddpg",
        "weights": {"w1": 0.1, "w2": 0.0},
    }
    with pytest.raises(typer.BadParameter, match="NAME:W1,W2"):
        algorithm_of("hybrid-ddpg:0.1")


def test_settings_and_grids_stand_behind_colons() -> None:
    assert algorithm_of("ddpg:noise=0.1,0.2:tau=1e-2:label=mine") == {
        "name": "ddpg",
        "config": {"noise": [0.1, 0.2], "tau": 0.01},
        "label": "mine",
    }
    assert algorithm_of("hybrid-sac:w1=0,1:w2=0.1:rate=1e-3,1e-4:zip=w1,rate") == {
        "name": "hybrid-sac",
        "weights": {"w1": [0, 1], "w2": 0.1},
        "config": {"rate": [0.001, 0.0001]},
        "zip": ["w1", "rate"],
    }
    assert algorithm_of("sac:temperature=learned") == {
        "name": "sac",
        "config": {"temperature": "learned"},
    }


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("ddpg:noise=1:noise=2", "names noise twice"),
        ("ddpg:1,2:w1=3", "names w1 twice"),
        ("ddpg:w1=3:1,2", "names weights twice"),
        ("ddpg:=3", "a value without a name"),
        ("ddpg:", "neither W1,W2 nor"),
    ],
)
def test_what_is_no_algorithm_says_how_to_write_one(text: str, says: str) -> None:
    with pytest.raises(typer.BadParameter, match=says) as refused:
        algorithm_of(text)
    assert "as in hybrid-ddpg:0.1,0.01" in str(refused.value)


def test_a_grid_of_flags(d3pg: Command) -> None:
    flags = ("-a", "ddpg:noise=0.1,0.2", "-e", "Pendulum", "--seeds", "0,5", "--scale", "0.1,0.2")
    said = d3pg("submit", *flags, "--dry-run").stdout
    assert "4 x 1 x 2 seeds = 8 runs, about" in said
    answer = as_json(d3pg("submit", *flags, "--tag", "a", "--notes", "n", "--json"))
    assert [entry["label"] for entry in answer["entries"]] == [
        "ddpg noise=0.1 scale=0.1",
        "ddpg noise=0.1 scale=0.2",
        "ddpg noise=0.2 scale=0.1",
        "ddpg noise=0.2 scale=0.2",
    ]
    assert (answer["tags"], answer["notes"], answer["request"]["seeds"]) == (["a"], "n", [0, 5])


@pytest.mark.parametrize(
    ("seconds", "text"), [(3.21, "3.2 s"), (59.9, "60 s"), (245, "4:05"), (3725, "1:02:05")]
)
def test_durations_in_words(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_a_file_whose_fields_flags_replace(d3pg: Command, service: Client) -> None:
    said = d3pg("submit", "-", "--seeds", "3", "--priority", "7", stdin=YAML).stdout
    (sweep,) = service.sweeps()
    assert said.splitlines()[0] == f"Sweep {sweep.id}: 3 runs queued."
    assert said.splitlines()[1] == f"{service.url}/sweeps/{sweep.id}"
    assert (sweep.name, sweep.priority, sweep.runs.queued) == ("é [b]", 7, 3)


def test_flags_alone(d3pg: Command) -> None:
    flags = ("-a", "ddpg", "-a", "hybrid-ddpg:0.1,0.01", "-e", "Pendulum", "-e", "MassPoint")
    answer = as_json(d3pg("submit", *flags, "--timesteps", "800", "--json"))
    assert answer["runs"]["queued"] == 4
    assert answer["request"]["algorithms"][1]["weights"] == {"w1": 0.1, "w2": 0.01}
    assert "at least --algorithm and" in d3pg("submit", "-a", "ddpg", code=2).stderr


def test_the_same_key_is_the_same_sweep(d3pg: Command, service: Client) -> None:
    for _ in range(2):
        d3pg("submit", "-", "--key", "figure 4", stdin=YAML)
    assert len(list(service.sweeps())) == 1


def test_a_dry_run_counts_and_estimates(d3pg: Command, service: Client) -> None:
    lines = d3pg("submit", "-", "--dry-run", stdin=YAML).stdout.splitlines()
    assert lines[1].split("\t")[:6] == ["Pendulum", "ddpg", "0", "0", "800", "2"]
    assert lines[2] == "2 runs, 1,600 timesteps; nothing was queued."
    assert "of one core" in lines[3]
    assert "on the 2 workers here" in lines[3]
    assert lines[5].startswith("1 x 1 x 2 seeds = 2 runs, about")
    assert as_json(d3pg("submit", "-", "--dry-run", "--json", stdin=YAML))["runs"]["total"] == 2
    assert list(service.sweeps()) == []


REPEATED = """
algorithms:
  - name: hybrid-ddpg
  - {name: hybrid-ddpg, weights: {w1: 1, w2: 0}}
environments: [MassPoint, MassPoint]
seeds: [0, 1, 0]
"""


def test_what_is_there_twice_is_refused_all_at_once(d3pg: Command, service: Client) -> None:
    """The preset written out: the same runs would be counted twice."""
    said = str(d3pg("submit", "-", code=1, stdin=REPEATED).exception)
    assert "3 things are wrong:" in said
    assert "algorithms[1]: is the same as algorithms[0] in MassPoint" in said
    assert "environments[1]: is the same as environments[0]" in said
    assert "seeds[2]: is the same as seeds[0]" in said
    assert list(service.sweeps()) == []


def test_a_hybrid_without_gradient_terms_is_noted(d3pg: Command) -> None:
    flags = ("-a", "ddpg", "-a", "hybrid-ddpg:0,0", "-e", "Pendulum", "--timesteps", "800")
    for more in ((), ("--dry-run",)):
        said = d3pg("submit", *flags, *more)
        assert "Note: algorithms[1] (hybrid-ddpg) has the weights (0, 0) in Pendulum" in said.stdout
        assert "It repeats algorithms[0]." in said.stdout
        assert said.stderr == ""
    [notice] = as_json(d3pg("submit", *flags, "--json"))["notices"]
    assert "it is ddpg, bit for bit" in notice
    clean = d3pg("submit", "-a", "hybrid-ddpg:0.1,0", "-e", "Pendulum", "--timesteps", "800")
    assert "Note:" not in clean.stdout
