"""What a sweep's question has come to."""

from fastapi import APIRouter

from service.analysis.question.verdict import verdict
from service.api.context import TheStore, TheSweep
from service.api.problems import NotFound
from service.api.revalidation import RevalidatedRoute
from service.api.schemas.verdict_answer import VerdictAnswer
from service.model.question import Question
from service.queue.question_rounds import pairs_of

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["curves"], route_class=RevalidatedRoute)


@router.get("/verdict")
def get_verdict(sweep: TheSweep, store: TheStore) -> VerdictAnswer:
    """Answer what is decided of the sweep's question, how, and how many more seeds it may take."""
    question = Question.of(sweep.request)
    if question is None:
        raise NotFound(f"Sweep {sweep.id} asks no question: submit one with `question`.")
    found = verdict(pairs_of(store, sweep, question), question)
    return VerdictAnswer.of(sweep.id, found, is_settled=not sweep.is_asking)
