"""What a worker logs of a cohort."""

import pytest

from algorithms.early_end import Divergence, Failure
from workers.messages.assignment import Assignment
from workers.messages.progress import Activity, CheckpointAttempt, Progress, Resumption
from workers.messages.run_spec import RunSpec, Weights
from workers.messages.work import Work
from workers.training.narrator import Narrator

SPECS = [
    RunSpec("hybrid-ddpg", "Pendulum", seed, Weights(0.1, 0.0), 4000, {"noise": 0.2})
    for seed in (3, 0, 1)
]
WORK = Work("a-0/1", tuple(Assignment(f"a-{s.seed}", 1, s, 1) for s in SPECS))


def test_every_change_is_a_line(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "d3pg")
    now = iter([10.0, 12.5])
    narrator = Narrator(WORK, lambda: next(now))
    resumed = (Resumption(0, 0), Resumption(1, 800, note="newest checkpoint damaged"))
    problem = CheckpointAttempt(3, 900, "its checkpoint of step 900 could not be written: full")
    for progress in (
        Progress(0, Activity.COMPILING),
        Progress(0, Activity.COMPILING, resumed=resumed),
        Progress(850),
        Progress(900, checkpoints=(problem, CheckpointAttempt(0, 900))),
        Progress(1000),
        Progress(
            4000,
            diverged=(Divergence(1, 3200, 17, "critic_loss"),),
            failed=(Failure(0, 3300, "ValueError: no"),),
            finished=(3,),
        ),
    ):
        narrator.tell(progress)
    assert caplog.messages == [
        "hybrid-ddpg w1=0.1 w2=0 noise=0.2 in Pendulum, seeds 0, 1, 3, 4000 timesteps",
        "seed 1 resumes at timestep 800",
        "seed 1: newest checkpoint damaged",
        "training, after 2.5 s of preparation",
        "seed 3: its checkpoint of step 900 could not be written: full",
        "seed 1 diverged at timestep 3200: critic_loss stopped being finite",
        "seed 0 failed at timestep 3300",
        "seed 3 reached the end",
    ]


def test_what_was_stopped_on_demand_is_named(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "d3pg")
    Narrator(WORK).tell(Progress(0, Activity.COMPILING, dropped=(1, 0)))
    assert caplog.messages[-1] == "seeds 0, 1 stopped on demand"
