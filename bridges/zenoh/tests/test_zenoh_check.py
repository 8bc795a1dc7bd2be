"""Shipped check of bridges, passed by the zenoh bridge, which a session of zenoh asks."""

import asyncio
import json
import socket
from collections.abc import Mapping
from typing import Any

import pytest
import zenoh

from bridges.zenoh.bridge import Options, make
from hil.testing import check_bridge


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


async def ask(status: Mapping[str, Any]) -> object:
    """Let ``m1`` wave, as a client."""
    return await asyncio.to_thread(_ask, status)


def _ask(status: Mapping[str, Any]) -> object:
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("connect/endpoints", json.dumps(status["listen"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        replies = session.get(f"{status['root']}/axis/m1/cmd/wave", payload=b"{}", timeout=5.0)
        return [json.loads(reply.ok.payload.to_bytes()) for reply in replies if reply.ok]


@pytest.mark.long
def test_it_keeps_to_what_bridges_keep_to() -> None:
    options = Options(listen=[f"tcp/127.0.0.1:{free_port()}"])
    check_bridge(lambda desk: make(options, desk), ask=ask)
