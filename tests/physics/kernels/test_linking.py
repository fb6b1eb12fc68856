"""A kernel is one piece of machine code, whatever it calls and whoever called that before."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from physics.kernels.compiled import compiled, compiled_fast

MODULE = """
import sys

import numpy as np
from physics.kernels.compiled import compiled, compiled_fast

@compiled
def checked(x):
    if x < 0.0:
        raise ValueError("negative: no root")
    return np.sqrt(x)

@compiled_fast
def total(values):
    result = values.dtype.type(0)
    for i in range(values.size):
        result += values[i]
    return result

@compiled_fast
def mean_root(values):
    return checked(total(values) / values.size)

if __name__ == "__main__":
    values = np.random.default_rng(0).random(1_001).astype(np.float32)
    if "part first" in sys.argv:
        total(values)
        checked(1.0)
    print(mean_root(values).hex())
    try:
        mean_root(-values)
    except ValueError as error:
        print(error)
"""


@compiled
def square(x: float) -> float:
    return x * x


@compiled
def sum_of_squares(values: NDArray[np.float64]) -> float:
    total = 0.0
    for value in values:
        total += square(value)
    return total


@compiled_fast
def refuse(x: float) -> float:
    if x > 1.0:
        raise ValueError("above 1")
    return x


@compiled_fast
def outer(x: float) -> float:
    return refuse(x) + 1.0


def test_a_function_is_called_from_python_and_from_kernels() -> None:
    assert sum_of_squares(np.array([1.0, 2.0, 3.0])) == 14.0
    assert square(4.0) == 16.0
    assert sum_of_squares(np.array([2.0])) == 4.0


def test_what_a_part_raises_reaches_python() -> None:
    assert outer(1.0) == 2.0
    with pytest.raises(ValueError, match="above 1"):
        outer(2.0)


def test_bits_and_errors_are_the_same_compiled_and_cached_and_whatever_was_called_before(
    tmp_path: Path,
) -> None:
    file = tmp_path / "kernels.py"
    file.write_text(MODULE)

    def run(cache: str, *arguments: str) -> list[str]:
        environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / cache)}
        done = subprocess.run(
            [sys.executable, str(file), *arguments],
            env=environment, capture_output=True, text=True, check=True, cwd=os.getcwd(),
        )  # fmt: skip
        return done.stdout.splitlines()

    told = [run("one"), run("one"), run("two", "part first"), run("two", "part first"), run("two")]
    assert told[0][1] == "negative: no root"
    assert told == [told[0]] * 5
