"""`d3pg ask`: the question that it posts, the answer that it prints, its exit code."""

import os
from collections.abc import Iterator
from typing import Any

import pytest

from service.api.schemas.question.verdict_answer import VerdictAnswer
from service.cli.asking import NO, UNDECIDED, YES, exit_code, sides_of
from service.client import Client
from service.queue.question_rounds import look_at_all
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.training import RANDOM, at_work, random_return, train
from workers.messages.run_spec import RunSpec

ASKED = ("-e", "Pendulum", "--clip", "0.25", "--timesteps", "800")


def gain(spec: RunSpec, _: int) -> float:
    """hybrid-ddpg is better by 0.2, td3 worse by as much."""
    gains = {"hybrid-ddpg": 0.2, "td3": -0.2}
    return RANDOM * (0.5 - gains.get(spec.algorithm, 0.0))


@pytest.fixture
def _trained(store: Store) -> Iterator[None]:
    """Workers, and the rounds of questions."""
    store.record_random_return(random_return("Pendulum", RANDOM))

    def work() -> None:
        train(store, 1, gain)
        look_at_all(store)

    with at_work(work):
        yield


@pytest.mark.usefixtures("_trained")
def test_it_waits_for_the_answer_and_exits_by_it(d3pg: Command, service: Client) -> None:
    said = d3pg("ask", "hybrid-ddpg vs ddpg", *ASKED).stdout
    assert "Note: The question adds seeds until it is decided: the 16 runs may become 256." in said
    assert "Pendulum: hybrid-ddpg vs ddpg: better by 0." in said
    assert "Waudby-Smith and Ramdas" in said
    [sweep] = service.sweeps()
    assert sweep.name == "hybrid-ddpg vs ddpg"
    shown = d3pg("show", sweep.id).stdout
    assert "Pendulum: hybrid-ddpg vs ddpg: better by 0." in shown


@pytest.mark.usefixtures("_trained")
def test_no_and_not_decided_have_codes_of_their_own(d3pg: Command) -> None:
    answer = as_json(d3pg("ask", "hybrid-ddpg and td3 vs ddpg", *ASKED, "--json", code=NO))
    assert {each["label"]: each["outcome"] for each in answer["comparisons"]} == {
        "hybrid-ddpg": "better",
        "td3": "worse",
    }
    d3pg("ask", "sac vs ddpg", *ASKED, "--max-seeds", "8", "--json", code=UNDECIDED)


@pytest.mark.usefixtures("_trained")
def test_weights_tell_entries_apart(d3pg: Command) -> None:
    question = "hybrid-ddpg:1,0 vs hybrid-ddpg:0.1,0"
    answer = as_json(d3pg("ask", question, *ASKED, "--max-seeds", "8", "--json", code=UNDECIDED))
    [only] = answer["comparisons"]
    assert (only["label"], only["against"]) == ("hybrid-ddpg w1=1", "hybrid-ddpg w1=0.1")


@pytest.mark.parametrize("question", ["ddpg", "vs ddpg", "a vs b vs c", "a vs ", "a and  vs b"])
def test_what_is_no_question_is_refused(d3pg: Command, question: str) -> None:
    refused = d3pg("ask", question, *ASKED, code=os.EX_USAGE)
    assert "is not a question" in refused.stderr


def test_a_grid_can_be_asked_about_but_not_compared_with(d3pg: Command, service: Client) -> None:
    refused = d3pg("ask", "sac vs ddpg:noise=0.1,0.2", *ASKED, code=os.EX_USAGE)
    assert "is a grid: compare with one learner" in refused.stderr
    asked = ("ask", "ddpg:noise=0.1,0.2 vs sac", "-e", "Pendulum", "--margin", "1.5")
    assert "question.margin" in d3pg(*asked, code=os.EX_DATAERR).stderr
    assert list(service.sweeps()) == []


@pytest.mark.parametrize(
    "arguments", [(), ("ddpg vs sac",), ("ddpg vs sac", *ASKED, "--margin", "x"), ("--looks", "3")]
)
def test_a_wrong_call_is_no_answer(d3pg: Command, arguments: tuple[str, ...]) -> None:
    assert d3pg("ask", *arguments, code=os.EX_USAGE).stderr
    d3pg("show", "--looks", "3", code=2)  # a command without answers


def test_no_service_is_no_answer(d3pg: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("D3PG_URL", "http://127.0.0.1:1")
    said = d3pg("ask", "sac vs ddpg", *ASKED, code=os.EX_UNAVAILABLE).stderr
    assert "No service answers" in said


def test_a_fault_of_our_own_is_no_answer(d3pg: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.cli.asking.exit_code", lambda _: 1 // 0)
    monkeypatch.setattr("service.cli.asking.follow", lambda *_: 0)
    said = d3pg("ask", "sac vs ddpg", *ASKED, code=os.EX_SOFTWARE).stderr
    assert "ZeroDivisionError" in said


def test_the_sides_of_a_question() -> None:
    assert sides_of("a:1,0 and c vs b") == (["a:1,0", "c"], "b")


@pytest.mark.parametrize(
    ("outcomes", "code"),
    [
        (["better", "equivalent"], YES),
        (["equivalent"], NO),
        (["better", "worse"], NO),
        (["worse", "undecided"], NO),
        (["better", "undecided"], UNDECIDED),
        (["better", "stalled"], UNDECIDED),
        ([], UNDECIDED),
    ],
)
def test_the_code_follows_from_the_outcomes(outcomes: list[Any], code: int) -> None:
    (example,) = VerdictAnswer.model_config["json_schema_extra"]["examples"]  # type: ignore
    document: Any = example
    [one] = document["comparisons"]
    comparisons = [{**one, "outcome": outcome} for outcome in outcomes]
    verdict = VerdictAnswer.model_validate({**document, "comparisons": comparisons})
    assert exit_code(verdict) == code
