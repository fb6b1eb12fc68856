"""Training as the store sees it: claims, measurements of chosen values, ends."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from algorithms.measurement import Measurement
from service.client import Client
from service.store.store import Store
from tests.service.conftest import SWEEP
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec

EVERY = 800
RANDOM = -1200.0
Value = Callable[[RunSpec, int], float]


def rising(spec: RunSpec, timestep: int) -> float:
    """A return that rises, faster the greater the seed, and higher the longer the name."""
    return RANDOM + timestep * (1 + spec.seed) / 100 + 50 * len(spec.algorithm)


def train(store: Store, points: int, value: Value, *, finish: bool = True) -> int:
    """Claim every queued run and record `points` measurements of it; how many runs there were."""
    runs = 0
    while (claim := store.claim_cohort("worker", 60.0)) is not None:
        measurements = tuple(
            measured(spec, EVERY * (index + 1), value(spec, EVERY * (index + 1)))
            for spec in claim.specs
            for index in range(points)
        )
        finished = tuple(spec.seed for spec in claim.specs) if finish else ()
        store.record(claim, Progress(EVERY * points, measurements=measurements, finished=finished))
        runs += len(claim.runs)
    return runs


def trained_sweep(service: Client, store: Store) -> str:
    """Submit the sweep that tests share, train it to its end, and return its id."""
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    sweep = service.submit(SWEEP).id
    train(store, 5, rising)
    return sweep


def measured(spec: RunSpec, timestep: int, value: float) -> Measurement:
    """A measurement whose return_history is half its return_mean."""
    needs_jacobians = any(spec.weights)
    return Measurement(
        seed=spec.seed,
        timestep=timestep,
        return_mean=value,
        return_history=value / 2,
        updates=timestep // 2,
        jacobians=timestep if needs_jacobians else 0,
        seconds=timestep / 1000 + spec.seed / 100,
        diagnostics={"critic_loss": value * value},
        compile_seconds=0.25,
    )


def random_return(environment: str, mean: float) -> RandomReturn:
    """What random actions earn in the first version of an environment."""
    return RandomReturn(environment, 1, mean, low=mean - 10, high=mean + 10, episodes=1000)


@contextmanager
def at_work(work: Callable[[], object]) -> Iterator[None]:
    """Work again and again, on a thread of its own, until the end of the block."""
    is_over = threading.Event()

    def go_on() -> None:
        while not is_over.wait(0.01):
            work()

    thread = threading.Thread(target=go_on)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()
