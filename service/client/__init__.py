"""The Python client: submit sweeps, follow them, fetch what they measured.

    client = Client()                                   # the service on this machine
    sweep = client.submit({"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"],
                           "seeds": 4, "timesteps": 20_000})
    client.wait(sweep.id)
    curves = client.curves(sweep.id, normalized=True)

Answers are the service's own models (`service.api.schemas`), as the OpenAPI document shows them.
Importing this module loads neither numba nor torch nor ray.
"""

from service.client.access import find_token, own_url, trusted
from service.client.client import Client
from service.client.errors import ServiceError, SubmissionNotice
from service.client.request import Request, as_json
from service.client.results import TableText
from service.client.sweeps import has_ended

__all__ = [
    "Client",
    "Request",
    "ServiceError",
    "SubmissionNotice",
    "TableText",
    "as_json",
    "find_token",
    "has_ended",
    "own_url",
    "trusted",
]
