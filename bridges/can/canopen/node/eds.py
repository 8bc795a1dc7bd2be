"""Electronic data sheet (EDS) of a node: its objects, for the tools of masters.

Source: CiA 306-1 version 1.3.0, 4 (EDS) and 7.
"""

from collections.abc import Iterator, Sequence

from bridges.can.canopen.node.application import Access, DataType, Entry, Value
from bridges.can.canopen.node.communication_entries import BIT_RATES, Identity
from bridges.can.canopen.node.data_types import size_of
from bridges.can.canopen.node.object_dictionary import ObjectDictionary
from bridges.can.canopen.node.pdo import DUMMIES
from bridges.can.canopen.node.pdos import RPDOS, TPDOS

_VAR, _DOMAIN, _ARRAY, _RECORD = 0x7, 0x2, 0x8, 0x9
_MANDATORY = (0x1000, 0x1001, 0x1018)
_MANUFACTURER = range(0x2000, 0x6000)
_RECORDS = (0x1018, *range(0x1200, 0x1300), *range(0x1400, 0x1C00))
"""Objects that are records though their sub-indices may be of one type (CiA 301, 7.4.8.1)."""
_DATE, _TIME = "01-01-2026", "12:00AM"
"""Time of the last change of the file's form: the same node has the same file on any day."""
_DUMMIES = range(1, 8)
_WAYS = {"tpdo": "rwr", "rpdo": "rww"}
"""Access of what can be read and written, but mapped one way only."""
_WITHOUT_VALUES = (DataType.DOMAIN, DataType.REAL32, DataType.REAL64)
"""Types whose values are left out: of reals some tools read a decimal number, others the bits as hex."""
_Row = tuple[str, str | int]


def eds_text(dictionary: ObjectDictionary, identity: Identity, file_name: str) -> str:
    """Write the EDS of a node, lines with LF. It is the same for each node id, and for the same objects
    byte by byte."""
    indexes = [index for index, _ in dictionary.objects()]
    groups = {
        "MandatoryObjects": [index for index in indexes if index in _MANDATORY],
        "OptionalObjects": [i for i in indexes if i not in _MANDATORY and i not in _MANUFACTURER],
        "ManufacturerObjects": [index for index in indexes if index in _MANUFACTURER],
    }
    lines = [
        *_section("FileInfo", _file_info(identity, file_name)),
        *_section("DeviceInfo", _device_info(identity, indexes)),
        *_section("DummyUsage", [(f"Dummy{at:04X}", int(at in DUMMIES)) for at in _DUMMIES]),
        *_section("Comments", [("Lines", 0)]),
    ]
    objects = dict(dictionary.objects())
    for name, group in groups.items():
        listed = [(str(at), f"0x{index:04X}") for at, index in enumerate(group, 1)]
        lines += _section(name, [("SupportedObjects", len(group)), *listed])
        for index in group:
            lines += _object(index, objects[index], dictionary.names.get(index, ""))
    return "\n".join(lines)


class StoredEds:
    """Object 1021h: the EDS as a device has it, lines with CR and LF."""

    def __init__(self, dictionary: ObjectDictionary, identity: Identity) -> None:
        self._dictionary, self._identity = dictionary, identity
        self._text = b""
        dictionary.own((0x1021,), self)

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        if not self._text:
            text = eds_text(self._dictionary, self._identity, f"{self._identity.name}.eds")
            self._text = text.replace("\n", "\r\n").encode("ascii")
        return self._text

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        raise AssertionError("1021h is read-only")


def _file_info(identity: Identity, file_name: str) -> list[_Row]:
    return [
        ("FileName", file_name),
        ("FileVersion", 1),
        ("FileRevision", 0),
        ("EDSVersion", "4.0"),
        ("Description", identity.name),
        ("CreationTime", _TIME),
        ("CreationDate", _DATE),
        ("CreatedBy", "hil"),
        ("ModificationTime", _TIME),
        ("ModificationDate", _DATE),
        ("ModifiedBy", "hil"),
    ]


def _device_info(identity: Identity, indexes: Sequence[int]) -> list[_Row]:
    return [
        ("VendorName", identity.vendor_name),
        ("VendorNumber", f"0x{identity.vendor_id:08X}"),
        ("ProductName", identity.name),
        ("ProductNumber", f"0x{identity.product_code:08X}"),
        ("RevisionNumber", f"0x{identity.revision:08X}"),
        ("OrderCode", identity.name),
        *((f"BaudRate_{rate // 1000}", int(rate in identity.bit_rates)) for rate in BIT_RATES),
        ("SimpleBootUpMaster", 0),
        ("SimpleBootUpSlave", 1),
        ("Granularity", 8),
        ("DynamicChannelsSupported", 0),
        ("CompactPDO", 0),
        ("GroupMessaging", 0),
        ("NrOfRXPDO", sum(index in RPDOS for index in indexes)),
        ("NrOfTXPDO", sum(index in TPDOS for index in indexes)),
        ("LSS_Supported", int(identity.has_lss)),
    ]


def _object(index: int, entries: Sequence[Entry], name: str) -> Iterator[str]:
    """Write the sections of an object: one, or one more for each sub-index."""
    if len(entries) == 1 and not name:
        yield from _section(f"{index:04X}", _rows(entries[0]))
        return
    is_array = len({entry.data_type for entry in entries[1:]}) == 1 and index not in _RECORDS
    rows: list[_Row] = [
        ("ParameterName", name),
        ("ObjectType", f"0x{_ARRAY if is_array else _RECORD:X}"),
        ("SubNumber", len(entries)),
    ]
    yield from _section(f"{index:04X}", rows)
    for entry in entries:
        yield from _section(f"{index:04X}sub{entry.subindex:X}", _rows(entry))


def _rows(entry: Entry) -> Iterator[_Row]:
    is_number = size_of(entry.data_type) > 0
    yield "ParameterName", entry.name
    yield "ObjectType", f"0x{_DOMAIN if entry.data_type is DataType.DOMAIN else _VAR:X}"
    yield "DataType", f"0x{entry.data_type:04X}"
    is_both_ways = entry.access is Access.RW
    yield "AccessType", _WAYS.get(entry.mapping, entry.access) if is_both_ways else entry.access.value
    if entry.data_type not in _WITHOUT_VALUES:
        yield "DefaultValue", _default(entry)
        if is_number and entry.low is not None:
            yield "LowLimit", str(entry.low)
        if is_number and entry.high is not None:
            yield "HighLimit", str(entry.high)
    yield "PDOMapping", int(bool(entry.mapping))


def _default(entry: Entry) -> str:
    value = entry.default
    if isinstance(value, bytes):
        return value.decode("latin-1") if entry.data_type is DataType.VISIBLE_STRING else value.hex().upper()
    if entry.adds_node_id:
        return f"$NODEID+0x{value:X}"
    return f"0x{value:08X}" if entry.data_type is DataType.UNSIGNED32 else str(value)


def _section(name: str, rows: Iterator[_Row] | Sequence[_Row]) -> Iterator[str]:
    yield f"[{name}]"
    for key, value in rows:
        yield f"{key}={_one_line(value)}"
    yield ""


def _one_line(value: str | int) -> str:
    """The value as one line of printable ASCII: everything else is left out."""
    return "".join(char if " " <= char <= "~" else "?" for char in str(value))
