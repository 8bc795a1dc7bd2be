"""Entries of the communication profile area, 1000h to 1FFFh, that every node has.

Source: CiA 301 version 4.2.0, 7.5.2.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from bridges.can.canopen.can_ids import EMCY, RPDO, SDO_ANSWER, SDO_REQUEST, SYNC, TPDO
from bridges.can.canopen.node.application import Access, DataType, Entry, Value
from bridges.can.canopen.node.data_types import size_of
from bridges.can.canopen.node.emergency import HISTORY
from bridges.can.canopen.node.error_control import CONSUMED

BIT_RATES = (10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""Bits per second that a data sheet can name."""
PDOS = 4
MAPPED = 8
"""Objects of one PDO."""
COMMUNICATION_NAMES: Mapping[int, str] = {
    0x1003: "Pre-defined error field",
    0x1010: "Store parameters",
    0x1011: "Restore default parameters",
    0x1016: "Consumer heartbeat time",
    0x1018: "Identity object",
    0x1029: "Error behavior",
    0x1200: "SDO server parameter",
    **{0x1400 + at: f"RPDO communication parameter {at + 1}" for at in range(PDOS)},
    **{0x1600 + at: f"RPDO mapping parameter {at + 1}" for at in range(PDOS)},
    **{0x1800 + at: f"TPDO communication parameter {at + 1}" for at in range(PDOS)},
    **{0x1A00 + at: f"TPDO mapping parameter {at + 1}" for at in range(PDOS)},
}
_U8, _U16, _U32, _TEXT = (
    DataType.UNSIGNED8,
    DataType.UNSIGNED16,
    DataType.UNSIGNED32,
    DataType.VISIBLE_STRING,
)
_RO, _RW, _CONST = Access.RO, Access.RW, Access.CONST


class Identity(NamedTuple):
    """Identity of a node: 1018h, by which LSS finds it too, and 1008h to 100Ah."""

    vendor_id: int
    product_code: int
    revision: int
    serial_number: int
    name: str
    hardware_version: str = "1.0"
    software_version: str = "1.0"
    vendor_name: str = "hil"
    bit_rates: tuple[int, ...] = BIT_RATES
    """Bits per second that it knows."""
    has_lss: bool = True


def communication_entries(device_type: int, identity: Identity) -> list[Entry]:
    """List all entries from 1000h to 1FFFh."""
    return [
        Entry(0x1000, 0, "Device type", _U32, _RO, device_type),
        Entry(0x1001, 0, "Error register", _U8, _RO, mapping="tpdo", is_live=True),
        *_errors(),
        Entry(0x1005, 0, "COB-ID SYNC message", _U32, _RW, SYNC, is_stored=True),
        Entry(0x1006, 0, "Communication cycle period", _U32, _RW, is_stored=True),
        Entry(0x1007, 0, "Synchronous window length", _U32, _RW, is_stored=True),
        Entry(0x1008, 0, "Manufacturer device name", _TEXT, _CONST, identity.name.encode()),
        Entry(0x1009, 0, "Manufacturer hardware version", _TEXT, _CONST, identity.hardware_version.encode()),
        Entry(0x100A, 0, "Manufacturer software version", _TEXT, _CONST, identity.software_version.encode()),
        Entry(0x100C, 0, "Guard time", _U16, _RW, is_stored=True),
        Entry(0x100D, 0, "Life time factor", _U8, _RW, is_stored=True),
        *_store(0x1010, "Save"),
        *_store(0x1011, "Restore"),
        Entry(0x1014, 0, "COB-ID EMCY", _U32, _RW, EMCY, is_stored=True, adds_node_id=True),
        Entry(0x1015, 0, "Inhibit time EMCY", _U16, _RW, is_stored=True),
        _highest(0x1016, CONSUMED),
        *(Entry(0x1016, 1 + at, f"Consumer heartbeat time {at + 1}", _U32, _RW, is_stored=True)
          for at in range(CONSUMED)),
        Entry(0x1017, 0, "Producer heartbeat time", _U16, _RW, is_stored=True),
        _highest(0x1018, 4),
        Entry(0x1018, 1, "Vendor-ID", _U32, _RO, identity.vendor_id),
        Entry(0x1018, 2, "Product code", _U32, _RO, identity.product_code),
        Entry(0x1018, 3, "Revision number", _U32, _RO, identity.revision),
        Entry(0x1018, 4, "Serial number", _U32, _RO, identity.serial_number),
        Entry(0x1019, 0, "Synchronous counter overflow value", _U8, _RW, is_stored=True),
        Entry(0x1021, 0, "Store EDS", DataType.DOMAIN, _RO, b"", is_live=True),
        Entry(0x1022, 0, "Store format", _U8, _RO, 0),
        _highest(0x1029, 1),
        Entry(0x1029, 1, "Communication error", _U8, _RW, 0, 0, 2, is_stored=True),
        _highest(0x1200, 2),
        Entry(0x1200, 1, "COB-ID client to server", _U32, _RO, SDO_REQUEST, adds_node_id=True),
        Entry(0x1200, 2, "COB-ID server to client", _U32, _RO, SDO_ANSWER, adds_node_id=True),
        *(entry for at in range(PDOS) for entry in (*_rpdo(at), *_tpdo(at))),
    ]  # fmt: skip


