"""Shipped check of codecs, passed by the Telnet codec."""

from collections.abc import Sequence

import pytest

from hil.testing import check_codec
from virtual_ports.rfc2217.telnet import Telnet


class Reader:
    """Reader of what one client sends: bytes of the line one by one, and whole answers."""

    def __init__(self) -> None:
        self._telnet = Telnet("hil")

    def __call__(self, data: bytes, at_ns: int) -> Sequence[tuple[str, int]]:
        line, reply = self._telnet.decode(data)
        return [("line", byte) for byte in line] + [("reply", byte) for byte in reply]


def of(line: bytes, reply: str) -> list[object]:
    return [("line", byte) for byte in line] + [("reply", byte) for byte in bytes.fromhex(reply)]


@pytest.mark.long
def test_it_keeps_to_what_codecs_keep_to() -> None:
    """Check an escaped 255, the question for RFC 2217, and 38400 baud, with their answers."""
    messages = {
        b"a\xff\xffb": of(b"a\xffb", ""),
        b"\xff\xfd\x2c": of(b"", "fffb2c fffa2c6bb0fff0"),
        b"\xff\xfa\x2c\x01\x00\x00\x96\x00\xff\xf0": of(b"", "fffa2c6500009600fff0"),
    }
    check_codec(Reader, messages, recovers=False)
