"""Stream of a long file's rows into a board's queue, each typed when there is room: by any terminal.

Sources: SAC user manual, companion app (files make the queue limitless), command buffer (30 commands, first
in, first out), soft_ops (DC1 and DC2 at the beginning and the end of each command), l (the current command
ends, the rest is dropped).
"""

import re
from collections.abc import Callable, Generator
from typing import Any

from device_profiles.sac.companion import BoardTerminal, stands_still
from device_profiles.sac.companion_files import LINE_BYTES
from device_profiles.sac.long_files import LongFile
from device_profiles.sac.network import DC1, DC2
from device_profiles.sac.screen_reading import (
    SOFT_OPS,
    STEPS_PER_REV,
    number_on,
    read_listing,
    read_speed,
)
from device_profiles.sac.terminal import PROMPT
from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Progress, Refusal, Send, Step
from hil.vocab.motion import QUEUE_LEN
from hil.vocab.time import NS_PER_MS, NS_PER_S

MOST_IN_BOARD = QUEUE_LEN - 1
"""Rows in the board, the running one too. One less than its queue has, so that "Q is at" tells how many."""
TRIES = 5
"""Number of times that a line is typed which comes back damaged."""
_ECHO_NS = 2 * NS_PER_S
"""Maximum wait for an echo or a prompt; a line takes 20 ms at 38400 baud."""
_LISTING_NS = 40 * NS_PER_S
_QUIET_NS = 300 * NS_PER_MS
_LOOK_NS = 10 * NS_PER_S
"""Silence after which the board is asked where it is."""
_PROMPT = PROMPT.encode()
_END = b"\r\n"
_ERASE = b"\b" * LINE_BYTES
_ERASED = b"\b \b"
_QUESTIONS = (b"", b"q", b"vd", b"cc", b"cf", b"x", b"xd")
"""Lines of other clients that change nothing."""
_BANNER = re.compile(rb"SAC \d\S*\r\n")


class _Trouble(Exception):
    """Reason to stop the stream at a board that still answers."""


class _Restarted(Exception):
    """Restart of the board."""


