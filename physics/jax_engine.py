"""JAX in float64, on the CPU and one thread; if it is missing, an error that says what to install.

A program's own configuration of JAX is not changed. JAX fixes the number of threads at its first
computation: this module must be imported before that.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["float64_on_cpu", "jax", "jnp"]

ONE_THREAD = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {ONE_THREAD}".strip()

try:
    import jax
    import jax.numpy as jnp
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "tasks of JAX functions need the package jax: pip install 'd3pg[jax]'", name="jax"
    ) from error


@contextmanager
def float64_on_cpu() -> Iterator[None]:
    """Compute in float64 on the CPU, whatever the program has configured."""
    with jax.enable_x64(True), jax.default_device(jax.devices("cpu")[0]):
        yield
