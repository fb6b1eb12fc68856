"""A plan: a sweep before it is stored. Its cells (curves) times its seeds are the runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from service.model.environment import environment_facts
from service.model.inquiry.search import Search
from service.model.request.entry import Entry
from workers.messages.run_spec import RunSpec


@dataclass(frozen=True)
class Plan:
    """A sweep before it is stored.

    cells    one spec per curve; its seed is the first one
    entries  what the cells are of
    seeds    of every cell
    notices  for the author of the submission
    search   that it is to make; its cells are as long as on the first rung
    """

    cells: tuple[RunSpec, ...]
    entries: tuple[Entry, ...]
    seeds: Sequence[int]
    notices: tuple[str, ...]
    search: Search | None = None

    @property
    def runs(self) -> int:
        """How many runs there will be."""
        return len(self.cells) * len(self.seeds)

    @property
    def timesteps(self) -> int:
        """Environment steps of all runs together."""
        if self.search is not None:
            return self.search.timesteps
        return sum(cell.timesteps for cell in self.cells) * len(self.seeds)

    @property
    def costed(self) -> tuple[RunSpec, ...]:
        """The cells with the final timesteps of their runs; in a search, on average."""
        begun = sum(cell.timesteps for cell in self.cells) * len(self.seeds)
        return tuple(
            replace(cell, timesteps=cell.timesteps * self.timesteps // begun) for cell in self.cells
        )

    @property
    def algorithms(self) -> frozenset[str]:
        """Their names."""
        return frozenset(cell.algorithm for cell in self.cells)

    @property
    def environment_versions(self) -> Mapping[str, int]:
        """The version of each environment's numbers."""
        names = {cell.environment for cell in self.cells}
        return {name: environment_facts(name).version for name in names}

    def specs(self) -> list[RunSpec]:
        """Every run; runs of a cell follow each other, since they are trained together."""
        return [replace(cell, seed=seed) for cell in self.cells for seed in self.seeds]

    def places(self) -> list[int]:
        """The place of each run's entry."""
        return [entry.place for entry in self.entries for _ in self.seeds]

    @property
    def product(self) -> str:
        """`3 x 2 x 16 seeds = 96 runs`: entries, tasks, seeds; `5 curves x ...` of no product."""
        entries = len({entry.place for entry in self.entries})
        tasks = len({cell.environment for cell in self.cells})
        curves = len(self.cells)
        factors = f"{entries} x {tasks}" if curves == entries * tasks else f"{curves} curves"
        seeds = "1 seed" if len(self.seeds) == 1 else f"{len(self.seeds):,} seeds"
        return f"{factors} x {seeds} = {self.runs:,} run{'' if self.runs == 1 else 's'}"
