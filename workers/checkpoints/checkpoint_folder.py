"""The files of checkpoints, and which of them are removed when a run has ended.

What was learned stays: at the end, and on MassPoint as of the epochs that figure 2 shows. An epoch
is the time between two measurements.
"""

import re

from workers.checkpoints.folder import Folder
from workers.checkpoints.place import Place, folder_in

POLICY = "policy"
"""What was learned; it outlives the checkpoints."""
SURFACE_TASK = "MassPoint"
"""The one task whose critic is a surface that can be looked at."""
EPOCHS = (1, 10, 75)
"""After which figure 2 shows the critic."""
NAME = re.compile(r"(?P<attempt>\d+)(-(?P<timestep>\d+)\.checkpoint|\.journal)")
"""A checkpoint or a journal, finished or not."""


def epoch_file(epoch: int) -> str:
    """The name of what was learned as of the end of an epoch, from 1 on."""
    return f"{POLICY}-epoch-{epoch}"


def newest_first(folder: Folder) -> list[str]:
    """The checkpoints: of later attempts, then of later timesteps first. Raises OSError."""
    found = [
        (int(named["attempt"]), int(named["timestep"]), name)
        for name in folder.names()
        if (named := NAME.fullmatch(name)) and named["timestep"]
    ]
    return [name for *_, name in sorted(found, reverse=True)]


def has_policy(place: Place, run_id: str) -> bool:
    """Whether what a run has learned was written.

    Raises ValueError for a name that is none, OSError.
    """
    return POLICY in folder_in(place, run_id).names()


def remove_checkpoints(place: Place, run_id: str) -> None:
    """Remove the checkpoints of a run that has ended; what it learned stays. Raises OSError."""
    folder_in(place, run_id).remove(_is_of_checkpoints)


def size_of_checkpoints(place: Place, run_id: str) -> int:
    """Bytes of a run's checkpoints. Raises OSError."""
    folder = folder_in(place, run_id)
    return sum(folder.size(name) for name in filter(_is_of_checkpoints, folder.names()))


def remove_policies(place: Place, run_id: str) -> int:
    """Remove what a run has learned, and return its bytes. Raises OSError."""
    folder = folder_in(place, run_id)
    learned = [name for name in folder.names() if not _is_of_checkpoints(name)]
    size = sum(map(folder.size, learned))
    folder.remove(lambda name: name in learned)
    return size


def remove_all(place: Place, run_id: str) -> None:
    """Remove every file of a run that was deleted. Raises OSError."""
    folder_in(place, run_id).remove(lambda _: True)


def _is_of_checkpoints(name: str) -> bool:
    return not name.startswith(POLICY)
