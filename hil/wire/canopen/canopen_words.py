"""Frames of a CANopen network in words.

Source: CiA 301, 7.2 and 7.3.5 (the identifiers of services that nodes have at first).
"""

from collections.abc import Mapping
from functools import partial

from hil.wire.can.can_frame import CanFrame
from hil.wire.canopen.canopen_codes import ERROR_REGISTER, NMT_COMMANDS, NMT_STATES, emergency_words
from hil.wire.canopen.lss_words import lss_request, lss_response
from hil.wire.canopen.object_words import Names, ObjectWords
from hil.wire.canopen.pdo_words import PdoWords
from hil.wire.canopen.sdo_words import SdoWords

_NMT, _SYNC, _TIME, _LSS_NODE, _LSS_MASTER = 0x000, 0x080, 0x100, 0x7E4, 0x7E5
_EMCY, _SDO_FROM, _SDO_TO, _ERROR_CONTROL = 0x080, 0x580, 0x600, 0x700
_NODES = range(1, 128)


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
        if identifier in (_NMT, _SYNC, _TIME, _LSS_NODE, _LSS_MASTER):
            return _of_all(identifier, data)
        if node not in _NODES:
            return ""
        service = identifier & ~0x7F
        if service == _EMCY:
            return f"EMCY of {node}: {_emergency(data)}"
        if service == _SDO_TO:
            return f"SDO to {node}: {self._dialogue(node).request(data)}"
        if service == _SDO_FROM:
            return f"SDO from {node}: {self._dialogue(node).response(data)}"
        if service == _ERROR_CONTROL:
            return _error_control(node, data)
        return self._pdo(identifier, data)

    def _remote(self, identifier: int, node: int) -> str:
        if identifier & ~0x7F == _ERROR_CONTROL and node in _NODES:
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
    if identifier == _NMT:
        return f"NMT {_nmt(data)}"
    if identifier == _SYNC:
        return f"SYNC {data[0]}" if len(data) == 1 else "SYNC" if not data else f"SYNC with {len(data)} bytes"
    if identifier == _TIME:
        return f"TIME {_time(data)}"
    return (
        f"LSS: {lss_request(data)}" if identifier == _LSS_MASTER else f"LSS of a node: {lss_response(data)}"
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
