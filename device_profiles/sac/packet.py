"""Packets of the SAC's network: to bytes and back. Source: SAC user manual, communications.

A packet is STX (2), destination, origin, data, ETX (3), CRC, NUL. The CRC is Dallas/Maxim's over the data
alone. The byte after ETX decides: NUL ends the packet, which is not checked then, anything else is a CRC and
NUL comes behind it. So a packet whose CRC happens to be 0, one in 256, ends with NUL twice and goes
unchecked; the second NUL is an idle character of the line and part of nothing.

Where the manual is silent, this is decided: data is at most ``DATA_MAX`` bytes and has no STX, ETX or NUL.
An STX begins a packet wherever it comes, but in the CRC's place, which is read by position; if no NUL
follows there, that STX was the next packet's. Addresses 2 and 3 can therefore not be used.

``PacketDecoder`` takes bytes in pieces of any size and gives ``Packet`` or ``Malformed``, whose ``fault`` is

- ``noise``: bytes outside a packet, given when an STX comes or the receiver's memory (86 bytes) is full;
- ``cut``: a packet that another STX has broken off;
- ``address``: address 3;
- ``no ETX``: a NUL in the data;
- ``too long``: more data than fits;
- ``no NUL``: another byte behind the CRC than the last one, NUL.

No other byte is lost, none is counted twice: the ``raw`` of all that was given, and ``pending``, are the
input. ``end`` is the number of bytes of the stream up to and with an item's last.
"""

from device_profiles.sac._packet import (
    DATA_MAX,
    FAULTS,
    FRAME_BYTES,
    Malformed,
    Packet,
    PacketDecoder,
    crc8,
    frame,
)

__all__ = [
    "DATA_MAX",
    "FAULTS",
    "FRAME_BYTES",
    "Malformed",
    "Packet",
    "PacketDecoder",
    "crc8",
    "encode",
    "frame",
]

UNUSABLE_ADDRESSES = (2, 3)


def encode(destination: int, origin: int, data: bytes, *, crc: bool = True) -> bytes:
    """Encode a packet; without ``crc`` NUL follows ETX.

    Raises:
        ValueError: an address that is not 0, 1 or 4 to 255, data that is too long, or that has an STX, ETX or
            NUL.
    """
    for address in (destination, origin):
        if not 0 <= address <= 255 or address in UNUSABLE_ADDRESSES:
            raise ValueError(f"{address} is no address: they are 0, 1 and 4 to 255")
    if len(data) > DATA_MAX:
        raise ValueError(f"{len(data)} bytes of data; a packet has at most {DATA_MAX}")
    if any(byte in data for byte in (0, 2, 3)):
        raise ValueError(f"data with STX, ETX or NUL cannot be told from a packet's frame: {data!r}")
    return frame(destination, origin, data, crc)
