"""The subject of curves, tables, statistics and figures: a sweep, or several sweeps as one.

With several sweeps, the name of an entry says which sweep it belongs to, and runs of equal seed in
equal tasks are pairs, as within one sweep.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from service.model.request.entry import Entries, Entry
from service.model.run_curve import RunCurve
from service.model.sweep import Sweep

SEPARATOR = "+"
"""Between the ids of several sweeps."""


class Compared:
    """One or more sweeps.

    Attributes:
        id: their ids, joined.
        name: their names, as a title.
        sweeps: themselves, at least one.
        timesteps: that their runs have trained, together.
        entries: of all of them; `RunCurve.entry` of `joined` is a place among these.
    """

    def __init__(self, sweeps: Sequence[Sweep]) -> None:
        """Compare sweeps; there is at least one, and each is in it once."""
        self.sweeps = tuple(sweeps)
        self.id = SEPARATOR.join(sweep.id for sweep in sweeps)
        self.timesteps = sum(sweep.timesteps for sweep in sweeps)
        self.name = " and ".join(sweep.name for sweep in sweeps)
        self._own = [Entries(sweep.request) for sweep in sweeps]
        self.entries = self._own[0] if len(sweeps) == 1 else Entries.of_all(self._labelled())

    def joined(self, runs: Sequence[Sequence[RunCurve]]) -> list[RunCurve]:
        """Return the runs of each sweep as runs of all.

        Raises ValueError where a task has changed between two of them: returns of its versions
        cannot be compared.
        """
        together: list[RunCurve] = []
        first = 0
        for own, entries in zip(runs, self._own, strict=True):
            together += [replace(run, entry=first + run.entry) for run in own] if first else own
            first += len(entries.all)
        if len(self.sweeps) > 1:
            _refuse_other_versions(together)
        return together

    def _labelled(self) -> list[Entry]:
        """The entries of all, each under a label that says whose it is."""
        names = Counter(sweep.name for sweep in self.sweeps)
        entries: list[Entry] = []
        for sweep, own in zip(self.sweeps, self._own, strict=True):
            whose = sweep.name if names[sweep.name] == 1 else f"{sweep.name} ({sweep.id})"
            first = len(entries)
            entries += [
                replace(each, place=first + each.place, label=f"{each.label} · {whose}")
                for each in own.all
            ]
        return entries


def _refuse_other_versions(runs: Sequence[RunCurve]) -> None:
    """Raise ValueError for tasks that are there in several versions."""
    versions: dict[str, set[int]] = {}
    for run in runs:
        versions.setdefault(run.spec.environment, set()).add(run.environment_version)
    changed = [task for task, known in versions.items() if len(known) > 1]
    if changed:
        raise ValueError(
            f"{', '.join(changed)} changed between these sweeps, and returns of two versions of a "
            "task cannot be compared: submit the older sweep again"
        )
