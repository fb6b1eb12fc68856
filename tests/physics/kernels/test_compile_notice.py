"""Compiling is told of where it happens, and nowhere else."""

import re
import time
from collections.abc import Iterator
from typing import Any

import numba
import pytest
from numba.core import event

from physics.kernels.cache import WAITING
from physics.kernels.compile_notice import compile_notice, noticed


def test_each_kernel_compiled_is_a_dot_and_the_second_use_is_silent(
    capsys: pytest.CaptureFixture[str],
) -> None:
    double: Any = numba.njit(lambda x: 2.0 * x)
    with compile_notice("a test"):
        double(1.0)
        double(1)
    line = r"compiling kernels for a test \(once on this machine\) \.\. \d+\.\d s\n"
    captured = capsys.readouterr()
    assert re.fullmatch(line, captured.err)
    assert captured.out == ""
    with compile_notice("a test"):
        double(1.0)
    double("outside, a third kernel".count("k"))
    assert capsys.readouterr().err == ""


def test_waiting_for_another_process_is_told_as_compiling(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with compile_notice("a test"):
        with event.trigger_event(WAITING):
            pass
        with event.trigger_event(WAITING):
            pass
    assert re.fullmatch(
        r"compiling kernels for a test .* \.\. \d+\.\d s\n", capsys.readouterr().err
    )


def test_items_pass_and_only_their_making_is_watched(capsys: pytest.CaptureFixture[str]) -> None:
    half: Any = numba.njit(lambda x: x / 2.0)

    def values() -> Iterator[float]:
        yield 1.0
        yield half(3.0)

    watched = noticed(values(), "values")
    assert next(watched) == 1.0
    half(2)  # the consumer's own
    assert capsys.readouterr().err == ""
    assert list(watched) == [1.5]
    assert capsys.readouterr().err.startswith("compiling kernels for values ")


def test_an_error_passes_through(capsys: pytest.CaptureFixture[str]) -> None:
    def failing() -> Iterator[float]:
        yield 1.0
        raise ValueError("as it was")

    with pytest.raises(ValueError, match="as it was"):
        list(noticed(failing(), "values"))
    assert capsys.readouterr().err == ""


def test_the_seconds_are_those_of_compiling_alone(capsys: pytest.CaptureFixture[str]) -> None:
    """A kernel compiles its callee within itself: its seconds count once, other work not at all."""
    inner: Any = numba.njit(lambda x: x + 1.0)
    outer: Any = numba.njit(lambda x: inner(x) * 2.0)
    before = time.perf_counter()
    with compile_notice("a test"):
        outer(1.0)
        compiled = time.perf_counter() - before
        while time.perf_counter() - before < compiled + 0.5:
            pass
    line = re.fullmatch(r".* \.\. (\d+\.\d) s\n", capsys.readouterr().err)
    assert line
    assert float(line[1]) <= compiled + 0.05  # as rounded
