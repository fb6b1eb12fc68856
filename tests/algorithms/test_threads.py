"""One thread: for the BLAS behind compiled products, and for torch behind torch's tasks."""

import subprocess
import sys
from collections.abc import Iterator

import pytest
import torch
from threadpoolctl import threadpool_info

from algorithms.threads import one_thread


@pytest.fixture(autouse=True)
def two_threads() -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(before)


def blas_threads() -> set[int]:
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


def test_within_it_both_have_one() -> None:
    before = blas_threads()
    with one_thread():
        assert (blas_threads(), torch.get_num_threads()) == ({1}, 1)
    assert (blas_threads(), torch.get_num_threads()) == (before, 2)


def fail() -> None:
    with one_thread():
        raise ZeroDivisionError


def test_threads_come_back_whatever_happens() -> None:
    before = blas_threads()
    with pytest.raises(ZeroDivisionError):
        fail()
    assert (blas_threads(), torch.get_num_threads()) == (before, 2)


def test_torch_is_not_loaded_for_it() -> None:
    code = (
        "import sys; from algorithms.threads import one_thread\n"
        "with one_thread(): print('torch' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "False\n"
