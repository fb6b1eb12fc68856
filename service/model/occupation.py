"""What workers do, and what waits for them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Training:
    """Runs of one entry in one task that a worker trains together.

    entry      the place of the entry in the sweep
    runs       how many they are; `first_run` is the id of the first
    since      when the worker claimed them, seconds since 1970
    timestep   of the run that has trained least
    """

    worker: str
    sweep_id: str
    sweep_name: str
    entry: int
    algorithm: str
    environment: str
    runs: int
    first_run: str
    since: float
    timestep: int
    timesteps: int


@dataclass(frozen=True)
class WaitingRuns:
    """Runs of one sweep that wait; `later` of them lost their worker and are tried again later."""

    sweep_id: str
    sweep_name: str
    priority: int
    runs: int
    later: int
    since: float
