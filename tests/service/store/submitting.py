"""A process that submits sweeps, each under a key, and says so when they are durable.

`python -m tests.service.store.submitting URL SWEEPS RUNS`; a line a sweep: its key and "kept", or
"refused" and why. For tests that kill it or break its disk.
"""

import sys

from sqlalchemy.exc import SQLAlchemyError

from service.store.store import Store
from workers.messages.run_spec import RunSpec


def submit(store: Store, key: str, runs: int) -> str:
    specs = [RunSpec("ddpg", "Pendulum", seed) for seed in range(runs)]
    versions = {"Pendulum": 1}
    return store.create_sweep(
        key, 0, {}, specs, environment_versions=versions, submission_key=key
    ).id


def main() -> None:
    url, sweeps, runs = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    store = Store.open(url)
    for place in range(sweeps):
        try:
            submit(store, f"key-{place}", runs)
        except SQLAlchemyError as error:
            said = f"key-{place} refused {error.args[0]}"
        else:
            said = f"key-{place} kept"
        print(said, flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
