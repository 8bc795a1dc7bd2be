"""Bytes that go out on a line of packets, and whether another station may send the same soon."""

from collections.abc import Callable

from bridges.modbus.protocol._crc16 import crc16
from bridges.modbus.protocol.exchange import is_answered_alike
from bridges.modbus.protocol.frame import FRAME_BYTES_MIN, TO_ALL
from bridges.modbus.protocol.rtu_framing import ModbusRtu
from hil.vocab.framing import Framing
from hil.vocab.ports import Sole, SoleOf
from hil.vocab.time import SimTimeNs

IsHere = Callable[[int], bool]
"""Says whether a node with this address is on this side of the line, and none with it on the other."""
_ANY_BAUD = 9600


def sole_by(framing: Framing, is_here: IsHere) -> SoleOf:
    """Make what says it of bytes on a line with this framing."""
    if isinstance(framing, ModbusRtu):
        return lambda data: sole_of_frame(data, is_here)
    return lambda data: sole_of_packets(framing, data)


def sole_of_frame(data: bytes, is_here: IsHere) -> Sole | None:
    """Say it of a frame of Modbus RTU: some answers equal their questions."""
    if len(data) < FRAME_BYTES_MIN or crc16(data):
        return None
    if data[0] == TO_ALL or not is_answered_alike(data):
        return Sole.ALONE
    return Sole.HERE if is_here(data[0]) else Sole.UNSURE


def sole_of_packets(framing: Framing, data: bytes) -> Sole | None:
    """Say it of packets: where each names its sender, nobody else sends the same."""
    if framing.has_ends and not framing.may_end(data[-1:]):
        return None
    splitter = framing.splitter()
    items = splitter.burst(data, SimTimeNs(0), _ANY_BAUD).items
    if not items or splitter.pending:
        return None
    return Sole.ALONE if all(each.origin is not None for each in items) else Sole.UNSURE
