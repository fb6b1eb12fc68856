"""The figure of learners over many tasks."""

import re

import numpy as np

from service.analysis.figures.today_figure import draw
from service.analysis.overview import Learner, SharedRun, standings

STEPS = np.linspace(0.04, 1.0, 25)


def learner(label: str, algorithm: str, *tasks: str) -> Learner:
    runs = [SharedRun(STEPS, STEPS, height * STEPS) for height in (0.1, 0.2, 0.3)]
    return Learner(label, algorithm, dict.fromkeys(tasks, runs))


FOUND = standings([
    learner("ddpg", "ddpg", "CartPole", "Acrobot"),
    learner("sac", "sac", "CartPole", "Acrobot"),
    learner("sac with learned temperature", "sac", "CartPole", "Acrobot"),
    learner("mpc", "mpc", "CartPole"),
])  # fmt: skip


def test_the_same_data_give_the_same_bytes() -> None:
    assert draw(FOUND, "svg") == draw(FOUND, "svg")
    assert draw(FOUND, "png").startswith(b"\x89PNG")


def test_every_learner_is_named_and_tells_how_many_tasks_it_has() -> None:
    text = draw(FOUND, "svg").decode()
    told = re.findall(r"<text[^>]*>(.*?)</text>", text)
    for label in ("ddpg", "sac", "sac with learned temperature", "mpc (1 of 2 tasks)"):
        assert label in told


def test_learners_of_one_colour_differ_in_their_dashes() -> None:
    text = draw(FOUND, "svg").decode()
    lines = re.findall(r'style="fill: none;( stroke-dasharray: [^"]*)?[^"]*stroke: #56b4e9', text)
    assert {bool(dashes) for dashes in lines} == {True, False}
