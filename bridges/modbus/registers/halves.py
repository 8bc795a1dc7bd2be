"""Values of several registers that a client writes one after the other."""

from collections.abc import Mapping, MutableMapping

Halves = MutableMapping[int, int]
"""Holding registers that a client has written of values whose other registers it has not, by address."""


class WrittenWords:
    """Words of one write, completed with ``halves``, what the client wrote before; ``keep`` changes those."""

    def __init__(self, words: Mapping[int, int], halves: Halves) -> None:
        self._words, self._halves, self._known = words, halves, {**halves, **words}
        self._done: list[int] = []
        self._parts: dict[int, int] = {}

    def whole(self, addresses: range) -> tuple[int, ...] | None:
        """Words of a value; None: one of them was never written."""
        if all(address in self._known for address in addresses):
            self._done += addresses
            return tuple(self._known[address] for address in addresses)
        self._parts |= {address: self._words[address] for address in addresses if address in self._words}
        return None

    def keep(self) -> None:
        """Keep the words of the values that are not complete, and no more those of the others."""
        for address in self._done:
            self._halves.pop(address, None)
        self._halves.update(self._parts)
