"""CAN frames as Linux has them on a socket and in captures (LINKTYPE_CAN_SOCKETCAN, 227); errors as its error
frames.

Sources: the Linux kernel's documentation "SocketCAN" and its headers linux/can.h and linux/can/error.h, for
numbers and flags; the registry of link types at tcpdump.org, for the order of bytes in captures.
"""

import struct
from typing import NamedTuple

from bridges.can.frames.can_frame import DATA_MAX, STANDARD_ID_MAX, CanFrame

EXTENDED, REMOTE, ERROR = 0x8000_0000, 0x4000_0000, 0x2000_0000
"""Flags beside an identifier."""
_ID_MASK = 0x1FFF_FFFF
_FD_FLAG = 0x04
"""Flag of a CAN FD frame, in the byte behind the length."""
_HEAD = struct.Struct(">IBBBB")

_CONTROLLER, _PROTOCOL, _NO_ACK, _BUS_OFF, BUS_ERROR = 0x04, 0x08, 0x20, 0x40, 0x80
"""Classes of errors, in the identifier."""
_LOST, _PASSIVE, _ACTIVE = 0x01, 0x30, 0x40
"""Bits of a controller's problem, in the second byte: frames lost for lack of room; passive as receiver or
sender; active again."""
_ERRORS = {
    "bit": (_PROTOCOL, 0x01, 0),
    "form": (_PROTOCOL, 0x02, 0),
    "stuff": (_PROTOCOL, 0x04, 0),
    "CRC": (_PROTOCOL, 0, 0x08),
    "acknowledgement": (_PROTOCOL | _NO_ACK, 0, 0x19),
}
"""Class of each kind of error, the bits of its third byte, and the place in the frame, its fourth."""
_STATES = {
    "error-passive": (_CONTROLLER, _PASSIVE),
    "error-active": (_CONTROLLER, _ACTIVE),
    "bus-off": (_BUS_OFF, 0),
    "frames lost": (_CONTROLLER, _LOST),
}
"""Class of each event, and the bits of its second byte."""
FRAMES_LOST = bytes.fromhex("20000004 08000000 00010000 00000000")
"""Frame that says that frames were lost: a controller's problem, its receive buffer is full.

Source: linux/can/error.h, CAN_ERR_CRTL and CAN_ERR_CRTL_RX_OVERFLOW."""


class CanError(NamedTuple):
    """Error on a bus. ``kind``: bit, form, stuff, CRC, acknowledgement; error-active, error-passive or
    bus-off, where a node has become that; frames lost, where who captured was too slow; or empty, where it is
    none of these."""

    kind: str

    def __str__(self) -> str:
        return f"{self.kind} error" if self.kind in _ERRORS else self.kind or "error"


class SocketCanError(ValueError):
    """Error of bytes that are no classic CAN frame: ``str(error)`` says why."""


def pack_frame(frame: CanFrame) -> bytes:
    """Pack a frame for a capture."""
    flags = (EXTENDED if frame.is_extended else 0) | (REMOTE if frame.is_remote else 0)
    return _HEAD.pack(frame.id | flags, frame.dlc, 0, 0, 0) + frame.data


def pack_error(kind: str) -> bytes:
    """Pack an error frame, for what is named as in ``CanError``."""
    error_class, data = error_parts(CanError(kind))
    return _HEAD.pack(ERROR | error_class, DATA_MAX, 0, 0, 0) + data


def error_parts(error: CanError) -> tuple[int, bytes]:
    """Class and data of an error frame."""
    data = bytearray(DATA_MAX)
    if error.kind in _STATES:
        error_class, data[1] = _STATES[error.kind]
        return error_class, bytes(data)
    error_class, data[2], data[3] = _ERRORS.get(error.kind, (0, 0, 0))
    return error_class | BUS_ERROR, bytes(data)


def unpack(payload: bytes) -> CanFrame | CanError:
    """Unpack a frame of a capture.

    Raises:
        SocketCanError: it is too short, has more than 8 bytes, or is of CAN FD.
    """
    if len(payload) < _HEAD.size:
        raise SocketCanError(f"{len(payload)} bytes are no CAN frame, which has {_HEAD.size} and more")
    word, size, flags, _, _ = _HEAD.unpack_from(payload)
    if flags & _FD_FLAG or size > DATA_MAX:
        raise SocketCanError("a frame of CAN FD; this reads classic CAN")
    data = payload[_HEAD.size : _HEAD.size + size]
    is_remote = bool(word & REMOTE)
    if len(data) < size and not is_remote:
        raise SocketCanError(f"{len(data)} bytes of data, where the frame says {size}")
    return from_word(word, data, size)


def from_word(word: int, data: bytes, dlc: int) -> CanFrame | CanError:
    """Make a frame of an identifier with its flags, its data, and the data length code.

    Raises:
        SocketCanError: an identifier of more than 11 bits without the flag of an extended one.
    """
    if word & ERROR:
        return CanError(_kind(word & _ID_MASK, data.ljust(DATA_MAX, b"\0")))
    identifier, is_extended = word & _ID_MASK, bool(word & EXTENDED)
    if identifier > STANDARD_ID_MAX and not is_extended:
        raise SocketCanError(f"identifier {identifier:X} has more than 11 bits, and no flag that it may")
    if word & REMOTE:
        return CanFrame(identifier, b"", is_extended, True, dlc)
    return CanFrame(identifier, data, is_extended)


def _kind(error_class: int, data: bytes) -> str:
    for kind, (wanted, second) in _STATES.items():
        if error_class & wanted and (data[1] & second or not second):
            return kind
    if error_class & _NO_ACK:
        return "acknowledgement"
    for kind, (_, third, fourth) in _ERRORS.items():
        if error_class & (_PROTOCOL | BUS_ERROR) and (data[2] & third or (fourth and data[3] == fourth)):
            return kind
    return ""
