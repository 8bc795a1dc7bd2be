"""Clients of ports with Telnet's escapes."""

import os
import socket

import pytest

from hil.net.port_client import opened_port

HELD = bytes(range(256)) + b"\xff\xff\xffend"


def received(source: socket.socket | int, size: int) -> bytes:
    data = b""
    while len(data) < size:
        piece = os.read(source, size) if isinstance(source, int) else source.recv(size)
        assert piece, data
        data += piece
    return data


@pytest.mark.parametrize(
    ("scheme", "on_the_wire"), [("socket", HELD), ("rfc2217", HELD.replace(b"\xff", b"\xff\xff"))]
)
def test_all_bytes_pass_in_both_directions(scheme: str, on_the_wire: bytes) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = f"{scheme}://127.0.0.1:{listener.getsockname()[1]}"
        with opened_port(address) as port:
            board, _ = listener.accept()
            with board:
                os.write(port, HELD)
                assert received(board, len(on_the_wire)) == on_the_wire
                for byte in on_the_wire:  # the two halves of an escape come apart
                    board.sendall(bytes((byte,)))
                assert received(port, len(HELD)) == HELD
                board.shutdown(socket.SHUT_WR)
                assert os.read(port, 9) == b""


def test_what_was_written_last_goes_out_before_the_end() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        with opened_port(f"rfc2217://127.0.0.1:{listener.getsockname()[1]}") as port:
            board, _ = listener.accept()
            os.write(port, b"last")
        with board:
            assert received(board, 4) == b"last"
            assert board.recv(1) == b""
