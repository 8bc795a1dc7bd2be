"""Faces of a CAN bus for tests: frames at times, an adapter's serial line, and a CANopen drive."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from bridges.can.bus.bus_events import NodeState
from bridges.can.canopen import can_ids, sdo_frames
from bridges.can.canopen.canopen_codes import NmtCommand
from bridges.can.canopen.cia402_words import CONTROLWORD, STATUSWORD, DriveCommand, DriveState, state_of
from bridges.can.canopen.sdo_frames import ABORT_BYTE, EXPEDITED_BYTES, SEGMENT_BYTES, SdoRequest
from bridges.can.cards.bench_bus import BenchBus
from bridges.can.cards.can_tap import CanTap
from bridges.can.frames.can_frame import CanFrame
from bridges.can.testing.heard_frames import PATIENCE_MS, SLICE_MS, HeardFrame, HeardFrames
from hil.config.station_names import CANOPEN
from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Attach, Frames, Input, Logged
from hil.testing.faces import TapFace
from hil.testing.given import NamedThings, checked_bytes
from hil.vocab.address import Address
from hil.vocab.time import NS_PER_MS, SimTimeNs

if TYPE_CHECKING:
    from bridges.can.cards.canopen_card import CanOpenCard
    from bridges.can.testing.python_can_bus import PythonCanBus


class SdoAborted(Exception):
    """Abort of a transfer by the node; ``code`` says why."""

    def __init__(self, index: int, subindex: int, code: int) -> None:
        self.code = code
        super().__init__(f"{index:04X}h:{subindex:02X}: aborted, {code:#010x}")


class SdoClient:
    """Client of one node. ``exchange`` sends eight bytes and answers the eight that come."""

    def __init__(self, exchange: Callable[[bytes], bytes]) -> None:
        self._exchange = exchange

    def upload(self, index: int, subindex: int = 0) -> bytes:
        """Read an object. Raises SdoAborted."""
        answer = self._ask(index, subindex, sdo_frames.begin(SdoRequest.UPLOAD, index, subindex))
        if sdo_frames.is_expedited(answer):
            return sdo_frames.expedited(answer)
        data, toggle, is_last = b"", 0, False
        while not is_last:
            request = sdo_frames.segment_answer(SdoRequest.UPLOAD_SEGMENT, toggle)
            answer = self._ask(index, subindex, request)
            data += sdo_frames.part_of(answer)
            is_last = sdo_frames.is_last(answer)
            toggle ^= sdo_frames.TOGGLE
        return data

    def download(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object. Raises SdoAborted."""
        if 0 < len(data) <= EXPEDITED_BYTES:
            self._ask(index, subindex, sdo_frames.begin(SdoRequest.DOWNLOAD, index, subindex, data))
            return
        begun = sdo_frames.begin_segments(SdoRequest.DOWNLOAD, index, subindex, len(data))
        self._ask(index, subindex, begun)
        toggle = 0
        for begin in range(0, max(len(data), 1), SEGMENT_BYTES):
            part = data[begin : begin + SEGMENT_BYTES]
            is_last = begin + SEGMENT_BYTES >= len(data)
            self._ask(index, subindex, sdo_frames.segment(toggle, part, is_last=is_last))
            toggle ^= sdo_frames.TOGGLE

    def _ask(self, index: int, subindex: int, request: bytes) -> bytes:
        answer = self._exchange(request)
        if answer[0] == ABORT_BYTE:
            raise SdoAborted(index, subindex, sdo_frames.abort_code(answer))
        return answer


SERVO = "mechaduino"
"""Profile that needs a table to move."""
TESTER = "tester"
"""Name of the node that a test has on the bus, behind the bus's."""
ENABLING = DriveCommand.SHUTDOWN, DriveCommand.SWITCH_ON, DriveCommand.ENABLE
_MAILBOXES = 256

