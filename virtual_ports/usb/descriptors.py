"""Descriptors of a CDC-ACM device: two interfaces, an endpoint for notifications and two for the bytes.

Sources: USB 2.0, chapter 9; CDC 1.2 and PSTN 1.2. Numbers are little-endian. The tables are those of a board
of the Arduino SAMD core: at full speed, its packets have 64 bytes.
"""

import struct
from dataclasses import dataclass

from hil.vocab.ports import UsbIdentity

DEVICE, CONFIGURATION, STRING = 1, 2, 3
_INTERFACE, _ENDPOINT, _CS_INTERFACE = 4, 5, 0x24
_HEADER, _CALL_MANAGEMENT, _ACM, _UNION = 0, 1, 2, 6
COMMUNICATION, DATA = 0, 1
"""Numbers of the interfaces."""
NOTIFY, BULK_OUT, BULK_IN = 1, 2, 3
"""Numbers of the endpoints: ``NOTIFY`` and ``BULK_IN`` towards the host."""
PACKET_BYTES = 64
_CONTROL_PACKET_BYTES = 64
_NOTIFY_PACKET_BYTES = 16
_NOTIFY_INTERVAL_MS = 16
_CLASS_COMMUNICATION, _CLASS_DATA = 2, 0x0A
_SUBCLASS_ACM = 2
_BUS_POWERED = 0x80
_HALF_MA = 250
_INTERRUPT, _BULK = 3, 2
LINES_AND_BREAK = 0x02 | 0x04
"""Capabilities: line coding, control lines and serial state; break."""
_ENGLISH = 0x0409
_MANUFACTURER, _PRODUCT, _SERIAL_NUMBER = 1, 2, 3
MOST_STRING_CHARACTERS = 126
CONFIGURATION_VALUE = 1


def _interface(number: int, endpoints: int, kind: tuple[int, int, int]) -> bytes:
    return bytes((9, _INTERFACE, number, 0, endpoints, *kind, 0))


def _endpoint(number: int, *, is_in: bool, kind: int, packet_bytes: int, interval: int) -> bytes:
    address = number | (0x80 if is_in else 0)
    return struct.pack("<BBBBHB", 7, _ENDPOINT, address, kind, packet_bytes, interval)


def _functional(kind: int, *fields: int) -> bytes:
    return bytes((3 + len(fields), _CS_INTERFACE, kind, *fields))


_BODY = b"".join(
    (
        _interface(COMMUNICATION, 1, (_CLASS_COMMUNICATION, _SUBCLASS_ACM, 0)),
        _functional(_HEADER, 0x10, 0x01),
        _functional(_CALL_MANAGEMENT, 0, DATA),
        _functional(_ACM, LINES_AND_BREAK),
        _functional(_UNION, COMMUNICATION, DATA),
        _endpoint(
            NOTIFY,
            is_in=True,
            kind=_INTERRUPT,
            packet_bytes=_NOTIFY_PACKET_BYTES,
            interval=_NOTIFY_INTERVAL_MS,
        ),
        _interface(DATA, 2, (_CLASS_DATA, 0, 0)),
        _endpoint(BULK_OUT, is_in=False, kind=_BULK, packet_bytes=PACKET_BYTES, interval=0),
        _endpoint(BULK_IN, is_in=True, kind=_BULK, packet_bytes=PACKET_BYTES, interval=0),
    )
)
CONFIGURATION_TABLE = (
    struct.pack(
        "<BBHBBBBB",
        *(9, CONFIGURATION, 9 + len(_BODY), 2, CONFIGURATION_VALUE, 0, _BUS_POWERED, _HALF_MA),
    )
    + _BODY
)


def string(text: str) -> bytes:
    """Descriptor of a text, which is cut to what fits."""
    encoded = text[:MOST_STRING_CHARACTERS].encode("utf-16-le", "replace")[: 2 * MOST_STRING_CHARACTERS]
    return bytes((2 + len(encoded), STRING)) + encoded


@dataclass(frozen=True)
class Descriptors:
    """Descriptors of one device."""

    identity: UsbIdentity
    serial_number: str

    def find(self, kind: int, index: int, language: int) -> bytes | None:
        """Find a descriptor; None: there is no such one."""
        if kind == DEVICE and index == 0:
            return self._device()
        if kind == CONFIGURATION and index == 0:
            return CONFIGURATION_TABLE
        if kind == STRING:
            return self._string(index, language)
        return None

    def _device(self) -> bytes:
        identity = self.identity
        return struct.pack(
            "<BBHBBBBHHHBBBB",
            *(18, DEVICE, 0x0200, _CLASS_COMMUNICATION, 0, 0, _CONTROL_PACKET_BYTES),
            *(identity.vendor_id, identity.product_id, identity.release_bcd),
            *(_MANUFACTURER, _PRODUCT, _SERIAL_NUMBER, 1),
        )

    def _string(self, index: int, language: int) -> bytes | None:
        if index == 0:
            return struct.pack("<BBH", 4, STRING, _ENGLISH)
        texts = {
            _MANUFACTURER: self.identity.manufacturer,
            _PRODUCT: self.identity.product,
            _SERIAL_NUMBER: self.serial_number,
        }
        if language not in (_ENGLISH, 0) or index not in texts:
            return None
        return string(texts[index])
