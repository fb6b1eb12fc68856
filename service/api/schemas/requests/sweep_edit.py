"""What `PATCH /sweeps/{id}` takes: how a sweep is described, found and ranked."""

from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field

from service.api.schemas.requests.texts import Name, Request, Text, label_text
from service.model.webhook import MAX_URL, webhook_url

MAX_NOTES = 20_000
MAX_TAG = 50
MAX_TAGS = 20
NAME_TEXT = "Any text; shown and stored exactly as it is."
NOTES_TEXT = "Markdown, shown as text."
TAGS_TEXT = "Short texts that sweeps are found by."
PRIORITY_TEXT = "Sweeps of higher priority start first."
WEBHOOK_TEXT = "URL that gets a signed POST when all runs have ended; null: none."
MAX_WORKERS_TEXT = "Workers that may train the sweep at once; null: any number."


def distinct(values: list[str]) -> list[str]:
    """Return values that differ; raises ValueError for a repeated one."""
    for place, value in enumerate(values):
        if value in values[:place]:
            raise ValueError(f"{value!r} appears twice")
    return values


Notes = Annotated[Text, Field(max_length=MAX_NOTES)]
OneTag = Annotated[Text, Field(min_length=1, max_length=MAX_TAG), AfterValidator(label_text)]
Tags = Annotated[list[OneTag], Field(max_length=MAX_TAGS), AfterValidator(distinct)]
Priority = Annotated[int, Field(ge=-1000, le=1000)]
WebhookURL = Annotated[Text, Field(min_length=1, max_length=MAX_URL), AfterValidator(webhook_url)]
MaxWorkers = Annotated[int, Field(ge=1, le=4096)]


class SweepEdit(Request):
    """Fields of a sweep to change, at any time; what is left out stays as it is."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "weights on Pendulum, second try",
                    "notes": "With the *longer* horizon; see the first one.",
                    "tags": ["paper", "pendulum"],
                    "archived": False,
                    "priority": 5,
                    "max_workers": 2,
                    "webhook": "https://hooks.example.org/d3pg",
                }
            ]
        }
    )

    name: Name = Field(default="", description=NAME_TEXT)
    notes: Notes = Field(default="", description=NOTES_TEXT)
    tags: Tags = Field(default=[], description=f"{TAGS_TEXT} They replace the present tags.")
    archived: bool = Field(default=False, description="Lists leave archived sweeps out.")
    priority: Priority = Field(
        default=0, description=f"{PRIORITY_TEXT} It applies to runs that wait."
    )
    max_workers: MaxWorkers | None = Field(default=None, description=MAX_WORKERS_TEXT)
    webhook: WebhookURL | None = Field(default=None, description=WEBHOOK_TEXT)

    @property
    def changes(self) -> dict[str, Any]:
        """The fields to change, by their names in `Sweep`."""
        changes = self.model_dump(exclude_unset=True)
        return changes | ({"tags": tuple(self.tags)} if "tags" in changes else {})