COMMANDS = {
    "operational": NmtCommand.START,
    "stopped": NmtCommand.STOP,
    "pre-operational": NmtCommand.PRE_OPERATIONAL,
    "reset": NmtCommand.RESET,
    "reset_communication": NmtCommand.RESET_COMMUNICATION,
}
"""Commands of network management, by the states that they lead to."""


class CanTapFace(TapFace):
    """Tap of a CAN bus, seen by the program that has its serial line open."""

    def __init__(self, runtime: BenchRuntime, tap: CanTap) -> None:
        super().__init__(runtime, tap)
        self._can_tap = tap

    def read_timed(self) -> list[tuple[SimTimeNs, int]]:
        """Read as ``read``: each character with the time at which it came."""
        pieces = self._can_tap.take_timed(self._runtime.now_ns)
        return [(SimTimeNs(at_ns), byte) for at_ns, data in pieces for byte in data]


class CanBusFace(HeardFrames):
    """A bus, with a node of the test's own on it, ``can0.tester``, that hears all frames of others."""

    def __init__(self, bench: Any, runtime: BenchRuntime, of: BenchBus) -> None:
        super().__init__(bench, of.name)
        self.bus = of.bus
        self._runtime = runtime
        self._group = runtime.parts.group_of(of.name)
        self._node = str(Address(of.name, TESTER))
        self.bus.join(self._node, self, mailboxes=_MAILBOXES)
        self._log(of.name, Attach(TESTER))

    # ---- frames ----

    def send(
        self, can_id: int, data: bytes = b"", *, at_ms: float | None = None, is_extended: bool = False
    ) -> None:
        """Send a frame now, or at a simulated time in ms."""
        __tracebackhide__ = True
        frame = CanFrame(can_id, checked_bytes(data), is_extended)
        self.send_frame(frame, at_ms=at_ms)

    def send_frame(self, frame: CanFrame, *, at_ms: float | None = None) -> None:
        """Send as ``send``, any frame."""
        if at_ms is None:
            self._send(frame)
        else:
            self._group.at(round(at_ms * NS_PER_MS), lambda now_ns: self._send(frame))

    def _send(self, frame: CanFrame) -> None:
        self.bus.send(self._node, frame)
        self._log(self._node, Frames((str(frame),)))

    def _log(self, target: str, given: Input) -> None:
        """Write down what a replay has to do in place of the test, as at a node of a channel."""
        if log := self._runtime.log:
            log.write(Logged(self._group.now_ns, target, given))

    def python_can(self, node: str = "python-can") -> "PythonCanBus":
        """Make a ``can.BusABC`` on this bus, a node of this name, for code that is written with python-can:
        its ``recv`` lets simulated time pass."""
        from bridges.can.testing.python_can_bus import PythonCanBus

        return PythonCanBus(self.bench, self._runtime, self.name, node)

    # ---- the bus ----

    def state(self, node: str) -> NodeState:
        """State of a node, as ``m1.canopen``, by its error counters."""
        return self.bus.state(node)

    def error_counters(self, node: str) -> tuple[int, int]:
        """Transmit and receive error counter of a node."""
        return self.bus.error_counters(node)

    @property
    def load_percent(self) -> float:
        """Share of the time since the start in which the bus was busy."""
        return float(self.bus.counters(self._runtime.now_ns)["load_percent"])

    def drive(self, axis: str) -> "DriveFace":
        """CANopen drive of an axis, by the axis's address. Raises KeyError: it has no node here."""
        __tracebackhide__ = True
        return DriveFace(self, axis, NamedThings(f"{self.name} drive", self._cards())[axis])

    def drives(self) -> "list[DriveFace]":
        """All drives on the bus, in the order of the configuration."""
        return [DriveFace(self, axis, card) for axis, card in self._cards().items()]

    def _cards(self) -> "dict[str, CanOpenCard]":
        cards = self._runtime.cards_on(self._runtime.wires[self.name])
        return {name.removesuffix(f".{CANOPEN}"): card for name, card in cards.items()}

    # ---- bridges.can.bus.bus_events.CanListener ----

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        self.heard.append(HeardFrame(end_ns, frame))

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        """Do nothing: what a test sends it knows."""

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        """Do nothing: a test asks."""


