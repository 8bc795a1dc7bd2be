"""Protocols between a CANopen node and its device profile.

The node has the communication objects (1000h to 1FFFh) and all services; an application adds the entries of
its profile, and is told what was written, and when SYNC came.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Protocol

from bridges.can.canopen.abort_codes import ABORTS
from bridges.can.canopen.canopen_codes import NmtState

Value = int | float | bytes
"""Value of an entry: ``int`` of integers and BOOLEAN, ``float`` of reals, ``bytes`` of all else."""


class DataType(IntEnum):
    """Data type, by its index in an object dictionary (CiA 301, 7.4.7.1)."""

    BOOLEAN = 0x01
    INTEGER8 = 0x02
    INTEGER16 = 0x03
    INTEGER32 = 0x04
    UNSIGNED8 = 0x05
    UNSIGNED16 = 0x06
    UNSIGNED32 = 0x07
    REAL32 = 0x08
    VISIBLE_STRING = 0x09
    OCTET_STRING = 0x0A
    UNICODE_STRING = 0x0B
    DOMAIN = 0x0F
    INTEGER24 = 0x10
    REAL64 = 0x11
    INTEGER40 = 0x12
    INTEGER48 = 0x13
    INTEGER56 = 0x14
    INTEGER64 = 0x15
    UNSIGNED24 = 0x16
    UNSIGNED40 = 0x18
    UNSIGNED48 = 0x19
    UNSIGNED56 = 0x1A
    UNSIGNED64 = 0x1B


class Access(StrEnum):
    """Access of SDO clients. The value of a ``CONST`` entry never changes."""

    RO = "ro"
    WO = "wo"
    RW = "rw"
    CONST = "const"


@dataclass(frozen=True)
class Entry:
    """Object without sub-indices (``subindex`` is 0), or one of an object's sub-indices."""

    index: int
    subindex: int
    name: str
    data_type: DataType
    access: Access
    default: Value = 0
    low: int | float | None = None
    """Lowest value that may be written; of strings nothing."""
    high: int | float | None = None
    """Highest value that may be written; of strings the number of bytes."""
    mapping: str = ""
    """PDOs into which it may be mapped: none, ``rpdo``, ``tpdo`` or ``both``."""
    is_stored: bool = False
    """True if 1010h keeps it."""
    is_live: bool = False
    """True if the application is asked for the value each time."""
    about: str = ""
    """One sentence, for the reference."""
    adds_node_id: bool = False
    """True if the default value is ``default`` plus the node's id, as of a COB-ID."""
    is_hidden: bool = False
    """True if clients do not see it: the node alone has its value, as a maker's drive without this object."""


class SdoAbort(Exception):
    """Refusal of an SDO client's request; ``code`` is the answer."""

    def __init__(self, code: int, why: str = "") -> None:
        self.code = code
        super().__init__(why or ABORTS.get(code, f"abort {code:#010x}"))


class PendingWrite:
    """Write that takes time: it has neither gone nor failed before ``end`` says so."""

    def __init__(self) -> None:
        self._ended: tuple[int, int] | None = None
        self._calls: list[Callable[[int, int], None]] = []

    def then(self, call: Callable[[int, int], None]) -> None:
        """Call with 0 or the code of an abort, and the time, when it has ended: now, if it has."""
        if self._ended is None:
            self._calls.append(call)
        else:
            call(*self._ended)

    def end(self, code: int, now_ns: int) -> None:
        """End it, once: with 0 if it has gone, or with the code of an abort."""
        self._ended = (code, now_ns)
        for call in self._calls:
            call(code, now_ns)


class Application(Protocol):
    """Device profile: what the objects of a node from 2000h on mean.

    All times are nanoseconds of simulated time and never go back. What it raises except ``SdoAbort`` is a
    mistake in the program.
    """

    entries: Sequence[Entry]
    """All entries from 2000h on, sub-index 0 of arrays and records included; and those of 1000h to 1FFFh
    whose defaults are others than the node's, as of PDOs (``communication_entries.mapping_entries``)."""
    names: Mapping[int, str]
    """Names of the objects that have sub-indices, by index. An object whose entries from sub-index 1 on
    are of one type is an array; others are records."""
    device_type: int
    """Object 1000h."""

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        """Read an entry that is live. Raises SdoAbort."""

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        """Take a value that the node has checked for type, access and limits, and which the services tell
        from now on. Raises SdoAbort: the former one is put back. From an RPDO an abort means that this value
        alone is not taken; of several the services tell all from the first call on."""

    def synced(self, now_ns: int) -> None:
        """Take note of SYNC in OPERATIONAL: synchronous RPDOs were taken; TPDOs are sampled behind this."""

    def entered(self, state: NmtState, now_ns: int) -> None:
        """Take note of a state. INITIALISING: power-up, or "reset node"; all values are what they are at
        power-on, stored or default, and the application begins again. The next states follow."""

    def lost(self, what: str, now_ns: int) -> None:
        """Communication was lost: ``heartbeat`` or ``guarding`` of the master, ``bus-off``."""

    @property
    def due_ns(self) -> int:
        """Next time at which it wants ``step``; FOREVER if none. It is read behind each call of the node."""

    def step(self, now_ns: int) -> None:
        """Do what was due. It may be called earlier too."""
