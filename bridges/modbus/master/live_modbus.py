"""Master of a line of Modbus RTU at a port, on this computer's clock."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from bridges.modbus.master.modbus_master import RESPONSE_NS, ModbusMaster, UnitPoll
from bridges.modbus.protocol.exchange import sole_of_frame
from bridges.modbus.protocol.pdu import Request
from hil.master.line_loop import LineLoop
from hil.master.line_place import LATENCY_NS, bench_here, bench_tap, is_address, wait_until_heard
from hil.master.line_port import LinePort
from hil.master.sans_io.transaction import Transaction
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.wire.echo import Echo

USUAL_BAUD = 19_200
"""Speed of a line of Modbus if nobody says another (MODBUS over Serial Line V1.02, 2.5.1)."""


class LiveModbus(LineLoop):
    """Master of Modbus RTU whose line is open. Made by ``open_modbus_line``."""

    def __init__(self, name: str, master: ModbusMaster, speed: float, echo: Echo) -> None:
        super().__init__(name, speed, echo)
        self.master = master

    async def open(self, address: str, baud: int, line_format: LineFormat, control: Path | None) -> None:
        """Open the port, and begin to poll. Raises LineUnreachable."""
        self._port = await LinePort.open(address, baud, self._received, self._lost, self._echo, line_format)
        try:
            if control is not None:
                await asyncio.to_thread(wait_until_heard, self._name, control)
        except BaseException:
            self.close()
            raise
        self._turn()

    async def ask(self, unit: int, request: Request, *, may_repeat: bool | None = None) -> Transaction:
        """Send a request behind the poll that has its turn, and wait for its outcome.

        Raises:
            ValueError: no unit has this address, or a server would refuse the request by its form alone.
            LineGone: the port has gone.
        """
        asked = self.master.ask(unit, request, self.now_ns(), may_repeat=may_repeat)
        self._turn()
        await self.settled([asked])
        return asked

    async def polled(self, cycles: int) -> None:
        """Wait until so many more cycles of polls have ended. Raises LineGone."""
        until = self.master.cycles + cycles
        while self.master.cycles < until:
            self._check()
            self._ended.clear()
            await self._ended.wait()
        self._check()

    @property
    def _master(self) -> ModbusMaster:
        return self.master

    def _outstanding(self) -> Sequence[Transaction]:
        return self.master.outstanding


@asynccontextmanager
async def open_modbus_line(
    line: str,
    polls: Sequence[UnitPoll] = (),
    *,
    baud: int | None = None,
    line_format: LineFormat = EIGHT_N_1,
    interval_ns: int = 0,
    response_ns: int = RESPONSE_NS,
    latency_ns: int | None = None,
    polled: Callable[[UnitPoll], None] = lambda poll: None,
    echo: bool | None = None,
    bench: str | None = None,
    runtime_dir: Path | None = None,
) -> AsyncIterator[LiveModbus]:
    """Open a line of Modbus RTU for the block, and poll its units meanwhile: a tap of the bench that runs
    here, by its name, or the address of a port, as of ``find_line``. ``baud``: None: the tap's, or 19200;
    ``polled``: called after each poll; ``echo``: whether the adapter echoes, None: recognised by itself.

    Raises:
        LineUnreachable: there is no such line, or it cannot be opened.
        ValueError: a poll's unit or request is wrong.
    """
    address, control, speed = line, None, 1.0
    kind = "path" if line.startswith("/") else "network"
    if not is_address(line):
        here = await asyncio.to_thread(bench_here, line, bench, runtime_dir)
        tap = await asyncio.to_thread(bench_tap, here, line)
        address, control, speed, kind = tap.address, here.socket, tap.speed, "tap"
        baud = baud or tap.baud
    master = ModbusMaster(
        polls,
        baud=baud or USUAL_BAUD,
        line_format=line_format,
        interval_ns=interval_ns,
        response_ns=response_ns,
        latency_ns=round((LATENCY_NS[kind] if latency_ns is None else latency_ns) * speed),
        polled=polled,
    )
    filtered = Echo(
        baud or USUAL_BAUD,
        line_format.bits,
        wanted=echo,
        sole=lambda data: sole_of_frame(data, lambda unit: False),
    )
    live = LiveModbus(line, master, speed, filtered)
    await live.open(address, baud or USUAL_BAUD, line_format, control)
    try:
        yield live
    finally:
        live.close()
