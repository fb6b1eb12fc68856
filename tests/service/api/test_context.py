"""A request's side: a figure whose client has gone is not drawn."""

from typing import Any

import anyio
import pytest
from anyio import to_thread
from fastapi import Request

from service.api.context import RequestedSide
from service.api.load.side_process import AbandonedError, SideProcess


async def asked(side: SideProcess, messages: list[dict[str, Any]]) -> Any:
    """What a request gets that has received these messages by the time of its turn."""

    async def receive() -> dict[str, Any]:
        if messages:
            return messages.pop(0)
        await anyio.sleep_forever()
        raise AssertionError

    request = Request({"type": "http"}, receive)
    return await to_thread.run_sync(RequestedSide(side, request).call, "operator:add", 2, 3)


def test_it_is_done_for_who_waits_and_for_nobody_else() -> None:
    side = SideProcess()
    try:
        assert anyio.run(asked, side, []) == 5
        with pytest.raises(AbandonedError):
            anyio.run(asked, side, [{"type": "http.disconnect"}])
    finally:
        side.close()
