"""`d3pg demo`: the whole system at once, for a first look.

Starts the service as a child process (embedded SQLite, a local Ray on two cores), waits until
it answers, submits the demo sweep (or goes on with one that was interrupted), prints the link
that signs a browser in, follows the training, and keeps the dashboard up until Ctrl-C.
"""

from __future__ import annotations

import json
from typing import Any

from service.cli.following import follow
from service.cli.host.own_service import data_dir, own_service
from service.cli.terminal import console, errors, say
from service.client import Client, has_ended

DEMO_SWEEP: dict[str, Any] = {
    "name": "demo",
    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg-robust"}],
    "environments": ["CartPole", "Pendulum"],
    "seeds": 4,
    "timesteps": 20_000,
}


def run(*, once: bool, as_json: bool) -> int:
    """Run the demo; return the exit code. Ctrl-C, or with `once` the end of the sweep, ends it."""
    told = errors if as_json else console
    told.print("Starting the service and a local Ray ...")
    try:
        with own_service() as (client, service):
            sweep_id = demo_sweep(client)
            link = client.sign_in_link(f"/sweeps/{sweep_id}").link
            if as_json:
                say(json.dumps({"sweep": sweep_id, "link": link}))
            else:
                told.print(f"\n  The curves, live:  {link}\n", soft_wrap=True)
            code = follow(client, sweep_id, console, as_json=as_json)
            if once:
                return code
            told.print("\nDone. The dashboard stays up until Ctrl-C.")
            return service.wait()
    except KeyboardInterrupt:
        return 0
    finally:
        kept = f"Stopped. Everything measured is kept in {data_dir()}/."
        told.print(kept, soft_wrap=True)


def demo_sweep(client: Client) -> str:
    """The id of the demo sweep to follow: an unfinished one, else a new one."""
    for sweep in client.sweeps():
        if sweep.name == DEMO_SWEEP["name"] and not has_ended(sweep):
            return sweep.id
    return client.submit(DEMO_SWEEP).id