class RowStream:
    """Stream of rows; one use. ``first``, ``last``: which of the file's, from 1; ``last`` None: to its end.

    A row goes into force only when its echo is whole. What is in the board is counted by soft_ops.

    Long because all its parts are steps of one dialogue, which share what was typed and heard.
    """

    def __init__(self, file: LongFile, first: int = 1, last: int | None = None) -> None:
        """Take the rows. Raises Refusal: the file has no such rows."""
        total = len(file.rows)
        self._file, self._first, self._last = file, first, total if last is None else last
        if not 1 <= first <= self._last <= total:
            raise Refusal(f"{file.name}: there are no rows {first} to {self._last}; it has 1 to {total}")
        self.sent = self.ended = first - 1
        """Last row that is in force in the board, and the last that has ended."""
        self._runs = False
        self._text = b""
        self._typed = b""
        """Line that is typed and has no end yet."""
        self._answers: dict[bytes, list[str]] = {}
        self._asked: set[bytes] = set()
        """Lines of its own, whose answers may come late."""
        self._next_position = 1
        self._steps_per_rev = 200
        self._had_soft_ops = True

    # ---- from the first row to the last ----

    def run(self) -> Dialogue[int]:
        """Stream the rows; answers how many have run.

        Raises:
            Refusal: a row's RPM and cycle contradict each other, or the motor runs; nothing was typed.
            DialogueError: it stopped; says at which row, and how to go on.
        """
        yield from self._prepare()
        try:
            for number in range(self._first, self._last + 1):
                while self.sent - self.ended >= MOST_IN_BOARD:
                    yield from self._wait()
                yield from self._type_row(number)
            while self.ended < self.sent:
                yield from self._wait()
            yield from self._leave()
        except _Restarted:
            row = f"; where row {self.ended + 1} was cut is not known" if self.sent > self.ended else ""
            raise DialogueError(f"the board has started again{row}; {self._go_on(self.ended + 1)}") from None
        except _Trouble as trouble:
            raise DialogueError(f"{trouble}; {(yield from self.halt())}") from None
        except DialogueError as error:
            left = self.sent - self.ended
            runs = f"; {left} more are in the board, which runs them" if left else ""
            raise DialogueError(f"{error}{runs}; {self._go_on(self.sent + 1)}") from error
        return self._last - self._first + 1

    def _prepare(self) -> Dialogue[None]:
        terminal = BoardTerminal()
        yield from terminal.sync()
        self._steps_per_rev = number_on((yield from terminal.screen("cc")), STEPS_PER_REV)
        self._file.check(self._steps_per_rev)
        yield from stands_still(terminal)
        self._had_soft_ops = bool(number_on((yield from terminal.screen("cf")), SOFT_OPS))
        yield from terminal.ask("$O1")
        self._next_position = read_listing((yield from terminal.ask("q", _LISTING_NS))).at

    def halt(self) -> Dialogue[str]:
        """End the stream behind the row that runs; answers what has run, and how to go on."""
        try:
            yield from self._erase()
            yield from self._ask(b"l")
            while self._runs:
                yield Progress(self.ended, self._last, f"row {self.ended + 1} ends")
                if not (yield from self._hear(_LOOK_NS)) and (yield from self._stands()):
                    break
            if self.ended < self.sent and (yield from self._place()) != self._next_position:
                yield from self._ask(b"S")  # a row that waits for its sync or its time: no pulse was made
            cut = f"row {self.ended + 1} was cut; " if self._runs else ""
            yield from self._leave()
        except (_Trouble, _Restarted, DialogueError) as error:
            why = str(error) or "it has started again"
            return f"the board could not be stopped: {why}; {self._go_on(self.ended + 1)}"
        return cut + self._go_on(self.ended + 1)

    def _leave(self) -> Dialogue[None]:
        if not self._had_soft_ops:
            yield from self._ask(b"$O0")

    def _go_on(self, row: int) -> str:
        ran = f"rows up to {self.ended} have run" if self.ended >= self._first else "no row has run"
        return f"{ran}; go on with --from {row}" if row <= len(self._file.rows) else ran

    # ---- a row ----

    def _type_row(self, number: int) -> Dialogue[None]:
        """Type a row. Its end goes out when its echo is whole; an end that is typed twice does nothing."""
        line = self._file.rows[number - 1].motion(self._steps_per_rev).encode()
        yield from self._settle()
        for _ in range(TRIES):
            yield Send(line)
            self._typed = line  # what breaks a dialogue off does so before a step is done
            while self._text != line and (yield from self._hear(_ECHO_NS)):
                self._take_blocks()
            if self._text == line:
                break
            yield from self._erase()
        else:
            raise _Trouble(f"row {number} came back damaged {TRIES} times; the line loses characters")
        self._text = b""
        for _ in range(TRIES):
            yield Send(b"\r")
            if self.sent < number:
                self._typed, self.sent = b"", number
                self._next_position = self._next_position % QUEUE_LEN + 1
            if (yield from self._until(lambda: self._text.endswith(_PROMPT), _ECHO_NS)):
                self._text = b""
                return
        raise _Trouble(f"no prompt after row {number}")

    def _erase(self) -> Dialogue[None]:
        """Erase what may be typed of a line."""
        while (yield from self._hear(_QUIET_NS)):
            pass
        self._take_blocks()
        if self._typed or self._text:
            self._text, count = b"", max(len(self._typed), 1)
            yield Send(_ERASE)
            while self._text.count(_ERASED) < count and (yield from self._hear(_ECHO_NS)):
                if b"\b" in self._text:
                    self._typed = b""
            if self._typed:
                raise _Trouble(f"the board does not erase: {self._typed.decode()!r} stands at its prompt")
        self._text, self._typed = b"", b""

    # ---- what is heard ----

    def _hear(self, timeout_ns: int) -> Generator[Step, Any, bool]:
        """Hear what comes; False: nothing."""
        heard: Heard = yield Listen(timeout_ns)
        before = self.ended
        for byte in heard.data:
            if byte == DC1[0]:
                self._begun()
            elif byte == DC2[0]:
                self._end()
        self._text += heard.data.translate(None, DC1 + DC2)
        if self.ended > before:
            yield Progress(self.ended, self._last, f"row {self.ended}")
        if _BANNER.search(self._text):
            raise _Restarted
        return bool(heard.data)

    def _begun(self) -> None:
        if self._runs:  # the signal of the end before was lost
            self._end()
        self._runs = True

    def _end(self) -> None:
        self._runs = False
        self.ended = min(self.ended + 1, self.sent)

    def _until(self, is_there: Callable[[], bool], timeout_ns: int) -> Generator[Step, Any, bool]:
        while not is_there():
            if not (yield from self._hear(timeout_ns)):
                return False
        return True

    def _settle(self) -> Dialogue[None]:
        """Let another client's line come to its end, and take it."""
        if self._text and not self._typed.startswith(self._text):
            yield from self._until(lambda: self._text.endswith(_PROMPT), _QUIET_NS)
        self._take_blocks()

    def _take_blocks(self, asked: bytes | None = None) -> None:
        """Take what stands before a prompt: an answer, another client's line, a message of the network."""
        while _PROMPT in self._text:
            block, _, self._text = self._text.partition(_PROMPT)
            echo, *lines = block.replace(_ERASED, b"").split(_END)
            is_message = self._typed.startswith(echo) and len(lines) > 1
            if echo == asked:
                self._answers[echo] = [line.decode("latin-1") for line in lines]
            elif echo not in _QUESTIONS and echo not in self._asked and not is_message:
                said = echo.decode("latin-1")[:LINE_BYTES]
                raise _Trouble(f'somebody else has typed "{said}" at the terminal, or a line was damaged')

    # ---- questions ----

    def _ask(self, line: bytes) -> Dialogue[list[str]]:
        """Type a line that may come twice; answers its lines."""
        self._asked.add(line)
        for _ in range(TRIES):
            self._answers.pop(line, None)
            yield Send(line + b"\r")
            while line not in self._answers:
                if not (yield from self._until(lambda: _PROMPT in self._text, _ECHO_NS)):
                    break
                self._take_blocks(line)
            else:
                return self._answers[line]
            self._text = b""
        raise _Trouble(f'no answer to "{line.decode()}"')

    def _wait(self) -> Dialogue[None]:
        """Wait for a row's end. After a long silence look where the board is: a signal may be lost, or a row
        wait for its sync."""
        ended = self.ended
        while self.ended == ended:
            if (yield from self._hear(_LOOK_NS)):
                yield from self._settle()
            elif (yield from self._stands()):
                self.ended, self._runs = self.sent, False
            else:
                left = (self._next_position - (yield from self._place())) % QUEUE_LEN
                self.ended = max(self.ended, self.sent - left) if left else self.ended
                yield Progress(self.ended, self._last, f"row {self.ended + 1} runs, or waits")

    def _stands(self) -> Generator[Step, Any, bool]:
        """True if no row runs, waits or is held."""
        for _ in range(2):  # between two rows it is at no row for an instant
            speed = read_speed((yield from self._ask(b"vd")))
            if speed != (0, 0) or (yield from self._place()) != self._next_position:
                return False
        return True

    def _place(self) -> Generator[Step, Any, int]:
        return read_listing((yield from self._ask(b"q"))).at
