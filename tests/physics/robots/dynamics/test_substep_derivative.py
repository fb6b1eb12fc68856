"""The derivative of contact where it is known by hand, and on robots other than the cheetah."""

from typing import Any

import pytest


def test_sliding_takes_the_transposed_operator(other_robots: dict[str, Any]) -> None:
    """A unit mass slides at mu = 0.3, momentum p: `vx' = px + 0.3 pz`, for friction takes 0.3 pn.

    With the untransposed operator the second derivative comes out as 0 (a published defect).
    """
    assert other_robots["ahead"] == pytest.approx([1.0, 0.3], abs=1e-12)
    assert other_robots["back"] == pytest.approx([1.0, -0.3], abs=1e-12)


def test_a_new_robot_is_a_description(other_robots: dict[str, Any]) -> None:
    hop = other_robots["hop"]
    assert hop["worst"] < 1e-6
    assert hop["residual"] < 1e-11
    assert hop["compared"] > 30
    assert hop["contacts"] > 10
