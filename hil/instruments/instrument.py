"""Program of a board by a table: it reads commands one by one, each in its time, and answers."""

import json
from collections.abc import Generator
from typing import Any

from hil.instruments.command_cuts import CommandCutter
from hil.instruments.instrument_table import OVERFLOW, UNKNOWN, InstrumentTable
from hil.instruments.matching import RowOutcome, fitting, prefixed
from hil.instruments.scpi import read_typed, split
from hil.instruments.scpi_status import ScpiStatus
from hil.instruments.slow_values import PresentValues
from hil.instruments.templates import Template
from hil.vocab.firmware import Board, ByteAvailable, Commit, CoreEvent, Delay, Main
from hil.vocab.time import FOREVER

KEPT = "kept"
"""Section of the memory in which values stay without power."""
Steps = Generator[Any, Any, None]


class Instrument:
    """One power-up. Between two commands it follows time: slow values, messages of its own."""

    def __init__(self, board: Board, table: InstrumentTable) -> None:
        self._board, self._uart, self._table = board, board.uart, table
        self._cutter = CommandCutter(table.cuts)
        self._status = ScpiStatus(table.queue, table.no_error, (table.errors or {}).get(OVERFLOW, ""))
        self._values = PresentValues(table, board.fields, self._status)
        self._messages_ns = [0] * len(table.messages)
        self._update_ns = self._last_byte_ns = 0

    def main(self) -> Main:
        """Run it: commands as they come, what is due in between."""
        table, board = self._table, self._board
        self._values.restore(board.nvm.get(KEPT, b""), board.now_ns)
        if table.ready_ns:
            yield Delay(table.ready_ns)
            self._uart.read_all()
        self._messages_ns = [board.now_ns + message.every_ns for message in table.messages]
        self._update_ns = board.now_ns
        if table.greeting:
            self._say([table.greeting])
        while True:
            due_ns = self._due()
            if self._cutter.text and table.cuts.silence_ns:
                ends_ns = self._last_byte_ns + table.cuts.silence_ns
                if board.now_ns >= ends_ns:
                    yield from self._carry_out(self._cutter.ended())
                    continue
                due_ns = min(due_ns, ends_ns)
            if (byte := self._uart.read()) < 0:
                yield ByteAvailable(None if due_ns == FOREVER else due_ns - board.now_ns)
                continue
            self._last_byte_ns = board.now_ns
            if table.echoes:
                self._uart.write(bytes((byte,)))
            if (line := self._cutter.feed(chr(byte))) is not None:
                yield from self._carry_out(line)

    def interrupt(self, event: CoreEvent) -> None:
        """Ignore the core's events: there is no motor."""

    def _due(self) -> int:
        """Do what is due now; answers when the next is."""
        now_ns, table, due_ns = self._board.now_ns, self._table, int(FOREVER)
        if self._values.is_slow:
            if now_ns >= self._update_ns:
                self._values.advance(now_ns)
                self._update_ns += _whole(now_ns - self._update_ns, table.update_ns)
            due_ns = self._update_ns
        for index, message in enumerate(table.messages):
            if now_ns >= self._messages_ns[index]:
                self._messages_ns[index] += _whole(now_ns - self._messages_ns[index], message.every_ns)
                self._values.advance(now_ns)
                if message.when is None or message.when.value(self._values.look):
                    self._say([message.says])
            due_ns = min(due_ns, self._messages_ns[index])
        return due_ns

    def _carry_out(self, line: str) -> Steps:
        """Carry out a line that has come: all its commands, in their time."""
        table, (is_cut, self._cutter.is_cut) = self._table, (self._cutter.is_cut, False)
        if table.check_sum:
            checked = table.check_sum.checked(line)
            if checked is None:
                return
            line = checked
        if (text := prefixed(table, line, self._values.look)) is None:
            return
        said: list[str] = []
        if is_cut:
            self._note_error(UNKNOWN, said)
            text = ""
        path: tuple[str, ...] = ()
        for unit in filter(None, split(text, ";")) if table.is_scpi else [text] if text else []:
            typed = None
            if table.is_scpi:
                typed, path = read_typed(unit, path)
            self._values.advance(self._board.now_ns)
            outcome = fitting(table, typed or unit, self._values)
            if outcome.takes_ns:
                yield Delay(outcome.takes_ns)
                self._values.advance(self._board.now_ns)
            self._status.has_answer = bool(said)
            yield from self._effect(outcome, said)
        if said:
            self._send(";".join(said) if table.is_scpi else table.answer_end.join(said))

    def _effect(self, outcome: RowOutcome, said: list[str]) -> Steps:
        """Let a command do what it does. ``said``: takes what it answers."""
        row, values = outcome.row, self._values
        if row is None:
            self._note_error(outcome.error, said)
            return
        if row.clears_errors:
            self._status.clear()
        if row.resets:
            values.reset()
        problem, is_kept = values.carry_out(row, outcome.given)
        if problem:
            self._note_error(problem, said)
        else:
            said += [answer.filled(values.look) for answer in row.answers]
        values.forget()
        if is_kept:
            yield Commit(KEPT, json.dumps(values.kept(), sort_keys=True).encode())

    def _note_error(self, kind: str, said: list[str]) -> None:
        text = (self._table.errors or {}).get(kind, "")
        if not text:
            return
        if not self._table.queue:
            said.append(text)
        else:
            self._status.note(text)

    def _say(self, templates: list[Template]) -> None:
        self._send(self._table.answer_end.join(each.filled(self._values.look) for each in templates))

    def _send(self, text: str) -> None:
        table = self._table
        if table.answer_prefix:
            text = table.answer_prefix.filled(self._values.look) + text
        if table.check_sum:
            text += table.check_sum.of(text)
        self._uart.write((text + table.answer_end).encode("latin-1", "replace"))


def _whole(late_ns: int, period_ns: int) -> int:
    """Time from when something was due to when it is due again: whole periods, beyond how late it is."""
    return (late_ns // period_ns + 1) * period_ns
