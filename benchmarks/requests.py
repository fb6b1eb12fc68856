"""The service's limits on requests: a sweep of 10,000 runs, and its end with open streams.

The time of the sweep covers the whole path: an HTTP request arrives, is validated and expanded, is
durable in SQLite, and is answered; to hold: 5 s. The end is that of `d3pg serve` with a local Ray
of two workers, stopped by SIGTERM while 50 event streams are open; to hold: 5 s. The worst of
several rounds counts.
"""

import signal
import tempfile
import time
from pathlib import Path

from service.client import Client
from tests.end_to_end.running_service import running_service

ROUNDS = 3
STREAMS = 50
SWEEP = {
    "name": "10,000 runs",
    "algorithms": [
        {
            "name": "hybrid-ddpg",
            "weights": [{"w1": 0.01 * (place + 1), "w2": 0.01} for place in range(100)],
        }
    ],
    "environments": ["Pendulum"],
    "seeds": 100,
    "timesteps": 800,
}


def main() -> None:
    """Print both figures."""
    submissions, ends = [], []
    for _ in range(ROUNDS):
        with (
            tempfile.TemporaryDirectory(prefix="d3pg-") as folder,
            running_service(Path(folder)) as (service, client),
        ):
            submissions.append(submission_seconds(client))
            with service.open_streams(STREAMS):
                ends.append(service.stop(signal.SIGTERM))
    print(f"10,000 runs submitted over REST: {max(submissions):.2f} s (to hold: 5 s)")
    print(f"SIGTERM to the end, {STREAMS} streams open: {max(ends):.2f} s (to hold: 5 s)")


def submission_seconds(client: Client) -> float:
    """The seconds until the sweep is accepted."""
    begun = time.perf_counter()
    sweep = client.submit(SWEEP)
    seconds = time.perf_counter() - begun
    assert sweep.runs.total == 10_000
    client.move(sweep.id, "pause")  # otherwise two workers would train meanwhile
    return seconds


if __name__ == "__main__":
    main()
