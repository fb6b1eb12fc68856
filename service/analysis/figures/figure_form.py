"""The file formats of figures."""

from collections.abc import Mapping
from typing import Literal

Form = Literal["png", "svg", "pdf"]

MEDIA_TYPES: Mapping[Form, str] = {
    "png": "image/png",
    "svg": "image/svg+xml",
    "pdf": "application/pdf",
}
