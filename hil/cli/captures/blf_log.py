"""Vector's binary logs, ``.blf``, by python-can's reader."""

import io
from collections.abc import Iterator
from typing import Any

from bridges.can.frames.can_frame import DATA_MAX, CanFrame
from bridges.can.frames.candump_log import LoggedFrame
from bridges.can.frames.socketcan import CanError
from hil.wire.outside_text import LeftOut
from hil.wire.pcapng import CaptureError

_SHOWN = 200


def read_blf(data: bytes, left_out: LeftOut) -> Iterator[LoggedFrame]:
    """Read a log.

    Raises:
        CaptureError: after all that can be read.
    """
    from can import BLFReader

    number = 0
    try:
        reader: Any = BLFReader(io.BytesIO(data))
        for number, message in enumerate(reader, 1):
            if message.is_fd or len(message.data) > DATA_MAX:
                left_out.add(f"frame {number}", "a frame of CAN FD; this reads classic CAN")
            else:
                yield _logged(message)
    except Exception as error:  # python-can's reader raises whatever the content makes it
        why = str(error)[:_SHOWN] or type(error).__name__
        raise CaptureError(f"python-can cannot read it: {why}") from None
    if reader.file_size > len(data):
        raise CaptureError(f"cut off: it has {len(data)} of {reader.file_size} bytes, by its head")


def _logged(message: Any) -> LoggedFrame:
    at_ns, bus = round(message.timestamp * 1e9), f"can{message.channel if message.channel is not None else 0}"
    if message.is_error_frame:  # its identifier is that of the frame that was damaged, and no class of errors
        return LoggedFrame(at_ns, bus, CanError(""))
    is_remote, is_extended = message.is_remote_frame, message.is_extended_id
    frame = CanFrame(
        message.arbitration_id,
        b"" if is_remote else bytes(message.data),
        is_extended,
        is_remote,
        min(message.dlc, DATA_MAX) if is_remote else 0,
    )
    return LoggedFrame(at_ns, bus, frame)
