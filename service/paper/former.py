"""The complete sweeps in a folder of results, which need not be trained again.

A sweep is complete if provenance.json has the same request, every run of it reached its end or
diverged, and the present code trained them. So an evaluation outlives its database: the results of
complete sweeps are kept as they are, and the others are trained.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from service.paper.evaluation import row
from service.paper.measured import lines
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


NOTHING = Former({}, {}, [], [])


def whole_sweeps(folder: Path, requests: Iterable[Request]) -> list[Request]:
    """Return those sweeps that are complete in a folder."""
    evidence = _document(folder / "provenance.json").get("sweeps", {})
    return [request for request in requests if _is_whole(evidence.get(request["name"]), request)]


def former(folder: Path, requests: Sequence[Request]) -> Former:
    """Read the results of complete sweeps from a folder."""
    if not requests:
        return NOTHING
    names = {request["name"] for request in requests}
    cells = {cell for request in requests for cell in _cells(request)}
    tasks = {environment for environment, _ in cells}
    evidence = _document(folder / "provenance.json")["sweeps"]
    statistics = _document(folder / "statistics.json")
    return Former(
        {name: evidence[name] for name in names},
        {name: found for name, found in statistics.items() if name in names},
        [
            line
            for line in lines(folder / "scores.csv")
            if (line["environment"], row(line["algorithm"], json.loads(line["config"]))) in cells
        ],
        [line for line in lines(folder / "random-returns.csv") if line["environment"] in tasks],
    )


def _is_whole(evidence: Mapping[str, Any] | None, request: Request) -> bool:
    if evidence is None or evidence["request"] != request:
        return False
    runs = evidence["runs"]
    codes = {fingerprint["code"] for fingerprint in evidence["fingerprints"]}
    return runs["succeeded"] + runs["diverged"] == runs["total"] and codes == {code_hash()}


def _cells(request: Request) -> Iterator[tuple[str, str]]:
    """Yield the tasks and learners of a sweep; no two sweeps of the evaluation share one."""
    for algorithm in request["algorithms"]:
        learner = row(algorithm["name"], algorithm.get("config", {}))
        for environment in algorithm.get("environments", request["environments"]):
            yield environment, learner


def _document(file: Path) -> dict[str, Any]:
    """Read a JSON document; an empty one where there is none."""
    if not file.exists():
        return {}
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found
