"""Captures in the older form, pcap: as ``tcpdump -w`` writes them. Times are microseconds or nanoseconds,
numbers in the order of the computer that wrote them.

Source: the pcap format (IETF draft-ietf-opsawg-pcap); libpcap's reader for the form with longer heads.
"""

import struct
from collections.abc import Iterator

from hil.wire.outside_text import LeftOut
from hil.wire.pcapng import (
    CAN_LINKS,
    LINKTYPE_CAN_SOCKETCAN,
    CaptureBytes,
    CaptureError,
    Interface,
    Record,
    unwrapped,
)

_FORMS = {0xA1B2C3D4: (1000, 16), 0xA1B23C4D: (1, 16), 0xA1B2CD34: (1000, 24)}
"""First number of a file: nanoseconds of a tick, and bytes before each packet."""
_FILE_HEAD = 24
_LONGEST = 1 << 24
"""Bytes of a packet; more cannot be."""
PCAP_MARKS = tuple(struct.pack(order + "I", magic) for magic in _FORMS for order in "<>")
"""First bytes of such files."""


def read_pcap(data: CaptureBytes, left_out: LeftOut) -> Iterator[Record]:
    """Read a file that begins with one of ``PCAP_MARKS``; packets of other things are left out.

    Raises:
        CaptureError: after all whole packets, where the file is cut off.
    """
    order = "<" if data[:4] in PCAP_MARKS[::2] else ">"
    if len(data) < _FILE_HEAD:
        raise CaptureError("cut off in its head")
    magic, *_, link = struct.unpack(f"{order}IHHiIII", data[:_FILE_HEAD])
    tick_ns, head = _FORMS[magic]
    link &= 0xFFFF  # above are bits about the checksums of Ethernet
    line = Interface("can0", link=LINKTYPE_CAN_SOCKETCAN) if link in CAN_LINKS else Interface("0")
    at = _FILE_HEAD
    while at < len(data):
        if at + head > len(data):
            raise CaptureError(cut_off(at))
        seconds, fraction, captured = struct.unpack(f"{order}III", data[at : at + 12])
        if captured > _LONGEST:
            raise CaptureError(f"a packet of {captured} bytes at byte {at} cannot be")
        if at + head + captured > len(data):
            raise CaptureError(cut_off(at))
        at_ns = seconds * 10**9 + fraction * tick_ns
        try:
            payload, event = unwrapped(link, data[at + head : at + head + captured], order)
            yield Record(line, at_ns, event, payload, "", at)
        except ValueError as error:
            left_out.add(f"byte {at}", str(error))
        at += head + captured


def cut_off(at: int) -> str:
    """Say of a file that its last packet, which begins at this byte, is not whole."""
    return f"cut off in the middle of a packet at byte {at}: what is whole ends there"
