"""Readiness, as `GET /readyz` answers it."""

from pydantic import BaseModel, ConfigDict


class CheckAnswer(BaseModel):
    """One thing the service needs; `problem` is a sentence, null while there is none."""

    name: str
    is_ready: bool
    problem: str | None


class ReadinessAnswer(BaseModel):
    """Whether runs can be stored and started."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "status": "not ready",
                    "checks": [
                        {"name": "database", "is_ready": True, "problem": None},
                        {"name": "cluster", "is_ready": False, "problem": "cluster starting"},
                    ],
                }
            ]
        }
    )

    status: str
    checks: list[CheckAnswer]
