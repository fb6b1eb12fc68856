"""Where the checkpoints of a run lie, and what is removed of them when it has ended.

What was learned stays: at the end, and on MassPoint as of the epochs that figure 2 shows. An epoch
is the time between two measurements.
"""

import re
from pathlib import Path

POLICY = "policy"
"""What was learned; it outlives the checkpoints."""
EPOCHS = (1, 10, 75)
"""After which figure 2 shows the critic."""
NAME = re.compile(r"(?P<attempt>\d+)(-(?P<timestep>\d+)\.checkpoint|\.journal)")
"""A checkpoint or a journal, finished or not."""


def folder_of(root: Path, run_id: str) -> Path:
    """The folder of a run. Raises ValueError for a name that is none."""
    if not re.fullmatch(r"[\w-]+", run_id, re.ASCII):
        raise ValueError(f"a run's name is no path, got {run_id!r}")
    return root / run_id


def epoch_file(epoch: int) -> str:
    """The name of what was learned as of the end of an epoch, from 1 on."""
    return f"{POLICY}-epoch-{epoch}"


def newest_first(folder: Path) -> list[Path]:
    """The checkpoints: of later attempts, then of later timesteps first."""
    found = [
        (int(named["attempt"]), int(named["timestep"]), path)
        for path in folder.glob("*.checkpoint")
        if (named := NAME.fullmatch(path.name))
    ]
    return [path for *_, path in sorted(found, reverse=True)]


def has_policy(root: Path, run_id: str) -> bool:
    """Whether what a run has learned was written. Raises ValueError for a name that is none."""
    return (folder_of(root, run_id) / POLICY).exists()


def remove_checkpoints(root: Path, run_id: str) -> None:
    """Remove the checkpoints of a run that has ended; what it learned stays."""
    folder = folder_of(root, run_id)
    if folder.exists():
        for path in folder.iterdir():
            if not path.name.startswith(POLICY):
                path.unlink(missing_ok=True)
