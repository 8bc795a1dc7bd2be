"""A tap: station of a segment for a program outside, as master, as node, or listening only."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import partial

from hil.sim.flight import heard
from hil.sim.inputs import Bytes, Input, Play
from hil.vocab.framing import Item
from hil.vocab.ports import SoleOf
from hil.vocab.segment import HeardCharacter, Segment
from hil.vocab.time import FOREVER, Clock, SimTimeNs
from hil.wire.serial_line import character_ns
from hil.wire.sole_senders import sole_by

TAP_ROOM_BYTES = 256
"""Maximum from a client that is not on the wire yet; more waits at the client."""


@dataclass(eq=False)
class Tap:
    """Station without a board. What a client sends goes on the wire at once and in order; ``heard`` keeps
    what the wire says, with its times, until ``drain``."""

    name: str
    segment: Segment
    clock: Clock
    baud: int
    """Speed of a client that has set none, in baud."""
    _: KW_ONLY
    client_baud: Callable[[], int | None] = lambda: None
    """Speed that a client has set, at which it sends and listens; None: it has set none. What others on the
    wire hear does not depend on it."""
    only_listens: bool = False
    is_real: bool = False
    """True if a real line hangs here: addresses that send there are left to the real nodes."""
    refused_bytes: int = 0
    """Number of bytes that a client sent to a tap that only listens."""
    heard: deque[tuple[int, int]] = field(default_factory=deque)
    """Time at which each character was complete, and the character."""
    listeners: list[Callable[[], None]] = field(default_factory=list)
    """Called when something was heard."""
    _free_ns: int = 0

    _gave_way: dict[str, int] = field(default_factory=dict)
    """Addresses that twins have left to real nodes here, by their stations."""

    def __post_init__(self) -> None:
        self._sent = self.segment.framing.splitter()
        self._bits = self.segment.line_format.bits

    @property
    def baud_now(self) -> int:
        """Speed at which a client listens now."""
        return self.client_baud() or self.baud

    @property
    def sole(self) -> SoleOf:
        """Function that says of the wire's bytes whether others on a real line here may send them."""
        return sole_by(
            self.segment.framing, lambda address: bool(self.segment.clashes_with(address, self.name))
        )

    @property
    def speed(self) -> str:
        """Speed of the wire, for people."""
        return f"{self.baud_now} baud"

    @property
    def notes(self) -> Mapping[int, str]:
        """Notes about real nodes that took a twin's place."""
        left_to = [each for each in self._gave_way.items() if self.segment.left_address(each[0]) == each[1]]
        return {
            number: f"address {address} is a real node: {station} was taken off the wire,"
            " until it has another address"
            for number, (station, address) in enumerate(left_to)
        }

    def apply(self, given: Input, now_ns: SimTimeNs) -> None:
        if isinstance(given, Play):
            for offset_ns, data in given.bursts:
                self.clock.at(now_ns + offset_ns, partial(self._send, bytes.fromhex(data), self.baud))
            return
        if not isinstance(given, Bytes):
            return
        if self.only_listens:
            self.refused_bytes += len(given.data)
            return
        if self.is_real:
            self._leave_to_real_nodes(given.data, now_ns)
        self._send(given.data, given.client_baud or self.baud, now_ns)

    def _send(self, data: bytes, baud: int, now_ns: SimTimeNs) -> None:
        start_ns = SimTimeNs(max(now_ns, self._free_ns))
        self._free_ns = start_ns + character_ns(len(data), baud, self._bits)
        self.segment.transmit(self.name, start_ns, data, baud)

    def _leave_to_real_nodes(self, data: bytes, now_ns: SimTimeNs) -> None:
        for item in self._sent.burst(data, now_ns, self.baud).items:
            if item.origin is not None and not item.fault:
                for station in self.segment.clashes_with(item.origin, self.name):
                    self.segment.give_way(station)
                    self._gave_way[station] = item.origin

    def room(self, now_ns: SimTimeNs) -> int:
        """Number of bytes that may be taken from a client."""
        waiting = max(self._free_ns - now_ns, 0) // character_ns(1, self.baud_now, self._bits)
        return max(0, TAP_ROOM_BYTES - int(waiting))

    @property
    def room_ns(self) -> SimTimeNs:
        """Time at which half of what may wait has gone out."""
        return SimTimeNs(max(0, self._free_ns - character_ns(TAP_ROOM_BYTES // 2, self.baud_now, self._bits)))

    def drain(self, until_ns: int) -> bytes:
        out = bytearray()
        while self.heard and self.heard[0][0] <= until_ns:
            out.append(self.heard.popleft()[1])
        return bytes(out)

    @property
    def next_ns(self) -> SimTimeNs:
        """Time at which the next character is complete, of those that are on the wire already."""
        return SimTimeNs(self.heard[0][0]) if self.heard else FOREVER

    # ---- hil.vocab.segment.Receiver ----

    def hear(
        self, start_ns: SimTimeNs, data: bytes, baud: int, packets: Sequence[Item] | None = None
    ) -> None:
        if flight := heard(start_ns, data, baud, self.baud_now, line_format=self.segment.line_format):
            self.heard.extend(flight.characters())
        self._tell()

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        self.heard.extend((each.at_ns, each.byte) for each in characters)
        self._tell()

    def _tell(self) -> None:
        for listener in self.listeners:
            listener()

    def retract(self, after_ns: SimTimeNs) -> None:
        self.heard = deque(each for each in self.heard if each[0] <= after_ns)
