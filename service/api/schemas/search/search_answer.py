"""The results of a sweep's search, as answers show them."""

from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field

from service.analysis.halving import Climb, Ladder, Standing
from service.api.schemas.number import finite_or_none
from service.model.inquiry.search import Rung, Search
from service.model.inquiry.tuning_seeds import seeds_text
from service.model.request.entry import Entries, Entry

DEFINITION = (
    "The entries of a task are trained to the timesteps of the first rung; the best of them, one "
    "in `reduction`, go on from there to the next rung. They are compared by the mean over seeds "
    "of the normalised score up to the rung's timesteps. A run that diverged counts as acting at "
    "random, an entry with a run that failed or was cancelled is left out."
)
KEPT_APART = (
    "A search trains on seeds of its own ({seeds}), which no question takes. The winner's score is "
    "too high to be expected again, because it was chosen for it: ask on other seeds whether it is "
    "better."
)


class StandingAnswer(BaseModel):
    """An entry on a rung."""

    label: str
    score: float | None = Field(
        description="Mean over seeds, normalised; null while runs train, or if left out."
    )
    climbing: int = Field(description="Runs that have not reached the timesteps of the rung.")
    diverged: int = Field(description="Runs that diverged before they reached them.")
    failed: int = Field(description="Runs that failed or were cancelled before they reached them.")
    goes_on: bool = Field(description="Whether it is among the best; on the last rung, the best.")

    @classmethod
    def of(cls, standing: Standing) -> Self:
        """Show an entry on a rung."""
        return cls(
            label=standing.label,
            score=finite_or_none(standing.score),
            climbing=standing.climbing,
            diverged=standing.diverged,
            failed=standing.failed,
            goes_on=standing.goes_on,
        )


class RungAnswer(BaseModel):
    """A rung of a task."""

    timesteps: int
    entries: int = Field(description="Entries on the rung, at most.")
    state: Literal["over", "climbing", "to come"]
    standings: list[StandingAnswer] = Field(description="The best first, if the rung is over.")

    @classmethod
    def of(cls, rung: Rung, climb: Climb | None) -> Self:
        """Show a rung, and who climbs it."""
        return cls(
            timesteps=rung.timesteps,
            entries=rung.entries,
            state="to come" if climb is None else "over" if climb.is_over else "climbing",
            standings=[] if climb is None else [StandingAnswer.of(e) for e in climb.standings],
        )


class SearchedTask(BaseModel):
    """What is known about one task."""

    environment: str
    sentence: str
    winner: str | None = Field(description="Label of the best entry; null while it is not known.")
    algorithm: dict[str, Any] | None = Field(
        description="The winner in the form of a request, for a question in another sweep."
    )
    rungs: list[RungAnswer]

    @classmethod
    def of(cls, ladder: Ladder, entries: Entries) -> Self:
        """Show the rungs of a task."""
        climbs = [*ladder.climbs, *[None] * (len(ladder.rungs) - len(ladder.climbs))]
        label = None if ladder.winner is None else ladder.winner.label
        return cls(
            environment=ladder.environment,
            sentence=sentence(ladder),
            winner=label,
            algorithm=next((_as_posted(e) for e in entries.all if e.label == label), None),
            rungs=[
                RungAnswer.of(rung, climb) for rung, climb in zip(ladder.rungs, climbs, strict=True)
            ],
        )


class SearchAnswer(BaseModel):
    """The results of a sweep's search."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "is_settled": True,
                    "budget": 300_000,
                    "timesteps": 286_400,
                    "reduction": 3,
                    "score": "area",
                    "seeds": [1_000_000_000, 1_000_000_001],
                    "definition": DEFINITION,
                    "kept_apart": KEPT_APART.format(seeds="1,000,000,000 to 1,000,000,001"),
                    "tasks": [
                        {
                            "environment": "Pendulum",
                            "sentence": "ddpg noise=0.4 is the best of 4: 0.74",
                            "winner": "ddpg noise=0.4",
                            "algorithm": {"name": "ddpg", "config": {"noise": 0.4}},
                            "rungs": [
                                {
                                    "timesteps": 20_000,
                                    "entries": 2,
                                    "state": "over",
                                    "standings": [
                                        {
                                            "label": "ddpg noise=0.4",
                                            "score": 0.74,
                                            "climbing": 0,
                                            "diverged": 0,
                                            "failed": 0,
                                            "goes_on": True,
                                        }
                                    ],
                                }
                            ],
                        }
                    ],
                }
            ]
        }
    )

    sweep: str
    is_settled: bool = Field(description="Nothing more will be trained.")
    budget: int
    timesteps: int = Field(description="Timesteps of all runs together.")
    reduction: int
    score: str
    seeds: list[int]
    definition: str = Field(description="How entries are compared, in words.")
    kept_apart: str = Field(description="What its seeds are not used for.")
    tasks: list[SearchedTask]

    @classmethod
    def of(
        cls,
        sweep_id: str,
        search: Search,
        climbed: list[Ladder],
        entries: Entries,
        *,
        is_settled: bool,
    ) -> Self:
        """Show a search."""
        return cls(
            sweep=sweep_id,
            is_settled=is_settled,
            budget=search.budget,
            timesteps=search.timesteps,
            reduction=search.reduction,
            score=search.score,
            seeds=list(search.seeds),
            definition=DEFINITION,
            kept_apart=KEPT_APART.format(seeds=seeds_text(search.seeds)),
            tasks=[SearchedTask.of(ladder, entries) for ladder in climbed],
        )


def sentence(ladder: Ladder) -> str:
    """Return the state of a task in words: `ddpg noise=0.4 is the best of 6: 0.74`."""
    if ladder.winner is not None:
        of = ladder.rungs[0].entries
        return f"{ladder.winner.label} is the best of {of}: {ladder.winner.score:.2f}"
    climb = ladder.climbs[-1]
    if climb.is_over and not climb.best:
        return "none: every entry that was left has runs that failed or were cancelled; retry them"
    place = f"rung {len(ladder.climbs)} of {len(ladder.rungs)}"
    return f"{place}: {len(climb.standings)} entries to {climb.rung.timesteps:,} timesteps"


def _as_posted(entry: Entry) -> dict[str, Any]:
    """Return an entry as an item of a request."""
    weights = {} if entry.weights is None else {"weights": entry.weights._asdict()}
    config = {"config": dict(entry.config)} if entry.config else {}
    return {"name": entry.algorithm, **weights, **config}
