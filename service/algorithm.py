"""What the service knows of an algorithm: its name, what it needs, what can be set."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AlgorithmFacts:
    """Constants of an algorithm.

    uses_weights           has gradient terms to weigh
    needs_reward_gradient  cannot learn where the reward has none
    """

    name: str
    uses_weights: bool
    needs_reward_gradient: bool


FACTS = {
    "ddpg": AlgorithmFacts("ddpg", uses_weights=False, needs_reward_gradient=False),
    "hybrid-ddpg": AlgorithmFacts("hybrid-ddpg", uses_weights=True, needs_reward_gradient=False),
}


def algorithm_names() -> list[str]:
    """Every algorithm's name."""
    return list(FACTS)


def algorithm_facts(name: str) -> AlgorithmFacts:
    """Return the facts of an algorithm. Raises KeyError for an unknown name."""
    return FACTS[name]
