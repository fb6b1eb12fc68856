"""Something that changed, in the order it was committed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Event:
    """One change.

    kind     "sweep" (created, edited, cancelled, paused, resumed, retried), "run" (its status
             changed), "measurements" (runs have new ones), "diagnosis" (a run has one, or several
             are asked for) or "log" (a worker printed something)
    payload  always sweep_id; sweep: change; run: run_id, status, reason, attempt, timestep;
             measurements: run_ids, from, to (timesteps, both inclusive); diagnosis: run_id, where
             it is of one; log: run_ids, of those that the worker trains
    """

    id: int
    sweep_id: str
    kind: str
    payload: Mapping[str, Any]
    created_at: float
