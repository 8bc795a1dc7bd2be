"""A real serial port as a ``Port``: it may go and come back, and says so."""

import asyncio
import errno
import logging
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from hil.net.address_holder import device_holder
from hil.net.echo_guard import EchoGuard
from hil.net.traffic import Traffic
from hil.vocab.ports import Port, PortContext, PortHost, PortStats, SoleOf
from hil.wire.address_keys import SERIAL_FORMS, is_serial_address
from hil.wire.echo import Echo

log = logging.getLogger("hil")

_BUSY = {errno.EAGAIN, errno.EBUSY}
"""Errors of flock(2), with which pyserial claims a port, and of open(2) after TIOCEXCL."""
_CLOSE_IT = "; close it there"
AGAIN_S = 1.0
"""Interval of attempts to open a port that is not there."""


def usable_url(value: Any) -> Any:
    """Check a URL for pydantic: answers the value, or raises why it is no serial port."""
    if isinstance(value, str) and not is_serial_address(value):
        raise PydanticCustomError("serial_url", "this is no serial port", {"remedy": SERIAL_FORMS})
    return value


SerialUrl = Annotated[str, BeforeValidator(usable_url)]


class Options(BaseModel):
    """A real serial port, at which a program on the other end of the cable finds the device."""

    model_config = ConfigDict(strict=True, extra="forbid")

    url: SerialUrl = Field(
        description="A path as in /dev/ttyUSB0, socket://host:port or rfc2217://host:port."
    )
    rs485: bool = Field(
        default=False,
        description="Let the kernel switch the adapter's driver on and off (RTS), where it can: a path only.",
    )
    baud: int = Field(default=115200, ge=50, le=4_000_000, description="The adapter's speed.")
    echo: bool | None = Field(
        default=None,
        description="Whether the adapter echoes what it sends, because its receiver stays on: the echo is"
        " dropped. Null: recognised by itself at taps of segments and lines of the Modbus bridge; a terminal"
        " is believed to have none, because a board may echo what is typed.",
    )


def make(options: Options, context: PortContext) -> Port:
    return SerialPort(options, context)


class SerialPort:
    """``Port`` whose one client is what hangs on the cable. While it is away, bytes for it are dropped and
    counted; it is tried again each second. ``away`` says why, None while it is open."""

    def __init__(self, options: Options, context: PortContext) -> None:
        self._options = options
        self._title = f"serial port of {context.device}"
        self._line: Any = None
        self._keeper: asyncio.Task[None] | None = None
        self._lost = asyncio.Event()
        self._traffic = Traffic()
        self._echo = Echo(options.baud, wanted=options.echo)
        self._guard: EchoGuard | None = None
        self.away: str | None = "not opened yet"

    def tell_sole(self, sole: SoleOf, *, in_pieces: bool) -> None:
        self._echo.seek(sole, in_pieces=in_pieces)

    @property
    def address(self) -> str:
        return self._options.url

    async def open(self, host: PortHost) -> None:
        self._host = host
        self._loop = asyncio.get_running_loop()
        await self._connect()
        if self.away:
            log.warning("%s: %s: %s; tried again each second", self._title, self.address, self.away)
        self._keeper = self._loop.create_task(self._keep())

    async def _connect(self) -> None:
        from virtual_ports.serial.open_line import FdLine, ThreadLine, open_serial, why

        try:
            port = await self._loop.run_in_executor(
                None, open_serial, self._options.url, self._options.baud, self._options.rs485
            )
        except (OSError, ValueError) as error:
            if getattr(error, "errno", None) not in _BUSY:
                self.away = why(error, self._options.url)
            elif not (self.away or "").endswith(_CLOSE_IT):  # who has it is looked for once, not each second
                holder = await self._loop.run_in_executor(None, device_holder, self._options.url)
                self.away = f"in use by {holder or 'another program'}{_CLOSE_IT}"
            return
        kind = ThreadLine if self._options.url.startswith("rfc2217://") else FdLine
        self._lost.clear()
        self.away = None
        self._traffic.connects += 1
        self._echo.reopened()
        self._guard = EchoGuard(self._echo, self._host.received, f"{self._title}: {self.address}")
        host = _Filtered(self._host, self._guard)
        self._line = kind(port, host, self._line_lost, self._traffic, self._loop)

    async def _keep(self) -> None:
        while True:
            if self.away is None:
                await self._lost.wait()
            await asyncio.sleep(AGAIN_S)
            await self._connect()
            if self.away is None:
                log.info("%s: %s is back", self._title, self.address)

    def _line_lost(self, reason: str) -> None:
        if self._line is None:
            return
        self.away = reason
        self._line = None
        self._end_guard()
        self._lost.set()
        log.warning("%s: %s: %s; tried again each second", self._title, self.address, reason)
        # What waited for the line is gone with it: who was held up by that goes on (`drained`).
        self._host.client_left(None)
        self._host.drained()

    def write(self, data: bytes) -> None:
        if self._line is None:
            self._traffic.unheard_bytes += len(data)
            return
        if self._guard:
            self._guard.sent(data)
        self._line.write(data)

    def resume_reading(self) -> None:
        if self._line is not None:
            self._line.resume()

    def backlog(self) -> int:
        return self._line.backlog if self._line is not None else 0

    def client_baud(self) -> int | None:
        """Baud of a client: always None, for the adapter's speed is fixed here."""
        return None

    def stats(self) -> PortStats:
        clients, echo = int(self.away is None), self._echo.told
        return PortStats(clients=clients, away=self.away, echo=echo, **vars(self._traffic))

    async def close(self) -> None:
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.gather(self._keeper, return_exceptions=True)
            self._keeper = None
        if self._line is not None:
            self._line.close()
            self._line = None
            self._end_guard()
            self.away = "closed"

    def _end_guard(self) -> None:
        if self._guard:
            self._guard.close()
            self._guard = None


class _Filtered:
    """Host of an open line, whose echoes are dropped before the port's own host."""

    def __init__(self, host: PortHost, guard: EchoGuard) -> None:
        self._host = host
        self.received = guard.received
        self.room, self.drained = host.room, host.drained
        self.client_left, self.port_failed = host.client_left, host.port_failed
