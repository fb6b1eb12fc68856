"""The real service on a real port and a new database; a test plays the worker.

It can be stopped and started again on the same port and database, as a service that crashes is.
"""

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import uvicorn
from numpy.typing import NDArray
from pydantic import SecretStr
from sse_starlette.sse import AppStatus
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from algorithms.early_end import Divergence
from algorithms.measurement import Measurement
from service.api.access.links import signin_path
from service.api.access.register import Register
from service.api.app import create_app
from service.model.claim import Claim
from service.model.environment import environment_facts
from service.model.sweep import Sweep
from service.settings import Settings
from service.store.store import Store
from tests.end_to_end.running_service import free_port
from workers.messages.progress import Activity, Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec, Weights

Floats = NDArray[np.float64]

TOKEN = "token-of-the-tests-000000"  # noqa: S105
MEASURED_EVERY = 800
SHARE_OF_RANDOM = 0.3  # the random policy's return, as a share of the largest; an invention


@dataclass
class ReadyDispatcher:
    """A cluster that is ready, and trains nothing."""

    problem: str | None = None
    workers: dict[str, bool] = field(default_factory=dict)


@dataclass
class Trouble:
    """Stands before the service, notes what is asked and fails where a test says so."""

    app: ASGIApp
    failing: dict[str, int] = field(default_factory=dict)
    requests: list[str] = field(default_factory=list)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or fail."""
        path = scope.get("path", "")
        self.requests.append(path)
        if path in self.failing:
            problem = {"title": "Trouble", "detail": "The database is on holiday."}
            await JSONResponse(problem, self.failing[path])(scope, receive, send)
        else:
            await self.app(scope, receive, send)


class LiveService:
    """The service: where it listens, its store, and whether it runs at all."""

    def __init__(self, data_dir: Path, public_url: str = "") -> None:
        """Serve on a free port; a test may put a proxy before it."""
        self.settings = Settings(
            data_dir=data_dir, port=free_port(), token=SecretStr(TOKEN), public_url=public_url
        )
        self.url = self.settings.public.url
        self.store = Store.open(self.settings.store_url)
        self._claims: list[Claim] = []
        self.start()

    def start(self) -> None:
        """Serve; the port is the same every time."""
        self.dispatcher = ReadyDispatcher()
        app = create_app(self.settings, self.store, self.dispatcher)
        self.register: Register = app.state.register
        self.trouble = Trouble(app)
        config = uvicorn.Config(self.trouble, port=self.settings.port, log_level="critical")
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run)
        self._thread.start()
        while not self._server.started:
            time.sleep(0.01)

    @property
    def signin_link(self) -> str:
        """A link that signs in one browser."""
        return f"{self.url}{signin_path(self.register.new_code())}"

    def stop(self) -> None:
        """End the server and every connection to it."""
        AppStatus.should_exit = True  # what uvicorn's signal handlers would tell the streams
        self._server.should_exit = True
        self._thread.join()
        AppStatus.should_exit = False

    def close(self) -> None:
        """End everything."""
        self.stop()
        self.store.close()

    def measure_random(self, environment: str) -> None:
        """Give an environment its zero."""
        facts = environment_facts(environment)
        mean = random_return(environment)
        spread = 0.01 * abs(facts.best_return - mean)
        self.store.record_random_return(
            RandomReturn(environment, facts.version, mean, mean - spread, mean + spread, 1000)
        )

    def add_sweep(
        self,
        name: str = "first look",
        learners: Sequence[tuple[str, float, float]] = (
            ("ddpg", 0.0, 0.0),
            ("hybrid-ddpg", 0.1, 0.1),
        ),
        environments: Sequence[str] = ("MassPoint", "Pendulum"),
        seeds: int = 4,
        timesteps: int = 20_000,
    ) -> Sweep:
        """Queue a sweep of learners (algorithm, w1, w2), and measure its random returns."""
        for environment in environments:
            self.measure_random(environment)
        specs = [
            RunSpec(algorithm, environment, seed, Weights(w1, w2), timesteps)
            for environment in environments
            for algorithm, w1, w2 in learners
            for seed in range(seeds)
        ]
        request = {
            "name": name,
            "algorithms": [
                {"name": algorithm, "weights": {"w1": w1, "w2": w2}}
                for algorithm, w1, w2 in learners
            ],
            "environments": list(environments),
            "seeds": seeds,
            "timesteps": timesteps,
        }
        versions = {each: environment_facts(each).version for each in environments}
        entries = [
            place for _ in environments for place in range(len(learners)) for _ in range(seeds)
        ]
        return self.store.create_sweep(
            name, 0, request, specs, entries=entries, environment_versions=versions
        )

    def train(self, start: int, end: int) -> None:
        """Claim what is queued, and train every claimed run from one timestep to another."""
        while (claim := self.store.claim_cohort("test", lease_seconds=3600)) is not None:
            self._claims.append(claim)
        going_on = []
        for claim in self._claims:
            is_last = end >= claim.specs[0].timesteps
            finished = tuple(spec.seed for spec in claim.specs) if is_last else ()
            taken = tuple(m for spec in claim.specs for m in measurements(spec, start, end))
            self.store.record(claim, Progress(end, measurements=taken, finished=finished))
            if not is_last:
                going_on.append(claim)
        self._claims = going_on

    def diverge(self, seed: int) -> None:
        """Let that seed of the first claimed cohort diverge."""
        divergence = Divergence(seed, 9600, 4212, "critic_loss")
        claim = self._claims[0]
        self.store.record(claim, Progress(9600, diverged=(divergence,)))
        others = {run.run_id for run in claim.runs if run.spec.seed != seed}
        self._claims[0] = claim.only(others)

    def print(self, log_tail: str) -> None:
        """Let the worker of the first claimed cohort print; these are its last lines."""
        self.store.record(self._claims[0], Progress(0, Activity.COMPILING, log_tail=log_tail))

    def fail(self, error: str) -> None:
        """Let the last claimed cohort fail."""
        self.store.fail(self._claims.pop(), error)


def measurements(spec: RunSpec, start: int, end: int) -> list[Measurement]:
    """What a run measures after one timestep, up to and with another."""
    grid = np.arange(MEASURED_EVERY, spec.timesteps + 1, MEASURED_EVERY)
    normalized = learning_curve(spec, len(grid))
    best = environment_facts(spec.environment).best_return
    zero = random_return(spec.environment)
    returns = zero + (best - zero) * normalized
    history = [returns[max(0, i - 99) : i + 1].mean() for i in range(len(grid))]
    uses_jacobians = spec.algorithm.startswith("hybrid")
    return [
        Measurement(
            seed=spec.seed,
            timestep=int(step),
            return_mean=float(value),
            return_history=float(mean),
            updates=int(step) // 2,
            jacobians=32 * int(step) if uses_jacobians else 0,
            seconds=float(step) * (4e-3 + 1e-4 * spec.seed),
            diagnostics={"critic_loss": float(1.05 - share) ** 2},
            compile_seconds=0.25,
        )
        for step, value, mean, share in zip(grid, returns, history, normalized, strict=True)
        if start < step <= end
    ]


def random_return(environment: str) -> float:
    """An invented zero of the normalised scale: below the best by a fixed margin."""
    best = environment_facts(environment).best_return
    return SHARE_OF_RANDOM * best if best > 0 else best - 1225.4


def learning_curve(spec: RunSpec, points: int) -> Floats:
    """A plausible normalised return [points]: rises towards a plateau, hybrids sooner; noisy."""
    cell: list[Any] = [*spec.algorithm.encode(), *spec.environment.encode()]
    noise = np.random.default_rng([*cell, *(int(1000 * w) for w in spec.weights), spec.seed])
    pace = (0.16 if spec.algorithm.startswith("hybrid") else 0.08) * noise.uniform(0.8, 1.2)
    rise = (0.92 + 0.03 * noise.standard_normal()) * (1 - np.exp(-pace * np.arange(points)))
    wobble = np.convolve(noise.standard_normal(points + 4), np.ones(5) / 5, mode="valid")
    return np.asarray(rise + 0.08 * wobble)
