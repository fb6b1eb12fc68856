"""What the terminal says of a sweep."""

import io
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from rich.console import Console

from service.api.schemas.curves_answer import CurvesAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.following import (
    changes,
    counts_text,
    eta_text,
    follow,
    standings,
    starting_text,
)
from service.cli.terminal import table_of
from service.client import Client
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import rising, train
from workers.messages.progress import Activity, Progress

COUNTS = {
    "total": 7, "queued": 0, "paused": 0, "running": 2, "succeeded": 4, "failed": 0,
    "diverged": 1, "cancelled": 0,
}  # fmt: skip


def sweep(**changes: Any) -> SweepAnswer:
    (example,) = SweepAnswer.model_config["json_schema_extra"]["examples"]  # type: ignore
    document: Any = example
    return SweepAnswer.model_validate({**document, "runs": COUNTS, "eta_seconds": None, **changes})


class FakeClient:
    """Answers the curves it was given."""

    def __init__(self, **curve: Any) -> None:
        (example,) = CurvesAnswer.model_config["json_schema_extra"]["examples"]  # type: ignore
        self.answer = CurvesAnswer.model_validate(example)
        (self.panel,) = self.answer.panels
        self.panel.curves = [self.panel.curves[0].model_copy(update=curve)]

    def curves(self, sweep_id: str, **options: Any) -> CurvesAnswer:
        assert options["normalized"] is True
        return self.answer


def test_counts_name_the_statuses_there_are() -> None:
    assert counts_text(sweep()) == "2 running, 4 succeeded, 1 diverged"


def test_eta_in_minutes_and_hours_or_nothing() -> None:
    assert eta_text(sweep()) == ""
    assert eta_text(sweep(eta_seconds=59.6)) == "ETA 1:00"
    assert eta_text(sweep(eta_seconds=3725)) == "ETA 1:02:05"


def test_standings_show_the_latest_known_point() -> None:
    client: Any = FakeClient(
        x=[800, 1600, 2400], mean=[0.1, 0.25, None], high=[0.2, 0.3, None], n=[4, 4, 0]
    )
    assert standings(client, "") == [("Pendulum", "ddpg", "1,600", "0.250 ± 0.050", "4")]


def test_standings_say_how_many_of_the_runs_got_there() -> None:
    client: Any = FakeClient(x=[800], mean=[0.1], high=[0.2], n=[3], unfinished={"diverged": 1})
    assert standings(client, "")[0][-1] == "3 of 4"


def test_curves_without_points_are_said() -> None:
    client: Any = FakeClient(x=[], mean=[], high=[], n=[])
    assert standings(client, "") == [("Pendulum", "ddpg", "-", "-", "0 of 4")]


def test_only_changes_are_passed_on() -> None:
    seen: list[SweepAnswer] = []
    pass_on = changes(seen.append)
    for progress, eta in ((0.1, 9), (0.1, 8), (0.2, 7)):
        pass_on(sweep(progress=progress, eta_seconds=eta))
    assert [each.progress for each in seen] == [0.1, 0.2]


def test_a_trained_sweep_in_lines_and_on_a_terminal(service: Client, store: Store) -> None:
    sweep_id = service.submit(SWEEP).id
    train(store, 5, rising)
    for is_terminal in (False, True):
        output = Console(file=io.StringIO(), force_terminal=is_terminal, width=120)
        assert follow(service, sweep_id, output) == 0
        text = output.file.getvalue()  # type: ignore[attr-defined]
        assert "12 succeeded" in text
        assert "Pendulum" in text
        assert ("\t" in text) is not is_terminal


