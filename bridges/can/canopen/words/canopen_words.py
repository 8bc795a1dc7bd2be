"""Frames of a CANopen network in words, those of LSS too.

Source: CiA 301, 7.2 and 7.3.5 (the identifiers of services that nodes have at first); CiA 305, chapter 6.
"""

from collections.abc import Callable, Mapping
from functools import partial

from bridges.can.canopen.can_ids import (
    EMCY,
    ERROR_CONTROL,
    LSS_ANSWER,
    LSS_REQUEST,
    NMT,
    SDO_ANSWER,
    SDO_REQUEST,
    SYNC,
    TIME,
)
from bridges.can.canopen.canopen_codes import ERROR_REGISTER, NMT_COMMANDS, NMT_STATES, emergency_words
from bridges.can.canopen.words.canopen_fields import (
    command_fields,
    emergency_fields,
    identifier_fields,
    nmt_fields,
    pdo_fields,
    sdo_fields,
    state_fields,
    sync_fields,
    time_fields,
)
from bridges.can.canopen.words.object_words import Names, ObjectWords
from bridges.can.canopen.words.pdo_words import PdoWords
from bridges.can.canopen.words.sdo_words import SdoWords
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.packet_field import Fields, PacketField
from hil.wire.packet_fields import bytes_field

_BIT_RATES = (1000, 800, 500, 250, 125, None, 50, 20, 10)
"""kbit/s by the index of the first table."""
_IDENTITY = ("vendor-id", "product code", "revision number", "serial number")
_MODES = ("waiting", "configuration")
_ANSWERS = ("done", "refused")


def lss_request(data: bytes) -> str:
    """Describe a frame of the master."""
    if len(data) != 8:
        return f"{len(data)} bytes, an LSS frame has 8"
    command, number = data[0], int.from_bytes(data[1:5], "little")
    if command == 0x04:
        return f"all: {_MODES[data[1]] if data[1] < 2 else f'unknown mode {data[1]}'}"
    if 0x40 <= command <= 0x43:
        return f"select by {_IDENTITY[command - 0x40]} {number:08X}h"
    if 0x46 <= command <= 0x4B:
        bounds = [f"{end} {name}" for name in _IDENTITY[2:] for end in ("lowest", "highest")]
        names = (*_IDENTITY[:2], *bounds)
        return f"who has {names[command - 0x46]} {number:08X}h"
    if command == 0x11:
        return f"set the node id to {data[1]}" if data[1] != 0xFF else "take the node id away"
    if command == 0x13:
        return f"set the bit rate to {_bit_rate(data[1], data[2])}"
    if command == 0x15:
        return f"switch to the new bit rate, {int.from_bytes(data[1:3], 'little')} ms before and behind"
    if 0x5A <= command <= 0x5D:
        return f"what is your {_IDENTITY[command - 0x5A]}"
    if command == 0x51:
        return _fastscan(data, number)
    plain = {0x17: "keep the configuration", 0x4C: "who has no node id yet", 0x5E: "what is your node id"}
    return plain.get(command, f"unknown command {command:02X}h")


def lss_response(data: bytes) -> str:
    """Describe a frame of a node."""
    if len(data) != 8:
        return f"{len(data)} bytes, an LSS frame has 8"
    command, number = data[0], int.from_bytes(data[1:5], "little")
    if command in (0x11, 0x13, 0x17):
        what = {0x11: "node id", 0x13: "bit rate", 0x17: "keep"}[command]
        return f"{what}: {_ANSWERS[data[1] > 0]}{f', reason {data[1]}.{data[2]}' if data[1] else ''}"
    if 0x5A <= command <= 0x5D:
        return f"{_IDENTITY[command - 0x5A]} {number:08X}h"
    if command == 0x5E:
        return "no node id" if data[1] == 0xFF else f"node id {data[1]}"
    plain = {0x44: "selected", 0x4F: "here is such a node", 0x50: "here is one without a node id"}
    return plain.get(command, f"unknown answer {command:02X}h")


