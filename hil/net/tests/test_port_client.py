"""Clients of ports with Telnet's escapes."""

import os
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.net.port_client import TelnetData, opened_port

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


COMMANDS = [
    b"\xff\xfb\x01",
    b"\xff\xfd\x00",
    b"\xff\xf1",
    b"\xff\xfa\x2c\x01\xff\xff\x00\xff\xf0",
    b"\xff\xfc\xff",
]


@given(
    st.lists(st.one_of(st.binary(max_size=4), st.sampled_from(COMMANDS).map(tuple)), max_size=12),
    st.lists(st.integers(1, 5)),
)
def test_commands_of_telnet_are_no_data(parts: list[bytes | tuple[int, ...]], pieces: list[int]) -> None:
    wire = b"".join(
        bytes(part) if isinstance(part, tuple) else part.replace(b"\xff", b"\xff\xff") for part in parts
    )
    data = b"".join(part for part in parts if isinstance(part, bytes))
    telnet, heard = TelnetData(), b""
    for piece in [*pieces, len(wire)]:
        heard += telnet.unescaped(wire[:piece])
        wire = wire[piece:]
    assert (heard, telnet.held) == (data, b"")