def test_runs_whose_kernels_are_loaded_or_compiled_are_named_once(
    service: Client, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep_id = service.submit(changed(seeds=5)).id

    def wait(_: str, *, progressed: Callable[[SweepAnswer], None]) -> SweepAnswer:
        assert starting_text(service, service.sweep(sweep_id)) == ""
        claim = store.claim_cohort("worker", 60.0)
        assert claim is not None
        first = Progress(0, Activity.COMPILING)
        for progress in (first, replace(first, fingerprint={"code": "x"})):
            store.record(claim, progress)
            progressed(service.sweep(sweep_id))
        store.record(claim, Progress(50))
        assert starting_text(service, service.sweep(sweep_id)) == ""
        train(store, 5, rising)
        return service.sweep(sweep_id)

    monkeypatch.setattr(service, "wait", wait)
    output = Console(file=io.StringIO(), width=120)
    follow(service, sweep_id, output)
    text = output.file.getvalue()  # type: ignore[attr-defined]
    names = ", ".join(f"{sweep_id}-{ordinal}" for ordinal in range(4))
    assert text.count(f"Kernels are loaded, or compiled at first use: {names} and 1 more\n") == 1


def test_a_sweep_that_is_given_more_runs_goes_its_way_again(
    service: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep_id = service.submit(changed(seeds=1)).id

    def wait(_: str, *, progressed: Callable[[SweepAnswer], None]) -> SweepAnswer:
        for progress in (0.0, 0.04, 0.92, 0.5, 0.97):
            progressed(sweep(progress=progress, runs={**COUNTS, "running": 0}))
        return service.sweep(sweep_id)

    monkeypatch.setattr(service, "wait", wait)
    output = Console(file=io.StringIO(), width=120)
    follow(service, sweep_id, output)
    lines = output.file.getvalue().splitlines()  # type: ignore[attr-defined]
    shown = [word for line in lines for word in line.split() if word.endswith("%")]
    assert shown == ["0%", "92%", "50%", "97%"]


def test_who_stops_looking_is_told_that_the_sweep_goes_on(
    service: Client, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> SweepAnswer:
        raise KeyboardInterrupt

    sweep_id = service.submit(SWEEP).id
    monkeypatch.setattr(service, "wait", interrupted)
    for is_terminal in (False, True):
        with pytest.raises(KeyboardInterrupt):
            follow(service, sweep_id, Console(file=io.StringIO(), force_terminal=is_terminal))
        assert f"The sweep goes on. Look again: d3pg watch {sweep_id}" in capsys.readouterr().err


def test_on_a_terminal_ids_stay_whole_and_empty_columns_are_left_out() -> None:
    output = Console(file=io.StringIO(), force_terminal=True, width=40)
    row = ("0123456789ab-0", "hybrid-ddpg-cosine", "", "why it failed: the loss was not finite")
    output.print(table_of(("run", "algorithm", "nothing", "reason"), [row], output.width))
    text = output.file.getvalue()  # type: ignore[attr-defined]
    assert "0123456789ab-0" in text
    assert "hybrid-ddpg-cosine" in text
    assert "nothing" not in text


def test_on_a_narrow_terminal_every_row_is_a_paragraph_with_all_of_it() -> None:
    output = Console(file=io.StringIO(), force_terminal=True, width=40)
    headings = ("run", "status", "learner", "task", "seed", "timestep", "reason")
    why = "critic_loss stopped being finite at update 4212, timestep 9600"
    row = ("0123456789ab-17", "diverged", "ddpg noise=0.1", "MountainCar", 3, "9600/20000", why)
    output.print(table_of(headings, [row, (*row[:-1], "")], output.width))
    lines = output.file.getvalue().splitlines()  # type: ignore[attr-defined]
    assert max(map(len, lines)) <= 40
    paragraph, other = " ".join(map(str.strip, lines)).split(" 0123456789ab-17, ")
    assert paragraph == (
        "0123456789ab-17, status diverged, learner ddpg noise=0.1, task MountainCar, seed 3, "
        f"timestep 9600/20000, reason {why}"
    )
    assert other.endswith("timestep 9600/20000")


def test_json_is_a_line_a_change(
    service: Client, store: Store, capsys: pytest.CaptureFixture[str]
) -> None:
    sweep_id = service.submit(SWEEP).id
    train(store, 5, rising)
    assert follow(service, sweep_id, Console(), as_json=True) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert json.loads(line)["runs"]["succeeded"] == 12
