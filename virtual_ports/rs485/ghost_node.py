"""Ghost node: one that a fault puts on the wire, with somebody's address."""

from collections.abc import Callable

from hil.vocab.framing import Framing


class GhostNode:
    """Node that answers all that is sent to an address. ``answer(at_ns, raw)`` sends for it, at that time."""

    def __init__(
        self, framing: Framing, address: int, baud: int, answer: Callable[[int, bytes], None]
    ) -> None:
        self.baud_now = baud
        self._framing = framing
        self._address = address
        self._answer = answer

    def hear(self, start_ns: int, data: bytes, baud: int, packets: object = None) -> None:
        character_ns = 10 * 10**9 / baud
        for characters, raw in self._framing.answers(data, self._address):
            self._answer(start_ns + round(characters * character_ns), raw)

    def hear_characters(self, characters: object) -> None:
        """Ignored: in a collision it understands nothing."""

    def retract(self, after_ns: int) -> None:
        """Ignored: it finishes an answer that it has begun."""
