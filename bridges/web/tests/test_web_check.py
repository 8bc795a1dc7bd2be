"""Shipped check of bridges, passed by the web bridge."""

from collections.abc import Mapping
from typing import Any

import aiohttp
import pytest

from bridges.web.bridge import Options, make
from hil.testing import check_bridge

OPTIONS = Options(listen="127.0.0.1:0")


async def ask(status: Mapping[str, Any]) -> bytes:
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f"{status['root']}ws", protocols=("hil.v1",)) as socket,
    ):
        await socket.send_json(
            {
                "id": 1,
                "do": "ask",
                "operation": "do",
                "target": "m1",
                "given": {"name": "wave", "parameters": {}},
            }
        )
        async for message in socket:
            if '"hello"' not in message.data:
                return str(message.data).encode()
    return b""


@pytest.mark.long
def test_it_keeps_to_what_bridges_keep_to() -> None:
    check_bridge(lambda desk: make(OPTIONS, desk), ask=ask)


@pytest.mark.long
def test_its_limits() -> None:
    request = b"GET /api/hello HTTP/1.1\r\nHost: localhost:1\r\n\r\n"  # refused, and answered
    check_bridge(lambda desk: make(OPTIONS, desk), request=request, only="limits")
