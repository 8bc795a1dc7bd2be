"""Clients at the control socket: who comes in, and who is let go."""

import asyncio
import json
import socket
from pathlib import Path

from hil.net.visitors import Visit
from hil.operations.control_socket import MAX_CLIENTS, let_in, listen_at


async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, visit: Visit) -> None:
    await reader.readline()


def test_who_is_let_go_before_anybody_served_it_is_not_kept_waiting(tmp_path: Path) -> None:
    async def let_go() -> bytes:
        visitors = let_in(listen_at(tmp_path / "control.sock"), serve, 1000)
        ours, client = socket.socketpair()
        with client:
            client.setblocking(False)
            visitors.admit(ours)
            assert visitors.let_go()
            try:
                return await asyncio.wait_for(asyncio.get_running_loop().sock_recv(client, 1), 5)
            finally:
                visitors.close()

    assert asyncio.run(let_go()) == b""


async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, visit: Visit) -> None:
    writer.write(await reader.readline())
    await writer.drain()


def test_who_comes_before_anybody_is_served_waits_and_is_answered(tmp_path: Path) -> None:
    async def answered() -> bytes:
        listener = listen_at(tmp_path / "control.sock")
        reader, writer = await asyncio.open_unix_connection(tmp_path / "control.sock")
        writer.write(b"hello\n")
        await writer.drain()
        visitors = let_in(listener, echo, 1000)
        try:
            return await asyncio.wait_for(reader.readline(), 5)
        finally:
            writer.close()
            visitors.close()
            await asyncio.gather(*visitors.send_away(), return_exceptions=True)

    assert asyncio.run(answered()) == b"hello\n"


async def keep(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, visit: Visit) -> None:
    visit.is_busy = True
    await reader.read()


def test_who_comes_when_all_are_busy_is_told_so(tmp_path: Path) -> None:
    path = tmp_path / "control.sock"

    async def answered() -> bytes:
        visitors = let_in(listen_at(path), keep, 1000)
        clients = [await asyncio.open_unix_connection(path) for _ in range(MAX_CLIENTS)]
        while sum(visit.is_busy for visit in visitors.visits) < MAX_CLIENTS:
            await asyncio.sleep(0)
        reader, writer = await asyncio.open_unix_connection(path)
        clients.append((reader, writer))
        writer.write(b'{"verb": "status"}\n')
        try:
            return await asyncio.wait_for(reader.read(), 5)
        finally:
            for _, each in clients:
                each.close()
            visitors.close()
            await asyncio.gather(*visitors.send_away(), return_exceptions=True)

    answer = json.loads(asyncio.run(answered()))
    assert (answer["ok"], answer["code"]) == (False, "busy")