class DriveFace:
    """A CANopen drive, as a master sees it. What needs an answer lets time pass until it is there."""

    def __init__(self, canbus: CanBusFace, axis: str, card: "CanOpenCard") -> None:
        self.canbus, self.axis, self._card = canbus, axis, card
        self.sdo = SdoClient(self._exchange)

    @property
    def node_id(self) -> int:
        """Its node id."""
        return self._card.node_id

    def nmt(self, command: str) -> None:
        """Command a state: ``operational``, ``stopped``, ``pre-operational``, ``reset`` or
        ``reset_communication``. Raises KeyError: there is no such command."""
        __tracebackhide__ = True
        self.canbus.send(can_ids.NMT, bytes((NamedThings("NMT command", COMMANDS)[command], self.node_id)))

    def read(self, index: int, subindex: int = 0, *, is_signed: bool = False) -> int:
        """Read an object that is a whole number.

        Raises:
            SdoAborted: the node answers with an abort.
        """
        return int.from_bytes(self.sdo.upload(index, subindex), "little", signed=is_signed)

    def write(self, index: int, subindex: int, value: int, size: int) -> None:
        """Write a whole number of so many bytes.

        Raises:
            SdoAborted: the node answers with an abort.
        """
        self.sdo.download(index, subindex, value.to_bytes(size, "little", signed=value < 0))

    @property
    def statusword(self) -> int:
        """Object 6041h."""
        return self.read(STATUSWORD)

    def controlword(self, value: int) -> int:
        """Write object 6040h; answers the statusword then."""
        self.write(CONTROLWORD, 0, value, 2)
        return self.statusword

    def enable(self) -> int:
        """Go to "operation enabled" by shutdown, switch on and enable; answers the statusword."""
        return [self.controlword(word) for word in ENABLING][-1]

    def await_ready(self, within_ms: float = 10_000.0) -> None:
        """Let time pass until the board has started, and the drive can be switched on. Fails if it does
        not."""
        bench, end_ns = self.canbus.bench, self.canbus.bench.now_ns + within_ms * NS_PER_MS
        bench.run(SLICE_MS)
        while state_of(self.statusword) is not DriveState.SWITCH_ON_DISABLED:
            assert bench.now_ns < end_ns, f"{self.axis} is not ready within {within_ms:g} ms"
            bench.run(10 * SLICE_MS)

    def boot(self, within_ms: float = PATIENCE_MS) -> HeardFrame:
        """Await the boot-up message."""
        return self.canbus.expect(can_ids.ERROR_CONTROL + self.node_id, b"\0", within_ms=within_ms)

    def _exchange(self, data: bytes) -> bytes:
        self.canbus.read()
        self.canbus.send(can_ids.SDO_REQUEST + self.node_id, data)
        return self.canbus.expect(can_ids.SDO_ANSWER + self.node_id).frame.data


def canbus_config(
    drives: int, profile: str, bit_rate: int, first_id: int, switches: Mapping[str, Any]
) -> dict[str, Any]:
    """Make the configuration of a bench of drives on one bus, as the fixture ``canbus`` describes it.

    Raises:
        ValueError: they do not fit.
    """
    if drives < 1 or first_id < 1 or first_id + drives > 128:
        raise ValueError(f"{drives} drives from id {first_id} on do not fit: ids are 1 to 127")
    device: dict[str, Any] = {"profile": profile}
    if profile == SERVO:
        device["flash"] = {"table": "identity"}
    ids = {f"{profile[0]}{number}": first_id + number - 1 for number in range(1, drives + 1)}
    nodes = {name: {"id": node_id, "switches": switches} for name, node_id in ids.items()}
    bus = {"bit_rate": bit_rate, "nodes": nodes}
    return {"bench": "drives", "devices": dict.fromkeys(ids, device), "can": {"can0": bus}}
