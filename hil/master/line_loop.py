"""A master of a line at its port, on this computer's clock: bytes in and out, the timer of what is due."""

import asyncio
from collections.abc import Iterable, Sequence

from hil.master.line_port import LinePort
from hil.master.sans_io.transaction import Transaction
from hil.net.silence_timer import SilenceTimer
from hil.vocab.line_node import LineMaster
from hil.vocab.ports import EchoStats
from hil.vocab.time import FOREVER, NS_PER_S
from hil.wire.echo import Echo


class LineGone(Exception):
    """Error of a port that has gone. ``outstanding``: the transactions that were not over; ``str(error)``
    names them."""

    def __init__(self, place: str, why: str, outstanding: Sequence[Transaction]) -> None:
        self.why = why
        self.outstanding = tuple(outstanding)
        lines = [f"{place} has gone ({why})", *map(_outstanding, outstanding)]
        super().__init__("; ".join(lines) if outstanding else f"{lines[0]}; nothing was outstanding")


def _outstanding(transaction: Transaction) -> str:
    command = transaction.command.decode("latin-1")
    return f"{transaction.unit} {command}: {transaction.outcome}"


class LineLoop:
    """Port of a line, and the turns of its master. ``name``: of the line, for people; ``speed``: simulated
    time that passes in a second; ``echo``: what of it is no answer."""

    def __init__(self, name: str, speed: float, echo: Echo) -> None:
        self.gone: LineGone | None = None
        """Error of the port, once it has gone."""
        self._name, self._speed, self._echo = name, speed, echo
        self._port: LinePort | None = None
        self._loop = asyncio.get_running_loop()
        self._timer = SilenceTimer(self._turn)
        self._is_closed = False
        self._ended = asyncio.Event()

    @property
    def echo(self) -> EchoStats:
        """Echo of the line's adapter, as far as it is known."""
        return self._echo.told

    @property
    def _master(self) -> LineMaster:
        """Master whose turn it is."""
        raise NotImplementedError

    def _outstanding(self) -> Sequence[Transaction]:
        raise NotImplementedError

    def _after_turn(self) -> None:
        """Hand on what the turn has brought."""

    def close(self) -> None:
        """Close the port."""
        self._timer.close()
        self._is_closed = True
        if self._port:
            self._port.close()

    def now_ns(self) -> int:
        """Time of this line: simulated time passes at the bench's speed."""
        return round(self._loop.time() * NS_PER_S * self._speed)

    async def settled(self, transactions: Iterable[Transaction]) -> None:
        """Wait until all of these are over. Raises LineGone."""
        while not all(each.is_over for each in transactions):
            self._check()
            self._ended.clear()
            await self._ended.wait()
        self._check()

    def _check(self) -> None:
        if self.gone:
            raise self.gone

    def _received(self, data: bytes) -> None:
        self._master.receive(data, self.now_ns())
        self._turn()

    def _lost(self, why: str) -> None:
        outstanding = self._outstanding()
        self._master.lose(self.now_ns(), f"{self._name} has gone ({why})")
        self.gone = LineGone(self._name, why, outstanding)
        self._turn()

    def _turn(self) -> None:
        """Do what is due, hand on what goes out, and set the timer for what is due next."""
        master, now_ns = self._master, self.now_ns()
        if master.due_ns() <= now_ns:
            master.advance(now_ns)
        if (out := master.to_send()) and self._port:
            self._port.write(out)
        self._after_turn()
        if (due_ns := master.due_ns()) != FOREVER and not self._is_closed:
            self._timer.start(round((due_ns - self.now_ns()) / self._speed))
        self._ended.set()