def mapping_value(entry: Entry) -> int:
    """Value by which 1600h and 1A00h name a mapped entry."""
    return entry.index << 16 | entry.subindex << 8 | 8 * size_of(entry.data_type)


def mapping_entries(index: int, mapped: Sequence[Entry]) -> list[Entry]:
    """List the entries of a mapping (1600h to 1603h, 1A00h to 1A03h) that has these by default. Those that an
    application has take the place of the node's own."""
    values = [*map(mapping_value, mapped), *(0,) * (MAPPED - len(mapped))]
    return [
        Entry(index, 0, "Number of mapped objects", _U8, _RW, len(mapped), 0, MAPPED, is_stored=True),
        *(Entry(index, 1 + at, f"Mapped object {at + 1}", _U32, _RW, value, is_stored=True)
          for at, value in enumerate(values)),
    ]  # fmt: skip


def _highest(index: int, value: Value) -> Entry:
    return Entry(index, 0, "Highest sub-index supported", _U8, _CONST, value)


def _errors() -> list[Entry]:
    return [
        Entry(0x1003, 0, "Number of errors", _U8, _RW, is_live=True),
        *(Entry(0x1003, 1 + at, f"Standard error field {at + 1}", _U32, _RO, is_live=True)
          for at in range(HISTORY)),
    ]  # fmt: skip


def _store(index: int, verb: str) -> list[Entry]:
    kinds = ("all", "communication", "application", "manufacturer defined")
    return [
        _highest(index, len(kinds)),
        *(Entry(index, 1 + at, f"{verb} {kind} parameters", _U32, _RW, is_live=True)
          for at, kind in enumerate(kinds)),
    ]  # fmt: skip


def _rpdo(at: int) -> list[Entry]:
    index = 0x1400 + at
    return [
        _highest(index, 5),
        Entry(index, 1, "COB-ID used by RPDO", _U32, _RW, RPDO[at], is_stored=True, adds_node_id=True),
        Entry(index, 2, "Transmission type", _U8, _RW, 255, is_stored=True),
        Entry(index, 5, "Event timer", _U16, _RW, is_stored=True),
        *mapping_entries(0x1600 + at, ()),
    ]


def _tpdo(at: int) -> list[Entry]:
    index = 0x1800 + at
    return [
        _highest(index, 6),
        Entry(index, 1, "COB-ID used by TPDO", _U32, _RW, TPDO[at], is_stored=True, adds_node_id=True),
        Entry(index, 2, "Transmission type", _U8, _RW, 255, is_stored=True),
        Entry(index, 3, "Inhibit time", _U16, _RW, is_stored=True),
        Entry(index, 5, "Event timer", _U16, _RW, is_stored=True),
        Entry(index, 6, "SYNC start value", _U8, _RW, 0, 0, 240, is_stored=True),
        *mapping_entries(0x1A00 + at, ()),
    ]