def _fastscan(data: bytes, number: int) -> str:
    bit, at, following = data[5:8]
    if bit == 0x80:
        return "fastscan: who has no node id yet"
    if at > 3 or bit > 31:
        return "fastscan of what cannot be"
    wanted = f"{number:08X}h from bit {bit} on" if bit else f"{number:08X}h"
    then = "" if bit or following == at else f", then {_IDENTITY[following & 3]}"
    return f"fastscan: whose {_IDENTITY[at]} is {wanted}{then}"


def _bit_rate(table: int, index: int) -> str:
    rate = _BIT_RATES[index] if table == 0 and index < len(_BIT_RATES) else None
    if rate:
        return f"{rate} kbit/s"
    return "what is found" if table == 0 and index == 9 else f"number {index} of table {table}"


_NODES = range(1, 128)


_FIELDS_OF_ALL: Mapping[int, tuple[str, Callable[[bytes], Fields]]] = {
    NMT: ("NMT", nmt_fields),
    SYNC: ("SYNC", sync_fields),
    TIME: ("TIME", time_fields),
    LSS_REQUEST: ("LSS request", command_fields),
    LSS_ANSWER: ("LSS answer", command_fields),
}


class CanOpenWords:
    """Words for one network, whose frames come in the order in which they were on the bus: what SDOs read and
    wrote tells which values its PDOs have. ``names``: objects of nodes, by node id; ``initial``: values that
    they have before anything was seen, by index and sub-index."""

    def __init__(
        self,
        names: Mapping[int, Names] | None = None,
        initial: Mapping[int, Mapping[tuple[int, int], bytes]] | None = None,
    ) -> None:
        self._objects = {node: ObjectWords(each) for node, each in (names or {}).items()}
        self._others = ObjectWords()
        self._sdo: dict[int, SdoWords] = {}
        self._pdos = PdoWords()
        for node, values in (initial or {}).items():
            for (index, subindex), data in values.items():
                self._pdos.note(node, index, subindex, data)

    def say(self, frame: CanFrame) -> str:
        """Say a frame; empty if it is none of CANopen's."""
        if frame.is_extended:
            return ""
        identifier, data = frame.id, frame.data
        node = identifier & 0x7F
        if frame.is_remote:
            return self._remote(identifier, node)
        if identifier in (NMT, SYNC, TIME, LSS_ANSWER, LSS_REQUEST):
            return _of_all(identifier, data)
        if node not in _NODES:
            return ""
        service = identifier & ~0x7F
        if service == EMCY:
            return f"EMCY of {node}: {_emergency(data)}"
        if service == SDO_REQUEST:
            return f"SDO to {node}: {self._dialogue(node).request(data)}"
        if service == SDO_ANSWER:
            return f"SDO from {node}: {self._dialogue(node).response(data)}"
        if service == ERROR_CONTROL:
            return _error_control(node, data)
        return self._pdo(identifier, data)

    def fields(self, frame: CanFrame) -> Fields:
        """Fields of a frame that ``say`` has said last."""
        identifier, data, node = frame.id, frame.data, frame.id & 0x7F
        digits = f"{identifier:08X}h, 29 bits" if frame.is_extended else f"{identifier:03X}h"
        if frame.is_remote:
            return [*identifier_fields(digits), PacketField("remote", f"asks for {frame.dlc} bytes")]
        if frame.is_extended:
            return [*identifier_fields(digits), *bytes_field(data)]
        if identifier in _FIELDS_OF_ALL:
            service, fields = _FIELDS_OF_ALL[identifier]
            return [*identifier_fields(digits, [("service", service)]), *fields(data)]
        service, found = self._fields_of_node(identifier, node, data)
        parts = [("service", service), ("node", str(node))] if service else []
        return [*identifier_fields(digits, parts), *found]

    def _fields_of_node(self, identifier: int, node: int, data: bytes) -> tuple[str, Fields]:
        """Service of a node, empty if it is none of CANopen's, and the fields of the data."""
        service = identifier & ~0x7F
        if node in _NODES and service == EMCY:
            return "EMCY", emergency_fields(data)
        if node in _NODES and service == ERROR_CONTROL:
            return "error control", state_fields(data)
        if node in _NODES and service in (SDO_REQUEST, SDO_ANSWER):
            is_request, dialogue = service == SDO_REQUEST, self._dialogue(node)
            objects = self._objects.get(node, self._others)
            is_segment = dialogue.is_in_block(is_request=is_request)
            fields = sdo_fields(data, objects, is_request=is_request, is_block_segment=is_segment)
            return f"SDO {'request' if is_request else 'answer'}", fields
        if node in _NODES and (pdo := self._pdos.find(identifier)):
            objects = self._objects.get(pdo.node, self._others)
            return f"{pdo.kind}{pdo.number}", pdo_fields(data, self._pdos.mapping(pdo), objects)
        return "", bytes_field(data)

    def _remote(self, identifier: int, node: int) -> str:
        if identifier & ~0x7F == ERROR_CONTROL and node in _NODES:
            return f"guarding of {node}: what is your state"
        pdo = self._pdos.find(identifier)
        return f"{pdo} is asked for" if pdo else ""

    def _pdo(self, identifier: int, data: bytes) -> str:
        if (pdo := self._pdos.find(identifier)) is None:
            return ""
        values = self._pdos.say(pdo, data, self._objects.get(pdo.node, self._others))
        return f"{pdo}: {values}" if values else str(pdo)

    def _dialogue(self, node: int) -> SdoWords:
        if node not in self._sdo:
            objects = self._objects.get(node, self._others)
            self._sdo[node] = SdoWords(objects, partial(self._pdos.note, node))
        return self._sdo[node]


