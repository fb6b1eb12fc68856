"""The runs of a sweep's CSV, one after the other."""

import math
from collections.abc import Iterator

from service.export.measured_run import measured_runs

HEAD = (
    "run,label,algorithm,environment,w1,w2,config,seed,timestep,return_mean,return_history,updates,"
    "jacobians,seconds,compile_seconds,critic_loss,entropy"
)


def lines(read: list[str]) -> Iterator[str]:
    told = '"ddpg ""a"", b",ddpg,Pendulum,0.1,0.0,"{""noise"": 0.1}"'
    for row in (
        HEAD,
        f"x-0,{told},4,800,-1.5,-1.5,400,0,0.5,,NaN,",
        f"x-0,{told},4,1600,-Infinity,-1.5,800,0,1.0,,0.25,",
        f"x-7,{told},5,800,2.0,2.0,400,0,0.5,1.25,,0.5",
    ):
        read.append(row)
        yield row


def test_rows_of_a_run_become_its_columns() -> None:
    read: list[str] = []
    runs = measured_runs(lines(read))
    first = next(runs)
    assert len(read) == 4  # the row that begins the next run, and no further
    assert (first.id, first.label, first.seed, first.w1) == ("x-0", 'ddpg "a", b', 4, 0.1)
    assert first.config == {"noise": 0.1}
    assert first.settings["noise"] == 0.1
    assert first.steps == [800, 1600]
    assert first.columns["return_mean"].tolist() == [-1.5, -math.inf]
    assert math.isnan(first.columns["critic_loss"][0])
    assert set(first.columns) & {"compile_seconds", "entropy"} == set()
    [second] = runs
    assert second.columns["entropy"].tolist() == [0.5]
    assert "timestep" not in second.metrics
