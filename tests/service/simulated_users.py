"""Users of a simulated service: they submit, and change their minds at any moment."""

import random
from collections.abc import Callable
from typing import Any

from service.model.inquiry.search import Search, rungs_of
from service.model.move import Move
from service.model.run import FINAL, RunStatus
from service.store.refusal import ImpossibleMoveError, NotFoundError
from tests.service.promises import Promises, sweep_of
from workers.messages.run_spec import NO_WEIGHTS, RunSpec

MOST_ACTIVE = 12
QUESTION: dict[str, Any] = {
    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}],
    "environments": ["Pendulum"],
    "seeds": [3, 6],  # of which one diverges
    "question": {
        "compare": ["hybrid-ddpg"], "with": "ddpg", "score": "final", "margin": 0.3, "clip": 0.5,
        "batch": 2, "max_seeds": 10,
    },
}  # fmt: skip

SEARCH: dict[str, Any] = {
    "algorithms": [{"name": "ddpg", "config": {"noise": [0.1, 0.2, 0.3, 0.4, 0.5]}}],
    "environments": ["Pendulum"],
    "seeds": 2,
    "search": {"budget": 10**6, "reduction": 2},
}


class SimulatedUsers:
    """What each of them does may be impossible, and is then refused; returns whether it was done.

    `tell` is told what was.
    """

    def __init__(
        self,
        promises: Promises,
        draw: random.Random,
        raising: set[int],
        tell: Callable[[object], None],
    ) -> None:
        self.promises = promises
        self.store = promises.store
        self.models = promises.models
        self.random = draw
        self.raising = raising
        self.tell = tell

    def ask_question(self) -> bool:
        """A sweep that is given seeds until its question is answered."""
        if self.promises.active > MOST_ACTIVE:
            return False
        specs = [
            RunSpec(name, "Pendulum", seed, timesteps=self.promises.timesteps)
            for name in ("ddpg", "hybrid-ddpg")
            for seed in QUESTION["seeds"]
        ]
        sweep = self.store.create_sweep(
            "x", 0, QUESTION, specs, entries=[0, 0, 1, 1], environment_versions={"Pendulum": 1}
        )
        self.promises.add(sweep.id)
        return True

    def search(self) -> bool:
        """A sweep whose best entries are given timesteps; now and then its code raises."""
        if self.promises.active > MOST_ACTIVE:
            return False
        rungs = rungs_of(5, self.promises.timesteps, 2)
        seeds = (3, 6, *([min(self.raising)] if self.random.random() < 0.2 else []))
        search = Search(10**6, 2, "final", seeds, {"Pendulum": rungs})
        specs = [
            RunSpec("ddpg", "Pendulum", seed, NO_WEIGHTS, rungs[0].timesteps, {"noise": noise})
            for noise in SEARCH["algorithms"][0]["config"]["noise"]
            for seed in search.seeds
        ]
        places = [place for place in range(5) for _ in search.seeds]
        sweep = self.store.create_sweep(
            "x", 0, SEARCH, specs, entries=places, environment_versions={"Pendulum": 1},
            search=search,
        )  # fmt: skip
        self.promises.add(sweep.id)
        return True

    def submit(self) -> bool:
        """A small sweep; now and then one whose code raises."""
        if self.promises.active > MOST_ACTIVE:
            return False
        seeds = list(range(self.random.randint(1, 4)))
        seeds += sorted(self.raising) if self.random.random() < 0.2 else []
        specs = [
            RunSpec("ddpg", "Pendulum", seed, timesteps=self.promises.timesteps) for seed in seeds
        ]
        sweep = self.store.create_sweep(
            "x", self.random.randint(0, 1), {}, specs, environment_versions={"Pendulum": 1}
        )
        self.promises.add(sweep.id)
        return True

    def move_run(self) -> bool:
        """Cancel, pause, resume or retry a run, one that has ended too."""
        fitting: dict[Move, RunStatus] = {
            "cancel": RunStatus.RUNNING,
            "pause": RunStatus.QUEUED,
            "resume": RunStatus.PAUSED,
            "retry": RunStatus.FAILED,
            "uncancel": RunStatus.CANCELLED,
        }
        asked = self.random.choice(list(fitting))
        return self.ask(asked, self.any_run(fitting[asked]))

    def cancel_sweep(self) -> bool:
        """Cancel any sweep: none of its runs begins after that."""
        sweep_id = sweep_of(self.any_run(RunStatus.RUNNING))
        is_done = self.ask("cancel", sweep_id)
        self.promises.cancelled |= {sweep_id} if is_done else set()
        return is_done

    def pause_sweep(self) -> bool:
        """Pause any sweep: none of its runs begins until it is resumed."""
        sweep_id = sweep_of(self.any_run(RunStatus.RUNNING))
        is_done = self.ask("pause", sweep_id)
        self.promises.paused |= {sweep_id} if is_done else set()
        return is_done

    def resume_sweep(self, sweep_id: str | None = None) -> bool:
        """Resume any sweep."""
        sweep_id = sweep_id or sweep_of(self.any_run(RunStatus.PAUSED))
        is_done = self.ask("resume", sweep_id)
        self.promises.paused -= {sweep_id} if is_done else set()
        return is_done

    def retry_sweep(self) -> bool:
        """Have what failed in any sweep tried again."""
        sweep_id = sweep_of(self.any_run(RunStatus.FAILED))
        return self.ask("retry", sweep_id)

    def delete_sweep(self) -> bool:
        """Delete any sweep that has ended: nothing of it is seen or changed any more."""
        sweep_id = sweep_of(self.any_run(RunStatus.SUCCEEDED))
        own = self.promises.of(sweep_id)
        try:
            with self.promises.touching(set()):
                self.store.delete_sweep(sweep_id)
        except (ImpossibleMoveError, NotFoundError):
            return False
        for name in own:
            assert self.models.pop(name).status in FINAL
        self.tell(f"a client: delete {sweep_id}")
        return True

    def purge(self) -> bool:
        """Throw a part of what was deleted away."""
        with self.promises.touching(set()):
            gone = self.store.deleted_runs(1)
            if gone:
                self.store.purge_runs(gone)
            else:
                self.store.purge_sweep()
        return bool(gone)

    def any_run(self, fitting: RunStatus) -> str:
        """Any run; as often as not one for which what is asked for makes sense."""
        suited = [name for name, model in self.models.items() if model.status == fitting]
        names = suited if suited and self.random.random() < 0.5 else list(self.models)
        return self.random.choice(names) if names else "none-0"

    def resume_all(self) -> None:
        """Have nothing wait for its user."""
        for sweep_id in list(self.promises.paused):
            self.resume_sweep(sweep_id)
        for name in [name for name, m in self.models.items() if m.status == RunStatus.PAUSED]:
            self.ask("resume", name)

    def ask(self, asked: Move, name: str) -> bool:
        """Ask the store for a move as a client would, who is told where it is impossible."""
        is_run = "-" in name
        runs = {name} if is_run else self.promises.of(name)
        move = self.store.move_run if is_run else self.store.move_sweep
        try:
            with self.promises.touching(runs, asked=asked):
                move(name, asked)
        except (ImpossibleMoveError, NotFoundError):
            return False
        self.tell(f"a client: {asked} {name}")
        return True
