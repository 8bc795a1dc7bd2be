"""Error control: heartbeat of this node (1017h) and of others (1016h), and node guarding (100Ch, 100Dh).

Source: CiA 301 version 4.2.0, 7.2.8.2.2, 7.2.8.3.2 and 7.5.2.11, 7.5.2.12, 7.5.2.19, 7.5.2.20.
"""

from collections.abc import Callable
from functools import partial

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import NODE_ID_MAX
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.application import SdoAbort, Value
from bridges.can.canopen.node.emergency import Emergencies, ErrorCode
from bridges.can.canopen.node.object_dictionary import ObjectDictionary, SettingsOwner
from bridges.can.canopen.node.timers import Timers
from hil.vocab.time import NS_PER_MS

CONSUMED = 4
"""Nodes whose heartbeat 1016h can watch, unless a maker's file says otherwise."""
_TOGGLE = 0x80


class HeartbeatConsumer(SettingsOwner):
    """Watch over the heartbeats of other nodes. ``lost`` is called with the time when one is missing,
    ``on_new_ids`` when other nodes than before are watched."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        timers: Timers,
        emergencies: Emergencies,
        lost: Callable[[int], None],
        on_new_ids: Callable[[], None],
    ) -> None:
        self._dictionary = dictionary
        self._emergencies = emergencies
        self._lost = lost
        self._on_new_ids = on_new_ids
        count = dictionary.count(0x1016)
        self._timers = [timers.make(partial(self._miss, at)) for at in range(count)]
        self._watched = [0] * count
        """Values of 1016h."""
        dictionary.own((0x1016,), self)

    @property
    def node_ids(self) -> list[int]:
        """Nodes whose heartbeats are watched."""
        return [value >> 16 for value in self._watched if _is_used(value)]

    def load(self) -> None:
        """Take the settings from the dictionary; nothing is missed before it was heard once."""
        self._watched = [self._dictionary.number(0x1016, 1 + at) for at in range(len(self._watched))]
        for timer in self._timers:
            timer.stop()

    def hear(self, node_id: int, _: bytes, now_ns: int) -> None:
        """Take a heartbeat, or a boot-up message, of another node."""
        for at, value in enumerate(self._watched):
            if value >> 16 == node_id and _is_used(value):
                self._emergencies.end(("heartbeat", at))
                self._timers[at].start(now_ns + (value & 0xFFFF) * NS_PER_MS)

    def _miss(self, at: int, now_ns: int) -> None:
        self._emergencies.begin(
            ("heartbeat", at), ErrorCode.HEARTBEAT, bytes((self._watched[at] >> 16 & 0x7F,))
        )
        self._lost(now_ns)

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        assert isinstance(value, int)
        at = subindex - 1
        others = [each >> 16 for i, each in enumerate(self._watched) if i != at and _is_used(each)]
        if _is_used(value) and value >> 16 in others:
            raise SdoAbort(AbortCode.INCOMPATIBLE, "the heartbeat of this node is watched already")
        if value >> 24:
            raise SdoAbort(AbortCode.VALUE)
        self._watched[at] = value
        self._timers[at].stop()
        self._emergencies.end(("heartbeat", at))
        self._on_new_ids()


class ErrorControl(SettingsOwner):
    """Heartbeat and guarding of this node. ``send`` takes bytes for its identifier of error control; ``lost``
    is called with the time when the master has stopped to guard."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        timers: Timers,
        emergencies: Emergencies,
        send: Callable[[bytes], None],
        lost: Callable[[int], None],
    ) -> None:
        self._dictionary = dictionary
        self._emergencies = emergencies
        self._send = send
        self._lost = lost
        self._heartbeat = timers.make(self._beat)
        self._guarding = timers.make(self._miss)
        self._heartbeat_ns = self._life_ns = 0
        self._toggle = 0
        self._state = NmtState.INITIALISING
        dictionary.own((0x100C, 0x100D, 0x1017), self)

    def boot(self, now_ns: int) -> None:
        """Send the boot-up message, with the settings of the dictionary from here on."""
        self._heartbeat_ns = self._dictionary.number(0x1017) * NS_PER_MS
        self._take_life_time()
        self._toggle = 0
        self._send(b"\x00")
        self._restart(now_ns)

    def enter(self, state: NmtState) -> None:
        """Tell this state from now on."""
        self._state = state

    def hear_request(self, _: bytes, now_ns: int) -> None:
        """Answer the master's remote frame, if heartbeat is not used instead."""
        if self._heartbeat_ns:
            return
        self._send(bytes((self._toggle | self._state,)))
        self._toggle ^= _TOGGLE
        if self._life_ns:
            self._guarding.start(now_ns + self._life_ns)
            self._emergencies.end("guarding")

    def _restart(self, now_ns: int) -> None:
        if self._heartbeat_ns:
            self._guarding.stop()
            self._heartbeat.start(now_ns + self._heartbeat_ns)
        else:
            self._heartbeat.stop()

    def _beat(self, now_ns: int) -> None:
        self._heartbeat.start(now_ns + self._heartbeat_ns)
        self._send(bytes((self._state,)))

    def _miss(self, now_ns: int) -> None:
        self._emergencies.begin("guarding", ErrorCode.HEARTBEAT)
        self._lost(now_ns)

    def _take_life_time(self) -> None:
        number = self._dictionary.number
        self._life_ns = number(0x100C) * number(0x100D) * NS_PER_MS
        self._guarding.stop()

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        assert isinstance(value, int)
        if index == 0x1017:
            self._heartbeat_ns = value * NS_PER_MS
            self._restart(now_ns)
        else:
            self._take_life_time()
            self._emergencies.end("guarding")


def _is_used(watched: int) -> bool:
    """True if a value of 1016h has a node id and a time."""
    return 1 <= watched >> 16 <= NODE_ID_MAX and bool(watched & 0xFFFF)
