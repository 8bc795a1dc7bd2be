"""Frames of CAN in captures, and logs of them: candump's (``.log``) and Vector's (``.asc``, ``.blf``), those
by python-can, which keeps something of them back until they are closed."""

import io
from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import attrgetter
from pathlib import Path
from typing import Any, BinaryIO

from bridges.can.canopen.words.canopen_words import CanOpenWords
from bridges.can.canopen.words.eds_names import EdsError, EdsObjects, read_eds
from bridges.can.frames.asc_log import is_asc_header, read_asc
from bridges.can.frames.can_frame import DATA_MAX, CanFrame
from bridges.can.frames.candump_log import (
    LoggedFrame,
    candump_line,
    is_candump_line,
    read_candump,
    read_candump_lines,
)
from bridges.can.frames.socketcan import (
    CanError,
    SocketCanError,
    error_parts,
    unpack,
)
from hil.vocab.bus import FrameDescription, LogKind
from hil.wire.outside_text import LeftOut, lines_of, text_of
from hil.wire.pcapng import CaptureError, Record

_BLF_MARK = b"LOGG"
_SHOWN = 200
Eds = Mapping[int, EdsObjects]
"""Objects of CANopen nodes from their EDS files, by node id."""


def looks(head: bytes) -> str:
    """Ending of the logs that a file is like by its first bytes; empty: none."""
    if head.startswith(_BLF_MARK):
        return ".blf"
    is_asc = False
    for line in lines_of(text_of(head)):
        if is_candump_line(line):
            return ".log"
        is_asc = is_asc or is_asc_header(line)
    return ".asc" if is_asc else ""


def read_log(ending: str, content: bytes, left_out: LeftOut) -> Iterator[LoggedFrame]:
    """Read a log. Raises CaptureError: after all that can be read."""
    if ending == ".blf":
        return _read_blf(content, left_out)
    read = read_candump if ending == ".log" else read_asc
    return read(lines_of(text_of(content)), left_out)


def read_lines(ending: str, lines: Iterable[str], left_out: LeftOut) -> Iterator[LoggedFrame] | None:
    """Read candump's lines as they come; None: it is no log of candump's."""
    return read_candump_lines(lines, left_out) if ending == ".log" else None


def _read_blf(data: bytes, left_out: LeftOut) -> Iterator[LoggedFrame]:
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


class CanLog:
    """Log that is being written."""

    def __init__(self, ending: str, out: BinaryIO) -> None:
        self._ending, self._out = ending, out
        self._writer = _writer(ending, out)
        self._channels: list[str] = []
        """Buses, in the order of their first frames: those logs have numbers for them."""

    def write(self, records: Iterable[Record]) -> None:
        """Write frames. Raises CaptureError: one is none of classic CAN."""
        for record in records:
            try:
                frame = LoggedFrame(record.at_ns, record.interface, unpack(record.data))
            except SocketCanError as error:
                raise CaptureError(f"{error}, at byte {record.offset}") from None
            self._put(frame)
        if self._ending != ".blf":
            self._out.flush()

    def close(self) -> None:
        """End the log, and close its file."""
        if self._writer:
            self._writer.stop()
        self._out.close()

    def _put(self, frame: LoggedFrame) -> None:
        if not self._writer:
            self._out.write(f"{candump_line(frame)}\n".encode())
            return
        if frame.bus not in self._channels:
            self._channels.append(frame.bus)
        self._writer.on_message_received(_message(frame, self._channels.index(frame.bus)))


def _writer(ending: str, out: BinaryIO) -> Any:
    """Writer of python-can; None for candump's log."""
    if ending == ".log":
        return None  # python-can's leaves out how much a remote frame asks for, and which error one is
    from can import ASCWriter, BLFWriter

    # The first channel of both is 1; those that python-can is given count from 0.
    if ending == ".asc":
        return ASCWriter(io.TextIOWrapper(out, encoding="utf-8", write_through=True))
    return BLFWriter(out)


def _message(each: LoggedFrame, channel: int) -> Any:
    from can import Message

    frame, at_s = each.frame, each.at_ns / 1e9
    if isinstance(frame, CanError):
        error_class, data = error_parts(frame)
        return Message(at_s, error_class, is_error_frame=True, data=data, channel=channel)
    return Message(
        at_s,
        frame.id,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        dlc=frame.dlc,
        data=None if frame.is_remote else frame.data,
        channel=channel,
    )


def read_names(texts: Iterable[str], tell: Callable[[str], None]) -> Eds:
    """Read EDS files, each text as ``5=drive.eds``. ``tell``: says what is left out of a file.

    Raises:
        ValueError: a text is none of these, or its file cannot be read.
    """
    found = dict[int, EdsObjects]()
    for text in texts:
        node, equals, name = text.partition("=")
        if not equals or not node.isdecimal() or not 1 <= int(node) <= 127:
            raise ValueError(f'"{text}": write a node id of 1 to 127 and its file, as in 5=drive.eds')
        file, left_out = Path(name), LeftOut()
        try:
            found[int(node)] = read_eds(text_of(file.read_bytes()), int(node), left_out)
        except OSError as error:
            raise ValueError(f"{file}: {error.strerror}") from None
        except EdsError as error:
            raise ValueError(f"{name}: {error}") from None
        if told := left_out.told():
            tell(f"{name}: {told}")
    return found


def frame_words(eds: Eds | None) -> Callable[[CanFrame | CanError], FrameDescription]:
    """Make what puts the frames of one bus, a CANopen network, into words."""
    known = (eds or {}).items()
    words = CanOpenWords(
        {node: objects.names for node, objects in known}, {node: objects.values for node, objects in known}
    )

    def described(frame: CanFrame | CanError) -> FrameDescription:
        if isinstance(frame, CanError):
            error = str(frame)
            return FrameDescription(lambda: error, error)
        said = f"{frame!s:20}"
        return FrameDescription(
            lambda: f"{said} {words.say(frame)}", "", frame.data, frame.id, lambda: words.fields(frame)
        )

    return described


LOGS = LogKind(
    wire="CAN bus",
    about="log of CAN (candump's, .asc, .blf)",
    endings=(".log", ".asc", ".blf"),
    looks=looks,
    read=read_log,
    read_lines=read_lines,
    writer=CanLog,
    has=attrgetter("is_can"),
    unpack=unpack,
    names=read_names,
    words=frame_words,
    dissectors=("-d", "can.subdissector,canopen"),
)
