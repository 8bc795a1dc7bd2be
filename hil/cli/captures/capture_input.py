"""Captures and logs of CAN from files and pipes, told apart by how they begin, and by the file's name where
that does not say it."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from bridges.can.frames.asc_log import is_asc_header, read_asc
from bridges.can.frames.candump_log import LoggedFrame, is_candump_line, read_candump, read_candump_lines
from hil.cli.captures.capture_files import Receive, records_of
from hil.cli.captures.decoded_item import DecodedItem
from hil.cli.captures.decoding import Decoder, decoded, decoded_live, decoded_log
from hil.cli.captures.time_order import in_window
from hil.wire.outside_text import LeftOut, lines_of, text_of
from hil.wire.pcap import PCAP_MARKS, read_pcap
from hil.wire.pcapng import SECTION_MARK, CaptureBytes, CaptureError, Record, read

_BLF = b"LOGG"
_HEAD_BYTES = 1 << 16
"""Bytes at the front by which a log of CAN is known."""
_NOTHING = "there is nothing in it"
_NONE_OF_THESE = "this is no capture (pcapng, pcap) and no log of CAN (candump's, .asc, .blf)"


def of_file(name: str, content: CaptureBytes, decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode a file.

    Raises:
        CaptureError: after all that can be read; it is none of these, or cut off.
    """
    if not content:
        raise CaptureError(_NOTHING)
    head, ending = content[:_HEAD_BYTES], Path(name).suffix.lower()
    if head.startswith((SECTION_MARK, *PCAP_MARKS)):
        return decoded(records_of_file(content, decoder.left_out), decoder)
    if head.startswith(_BLF):
        ending = ".blf"
    elif looks := _looks(lines_of(text_of(head))):
        ending = looks
    return decoded_log(_log(ending, content[:], decoder.left_out), decoder)


def records_of_file(content: CaptureBytes, left_out: LeftOut) -> Iterator[Record]:
    """Records of a capture, pcapng or pcap.

    Raises:
        CaptureError: after all that is whole; or it is neither.
    """
    if content[: len(SECTION_MARK)] in PCAP_MARKS:
        return read_pcap(content, left_out)
    return read(content, left_out)


def any_form(receive: Receive, decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode what comes from a pipe: pcapng and candump's logs as they come, all else when it has ended.

    Raises:
        CaptureError: after all that can be read; it is none of these, or cut off.
    """
    head = b""
    while not _is_telling(head) and (data := receive(65536)) != b"":
        head += data or b""
    again = _with_head(head, receive)
    if head.startswith(SECTION_MARK):
        return in_window(decoded_live(records_of(again, decoder.left_out), decoder))
    if _looks(lines_of(text_of(head))) == ".log":
        return decoded_log(read_candump_lines(_lines(again), decoder.left_out), decoder)
    return of_file("-", _all(again), decoder)


def _is_telling(head: bytes) -> bool:
    """True if enough has come to say what it is: its mark, or a line."""
    mark = len(SECTION_MARK)
    if len(head) < mark:
        return False
    is_binary = head.startswith((SECTION_MARK, _BLF, *PCAP_MARKS))
    return is_binary or len(head) >= _HEAD_BYTES or b"\n" in head.lstrip()


def _looks(lines: Iterable[str]) -> str:
    """Ending of the logs that lines look like; empty: none."""
    is_asc = False
    for line in lines:
        if is_candump_line(line):
            return ".log"
        is_asc = is_asc or is_asc_header(line)
    return ".asc" if is_asc else ""


def _log(ending: str, content: bytes, left_out: LeftOut) -> Iterator[LoggedFrame]:
    """Read a log of CAN. Raises CaptureError: after all that can be read, or it is none."""
    if ending == ".blf":
        from hil.cli.captures.blf_log import read_blf

        return read_blf(content, left_out)
    if ending == ".log":
        return read_candump(lines_of(text_of(content)), left_out)
    if ending == ".asc":
        return read_asc(lines_of(text_of(content)), left_out)
    raise CaptureError(_NONE_OF_THESE)


def _with_head(head: bytes, receive: Receive) -> Receive:
    """Receiver that has what was read already."""
    held = [head]
    return lambda size: held.pop() if held else receive(size)


def _all(receive: Receive) -> bytes:
    pieces = []
    while (data := receive(65536)) != b"":
        pieces.append(data or b"")
    return b"".join(pieces)


def _lines(receive: Receive) -> Iterator[str]:
    held = b""
    while (data := receive(65536)) != b"":
        *lines, held = (held + (data or b"")).split(b"\n")
        yield from map(text_of, lines)
    yield text_of(held)
