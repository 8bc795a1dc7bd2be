"""Captures and logs of buses from files and pipes, told apart by how they begin, and by the file's name where
that does not say it."""

from collections.abc import Iterator
from pathlib import Path

from hil.cli.captures.capture_files import Receive, log_kind, records_of
from hil.cli.captures.time_order import in_window
from hil.compose.decoded_item import DecodedItem
from hil.compose.decoding import Decoder, decoded, decoded_live, decoded_log
from hil.discovery.named_kinds import find_logs
from hil.vocab.bus import LogKind
from hil.wire.outside_text import LeftOut, text_of
from hil.wire.pcap import PCAP_MARKS, read_pcap
from hil.wire.pcapng import SECTION_MARK, CaptureBytes, CaptureError, Record, read

_HEAD_BYTES = 1 << 16
"""Bytes at the front by which a log is known."""
_NOTHING = "there is nothing in it; write a capture of `hil capture -w FILE`"


def of_file(name: str, content: CaptureBytes, decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode a file.

    Raises:
        CaptureError: after all that can be read; it is none of these, or cut off.
    """
    if not content:
        raise CaptureError(_NOTHING)
    head, kind = content[:_HEAD_BYTES], log_kind(name)
    if head.startswith((SECTION_MARK, *PCAP_MARKS)):
        return decoded(records_of_file(content, decoder.left_out), decoder)
    if not (found := _looks(head) or (kind and (kind, Path(name).suffix.lower()))):
        logs = " and no ".join(each.about for each in find_logs())
        raise CaptureError(
            f"this is no capture (pcapng, pcap) and no {logs}; write a capture of `hil capture -w FILE`"
        )
    kind, ending = found
    return decoded_log(kind, kind.read(ending, content[:], decoder.left_out), decoder)


def records_of_file(content: CaptureBytes, left_out: LeftOut) -> Iterator[Record]:
    """Records of a capture, pcapng or pcap.

    Raises:
        CaptureError: after all that is whole; or it is neither.
    """
    if content[: len(SECTION_MARK)] in PCAP_MARKS:
        return read_pcap(content, left_out)
    return read(content, left_out)


def any_form(receive: Receive, decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode what comes from a pipe: pcapng and logs of lines as they come, all else when it has ended.

    Raises:
        CaptureError: after all that can be read; it is none of these, or cut off.
    """
    head = b""
    while not _is_telling(head) and (data := receive(65536)) != b"":
        head += data or b""
    again = _with_head(head, receive)
    if head.startswith(SECTION_MARK):
        return in_window(decoded_live(records_of(again, decoder.left_out), decoder))
    if found := _looks(head):
        kind, ending = found
        if frames := kind.read_lines(ending, _lines(again), decoder.left_out):
            return decoded_log(kind, frames, decoder)
    return of_file("-", _all(again), decoder)


def _is_telling(head: bytes) -> bool:
    """True if enough has come to say what it is: its mark, or a line."""
    mark = len(SECTION_MARK)
    if len(head) < mark:
        return False
    is_binary = head.startswith((SECTION_MARK, *PCAP_MARKS))
    return is_binary or len(head) >= _HEAD_BYTES or b"\n" in head.lstrip()


def _looks(head: bytes) -> tuple[LogKind, str] | None:
    """Kind and ending of the logs that a file is like by its front."""
    return next(((kind, ending) for kind in find_logs() if (ending := kind.looks(head))), None)


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
