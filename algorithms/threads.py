"""Threads: limits the libraries that multiply matrices to one thread.

A product's bits may depend on the number of threads, a worker has one core, and a run's seconds are
those of one thread. The libraries are the BLAS of the compiled products, and torch, for tasks that
are written in it.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import scipy.linalg.cython_blas  # noqa: F401  (loads the BLAS that numba's np.dot calls)
from threadpoolctl import ThreadpoolController

_LIBRARIES = ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Within this context, linear algebra uses one thread."""
    with _LIBRARIES.limit(limits=1, user_api="blas"), _one_torch_thread():
        yield


@contextmanager
def _one_torch_thread() -> Iterator[None]:
    """The same for torch, if it has been loaded: tasks written in numba do not need it."""
    torch = sys.modules.get("torch")
    if torch is None:
        yield
        return
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
