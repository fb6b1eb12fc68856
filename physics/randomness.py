"""Randomness: the one source of every random number of the project.

A generator is named by a seed, a purpose and an index. It is numpy's Philox with the first 128 bits
of SHA-256 of that name as its key: the same in every process and on every machine, and unrelated to
the generator of any other name. Nothing draws from a global generator.
"""

import hashlib
import operator

import numpy as np


def generator(seed: int, purpose: str, index: int = 0) -> np.random.Generator:
    """The generator of `(seed, purpose, index)`.

    Args:
        seed: any integer from 0 on, such as a run's seed.
        purpose: what is drawn, in words ("initial state").
        index: the number of the generator, where a purpose needs many (an episode's number).

    Raises:
        ValueError: for a seed or index that is negative or not an integer.
    """
    name = f"{purpose}\0{_natural(seed, 'seed')}\0{_natural(index, 'index')}"
    key = int.from_bytes(hashlib.sha256(name.encode()).digest()[:16], "little")
    return np.random.Generator(np.random.Philox(key=key))


def _natural(number: int, what: str) -> int:
    """`number` as a plain integer, refused when negative or fractional."""
    try:
        whole = operator.index(number)
    except TypeError:
        raise ValueError(f"{what} must be an integer from 0 on, not {number!r}") from None
    if whole < 0:
        raise ValueError(f"{what} must be an integer from 0 on, not {whole}")
    return whole
