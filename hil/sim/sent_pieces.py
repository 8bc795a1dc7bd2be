"""Store of all that devices sent, for logs of hours: some 40 bytes a piece beside its own."""

from array import array
from collections.abc import Iterator, Sequence
from typing import overload

from hil.sim.input_log import Sent
from hil.vocab.time import SimTimeNs

_NONE = -1


class SentPieces(Sequence[Sent]):
    """Pieces in the order of the log."""

    def __init__(self) -> None:
        self._at_ns, self._states = array("q"), array("q")
        self._from = array("I")
        self._ends = array("Q")
        self._data = bytearray()
        self._places: list[tuple[str, str]] = []
        self._numbers: dict[tuple[str, str], int] = {}

    def append(self, at_ns: int, device: str, data: bytes, state: int | None, port: str) -> None:
        """Append a piece, in the fields of ``Sent``."""
        place = device, port
        if (number := self._numbers.get(place)) is None:
            number = self._numbers[place] = len(self._places)
            self._places.append(place)
        self._at_ns.append(at_ns)
        self._states.append(_NONE if state is None else state)
        self._from.append(number)
        self._data += data
        self._ends.append(len(self._data))

    def cut(self, length: int) -> None:
        """Leave out all after the first ``length`` pieces."""
        del self._data[self._ends[length - 1] if length else 0 :]
        for column in (self._at_ns, self._states, self._from, self._ends):
            del column[length:]

    def __len__(self) -> int:
        return len(self._ends)

    @overload
    def __getitem__(self, index: int) -> Sent: ...
    @overload
    def __getitem__(self, index: slice) -> list[Sent]: ...
    def __getitem__(self, index: int | slice) -> Sent | list[Sent]:
        if isinstance(index, slice):
            return [self[each] for each in range(*index.indices(len(self)))]
        end, at = self._ends[index], range(len(self))[index]
        device, port = self._places[self._from[at]]
        state = self._states[at]
        data = bytes(self._data[self._ends[at - 1] if at else 0 : end])
        return Sent(SimTimeNs(self._at_ns[at]), device, data, None if state == _NONE else state, port)

    def __iter__(self) -> Iterator[Sent]:
        return map(self.__getitem__, range(len(self)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)

    __hash__ = None  # type: ignore[assignment]
