"""Captures and logs of CAN from a pipe, told apart by how they begin."""

from collections.abc import Iterator

from hil.cli.capture_files import MAGIC, Receive, read_candump, read_log, records_of
from hil.cli.decoded_item import DecodedItem
from hil.cli.decoding import Decoder, decoded_live, decoded_log
from hil.cli.time_order import in_window
from hil.wire.pcapng import CaptureError

_BLF, _CANDUMP, _ASC = b"LOGG", b"(", (b"date", b"base", b"//")


def any_form(receive: Receive, decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode pcapng, candump's log, Vector's .asc or .blf, as it comes.

    Raises:
        CaptureError: after all that can be read; it is none of these, or cut off.
    """
    head = b""
    while len(head) < len(MAGIC) and (data := receive(65536)) != b"":
        head += data or b""
    if not head:
        raise CaptureError("there is nothing in it")
    again = _with_head(head, receive)
    if head.startswith(MAGIC):
        return in_window(decoded_live(records_of(again), decoder))
    if head.startswith(_BLF):
        return decoded_log(read_log(".blf", _all(again)), decoder)
    if head.lstrip().startswith(_CANDUMP):
        return decoded_log(read_candump(_lines(again)), decoder)
    if head.lstrip().lower().startswith(_ASC):
        return decoded_log(read_log(".asc", _all(again)), decoder)
    raise CaptureError("this is no pcapng, and no log of CAN (candump's, .asc, .blf)")


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
        yield from (line.decode("utf-8", "replace") for line in lines)
    yield held.decode("utf-8", "replace")
