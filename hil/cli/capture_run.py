"""Run of ``hil capture``: what comes from the bench goes to a target, and is counted."""

import socket
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial

from hil.cli.capture_files import Records, blocks_of
from hil.cli.capture_targets import FileTarget, LinesTarget, WiresharkTarget
from hil.cli.decoded_item import DecodedItem, DecodedKind, printable
from hil.cli.decoding import Decoder
from hil.cli.interrupts import ended_by
from hil.cli.live_input import LiveInput
from hil.host.journal import say
from hil.wire.pcapng import RAW, Interface, interfaces_in, split_blocks

_WORDS = {
    DecodedKind.PACKET: "packet",
    DecodedKind.FRAME: "frame",
    DecodedKind.BYTES: "line of bytes",
    DecodedKind.EVENT: "event",
}
Target = LinesTarget | FileTarget | WiresharkTarget


class Tally:
    """Numbers of a capture."""

    def __init__(self) -> None:
        self.items: Counter[DecodedKind] = Counter()
        self.errors = 0

    @property
    def total(self) -> int:
        return self.items.total()

    def add(self, item: DecodedItem) -> None:
        self.items[item.kind] += 1
        self.errors += bool(item.error)

    def told(self, lost: int) -> str:
        """Say them, as in ``8 packets, 1 with errors; none lost``. ``lost``: records that the bench could not
        hand over in time."""
        counted = [_counted(self.items[kind], word) for kind, word in _WORDS.items() if self.items[kind]]
        errors = f", {self.errors} with errors" if self.errors else ""
        return f"{', '.join(counted) or 'nothing'}{errors}; {lost or 'none'} lost"


def _counted(number: int, word: str) -> str:
    first, _, rest = word.partition(" ")
    return f"{number} {first}{'s' * (number != 1)}{f' {rest}' if rest else ''}"


def capture_run(client: socket.socket, target: Target, count: int | None, idle_s: float | None) -> None:
    """Carry a capture to a target until it ends, ``count`` items have come, a signal comes, or nobody takes
    anything any more; says on the standard error what it captures, and at the end how much. ``idle_s``: pause
    after which what is held is shown.

    Raises:
        OSError: the target cannot be written.
        CaptureError: what comes is no capture, or none for this target.
    """
    tally, decoder = Tally(), Decoder()
    with suppress(KeyboardInterrupt), target.open(), ended_by(partial(_hang_up, client)):
        for items in _carried(client, target, idle_s, decoder, is_by_block=count is not None):
            shown = items if count is None else items[: count - tally.total]
            for item in shown:
                tally.add(item)
            target.show(shown, decoder.first_ns or 0)
            if tally.total == count:
                break
    say(f"hil: {tally.told(decoder.lost)}{target.told()}", sys.stderr)


def _hang_up(client: socket.socket) -> None:
    """Shut the connection down; what has come already can still be read."""
    with suppress(OSError):  # the connection has ended by itself
        client.shutdown(socket.SHUT_RDWR)


def _carried(
    client: socket.socket, target: Target, idle_s: float | None, decoder: Decoder, *, is_by_block: bool
) -> Iterator[list[DecodedItem]]:
    """Give what comes to the target; answers the items of it. ``is_by_block``: of each block alone."""
    records, receive = Records(), LiveInput(client.fileno(), idle_s)
    has_begun = False
    for blocks in blocks_of(receive):
        if not blocks:
            yield list(decoder.silence())
            continue
        if not has_begun:
            has_begun = True
            interfaces = interfaces_in(blocks)
            receive.watch(target.begin(interfaces))
            say(f"hil: capturing {described(interfaces)}; Ctrl-C ends it", sys.stderr)
        for piece in split_blocks(blocks) if is_by_block else (blocks,):
            target.take(piece)
            yield [item for record in records.take(piece) for item in decoder.take(record)]
    yield list(decoder.silence())


def described(interfaces: Sequence[Interface]) -> str:
    """Say what is captured, as in ``bus0 (sac, 38400 baud), can0 (CAN, 1000000 bit/s), m1 (bytes)``."""
    return printable(", ".join(f"{each.name} ({_line(each)})" for each in interfaces))


def _line(each: Interface) -> str:
    if each.is_can:
        return f"CAN, {each.baud} bit/s"
    if each.framing == RAW:
        return "bytes"
    return f"{each.description}, {each.baud} baud" if each.baud else each.description
