"""A CANopen node alone with a small device profile, and what it was told and has sent."""

from collections.abc import Callable
from types import MappingProxyType
from typing import Any, NamedTuple

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.application import Access, DataType, Entry, SdoAbort, Value
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import Identity, mapping_entries
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import FOREVER, NS_PER_MS

NODE = 5
IDENTITY = Identity(0x1122, 0x33445566, 0x10002, 77, "stub", "B", "2.1")
RO, WO, RW, CONST = Access.RO, Access.WO, Access.RW, Access.CONST
POSITION = Entry(0x2009, 0, "Position", DataType.INTEGER32, RW, 0, mapping="both", is_stored=True)
TORQUE = Entry(0x2003, 0, "Torque", DataType.INTEGER16, RW, 0, -100, 100, "both", is_stored=True)
TICKS = Entry(0x2005, 0, "Ticks", DataType.UNSIGNED32, RO, mapping="tpdo", is_live=True)
ENTRIES = (
    Entry(0x2000, 0, "Text", DataType.VISIBLE_STRING, RW, b"hello", high=4096, is_stored=True),
    Entry(0x2001, 0, "Bulk", DataType.DOMAIN, RW, b""),
    Entry(0x2002, 0, "Highest sub-index supported", DataType.UNSIGNED8, CONST, 3),
    *(
        Entry(0x2002, 1 + at, f"Gain {at}", DataType.UNSIGNED8, RW, at, 0, 200, "both", is_stored=True)
        for at in range(3)
    ),
    TORQUE,
    Entry(0x2004, 0, "Key", DataType.UNSIGNED32, WO, mapping="rpdo"),
    TICKS,
    Entry(0x2006, 0, "Picky", DataType.UNSIGNED8, RW, mapping="both"),
    Entry(0x2007, 0, "Ratio", DataType.REAL32, RW, 1.5, mapping="both", is_stored=True),
    Entry(0x2008, 0, "Serial", DataType.UNSIGNED64, RW, mapping="both"),
    POSITION,
    Entry(0x200A, 0, "Flag", DataType.BOOLEAN, RW),
    Entry(0x200B, 0, "Nowhere", DataType.UNSIGNED8, RW),
    Entry(0x6000, 0, "Limit", DataType.INTEGER8, RW, -3, is_stored=True),
    *mapping_entries(0x1600, (POSITION, TORQUE)),
    *mapping_entries(0x1A00, (TICKS, TORQUE)),
)
PICKY_REFUSES = 13


class StubApplication:
    """Profile that notes what it is told, as tuples. Ticks are milliseconds."""

    entries = ENTRIES
    names = MappingProxyType({0x2002: "Gains"})
    device_type = 0x0002_0192
    due_ns: int = FOREVER

    def __init__(self, services: CanOpenNode) -> None:
        self.services = services
        self.told: list[tuple[Any, ...]] = []
        self.read_fails = False

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        assert (index, subindex) == (0x2005, 0)
        if self.read_fails:
            raise SdoAbort(AbortCode.HARDWARE)
        return now_ns // NS_PER_MS

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        if index == 0x2006 and value == PICKY_REFUSES:
            raise SdoAbort(AbortCode.LOCAL_CONTROL)
        self.told.append(("write", index, subindex, value))

    def synced(self, now_ns: int) -> None:
        self.told.append(("synced",))

    def entered(self, state: NmtState, now_ns: int) -> None:
        self.told.append(("entered", state.name))

    def lost(self, what: str, now_ns: int) -> None:
        self.told.append(("lost", what))

    def step(self, now_ns: int) -> None:
        self.due_ns = FOREVER
        self.told.append(("step",))


class Sent(NamedTuple):
    """Frame that the node has sent."""

    at_ms: float
    frame: str


