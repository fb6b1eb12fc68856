"""Findings as a diagnosis has them, of chosen values; and runs that have them."""

from algorithms.diagnostics.finding import Finding
from service.store.store import Store
from workers.messages.run_spec import RunSpec

HORIZONS = (1, 4, 16)


def findings(scale: float = 1.0, *, has_critic: bool = True) -> list[Finding]:
    """A bias of a quarter of the gradient's norm, and growth by `scale` with each horizon."""
    smoothing = [
        Finding("smoothing", quantity, horizon, noise, value * horizon)
        for noise in (0.05, 0.2)
        for horizon in HORIZONS
        for quantity, value in (
            ("norm", 4.0), ("bias", 1.0), ("resolution", 0.5), ("exact_std", 2.0),
            ("zeroth_std", 8.0),
        )
    ]  # fmt: skip
    growth = [
        Finding("growth", quantity, horizon, None, scale * horizon * factor)
        for horizon in HORIZONS
        for quantity, factor in (("median_norm", 1.0), ("high_norm", 3.0))
    ]
    critic = [
        Finding("critic", f"{part}_cosine", horizon, None, 0.5)
        for horizon in HORIZONS
        for part in ("action", "state")
    ]
    loss = [Finding("loss", f"{part}_top_share", None, 0.2, 0.1) for part in ("action", "state")]
    crossing = [Finding("kinks", "crossing", None, None, 0.25)]
    return [*smoothing, *growth, *crossing, *(critic + loss if has_critic else [])]


def find(store: Store) -> None:
    """Answer every diagnosis that waits; those of gd have no critic."""
    while (run := store.next_waiting_diagnosis()) is not None:
        store.record_diagnosis(run, of_spec(run.spec))


def of_spec(spec: RunSpec) -> list[Finding]:
    """What is found about a run of that spec."""
    return findings(1.0 + spec.seed, has_critic=spec.algorithm != "gd")
