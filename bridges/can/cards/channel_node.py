"""Node of a CAN bus without a device: what a channel's programs outside send goes on the bus from here."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence

from bridges.can.bus.bus_events import NodeState
from bridges.can.bus.can_bus import CanBus
from bridges.can.frames.can_frame import CanFrame, parse_frame
from hil.sim.client_tap import ClientChannel
from hil.sim.inputs import Attach, Detach, Frames, Input
from hil.vocab.time import FOREVER, SimTimeNs

MOST_WAITING = 1024
"""Frames that may wait. Linux gives an interface ten (its ``txqueuelen``), and lets senders wait; those of a
channel cannot be told to."""
MOST_NODES = 16
"""Channels of one bus."""


class ChannelNode(ClientChannel):
    """Node ``name`` on a bus. Frames go out one after the other, in the order in which they came, as from a
    driver with one mailbox; each takes part in the arbitration when it is the first.

    It hears everything, as it acknowledges, and is told of nothing: who looks on has it from the bus.
    """

    def __init__(self, name: str, bus: CanBus) -> None:
        self.name = name
        self.listeners: list[Callable[[], None]] = []
        self.refused = 0
        """Number of frames that came when too many waited, or the node was off the bus."""
        self._bus = bus
        self._queue: deque[CanFrame] = deque()
        self._is_sending = False
        self._is_on = True
        bus.join(name, self, filters=())

    @property
    def free(self) -> int:
        """Number of frames that may come now."""
        return MOST_WAITING - len(self._queue)

    def put(self, frames: Sequence[CanFrame]) -> None:
        """Send frames from now on; those for which there is no room are refused."""
        taken = frames[: self.free] if self._is_on else ()
        self.refused += len(frames) - len(taken)
        self._queue.extend(taken)
        self._send_next()

    def frames_problem(self, frames: Sequence[str]) -> str | None:
        try:
            for frame in frames:
                parse_frame(frame)
        except ValueError as error:
            return str(error)
        return None

    # ---- hil.sim.client_tap.ClientTap ----

    @property
    def speed(self) -> str:
        return f"{self._bus.bit_rate} bit/s"

    @property
    def notes(self) -> Mapping[int, str]:
        return {}

    def apply(self, given: Input, now_ns: SimTimeNs) -> None:
        match given:
            case Attach():
                self._switch(True)
            case Detach():
                self._switch(False)
            case Frames(frames):
                self.put([parse_frame(frame) for frame in frames])

    def room(self, now_ns: SimTimeNs) -> int:
        """Answer 0: no bytes come here."""
        return 0

    @property
    def room_ns(self) -> SimTimeNs:
        return FOREVER

    def drain(self, until_ns: int) -> bytes:
        return b""

    @property
    def next_ns(self) -> SimTimeNs:
        return FOREVER

    def _switch(self, is_on: bool) -> None:
        if is_on == self._is_on:
            return
        self._is_on = is_on
        self._queue.clear()
        self._is_sending = False
        if is_on:
            self._bus.switch_on(self.name)
        else:
            self._bus.switch_off(self.name)

    def _send_next(self) -> None:
        if self._queue and not self._is_sending:
            self._is_sending = True
            self._bus.send(self.name, self._queue[0])

    # ---- bridges.can.bus.bus_events.CanListener ----

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        """Do nothing: its filters let nothing in."""

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        if self._queue:
            self._queue.popleft()
        self._is_sending = False
        self._send_next()

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        """Do nothing: it comes back from bus-off by itself, and goes on."""
