"""A sweep's request with what is added to it: more seeds, more entries, more timesteps."""

from collections.abc import Mapping, Sequence
from typing import Any

Json = Mapping[str, Any]


def seeds_of(request: Json) -> list[int]:
    """Return the seeds that a request asks for."""
    seeds = request["seeds"]
    return list(range(seeds)) if isinstance(seeds, int) else list(seeds)


def with_seeds(request: Json, seeds: Sequence[int]) -> dict[str, Any]:
    """Return a request with more seeds; as their number where it was one and they go on from it."""
    own = seeds_of(request)
    together = [*own, *seeds]
    counts_on = isinstance(request["seeds"], int) and together == list(range(len(together)))
    return {**request, "seeds": len(together) if counts_on else together}


def with_algorithms(request: Json, algorithms: Sequence[Json]) -> dict[str, Any]:
    """Return a request with more algorithms, after those that it has."""
    return {**request, "algorithms": [*request["algorithms"], *algorithms]}


def with_timesteps(request: Json, timesteps: int) -> dict[str, Any]:
    """Return a request whose runs have so many timesteps, whatever share of others they had."""
    return {**{k: v for k, v in request.items() if k != "scale"}, "timesteps": timesteps}
