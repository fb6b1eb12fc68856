"""Threads: the BLAS behind the compiled products runs on one, whoever else uses it.

A product's bits may depend on the number of threads, and a worker has one core.
"""

from contextlib import AbstractContextManager

import scipy.linalg.cython_blas  # noqa: F401  (loads the BLAS that numba's np.dot calls)
from threadpoolctl import ThreadpoolController

_LIBRARIES = ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Within this context, linear algebra uses one thread."""
    context: AbstractContextManager[object] = _LIBRARIES.limit(limits=1, user_api="blas")
    return context
