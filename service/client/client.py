"""The client: every call of the service."""

from __future__ import annotations

from typing import Literal

from service.api.schemas.readiness_answer import ReadinessAnswer
from service.client.learned import Learned
from service.client.measurements import Measurements
from service.client.moves import Moves
from service.client.people import People
from service.client.results import Results
from service.client.runs import Runs
from service.client.sweeps import Sweeps


class Client(Sweeps, Runs, Moves, Measurements, Results, Learned, People):
    """A connection to one service; usable as a context manager.

    Every method that calls the service raises `ServiceError` if the service refuses the call or
    does not answer.

    Attributes:
        url: the service's address.
        token: the access token.
    """

    def catalogue_names(self, kind: Literal["algorithms", "environments"]) -> dict[str, str]:
        """The names of the algorithms or of the tasks, each with its summary, if there is one."""
        listed = self._call("GET", "/catalogue").json()[kind]
        return {each["name"]: str(each.get("summary", "")) for each in listed}

    def readiness(self) -> ReadinessAnswer:
        """The state of database and cluster (`/readyz`), whether they are ready or not."""
        answer = self._call("GET", "/readyz", allowed=(503,), prefix="")
        return ReadinessAnswer.model_validate_json(answer.content)
