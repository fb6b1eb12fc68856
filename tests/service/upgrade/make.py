"""Makes the fixture of this version: its data directory as a service leaves it that was killed.

    python -m tests.service.upgrade.make tests/service/upgrade/NAME.tar.xz

Two runs have ended, with their policies; one was half trained and is still its worker's. Beside the
data lies what must be found again: `expected.json`.
"""

import json
import sys
import tarfile
import tempfile
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from service.model.run import Run
from service.settings import Settings
from service.store.store import Store
from workers.messages.run_spec import RunSpec
from workers.policies.rollout import rollout
from workers.training import cadence
from workers.training.execute import execute

LEASE_SECONDS = 60.0
SMALL = {"hidden_units": 8}
START = 7
"""The seed of the state that policies are played from."""


def main(file: Path) -> None:
    cadence.SHORTEST_SECONDS, cadence.SHARE = 0.0, 1.0  # a checkpoint as often as one can be
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data_dir=Path(folder) / "data")
        settings.data_dir.mkdir(mode=0o700)
        with closing(Store.open(settings.store_url)) as store:
            expected = fill(store, settings)
        (Path(folder) / "expected.json").write_text(json.dumps(expected, indent=1))
        with tarfile.open(file, "w:xz") as archive:
            for name in ("data", "expected.json"):
                archive.add(Path(folder) / name, name)


def fill(store: Store, settings: Settings) -> dict[str, Any]:
    """Train one sweep to its end and another half, and return what there is then."""
    ended = submitted(store, "ended", seeds=2, timesteps=800)
    trained(store, settings, timesteps=800)
    half = submitted(store, "half trained", seeds=1, timesteps=2400)
    trained(store, settings, timesteps=1600)
    runs = [run for sweep in (ended, half) for run in store.list_runs(sweep)]
    return {
        "ended": ended,
        "half": half,
        "statuses": {run.id: run.status for run in runs},
        "measurements": {
            run.id: [asdict(point) for point in store.measurements(run.id)] for run in runs
        },
        "rewards": {run.id: played(settings, run) for run in runs},
    }


def submitted(store: Store, name: str, seeds: int, timesteps: int) -> str:
    specs = [
        RunSpec("ddpg", "MassPoint", seed, timesteps=timesteps, config=SMALL)
        for seed in range(seeds)
    ]
    request = {
        "name": name,
        "algorithms": [{"name": "ddpg", "config": SMALL}],
        "environments": ["MassPoint"],
        "seeds": seeds,
        "timesteps": timesteps,
    }
    versions = {"MassPoint": 1}
    return store.create_sweep(name, 0, request, specs, environment_versions=versions).id


def trained(store: Store, settings: Settings, timesteps: int) -> None:
    """Train what is queued until a checkpoint of so many timesteps is recorded."""
    claim = store.claim_cohort("worker-1", LEASE_SECONDS)
    assert claim is not None
    progress = execute(
        claim.runs, settings.checkpoint_place, tuple, lambda: None, report_seconds=0.0
    )
    with closing(progress):
        for each in progress:
            store.record(claim, each)
            if any(written.timestep >= timesteps for written in each.checkpoints) and (
                timesteps < claim.specs[0].timesteps
            ):
                return


def played(settings: Settings, run: Run) -> list[float]:
    """Return the rewards of a rollout of what a run has learned."""
    played = rollout(settings.checkpoint_place, run.id, run.spec, None, START)
    assert played is not None
    rewards: list[float] = played["rewards"]
    return rewards


if __name__ == "__main__":
    main(Path(sys.argv[1]))