def _of_all(identifier: int, data: bytes) -> str:
    """Say a frame whose identifier is of no node."""
    if identifier == NMT:
        return f"NMT {_nmt(data)}"
    if identifier == SYNC:
        return f"SYNC {data[0]}" if len(data) == 1 else "SYNC" if not data else f"SYNC with {len(data)} bytes"
    if identifier == TIME:
        return f"TIME {_time(data)}"
    return (
        f"LSS: {lss_request(data)}" if identifier == LSS_REQUEST else f"LSS of a node: {lss_response(data)}"
    )


def _nmt(data: bytes) -> str:
    if len(data) != 2:
        return f"with {len(data)} bytes, it has 2"
    whom = f"node {data[1]}" if data[1] else "all nodes"
    return f"to {whom}: {NMT_COMMANDS.get(data[0], f'unknown command {data[0]}')}"


def _time(data: bytes) -> str:
    if len(data) != 6:
        return f"with {len(data)} bytes, it has 6"
    of_day_ms = int.from_bytes(data[:4], "little") & 0x0FFF_FFFF
    return f"{of_day_ms / 1000:.3f} s of day {int.from_bytes(data[4:], 'little')} since 1984"


def _emergency(data: bytes) -> str:
    if len(data) != 8:
        return f"{len(data)} bytes, it has 8"
    code, register, own = int.from_bytes(data[:2], "little"), data[2], data[3:]
    bits = [name for bit, name in enumerate(ERROR_REGISTER) if register >> bit & 1]
    named = f" ({', '.join(bits)})" if bits else ""
    more = f", manufacturer {own.hex(' ')}" if any(own) else ""
    return f"{emergency_words(code)} ({code:04X}h), error register {register:02X}h{named}{more}"


def _error_control(node: int, data: bytes) -> str:
    if len(data) != 1:
        return f"error control of {node} with {len(data)} bytes, it has 1"
    if data[0] == 0:
        return f"boot-up of {node}"
    state = NMT_STATES.get(data[0] & 0x7F, f"unknown state {data[0] & 0x7F}")
    toggled = ", toggled" if data[0] & 0x80 else ""
    return f"heartbeat of {node}: {state}{toggled}"
