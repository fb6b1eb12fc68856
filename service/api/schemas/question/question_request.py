"""What `POST /sweeps` takes as a sweep's question."""

from typing import Annotated, Literal

from pydantic import AfterValidator, ConfigDict, Field

from service.api.schemas.requests.texts import Request, Text
from service.model.inquiry.question import SECONDS_TO, Method

MAX_SEEDS = 10_000

Label = Annotated[Text, Field(min_length=1, max_length=1000)]


def question_score(text: str) -> str:
    """Return the name of a score. Raises ValueError for another text."""
    if text in ("area", "final") or SECONDS_TO.fullmatch(text):
        return text
    raise ValueError(
        'is "area", "final", or "seconds to X" with X above 0 and at most 1, as in "seconds to 0.9"'
    )


class QuestionRequest(Request):
    """A question: the sweep gets seeds until each of its comparisons is decided in each task."""

    model_config = ConfigDict(serialize_by_alias=True)

    compare: list[Label] = Field(
        min_length=1, max_length=100, description="Labels of the entries that are asked about."
    )
    against: Label = Field(
        alias="with", description="Label of the entry that each of them is compared with."
    )
    score: Annotated[str, AfterValidator(question_score)] = Field(
        default="area",
        description="`area`, `final`, or `seconds to X`: processor seconds until return_mean "
        "reaches X on the normalised scale.",
    )
    until: Literal["decided"] = "decided"
    margin: float = Field(
        default=0.02,
        gt=0,
        lt=1,
        description="Smaller differences do not matter: entries are equivalent within it.",
    )
    confidence: float = Field(
        default=0.95, ge=0.5, le=0.9999, description="Confidence of all decisions together."
    )
    max_seeds: int = Field(
        default=128, ge=1, le=MAX_SEEDS, description="Seeds of each entry in each task, at most."
    )
    batch: int = Field(default=8, ge=1, le=MAX_SEEDS, description="Seeds between two looks.")
    clip: float = Field(
        default=1.0,
        gt=0,
        le=1,
        description="Larger differences of a pair count as this value: decides sooner, and says "
        "less of rare failures.",
    )
    method: Method = Field(
        default="bounded",
        description="`bounded` holds whatever the differences are; `normal` decides sooner, and "
        "is wrong where few seeds fail badly.",
    )
    drop_losers: bool = Field(
        default=False,
        description="An entry that is worse in one task gets no more seeds in the others.",
    )
