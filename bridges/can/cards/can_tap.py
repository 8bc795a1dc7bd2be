"""A tap of a CAN bus: an slcan adapter, at whose serial line a program outside is.

What the client sends takes effect at once, as at an adapter on USB, and answers and frames are there at once,
a frame at the end of its last bit. The adapter sends in the client's order, whatever is more urgent. It is no
part of the bus until the client opens it, and stays open when the client goes, as real ones do.
"""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from bridges.can.bus.bus_events import MailboxesFull, NodeState
from bridges.can.bus.can_bus import CanBus
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.slcan import LINE_MAX, SlcanAdapter, SlcanStatus
from hil.sim.inputs import Bytes, Input, Play
from hil.vocab.time import FOREVER, NS_PER_MS, Clock, SimTimeNs

QUEUE_FRAMES = 64
"""Frames of the client that may wait. Decision: the queue of a larger adapter."""
SHORTEST_FRAME = 6
"""Characters of the shortest command that is a frame, with its end."""
CLOSED_ROOM = 256
"""Bytes that are taken at a time while the adapter is closed: no frame is among what it does."""
STUCK_NS = 1000 * NS_PER_MS
"""Time without a frame sent after which the client is not held up any more, but told that no mailbox is free:
nobody acknowledges, or others have all of the bus."""
_WARNING_FROM = 96
"""Error counter that is a warning. SJA1000 data sheet, 6.4.9, error warning limit register, default."""


class CanTap:
    """Adapter ``name`` on a bus. It is a node of the bus by that name."""

    def __init__(self, name: str, bus: CanBus, clock: Clock) -> None:
        self.name = name
        self.notes: dict[int, str] = {}
        self.listeners: list[Callable[[], None]] = []
        self._bus, self._clock = bus, clock
        self._adapter = SlcanAdapter(self)
        self._said: deque[tuple[int, bytes]] = deque()
        """Output for the client, with its times."""
        self._queue: deque[CanFrame] = deque()
        """Frames that are not sent yet, the oldest first."""
        self._is_given = False
        """True if the controller has the first of them."""
        self._moved_ns = 0
        """Time at which its frames last went forward: one was sent, or the first came."""
        self._is_short = False
        """True if the client has been held up, and nobody was told of room since."""
        self._seen = (0, 0)
        """Errors and lost arbitrations when the client last asked for the flags."""
        bus.join(name, self, is_on=False)

    # ---- hil.sim.client_tap.ClientTap ----

    @property
    def speed(self) -> str:
        return f"slcan, {self._bus.bit_rate} bit/s"

    def apply(self, given: Input, now_ns: SimTimeNs) -> None:
        if isinstance(given, Play):
            for offset_ns, data in given.bursts:
                self._clock.at(now_ns + offset_ns, partial(self._feed, bytes.fromhex(data)))
        elif isinstance(given, Bytes):
            self._feed(given.data, now_ns)

    def room(self, now_ns: SimTimeNs) -> int:
        if not self._adapter.is_open:
            return CLOSED_ROOM
        if free := QUEUE_FRAMES - len(self._queue):
            return free * SHORTEST_FRAME
        if now_ns >= self._moved_ns + STUCK_NS:
            return LINE_MAX
        self._is_short = True
        return 0

    @property
    def room_ns(self) -> SimTimeNs:
        return SimTimeNs(self._moved_ns + STUCK_NS if len(self._queue) == QUEUE_FRAMES else 0)

    def drain(self, until_ns: int) -> bytes:
        out = bytearray()
        while self._said and self._said[0][0] <= until_ns:
            out += self._said.popleft()[1]
        return bytes(out)

    def take_timed(self, until_ns: int) -> list[tuple[int, bytes]]:
        """Take as ``drain``, each piece with its time."""
        pieces = []
        while self._said and self._said[0][0] <= until_ns:
            pieces.append(self._said.popleft())
        return pieces

    @property
    def next_ns(self) -> SimTimeNs:
        return SimTimeNs(self._said[0][0]) if self._said else FOREVER

    def _feed(self, data: bytes, now_ns: SimTimeNs) -> None:
        self._say(now_ns, self._adapter.feed(data))

    def _say(self, at_ns: SimTimeNs, data: bytes) -> None:
        if data:
            self._said.append((at_ns, data))
            self._tell()

    def _tell(self) -> None:
        for listener in self.listeners:
            listener()

    # ---- bridges.can.frames.slcan.SlcanChannel ----

    def open(self, bit_rate: int, *, is_listening: bool) -> bool:
        """Go on the bus. With another rate than the bus has it destroys frames, as a real one does."""
        self._bus.set_listening(self.name, is_listening)
        self._bus.switch_on(self.name, bit_rate)
        self._seen = self._bus.tally(self.name)
        if bit_rate != self._bus.bit_rate:
            self.notes[0] = f"its client has opened it with {bit_rate} bit/s on a bus of {self._bus.bit_rate}"
        else:
            self.notes.clear()
        return True

    def close(self) -> None:
        self._bus.switch_off(self.name)
        self._queue.clear()
        self._is_given = False
        self.notes.clear()

    def send(self, frame: CanFrame) -> bool:
        if len(self._queue) == QUEUE_FRAMES:
            return False
        if not self._queue:
            self._moved_ns = self._clock.now_ns
        self._queue.append(frame)
        self._give()
        return True

    def _give(self) -> None:
        """Give the controller the first frame, if it has not got it."""
        if self._queue and not self._is_given:
            with suppress(MailboxesFull):  # a fault that babbles has all of them
                self._bus.send(self.name, self._queue[0])
                self._is_given = True

    def status(self) -> SlcanStatus:
        bus, name = self._bus, self.name
        state, counters = bus.state(name), bus.error_counters(name)
        seen, self._seen = self._seen, bus.tally(name)
        flags = {
            SlcanStatus.SEND_FULL: len(self._queue) == QUEUE_FRAMES,
            SlcanStatus.ERROR_WARNING: max(counters) >= _WARNING_FROM or state is NodeState.BUS_OFF,
            SlcanStatus.ERROR_PASSIVE: state in (NodeState.PASSIVE, NodeState.BUS_OFF),
            SlcanStatus.ARBITRATION_LOST: self._seen[1] > seen[1],
            SlcanStatus.BUS_ERROR: self._seen[0] > seen[0],
        }
        return SlcanStatus(sum(flag for flag, is_set in flags.items() if is_set))

    # ---- bridges.can.bus.bus_events.CanListener ----

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        self._say(end_ns, self._adapter.received(frame, end_ns))

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        self._moved_ns = end_ns
        if self._is_given and self._queue[0] is frame:
            self._queue.popleft()
            self._is_given = False
        self._give()
        if self._is_short:
            self._is_short = False
            self._tell()

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        """Do nothing: a client asks for the flags."""
