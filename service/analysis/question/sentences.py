"""The verdict in words: a sentence a comparison, and one for a paper."""

from collections.abc import Sequence

from service.analysis.question.decision import Outcome
from service.analysis.question.forecast import HORIZON
from service.analysis.question.verdict import Answer, Verdict
from service.model.inquiry.question import Method, Question

SCORE_TEXT = {
    "area": "the area under the curve of the normalised return (0 at random, 1 at best)",
    "final": "the normalised return in the last tenth of training (0 at random, 1 at best)",
}
METHODS: dict[Method, str] = {
    "bounded": "betting confidence sequences (Waudby-Smith and Ramdas, JRSS B 2024), which assume "
    "nothing of the differences but their bounds",
    "normal": "sequential t-tests (Wang and Ramdas, 2025), which assume that the differences are "
    "normally distributed",
}


def sentence(answer: Answer, question: Question) -> str:
    """Return the state of one comparison in words: `better by 0.05 to 0.11; 24 seeds`."""
    match answer.outcome:
        case Outcome.BETTER | Outcome.WORSE:
            return f"{answer.outcome.name.lower()} by {_extent(answer)}; {_seeds(answer.seeds)}"
        case Outcome.EQUIVALENT:
            return f"equivalent within {question.margin:g}; {_seeds(answer.seeds)}"
        case Outcome.DROPPED:
            return f"dropped after {_seeds(answer.seeds)}: worse in another task ({_range(answer)})"
        case Outcome.STALLED:
            return (
                f"stopped after {_seeds(answer.seeds)}: no pair of the last batch can be compared, "
                f"because {_why_left_out(question)}"
            )
        case _:
            return _undecided(answer, question)


def _why_left_out(question: Question) -> str:
    if question.threshold is None:
        return "runs failed or were cancelled; retry them"
    return "runs failed, were cancelled or had different processors; retry them on equal ones"


def _undecided(answer: Answer, question: Question) -> str:
    if not answer.seeds:
        return "not decided: its first runs have not ended"
    spent = answer.seeds >= question.max_seeds
    so_far = f"not decided ({_range(answer)}); {_seeds(answer.seeds)}{'' if spent else ' so far'}"
    if answer.forecast is None:
        return so_far
    if answer.forecast.more is None:
        return f"{so_far}; more than {HORIZON:,} more would be needed"
    return f"{so_far}; about {answer.forecast.more} more would decide"


def paper_sentence(verdict: Verdict) -> str:
    """Return method, numbers of seeds, correction and results, ready for a paper."""
    question = verdict.question
    clip = f", each counted up to {question.clip:g}," if question.clip < 1.0 else ""
    compared = len(verdict.answers)
    comparisons = f"{compared} comparison{'s' * (compared != 1)}"
    return (
        f"Runs of equal seed were compared by {_score_text(question)}. The mean of their "
        f"differences{clip} was followed by {METHODS[question.method]}, looked at after "
        f"{len(question.first)} seeds and after every {question.batch} more, to at most "
        f"{question.max_seeds}. Holm's step-down procedure over "
        f"{comparisons} bounds the probability of any wrong decision, at any time, by "
        f"{question.error_rate:.2g}. Runs that diverged count as acting at random. "
        + " ".join(_results(verdict))
    )


def _results(verdict: Verdict) -> list[str]:
    """Return a sentence for each kind of outcome that there is."""
    words = {
        Outcome.BETTER: "Better than",
        Outcome.WORSE: "Worse than",
        Outcome.EQUIVALENT: f"Equivalent within {verdict.question.margin:g} to",
    }
    found = []
    for outcome, word in words.items():
        own = [answer for answer in verdict.answers if answer.outcome == outcome]
        if own:
            found.append(f"{word} {verdict.question.against}: {_listed(own)}.")
    others = [answer for answer in verdict.answers if answer.outcome not in words]
    return [*found, *([f"Not decided: {_listed(others)}."] if others else [])]


def _listed(answers: Sequence[Answer]) -> str:
    return "; ".join(f"{a.pairs.label} in {a.pairs.environment} ({_result(a)})" for a in answers)


def _result(answer: Answer) -> str:
    n = answer.sequence.n[-1] if answer.sequence.n else 0
    if not n:
        return "n = 0"
    confidence = 1 - 2 * answer.level
    return f"{answer.sequence.mean[-1]:+.3f}, {confidence:.1%} CI {_range(answer)}, n = {n}"


def _score_text(question: Question) -> str:
    if question.threshold is not None:
        return (
            "the share of processor seconds that one saves until the normalised return reaches "
            f"{question.threshold:g}"
        )
    return SCORE_TEXT[question.score]


def _extent(answer: Answer) -> str:
    low, high = answer.sequence.low[-1], answer.sequence.high[-1]
    nearest, farthest = sorted((abs(low), abs(high)))
    return f"{_number(nearest)} to {_number(farthest)}"


def _range(answer: Answer) -> str:
    if not len(answer.sequence.low):
        return "nothing is known"
    return f"{_number(answer.sequence.low[-1])} to {_number(answer.sequence.high[-1])}"


def _number(value: float) -> str:
    """Return two decimals, more where these would be 0."""
    return f"{value:.2f}" if abs(value) >= 0.005 else f"{value:.1g}"


def _seeds(count: int) -> str:
    return f"{count} seed{'s' * (count != 1)}"
