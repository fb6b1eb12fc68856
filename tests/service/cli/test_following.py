"""What the terminal says of a sweep."""

from typing import Any

from rich.console import Console

from service.cli.following import counts_text, eta_text, standings

COUNTS = {
    "total": 7, "queued": 0, "running": 2, "paused": 0, "succeeded": 4, "failed": 0, "diverged": 1,
    "cancelled": 0,
}  # fmt: skip


def sweep(**changes: Any) -> dict[str, Any]:
    return {"id": "0" * 12, "runs": COUNTS, "eta_seconds": None} | changes


class FakeClient:
    """Answers the curves it was given."""

    def __init__(self, *curves: dict[str, Any]) -> None:
        self.panels = [{"environment": "[red]Pendulum[/red]", "curves": list(curves)}]

    def curves(self, sweep_id: str, **options: Any) -> dict[str, Any]:
        assert options["normalized"] is True
        return {"panels": self.panels}


def rendered(client: FakeClient) -> str:
    console = Console(width=100, no_color=True)
    with console.capture() as capture:
        console.print(standings(client, sweep()))  # type: ignore[arg-type]
    return capture.get()


def test_counts_name_the_statuses_there_are() -> None:
    assert counts_text(sweep()) == "2 running, 4 succeeded, 1 diverged"


def test_eta_in_minutes_and_hours_or_nothing() -> None:
    assert eta_text(sweep()) == ""
    assert eta_text(sweep(eta_seconds=59.6)) == "ETA 1:00"
    assert eta_text(sweep(eta_seconds=3725)) == "ETA 1:02:05"


def test_standings_show_the_latest_known_point() -> None:
    curve = {
        "label": "ddpg", "x": [800, 1600, 2400], "mean": [0.1, 0.25, None],
        "high": [0.2, 0.3, None], "n": [4, 4, 0],
    }  # fmt: skip
    text = rendered(FakeClient(curve))
    assert "1,600" in text
    assert "0.250 ± 0.050" in text


def test_names_are_text_and_curves_without_points_are_said() -> None:
    text = rendered(FakeClient({"label": "new", "x": [], "mean": [], "high": [], "n": []}))
    assert "[red]Pendulum[/red]" in text
    assert " - " in text
