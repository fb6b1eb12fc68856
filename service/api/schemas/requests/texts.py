"""What requests are made of: strict bodies, and texts that databases and pages can hold."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

MAX_NAME = 200


class Request(BaseModel):
    """A strict request body."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


def storable(text: str) -> str:
    """Return text that databases can hold exactly; raises ValueError for what they cannot."""
    if "\0" in text:
        raise ValueError("holds the character NUL, which databases cannot store")
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise ValueError("is not valid Unicode: it holds half of a surrogate pair")
    return text


def label_text(value: str) -> str:
    """Return a label; raises ValueError for what no table, legend or terminal can show as it is."""
    if not value.isprintable() or value != value.strip():
        raise ValueError("is not printable text without spaces around it")
    return value


Text = Annotated[str, AfterValidator(storable)]
Name = Annotated[Text, Field(min_length=1, max_length=MAX_NAME)]
