"""Headers of USB/IP: commands of the kernel's virtual host controller, and answers to them.

Source: drivers/usb/usbip and Documentation/usb/usbip_protocol.rst of Linux 6.1. All numbers are big-endian, a
header has 48 bytes, and the data of a transfer follows it. Status values are negative numbers of errno.
"""

import errno
import struct
from collections.abc import Iterator
from dataclasses import dataclass

HEADER_BYTES = 48
MOST_TRANSFER_BYTES = 16 * 1024 * 1024
"""Maximum length of a transfer: what usbfs lets a program have, usbcore.usbfs_memory_mb."""
CMD_SUBMIT, CMD_UNLINK, RET_SUBMIT, RET_UNLINK = 1, 2, 3, 4
_OUT, _IN = 0, 1
_MOST_ENDPOINT = 15
_NO_PACKETS = (0, -1)
"""Number of isochronous packets in a transfer that has none."""
SHORT_NOT_OK = 0x0001
"""Flag of a transfer for which fewer bytes than asked for are an error."""

OK = 0
STALL = -errno.EPIPE
UNLINKED = -errno.ECONNRESET
SHUT_DOWN = -errno.ESHUTDOWN
SHORT = -errno.EREMOTEIO

_BASE = struct.Struct(">IIIII")
_SUBMIT = struct.Struct(">Iiiii8s")
_RET_SUBMIT = struct.Struct(">IIIIIiiiii8x")
_RET_UNLINK = struct.Struct(">IIIIIi24x")


class ProtocolError(Exception):
    """Error of bytes that no host controller sends: where the next header begins is unknown."""


@dataclass(frozen=True, slots=True)
class Submit:
    """Transfer that the host asks for. ``length``: bytes that it sends, or that it takes at most; ``data``:
    what it sends; ``setup``: the eight bytes of a control transfer."""

    seqnum: int
    endpoint: int
    is_in: bool
    flags: int
    length: int
    setup: bytes
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class Unlink:
    """Request to give up a transfer, ``victim``."""

    seqnum: int
    victim: int


Command = Submit | Unlink


class CommandReader:
    """Reader of commands, in whatever pieces they come."""

    def __init__(self) -> None:
        self._unread = bytearray()
        self._submit: Submit | None = None
        """Transfer whose data has not come yet."""

    def read(self, data: bytes) -> Iterator[Command]:
        """Read the commands that are complete with these bytes.

        Raises:
            ProtocolError: this is no command; those before it have been answered.
        """
        unread = self._unread
        unread += data
        at = 0
        try:
            while True:
                if self._submit is None:
                    if len(unread) - at < HEADER_BYTES:
                        return
                    command = _command(unread, at)
                    at += HEADER_BYTES
                    if not isinstance(command, Submit) or command.is_in or not command.length:
                        yield command
                        continue
                    self._submit = command
                submit = self._submit
                if len(unread) - at < submit.length:
                    return
                self._submit = None
                sent = bytes(unread[at : at + submit.length])
                at += submit.length
                yield Submit(
                    submit.seqnum,
                    submit.endpoint,
                    False,
                    submit.flags,
                    submit.length,
                    submit.setup,
                    sent,
                )
        finally:
            del unread[:at]


def _command(data: bytearray, at: int) -> Command:
    command, seqnum, _, direction, endpoint = _BASE.unpack_from(data, at)
    if command == CMD_UNLINK:
        return Unlink(seqnum, int.from_bytes(data[at + 20 : at + 24], "big"))
    if command != CMD_SUBMIT:
        raise ProtocolError(f"command {command:#x} is none of USB/IP")
    flags, length, _, packets, _, setup = _SUBMIT.unpack_from(data, at + _BASE.size)
    if direction not in (_OUT, _IN) or endpoint > _MOST_ENDPOINT:
        raise ProtocolError(f"there is no endpoint {endpoint} in direction {direction}")
    if not 0 <= length <= MOST_TRANSFER_BYTES:
        raise ProtocolError(f"a transfer of {length} bytes is impossible")
    if packets not in _NO_PACKETS:
        raise ProtocolError(f"a transfer of {packets} packets: no endpoint is isochronous")
    return Submit(seqnum, endpoint, direction == _IN, flags, length, setup)


def ret_submit(seqnum: int, status: int, actual_length: int, data: bytes | bytearray = b"") -> bytes:
    """Build the answer to a transfer. ``data``: what the host gets."""
    return _RET_SUBMIT.pack(RET_SUBMIT, seqnum, 0, 0, 0, status, actual_length, 0, 0, 0) + data


def ret_unlink(seqnum: int, status: int) -> bytes:
    """Build the answer to ``Unlink``: ``UNLINKED``, or ``OK`` for a transfer that was answered before."""
    return _RET_UNLINK.pack(RET_UNLINK, seqnum, 0, 0, 0, status)
