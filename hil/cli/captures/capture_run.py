"""Run of ``hil capture``: what comes from the bench goes to a target, and is counted."""

import os
import select
import socket
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import islice

from hil.cli.captures.capture_files import Records, blocks_of
from hil.cli.captures.capture_targets import FileTarget, LinesTarget, WiresharkTarget
from hil.cli.captures.counted_blocks import CountedBlocks
from hil.cli.captures.time_order import WINDOW_NS, ReorderWindow
from hil.cli.framework.ask import fail
from hil.cli.framework.interrupts import ended_by
from hil.compose.decoded_item import DecodedItem, DecodedKind
from hil.compose.decoding import Decoder
from hil.host.journal import say
from hil.vocab.shown_text import printable
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


def capture_run(
    client: socket.socket,
    target: Target,
    count: int | None,
    idle_s: float | None,
    window_ns: int = WINDOW_NS,
) -> None:
    """Carry a capture to a target until it ends, ``count`` items have come, a signal comes, or nobody takes
    anything any more; says on the standard error what it captures, and at the end how much. ``idle_s``: pause
    after which what is held is shown; ``window_ns``: time by which items may come out of order.

    Raises:
        OSError: the target cannot be written.
        CaptureError: what comes is no capture, or none for this target.
        typer.Exit: the bench has ended.
    """
    run = _Run(client, target, count, idle_s, window_ns)
    with suppress(KeyboardInterrupt), target.open(), ended_by(run.hang_up):
        run.carry()
    told = f"{run.tally.told(run.decoder.lost)}{target.told()}"
    if run.has_bench_ended:
        raise fail(f"hil: the bench has ended, and with it the capture: {told}")
    say(f"hil: {told}", sys.stderr)
    if isinstance(target, FileTarget) and sys.stderr.isatty():
        for command in target.openers():
            say(f"  {command}", sys.stderr)


class _Run:
    """Run of a capture, with what it has counted."""

    def __init__(
        self, client: socket.socket, target: Target, count: int | None, idle_s: float | None, window_ns: int
    ) -> None:
        self._client, self._target, self._count = client, target, count
        self._receive = LiveInput(client.fileno(), idle_s)
        self._records, self._window = Records(), ReorderWindow(window_ns)
        self._interfaces: list[Interface] = []
        self._counted = CountedBlocks()
        self._first_ns: int | None = None
        self._is_hung_up = False
        self.tally, self.decoder = Tally(), Decoder()
        self.has_bench_ended = False

    def hang_up(self) -> None:
        """Shut the connection down; what has come already can still be read."""
        self._is_hung_up = True
        with suppress(OSError):  # the connection has ended by itself
            self._client.shutdown(socket.SHUT_RDWR)

    def carry(self) -> None:
        """Carry what comes to the target, in the order of time, until there is no more or enough."""
        for blocks in blocks_of(self._receive):
            if blocks:
                self._take(blocks)
            else:
                self._show(self._silence())
            if self._has_enough():
                break
        else:
            self._show(self._silence())
            self.has_bench_ended = not self._is_hung_up and not self._has_enough()
        if self._interfaces:
            self._target.write(self._counted.rest(self._interfaces))

    def _begin(self, blocks: bytes) -> None:
        self._interfaces = interfaces_in(blocks)
        self._receive.watch(self._target.begin(self._interfaces))
        say(f"hil: capturing {described(self._interfaces)}; Ctrl-C ends it", sys.stderr)

    def _take(self, blocks: bytes) -> None:
        if not self._interfaces:
            self._begin(blocks)
        for piece in split_blocks(blocks) if self._count else (blocks,):
            self._take_piece(piece)

    def _take_piece(self, blocks: bytes) -> None:
        """Take whole blocks; where items are counted, one."""
        records = list(self._records.feed(blocks))
        if not self._count or not records:
            self._target.write(blocks)
        for record in records:
            items = list(self.decoder.feed(record))
            if self._count:
                self._counted.put(blocks, record, self.decoder.stream_of(record))
            self._show(self._window.put(items))

    def _silence(self) -> Iterator[DecodedItem]:
        """Items that are complete, and in order, as nothing follows."""
        yield from self._window.put(self.decoder.silence())
        yield from self._window.rest()

    def _show(self, items: Iterable[DecodedItem]) -> None:
        left = None if self._count is None else self._count - self.tally.total
        shown = list(islice(items, left))
        for item in shown:
            self.tally.add(item)
            self._first_ns = item.at_ns if self._first_ns is None else self._first_ns
        if self._count:
            self._target.write(self._counted.count(shown))
        self._target.show(shown, self._first_ns or 0)

    def _has_enough(self) -> bool:
        return self._count is not None and self.tally.total >= self._count


def described(interfaces: Sequence[Interface]) -> str:
    """Say what is captured, as in ``bus0 (sac, 38400 baud), can0 (CAN, 1000000 bit/s), m1 (bytes)``."""
    return printable(", ".join(f"{each.name} ({_line(each)})" for each in interfaces))


def _line(each: Interface) -> str:
    if each.is_can:
        return f"CAN, {each.baud} bit/s"
    if each.framing == RAW:
        return "bytes"
    unit = "baud" if each.is_serial else "bit/s"
    return f"{each.description}, {each.baud} {unit}" if each.baud else each.description


_GONE = select.POLLERR | select.POLLHUP | select.POLLNVAL


class LiveInput:
    """Receiver of bytes of a file descriptor. ``idle_s``: pause after which it says that nothing has come;
    None: never. ``out``: file descriptor of who takes what is made of it; it awaits nothing without him."""

    def __init__(self, fd: int, idle_s: float | None = None, out: int | None = None) -> None:
        self._fd = fd
        self._pause_ms = None if idle_s is None else round(1000 * idle_s)
        self._poll = select.poll()
        self._poll.register(fd, select.POLLIN)
        self.watch(out)

    def watch(self, out: int | None) -> None:
        """Watch whether somebody takes what is made of it, as ``out`` does."""
        self._out = out
        if out is not None:
            self._poll.register(out, 0)

    def __call__(self, size: int) -> bytes | None:
        """Receive at most so many bytes; none at the end, None after a pause.

        Raises:
            BrokenPipeError: nobody takes anything any more.
        """
        ready = dict(self._poll.poll(self._pause_ms))
        if self._out is not None and ready.get(self._out, 0) & _GONE:
            raise BrokenPipeError
        return os.read(self._fd, size) if ready else None
