"""The scheduler in a simulated world: whatever happens, in whatever order, its promises hold.

`D3PG_SIMULATED_STEPS=1000000 pytest tests/service/test_scheduler.py` simulates for longer;
`D3PG_SIMULATED_SEED=17 pytest tests/service/test_scheduler.py` replays one world.
"""

import os

import pytest

from tests.service.simulation import Simulation

STEPS = int(os.environ.get("D3PG_SIMULATED_STEPS", "4000"))
STEPS_OF_THE_LONG_TEST = 100_000
STEPS_A_WORLD = 1000
REPLAYED = os.environ.get("D3PG_SIMULATED_SEED")


def simulate(seed: int) -> int:
    """Simulate one world; says how to see a failure again."""
    simulation = Simulation(seed)
    try:
        simulation.run(STEPS_A_WORLD)
    except Exception as failure:
        story = "\n".join(simulation.story)
        raise AssertionError(
            f"{failure}\nafter step {simulation.steps} of seed {seed}; the last events:\n{story}\n"
            f"again: D3PG_SIMULATED_SEED={seed} pytest tests/service/test_scheduler.py"
        ) from failure
    finally:
        simulation.close()
    return simulation.steps


def simulate_worlds(first_seed: int, steps: int) -> None:
    """Simulate one world after the other until so many things have happened."""
    done, seed = 0, first_seed
    while done < steps:
        done += simulate(seed)
        seed += 1


@pytest.mark.timeout(0)
def test_any_order_of_events_keeps_every_promise() -> None:
    if REPLAYED is not None:
        simulate(int(REPLAYED))
    else:
        simulate_worlds(0, STEPS)


@pytest.mark.slow
def test_a_hundred_thousand_events_keep_every_promise() -> None:
    simulate_worlds(1000, STEPS_OF_THE_LONG_TEST)
