"""The complete sweeps in a folder of results, which need not be trained again.

So an evaluation outlives its database and its machine: results of complete sweeps are kept as they
are, and the others are trained. A sweep is complete if all of this holds:

- provenance.json has the same request, whatever its priority, and every run of it has ended;
- its runs have the settings and weights that the presets have now;
- the present code trained them, unless the caller accepts any code: a change of it may leave the
  bits of a learner as they were. provenance.json says which code it was.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from algorithms.presets import completed, preset
from service.paper.evaluation import row
from service.paper.measured import lines
from workers.messages.run_spec import Weights
from workers.training.fingerprint import code_hash

Request = Mapping[str, Any]
Line = Mapping[str, str]


@dataclass(frozen=True)
class Former:
    """The results of some sweeps in a folder.

    Attributes:
        evidence: of provenance.json, by sweep.
        statistics: by sweep.
        scores: the lines of scores.csv.
        random_returns: the lines of random-returns.csv, of their tasks.
    """

    evidence: Mapping[str, Any]
    statistics: Mapping[str, Any]
    scores: Sequence[Line]
    random_returns: Sequence[Line]


class Learner(NamedTuple):
    """A learner in a task: its row, its weights and its settings, as text."""

    environment: str
    row: str
    weights: Weights
    settings: str


NOTHING = Former({}, {}, [], [])


def whole_sweeps(
    folder: Path, requests: Iterable[Request], *, any_code: bool = False
) -> list[Request]:
    """Return those sweeps that are complete in a folder."""
    evidence = _provenance(folder)
    scores = list(lines(folder / "scores.csv")) if evidence else []
    return [
        request
        for request in requests
        if _has_ended(evidence.get(request["name"]), request)
        and (any_code or _codes(evidence[request["name"]]) == {code_hash()})
        and {_learner_of(line) for line in _of(scores, [request])} <= set(_learners(request))
    ]


def former(folder: Path, requests: Sequence[Request]) -> Former:
    """Read the results of complete sweeps from a folder."""
    if not requests:
        return NOTHING
    names = {request["name"] for request in requests}
    tasks = {learner.environment for request in requests for learner in _learners(request)}
    evidence = _provenance(folder)
    statistics = _document(folder / "statistics.json")
    return Former(
        {name: evidence[name] for name in names},
        {name: found for name, found in statistics.items() if name in names},
        _of(lines(folder / "scores.csv"), requests),
        [line for line in lines(folder / "random-returns.csv") if line["environment"] in tasks],
    )


def _of(scores: Iterable[Line], requests: Iterable[Request]) -> list[Line]:
    """Return the lines of the tasks and rows of some sweeps; no two sweeps share one."""
    cells = {(each.environment, each.row) for request in requests for each in _learners(request)}
    found = ((line, _learner_of(line)) for line in scores)
    return [line for line, of in found if (of.environment, of.row) in cells]


def _provenance(folder: Path) -> dict[str, Any]:
    """Return the evidence of provenance.json, by sweep."""
    found: dict[str, Any] = _document(folder / "provenance.json").get("sweeps", {})
    return found


def _has_ended(evidence: Mapping[str, Any] | None, request: Request) -> bool:
    if evidence is None or _asked(evidence["request"]) != _asked(request):
        return False
    runs = evidence["runs"]
    return bool(
        runs["total"] == sum(runs[status] for status in ("succeeded", "diverged", "failed"))
    )


def _asked(request: Request) -> Request:
    """The request without its place in the queue, which changes no result."""
    return {name: value for name, value in request.items() if name != "priority"}


def _codes(evidence: Mapping[str, Any]) -> set[str]:
    return {fingerprint["code"] for fingerprint in evidence["fingerprints"]}


def _learners(request: Request) -> Iterator[Learner]:
    """Yield what a sweep trains, with the settings that the presets have now."""
    for algorithm in request["algorithms"]:
        name, stated = algorithm["name"], algorithm.get("config", {})
        for task in algorithm.get("environments", request["environments"]):
            given = algorithm.get("weights", preset(name, task).weights)
            for pair in given if isinstance(given, list) else [given]:
                weights = (pair["w1"], pair["w2"]) if isinstance(pair, Mapping) else pair
                yield _learner(task, name, completed(name, task, stated), *weights)


def _learner_of(line: Line) -> Learner:
    config = json.loads(line["config"])
    return _learner(line["environment"], line["algorithm"], config, line["w1"], line["w2"])


def _learner(
    task: str, algorithm: str, config: Mapping[str, Any], w1: float | str, w2: float | str
) -> Learner:
    settings = json.dumps(config, sort_keys=True)
    return Learner(task, row(algorithm, config), Weights(float(w1), float(w2)), settings)


def _document(file: Path) -> dict[str, Any]:
    """Read a JSON document; an empty one where there is none."""
    if not file.exists():
        return {}
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found
