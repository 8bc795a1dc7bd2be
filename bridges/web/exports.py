"""Captures that go out to pages, made while they do: only so many at a time."""

from base64 import b64encode
from collections.abc import Iterator

from bridges.web.outbox import LongText
from bridges.web.wire_streams import Captured
from hil.vocab.verbs import VerbRefused

MOST_EXPORTS = 8
"""Maximum number of captures of all pages that have not gone out: each may hold some megabytes."""
_TRIPLET = 3


class Exports:
    """Captures under way, of all pages."""

    def __init__(self) -> None:
        self._under_way: set[object] = set()

    def begin(self, page: object, number: int, captured: Captured) -> LongText:
        """Message with a capture. Raises VerbRefused: the page has one under way, or too many have."""
        if page in self._under_way:
            raise VerbRefused("not_now", "a capture is under way to this page; wait for it")
        if len(self._under_way) >= MOST_EXPORTS:
            raise VerbRefused("not_now", f"{MOST_EXPORTS} captures are under way to pages; try again")
        self._under_way.add(page)
        return LongText(_message(number, captured), 0, lambda: self._under_way.discard(page))


def _message(number: int, captured: Captured) -> Iterator[bytes]:
    """Answer in parts, each of some records."""
    yield f'{{"id":{number},"answer":{{"pcapng_base64":"'.encode()
    rest = b""
    for data in captured.pcapng():
        data = rest + data
        whole = len(data) - len(data) % _TRIPLET
        rest = data[whole:]
        yield b64encode(data[:whole])
    yield b64encode(rest)
    yield f'","events":{len(captured)}}}}}'.encode()
