"""The processor that a run was trained on; seconds of two processors cannot be compared."""

from collections.abc import Mapping
from typing import Any

UNKNOWN = ""
"""Of a run that has not reported yet, or that continued on another machine."""


def processor_of(fingerprint: Mapping[str, Any] | None) -> str:
    """Return LLVM's name of the processor that a run was trained on from beginning to end."""
    if fingerprint is None or fingerprint.get("mixed_with"):
        return UNKNOWN
    return str(fingerprint.get("processor", UNKNOWN))


def are_comparable(processor: str, other: str) -> bool:
    """Whether seconds of runs on these processors can be compared."""
    return processor == other != UNKNOWN
