"""``hil type``: a text typed at a port, and what comes of it."""

import os
import select
import sys
import time
from contextlib import suppress
from typing import Annotated, Any

import typer

from hil.cli.boards.board_access import SHARED, open_address
from hil.cli.boards.time_given import Within, seconds_of
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.paused_note import told_if_paused
from hil.cli.framework.progress_bars import bar
from hil.cli.framework.shown_words import line_end, starts_words
from hil.host.journal import say
from hil.vocab.shown_text import printable_lines
from hil.vocab.typed_bytes import typed
from hil.vocab.verbs import VerbRefused

_READ_BYTES = 4096
_LOOK_S = 0.01
"""Shortest wait between two looks at the bench's clock."""
_BOOTLOADER = "runs the bootloader"
"""Note of a board that the opening of its port has reset: what is typed now is its bootloader's."""
_OPENED_S, _LONGEST_S = 0.1, 10.0
"""Wall time in which a bench has noted that its port was opened, and that after which nobody waits longer."""
_STARTED_NS = 100_000_000
"""Time in which a program is ready to hear something behind it: its processor's start, and its setup()."""


def type_text(
    device: DeviceName,
    keys: Annotated[str, typer.Argument(help=r"What is typed; \r, \n, \t, \\ and \xHH are one byte each.")],
    until: Annotated[
        str | None,
        typer.Option(
            "--until", metavar="ANSWER", help="End when this has come. [default: all that comes in that time]"
        ),
    ] = None,
    enter: Annotated[
        bool, typer.Option("--enter", help="Press Enter behind it: the end of line that the board takes.")
    ] = False,
    within: Within = "2s",
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Type a text at a port as a program that opens it, and print what comes.

    Exits with 1 if what is awaited by --until did not come within --within; it prints what came instead. A
    port that another program has open is refused, unless each gets all that the board says.

    Example: hil type m1 p --until encoder
    """
    within_s = seconds_of(within)
    awaited = None if until is None else _bytes_of(until)
    if awaited == b"":
        raise fail("hil: --until has no text; leave it out for all that comes", Exit.MISTAKE)
    data = _bytes_of(keys)
    row, address = open_address(bench, device)
    if row["clients"] and not address.startswith(SHARED):
        raise fail(f"hil: another program has {address} open, and would get a part of what comes; close it")
    if enter:
        data += line_end(row.get("greeting", ""))
    if ready_in_ns := int(row.get("ready_in_ns", 0)):
        within_s += ready_in_ns / 1e9  # what is typed waits for the board
        if not wants_json():
            say(f"hil: {starts_words(device, ready_in_ns)}", sys.stderr)
    talk = _Conversation(bench, address, data, awaited)
    with (
        told_if_paused(bench.meant().socket),
        bar(f"{device} is heard" if until is None else f"{device} until {until!r}"),
    ):
        came = talk.came(within_s, device if not row.get("greeting") else "")
    said = came.decode("latin-1")
    has_come = awaited is None or awaited in came
    if not has_come and not wants_json():
        say(f"hil: {device}: {until!r} did not come within {within_s:g} s", sys.stderr)
    answer = {"came": has_come, "text": said}
    shown = printable_lines(said).removesuffix("\n").removesuffix("\r")
    return CommandAnswer(answer, shown, Exit.DONE if has_come else Exit.FAILED)


def _bytes_of(text: str) -> bytes:
    try:
        return typed(text)
    except VerbRefused as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None


class _Conversation:
    """One text typed at a port. ``awaited``: what ends it before its time."""

    def __init__(self, bench: BenchOptions, address: str, data: bytes, awaited: bytes | None) -> None:
        self._bench, self._address, self._data, self._awaited = bench, address, data, awaited
        self._speed = 1.0

    def came(self, within_s: float, programmed: str = "") -> bytes:
        """Type, and answer what comes in so much simulated time, or up to what is awaited. ``programmed``: a
        device that the opening of its port may reset."""
        from hil.net.port_client import PortUnreachable, opened_port

        try:
            with opened_port(self._address) as port:
                if programmed:
                    self._wait_for_program(programmed)
                return self._copied(port, within_s)
        except PortUnreachable as error:
            raise fail(f"hil: {error}") from None

    def _wait_for_program(self, device: str) -> None:
        """Wait until a board that the opening of its port has reset runs its program."""
        end_s = time.monotonic() + _LONGEST_S
        time.sleep(_OPENED_S)
        if not self._is_in_bootloader(device):
            return
        while self._is_in_bootloader(device) and time.monotonic() < end_s:
            time.sleep(_LOOK_S)
        end_ns = self._sim_ns() + _STARTED_NS
        while self._sim_ns() < end_ns and time.monotonic() < end_s:
            time.sleep(_LOOK_S)

    def _is_in_bootloader(self, device: str) -> bool:
        status: Any = self._bench.ask("status")
        notes = {row["device"]: row["note"] for row in status["devices"]}
        return _BOOTLOADER in (notes.get(device) or "")

    def _copied(self, port: int, within_s: float) -> bytes:
        os.set_blocking(port, False)  # the board may hold up what is typed until its answers have been read
        waiting, came = self._data, bytearray()
        end_ns, next_look_s = self._sim_ns() + within_s * 1e9, time.monotonic() + within_s / self._speed
        while True:
            left_s = max(next_look_s - time.monotonic(), 0.0)
            ready, writable, _ = select.select([port], [port] if waiting else [], [], left_s)
            try:
                with suppress(BlockingIOError):  # another client was quicker
                    if ready:
                        if not (piece := os.read(port, _READ_BYTES)):
                            raise self._gone()
                        came += piece
                        if self._awaited and (at := came.find(self._awaited)) >= 0:
                            return bytes(came[: at + len(self._awaited)])
                with suppress(BlockingIOError):
                    if writable:
                        waiting = waiting[os.write(port, waiting) :]
            except OSError:  # EIO of a terminal, or a reset: its bench has gone
                raise self._gone() from None
            if time.monotonic() >= next_look_s:
                if (left_ns := end_ns - self._sim_ns()) <= 0:
                    return bytes(came)
                next_look_s = time.monotonic() + max(left_ns * 1e-9 / self._speed, _LOOK_S)

    def _sim_ns(self) -> int:
        status: Any = self._bench.ask("status")
        self._speed = float(status["speed"])
        return int(status["sim_ns"])

    def _gone(self) -> typer.Exit:
        return fail("hil: the port has gone: its bench has ended, or has the device no more")
