"""Why what a run has learned cannot be used, as sentences."""

from service.model.environment import environment_facts
from service.model.run import Run


def other_version(run: Run) -> str:
    """Say that a run learned in another version of its task; empty where it did not."""
    now = environment_facts(run.spec.environment).version
    if now == run.environment_version:
        return ""
    return (
        f"Run {run.id} learned in version {run.environment_version} of {run.spec.environment}; "
        f"this service has version {now}."
    )


def no_policy(run: Run) -> str:
    """Say that a run has written no policy."""
    return (
        f"Run {run.id} ({run.status}) has no policy: one is written with every checkpoint and "
        "at the end, and mpc, which plans, learns none."
    )
