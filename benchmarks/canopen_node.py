"""A CANopen node alone: time for an RPDO, a TPDO, an SDO, a block of SDO.

``canopen_cycle``: an RPDO of two objects, SYNC, and a TPDO of two live objects, in a node whose application
does nothing; the reference is 50 us, of which 100 nodes at 40 Hz would take a fifth of a core and 4 at 1 kHz
as much. ``canopen_sdo_*``: a request and its answer, beside the slave of the ``canopen`` library (extra dev)
in turns; it has no limits, owners and states to look at, and twice its time is allowed.
"""

import statistics
import struct
import time
from collections.abc import Callable, Mapping, Sequence

from _report import is_quick, report

from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.application import Access, DataType, Entry, Value
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import Identity, mapping_entries
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import FOREVER

ROUNDS = 2_000 if is_quick() else 20_000
RUNS = 3 if is_quick() else 11
CYCLE_LIMIT_US = 50.0
NODE = 5
CONTROL = Entry(0x6040, 0, "Controlword", DataType.UNSIGNED16, Access.RW, mapping="both")
STATUS = Entry(0x6041, 0, "Statusword", DataType.UNSIGNED16, Access.RO, mapping="tpdo", is_live=True)
ACTUAL = Entry(
    0x6064, 0, "Position actual value", DataType.INTEGER32, Access.RO, mapping="tpdo", is_live=True
)
TARGET = Entry(0x607A, 0, "Target position", DataType.INTEGER32, Access.RW, mapping="both")
BULK = Entry(0x2000, 0, "Bulk", DataType.DOMAIN, Access.RW, bytes(889))

Work = Callable[[], float]
"""Work that answers its time for one round, in seconds."""


class IdleDrive:
    """Device profile that takes everything and does nothing."""

    entries: Sequence[Entry] = (
        *(BULK, CONTROL, STATUS, ACTUAL, TARGET),
        *mapping_entries(0x1600, (CONTROL, TARGET)),
        *mapping_entries(0x1A00, (STATUS, ACTUAL)),
    )
    names: Mapping[int, str] = {}
    device_type = 0x0002_0192
    due_ns: int = FOREVER

    def __init__(self, services: CanOpenNode) -> None:
        pass

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        return 7

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None: ...
    def synced(self, now_ns: int) -> None: ...
    def entered(self, state: NmtState, now_ns: int) -> None: ...
    def lost(self, what: str, now_ns: int) -> None: ...
    def step(self, now_ns: int) -> None: ...


def node_of(sent: list[CanFrame]) -> CanOpenNode:
    node = CanOpenNode(NODE, 1_000_000, IdleDrive, Identity(0, 1, 1, 1, "idle"), sent.append)
    node.power_up(0)
    for index in (0x1400, 0x1800):
        node.hear(CanFrame(0x605, struct.pack("<BHBI", 0x2F, index, 2, 1)), 0)
    node.hear(CanFrame(0, bytes((1, NODE))), 0)
    return node


def timed(frames: Sequence[CanFrame], answers: int) -> float:
    """Time of a round in which a node hears these frames, and sends so many."""
    sent: list[CanFrame] = []
    node = node_of(sent)
    sent.clear()
    began = time.perf_counter()
    for now_ns in range(ROUNDS):
        for frame in frames:
            node.hear(frame, now_ns)
    took = time.perf_counter() - began
    assert len(sent) == answers * ROUNDS, len(sent)
    return took / ROUNDS


RPDO, SYNC = CanFrame(0x205, b"\x0f\0\1\2\3\4"), CanFrame(0x080)
READ = CanFrame(0x605, struct.pack("<BHBI", 0x40, 0x607A, 0, 0))
WRITE = CanFrame(0x605, struct.pack("<BHBI", 0x23, 0x607A, 0, 99))
BLOCK = [CanFrame(0x605, struct.pack(form, *values)) for form, values in (
    ("<BHBBBxx", (0xA4, 0x2000, 0, 127, 0)),
    ("<B7x", (0xA3,)),
    ("<BBB5x", (0xA2, 127, 127)),
    ("<B7x", (0xA1,)),
)]  # fmt: skip


def theirs(frame: CanFrame) -> float:
    """Time of the library's slave for a request."""
    import canopen
    from canopen.objectdictionary import ODVariable

    dictionary = canopen.ObjectDictionary()
    variable = ODVariable("Target position", 0x607A)
    variable.data_type = DataType.INTEGER32
    variable.access_type = "rw"
    dictionary.add_object(variable)
    network = canopen.Network()
    sent: list[bytes] = []
    network.send_message = lambda can_id, data, remote=False: sent.append(bytes(data))
    node = network.create_node(NODE, dictionary)
    node.sdo[0x607A].raw = 1
    sent.clear()
    data = bytearray(frame.data)
    began = time.perf_counter()
    for _ in range(ROUNDS):
        network.notify(frame.id, data, 0.0)
    took = time.perf_counter() - began
    assert len(sent) == ROUNDS, len(sent)
    return took / ROUNDS


def has_library() -> bool:
    try:
        import canopen
    except ImportError:
        return False
    return bool(canopen)


def medians(works: Mapping[str, Work]) -> dict[str, float]:
    """Median of each in microseconds, in turns."""
    found: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(RUNS):
        for name, work in works.items():
            found[name].append(work() * 1e6)
    return {name: statistics.median(times) for name, times in found.items()}


def main() -> None:
    works: dict[str, Work] = {
        "cycle": lambda: timed([RPDO, SYNC], 1),
        "rpdo": lambda: timed([RPDO], 0),
        "sync_tpdo": lambda: timed([SYNC], 1),
        "other": lambda: timed([CanFrame(0x206, RPDO.data)], 0),
        "sdo_read": lambda: timed([READ], 1),
        "sdo_write": lambda: timed([WRITE], 1),
        "block": lambda: timed(BLOCK, 129),
    }
    if has_library():
        works |= {"their_read": lambda: theirs(READ), "their_write": lambda: theirs(WRITE)}
    found = medians(works)
    parts = {f"{name}_us": found[name] for name in ("rpdo", "sync_tpdo", "other", "block")}
    report(
        "canopen_cycle",
        found["cycle"],
        "us",
        CYCLE_LIMIT_US,
        1.0,
        {"reference": "what 100 nodes at 40 Hz may take: 0.2 of a core", **parts},
    )
    for name in ("read", "write"):
        their = found.get(f"their_{name}", 0.0)
        about = {"reference": "the canopen library's slave" if their else "it is not installed"}
        report(f"canopen_sdo_{name}", found[f"sdo_{name}"], "us", their, 2.0 if their else None, dict(about))


if __name__ == "__main__":
    main()
