"""The header of Modbus over TCP: packets in a stream of bytes, however it is cut.

Source: MODBUS Messaging on TCP/IP Implementation Guide V1.0b, 3.1.3.
"""

import struct
from typing import NamedTuple

from bridges.modbus.protocol.pdu import PDU_BYTES_MAX

_HEAD = struct.Struct(">HHH")
"""Transaction, protocol and length; the unit and the PDU, which the length counts, follow."""
_HEADER = struct.Struct(">HHHB")
_PROTOCOL = 0
_LENGTH_MIN, _LENGTH_MAX = 2, PDU_BYTES_MAX + 1
_HEAD_BYTES = _HEAD.size


class MbapPacket(NamedTuple):
    """A request or an answer, by its transaction: whatever number the client gave it."""

    transaction: int
    unit: int
    pdu: bytes


def encode(transaction: int, unit: int, pdu: bytes) -> bytes:
    """Encode a packet.

    Raises:
        ValueError: a PDU of another size than 1 to 253 bytes, or a number that does not fit.
    """
    if not _LENGTH_MIN <= len(pdu) + 1 <= _LENGTH_MAX:
        raise ValueError(f"a PDU of {len(pdu)} bytes; it has 1 to {PDU_BYTES_MAX}")
    if not 0 <= transaction <= 0xFFFF or not 0 <= unit <= 0xFF:
        raise ValueError(f"transaction {transaction} or unit {unit} does not fit into the header")
    return _HEADER.pack(transaction, _PROTOCOL, len(pdu) + 1, unit) + pdu


class MbapSplitter:
    """Splits one direction of a connection. It holds less than a packet."""

    def __init__(self) -> None:
        self._held = b""
        self.fault = ""
        """Error of the stream. Nothing after it can be read: the connection is to be closed."""

    def feed(self, data: bytes) -> list[MbapPacket]:
        """Take bytes; gives the packets that they complete, those before a fault too."""
        packets: list[MbapPacket] = []
        if self.fault:
            return packets
        if self._held:
            data = self._held + data
        at, size = 0, len(data)
        while size - at >= _HEAD_BYTES:
            transaction, protocol, length = _HEAD.unpack_from(data, at)
            if protocol != _PROTOCOL or not _LENGTH_MIN <= length <= _LENGTH_MAX:
                self.fault = _fault(protocol, length)
                break
            start = at + _HEAD_BYTES
            end = start + length
            if end > size:
                break
            packets.append(MbapPacket(transaction, data[start], data[start + 1 : end]))
            at = end
        self._held = b"" if self.fault else data[at:]
        return packets


def _fault(protocol: int, length: int) -> str:
    if protocol != _PROTOCOL:
        return f"protocol {protocol}; Modbus is {_PROTOCOL}"
    return f"a length of {length}; it is {_LENGTH_MIN} to {_LENGTH_MAX}"