class Rig:
    """Node that is on from 0 ms, with a clock that goes as the test says."""

    def __init__(self, node_id: int = NODE, kept: bytes = b"", identity: Identity = IDENTITY) -> None:
        self.now_ns = 0
        self.sent: list[Sent] = []
        self.listeners: list[Callable[[CanFrame], None]] = []
        """Called with each frame that the node sends."""
        self.kept = kept
        self.memory_fails = False
        self.memory_waits = False
        """True if stores end by ``end_store``, and not at once."""
        self._stores: list[tuple[bytes, Callable[[bool, int], None]]] = []
        self.bit_rates: list[int] = []
        self.node = CanOpenNode(
            node_id,
            500_000,
            self._make,
            identity,
            self._send,
            kept=kept,
            keep=self._keep,
            use_bit_rate=self.bit_rates.append,
        )
        self.node.power_up(0)

    def _make(self, services: CanOpenNode) -> StubApplication:
        self.application = StubApplication(services)
        return self.application

    def _send(self, frame: CanFrame) -> None:
        self.sent.append(Sent(self.now_ns / NS_PER_MS, str(frame)))
        for listener in self.listeners:
            listener(frame)

    def _keep(self, section: bytes, stored: Callable[[bool, int], None]) -> None:
        self._stores.append((section, stored))
        if not self.memory_waits:
            self.end_store()

    def end_store(self) -> list[str]:
        """End the oldest store; answers what was sent since the last look."""
        section, stored = self._stores.pop(0)
        if not self.memory_fails:
            self.kept = section
        stored(not self.memory_fails, self.now_ns)
        return self.take() if self.memory_waits else []

    def run(self, to_ms: float) -> list[str]:
        """Let time pass up to and with a time; answers what was sent since the last look."""
        self.advance(to_ms)
        return self.take()

    def advance(self, to_ms: float) -> None:
        """Let time pass up to and with a time."""
        to_ns = round(to_ms * NS_PER_MS)
        while self.node.due_ns <= to_ns:
            self.now_ns = max(self.now_ns, self.node.due_ns)
            self.node.step(self.now_ns)
        self.now_ns = max(self.now_ns, to_ns)

    def hear(self, *texts: str) -> list[str]:
        """Give the node frames, as ``605#40001000``, at this time; answers what it has sent since the last
        look."""
        for text in texts:
            self.node.hear(frame_of(text), self.now_ns)
        return self.take()

    def take(self) -> list[str]:
        """Answer what was sent since the last look."""
        sent, self.sent = [each.frame for each in self.sent], []
        return sent

    def told(self, *kinds: str) -> list[tuple[Any, ...]]:
        """Answer what the application was told since the last look, of these kinds or of all."""
        told, self.application.told = self.application.told, []
        return [each for each in told if not kinds or each[0] in kinds]

    # ---- SDO ----

    def upload(self, index: int, subindex: int = 0) -> bytes | int:
        """Read up to four bytes; or the code of the abort."""
        (answer,) = self.hear(f"{0x600 + NODE:03X}#40{_multiplexer(index, subindex)}00000000")
        data = bytes.fromhex(answer.partition("#")[2])
        if data[0] == 0x80:
            return int.from_bytes(data[4:], "little")
        assert data[0] & 0xE3 == 0x43, answer
        return data[4 : 8 - (data[0] >> 2 & 3)]

    def download(self, index: int, subindex: int, data: bytes) -> int:
        """Write up to four bytes; answers 0 or the code of the abort. Other frames are left to look at."""
        command = 0x23 | (4 - len(data)) << 2
        text = (
            f"{0x600 + NODE:03X}#{command:02X}{_multiplexer(index, subindex)}{data.ljust(4, bytes(1)).hex()}"
        )
        before = self.sent
        self.sent = []
        answer, *others = sorted(self.hear(text), key=lambda sent: not sent.startswith("585#"))
        self.sent = [*before, *(Sent(self.now_ns / NS_PER_MS, other) for other in others)]
        found = bytes.fromhex(answer.partition("#")[2])
        return int.from_bytes(found[4:], "little") if found[0] == 0x80 else 0

    def put(self, index: int, subindex: int, value: int, size: int) -> None:
        """Write a number, which has to go."""
        assert self.download(index, subindex, value.to_bytes(size, "little")) == 0, hex(index)

    def map(self, index: int, entries: list[Entry | int], *, enable: bool = True) -> None:
        """Map by the book: ``index`` 1600h.. or 1A00h.."""
        cob_id = int.from_bytes(self.node.dictionary.upload(index - 0x200, 1, 0), "little") & 0x7FFF_FFFF
        self.put(index - 0x200, 1, cob_id | 1 << 31, 4)
        self.put(index, 0, 0, 1)
        for at, entry in enumerate(entries):
            value = entry if isinstance(entry, int) else mapping_entries(index, (entry,))[1].default
            assert isinstance(value, int)
            self.put(index, 1 + at, value, 4)
        self.put(index, 0, len(entries), 1)
        if enable:
            self.put(index - 0x200, 1, cob_id, 4)


def entry(index: int, subindex: int = 0) -> Entry:
    """Find an entry of the stub."""
    return next(each for each in ENTRIES if (each.index, each.subindex) == (index, subindex))


def frame_of(text: str) -> CanFrame:
    """Parse a frame in the notation of ``cansend``; blanks in the data do not count."""
    name, _, data = text.replace(" ", "").partition("#")
    if data.startswith("R"):
        return CanFrame(int(name, 16), b"", len(name) > 3, True, int(data[1:] or 0))
    return CanFrame(int(name, 16), bytes.fromhex(data), len(name) > 3)


def _multiplexer(index: int, subindex: int) -> str:
    return (index.to_bytes(2, "little") + bytes((subindex,))).hex()
