from collections import deque
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import Any, Generic, TypeVar

from typing_extensions import Buffer

from hil.sim.flight import Flight
from hil.vocab.framing import Framing, Item
from hil.vocab.time import SimTimeNs

class Wakes:
    framing: Framing | None
    is_loose: bool
    has_gap: bool
    before: bytes
    @property
    def times_ns(self) -> deque[int]: ...
    def add(self, flight: Flight) -> Sequence[int]: ...

_W = TypeVar("_W", bound=Wakes)

class RxLine(Generic[_W]):
    next_ns: SimTimeNs
    unread: Buffer
    is_woken: bool
    taken: int
    def __init__(self, wakes: _W, due_changed: Callable[[SimTimeNs | None], None]) -> None: ...
    @property
    def flights(self) -> list[Flight]: ...
    @property
    def wakes(self) -> _W: ...
    def add(self, flight: Flight) -> None: ...
    def hear(
        self,
        start_ns: int,
        data: bytes,
        baud: int,
        own_baud: int | None,
        framing: Framing | None,
        packets: Sequence[Item] | None,
    ) -> None: ...

def offered(lines: Sequence[RxLine[Any]], now_ns: int, from_ns: int) -> tuple[int, Flight] | None: ...

class Nothing(AbstractContextManager[None]):
    def __exit__(self, kind: object, error: object, trace: object) -> None: ...
