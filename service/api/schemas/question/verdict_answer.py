"""The verdict on a sweep's question, as answers show it."""

from collections.abc import Sequence
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field

from service.analysis.curves import Floats
from service.analysis.question.decision import Outcome
from service.analysis.question.sentences import paper_sentence, sentence
from service.analysis.question.verdict import Answer, Verdict
from service.api.schemas.number import Numbers, finite_or_none, numbers
from service.model.inquiry.question import Question
from service.model.inquiry.tuning_seeds import PRESETS, SEARCHES, seeds_text
from service.model.sweep import Sweep

Decision = Literal["open", "better", "worse", "equivalent", "dropped", "stalled", "undecided"]

DECISIONS: dict[Outcome, Decision] = {
    Outcome.BETTER: "better",
    Outcome.WORSE: "worse",
    Outcome.EQUIVALENT: "equivalent",
    Outcome.DROPPED: "dropped",
    Outcome.STALLED: "stalled",
}
DEFINITION = (
    "Differences of runs of equal seed, ours minus theirs, each score normalised and in [0, 1]; "
    "for seconds, the share of the time that is saved. A run that diverged counts as acting at "
    "random, a pair with a run that failed or was cancelled does not count. Bounds hold at every "
    "look; all decisions together are right with the question's confidence, whenever one looks."
)
KEPT_APART = (
    f"Seeds that chose settings do not count: {seeds_text(PRESETS)}, of the presets, and those of "
    f"searches, from {SEARCHES[0]:,} on."
)


class SequenceAnswer(BaseModel):
    """The confidence sequence, look by look, as columns of equal length."""

    n: list[int] = Field(description="Pairs that counted at each look.")
    mean: Numbers
    low: Numbers
    high: Numbers


class ForecastAnswer(BaseModel):
    """What more seeds would do if they were like those seen."""

    more: int | None = Field(
        description="Seeds until a decision is as likely as not; null: more than 512."
    )
    power: float = Field(description="Probability of a decision within the budget.")


class ComparisonAnswer(BaseModel):
    """What is known about one entry in one task."""

    environment: str
    label: str
    against: str
    outcome: Decision = Field(
        description="`undecided`: the budget has ended; `dropped`: its entry is worse in another "
        "task; `stalled`: no pair of its last batch can be compared."
    )
    sentence: str
    seeds: int = Field(description="Seeds that the outcome is based on.")
    n: int = Field(description="Pairs that count.")
    left_out: int = Field(
        description="Pairs with a run that failed or was cancelled, and those of `unequal`."
    )
    unequal: int = Field(
        description="Pairs whose seconds cannot be compared: different processors trained them."
    )
    diverged: int = Field(description="Runs of `label` that diverged.")
    diverged_against: int = Field(description="Runs of `against` that diverged.")
    confidence: float = Field(description="Confidence of `low` and `high` by themselves.")
    mean: float | None
    low: float | None
    high: float | None
    sequence: SequenceAnswer
    forecast: ForecastAnswer | None = Field(description="null if decided, or if it is too early.")

    @classmethod
    def of(cls, answer: Answer, question: Question, *, is_settled: bool) -> Self:
        """Show an answer."""
        sequence, counts = answer.sequence, answer.pairs.looks[-1:]
        forecast = answer.forecast
        return cls(
            environment=answer.pairs.environment,
            label=answer.pairs.label,
            against=question.against,
            outcome=_decision(answer.outcome, is_settled=is_settled),
            sentence=sentence(answer, question),
            seeds=answer.seeds,
            n=sum(each.n for each in counts),
            left_out=sum(each.left_out for each in counts),
            unequal=sum(each.unequal for each in counts),
            diverged=sum(each.ours_diverged for each in counts),
            diverged_against=sum(each.theirs_diverged for each in counts),
            confidence=1 - 2 * answer.level,
            mean=_last(sequence.mean),
            low=_last(sequence.low),
            high=_last(sequence.high),
            sequence=SequenceAnswer(
                n=list(sequence.n),
                mean=numbers(sequence.mean),
                low=numbers(sequence.low),
                high=numbers(sequence.high),
            ),
            forecast=None
            if forecast is None
            else ForecastAnswer(more=forecast.more, power=forecast.power),
        )


class VerdictAnswer(BaseModel):
    """The verdict on a sweep's question."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "is_settled": True,
                    "margin": 0.02,
                    "definition": DEFINITION,
                    "kept_apart": KEPT_APART,
                    "searches": [],
                    "comparisons": [
                        {
                            "environment": "Pendulum",
                            "label": "hybrid-ddpg",
                            "against": "ddpg",
                            "outcome": "better",
                            "sentence": "better by 0.05 to 0.11; 24 seeds",
                            "seeds": 24,
                            "n": 24,
                            "left_out": 0,
                            "unequal": 0,
                            "diverged": 0,
                            "diverged_against": 0,
                            "confidence": 0.95,
                            "mean": 0.083,
                            "low": 0.052,
                            "high": 0.113,
                            "sequence": {
                                "n": [8, 16, 24],
                                "mean": [0.09, 0.087, 0.083],
                                "low": [-0.09, 0.0, 0.052],
                                "high": [0.2, 0.15, 0.113],
                            },
                            "forecast": None,
                        }
                    ],
                    "paper": "Differences of the area under the curve ...",
                }
            ]
        }
    )

    sweep: str
    is_settled: bool = Field(description="No more seeds will be added.")
    margin: float = Field(description="Smaller differences do not matter.")
    definition: str = Field(description="What is compared, in words.")
    kept_apart: str = Field(description="Which seeds do not count, because they chose settings.")
    searches: list[str] = Field(
        description="Sweeps that searched among the settings compared here; their seeds do not "
        "count."
    )
    comparisons: list[ComparisonAnswer] = Field(description="Task by task.")
    paper: str = Field(description="Method, numbers of seeds, correction and results in words.")

    @classmethod
    def of(
        cls, sweep_id: str, verdict: Verdict, searches: Sequence[Sweep], *, is_settled: bool
    ) -> Self:
        """Show a verdict; the searches tried settings that are compared."""
        return cls(
            sweep=sweep_id,
            is_settled=is_settled,
            margin=verdict.question.margin,
            definition=DEFINITION,
            kept_apart=kept_apart(searches),
            searches=[sweep.id for sweep in searches],
            comparisons=[
                ComparisonAnswer.of(answer, verdict.question, is_settled=is_settled)
                for answer in verdict.answers
            ],
            paper=paper_sentence(verdict),
        )


def kept_apart(searches: Sequence[Sweep]) -> str:
    """Return which seeds do not count, and whose they are where settings come from a search."""
    parts = [
        f" Sweep {sweep.id} searched these settings on seeds {seeds_text(sweep.search.seeds)}."
        for sweep in searches
        if sweep.search is not None
    ]
    return KEPT_APART + "".join(parts)


def _decision(outcome: Outcome, *, is_settled: bool) -> Decision:
    if outcome == Outcome.OPEN:
        return "undecided" if is_settled else "open"
    return DECISIONS[outcome]


def _last(values: Floats) -> float | None:
    return finite_or_none(float(values[-1])) if len(values) else None
