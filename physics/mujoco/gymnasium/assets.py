"""Assets: the models that come with Gymnasium."""

from importlib.metadata import distribution
from pathlib import Path


def asset(name: str) -> Path:
    """The MJCF file of that name; Gymnasium itself is not imported."""
    files = distribution("gymnasium")
    return Path(str(files.locate_file(f"gymnasium/envs/mujoco/assets/{name}")))
