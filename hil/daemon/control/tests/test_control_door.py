"""Who comes in at the control socket, and who is let go."""

import asyncio
import socket
from pathlib import Path

from hil.daemon.control.door import ControlDoor, Visit


async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, visit: Visit) -> None:
    await reader.readline()


def test_who_is_let_go_before_anybody_served_it_is_not_kept_waiting(tmp_path: Path) -> None:
    async def let_go() -> bytes:
        path = tmp_path / "control.sock"
        door = ControlDoor(path, serve, 1000)
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(str(path))
            client.setblocking(False)
            door._acceptor.accept()
            assert door._let_go()
            try:
                return await asyncio.wait_for(asyncio.get_running_loop().sock_recv(client, 1), 5)
            finally:
                door.close()

    assert asyncio.run(let_go()) == b""
