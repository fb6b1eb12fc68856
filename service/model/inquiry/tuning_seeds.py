"""Seeds that choose settings. No question counts them: a setting chosen for its luck would win.

PRESETS   searches and trials that the presets come from (service/paper/search, results/trials.csv)
SEARCHES  searches of a service (service/model/inquiry/search.py)
"""

from collections.abc import Sequence

PRESETS = range(100, 116)
SEARCHES = range(1_000_000_000, 1_000_010_000)


def chooses(seed: int) -> bool:
    """Whether a seed is reserved for choosing settings."""
    return seed in PRESETS or seed in SEARCHES


def seeds_text(seeds: Sequence[int]) -> str:
    """Return seeds as `100 to 115` where they follow each other, else as a list."""
    if len(seeds) > 1 and list(seeds) == list(range(seeds[0], seeds[-1] + 1)):
        return f"{seeds[0]:,} to {seeds[-1]:,}"
    return "; ".join(f"{seed:,}" for seed in seeds)
