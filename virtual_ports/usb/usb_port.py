"""Board on the USB of this computer, as a ``Port``. Pulled out, it plugs itself in again."""

import asyncio
import logging
import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from hil.net import stable_name
from hil.net.traffic import Traffic
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.ports import PortContext, PortError, PortHost, PortStats
from virtual_ports.usb.cdc_acm import FRAMING, PARITY
from virtual_ports.usb.descriptors import Descriptors
from virtual_ports.usb.usb_options import Options
from virtual_ports.usb.usb_session import UsbSession
from virtual_ports.usb.vhci import Attachment, VhciError, attach

RESET_S = 0.5
"""Time for which a board that resets is away: long enough for a tool that looks each 0.25 s."""
AGAIN_S = 1.0
"""Interval of attempts to plug in again what was pulled out."""
TRIES = 5
TTY_S = 20.0
"""Maximum time for the kernel to make a tty of the device; most often it takes 0.3 s."""
_TTY_LOOK_S = 0.02
_NO_POWER = "the board has no power"

log = logging.getLogger("hil")


Attach = Callable[[socket.socket, int], Attachment]
"""Plugs a device in: the kernel's end of its socket, and a number for it. Raises VhciError."""


class UsbPort:
    """``Port`` of a device on the USB. ``attach`` plugs it in."""

    def __init__(self, options: Options, context: PortContext, attach: Attach = attach) -> None:
        self._is_native = context.usb.is_native
        serial_number = options.serial_number or f"{context.bench}.{context.device}"
        self._descriptors = Descriptors(context.usb, serial_number)
        self._title = f"usb port of {context.device}"
        self._name = context.runtime_dir / (options.path or context.device)
        self._attach = attach
        self._traffic = Traffic()
        self._session: UsbSession | None = None
        self._plugged: Attachment | None = None
        self._tty: str | None = None
        self._keeper: asyncio.Task[None] | None = None
        self._away: str | None = "not opened yet"
        """Reason why it is not plugged in."""
        self._for_s = 0.0
        """Time until it is plugged in again."""
        self._has_power = True
        self._is_closing = False

    @property
    def address(self) -> str:
        """The /dev/ttyACM, or the symlink while there is none."""
        return self._tty or str(self._name)

    async def open(self, host: PortHost) -> None:
        self._host = host
        self._news = asyncio.Event()
        await self._plug_in()
        self._keeper = asyncio.get_running_loop().create_task(self._keep())

    def write(self, data: bytes) -> None:
        if self._session:
            self._session.write(data)
        else:
            self._traffic.unheard_bytes += len(data)

    def resume_reading(self) -> None:
        if self._session:
            self._session.resume()

    def backlog(self) -> int:
        return self._session.backlog_bytes if self._session else 0

    def client_baud(self) -> int | None:
        return self._session.device.coding.baud if self._session else None

    def client_format(self) -> LineFormat:
        """Format of a client's characters."""
        client_format = self._session.device.coding.line_format if self._session else None
        return client_format or EIGHT_N_1

    def tell_errors(self, *, framing: bool, parity: bool) -> None:
        """Tell the host that the last bytes came with these errors."""
        if self._session:
            self._session.tell(FRAMING * framing | PARITY * parity)

    def stats(self) -> PortStats:
        is_open = self._session is not None and self._session.device.is_open
        return PortStats(clients=int(is_open), away=self._away, **vars(self._traffic))

    async def close(self) -> None:
        self._is_closing = True
        if self._keeper:
            self._news.set()
            await self._keeper
            self._keeper = None
        self._pull_out("closed", 0)

    def power(self, is_on: bool) -> None:
        """Note the power of the board: a native one is away without it."""
        if self._is_native and is_on != self._has_power:
            self._has_power = is_on
            if is_on:
                self._news.set()
            else:
                self._pull_out(_NO_POWER, RESET_S)

    # ---- coming and going ----

    async def _plug_in(self) -> None:
        """Plug the device in, and wait for its tty.

        Raises:
            PortError: it cannot be plugged in, or is no tty then; nothing of it is left.
        """
        loop = asyncio.get_running_loop()
        kernels_end, our_end = socket.socketpair()
        try:
            plugged = await loop.run_in_executor(None, self._attach, kernels_end, secrets.randbits(31) or 1)
        except BaseException as error:
            our_end.close()  # what was plugged in meanwhile is pulled out by it
            if not isinstance(error, VhciError):
                raise
            kernels_end.close()
            raise PortError(f"{self._title}: {error}") from error
        self._plugged = plugged
        session = UsbSession(self._descriptors, self._host, self._traffic, self._lost)
        self._session = session
        try:
            await loop.create_unix_connection(lambda: session, sock=our_end)
            tty = await self._find_tty(session, plugged)
            stable_name.publish(self._title, self._name, Path(tty))
        except BaseException as error:
            self._pull_out(str(error), AGAIN_S)
            our_end.close()
            raise
        self._tty, self._away = tty, None

    async def _find_tty(self, session: UsbSession, plugged: Attachment) -> str:
        loop = asyncio.get_running_loop()
        end_s = loop.time() + TTY_S
        while self._session is session and not self._is_closing:
            if tty := await loop.run_in_executor(None, plugged.tty):
                return tty
            if loop.time() > end_s:
                raise PortError(
                    f"{self._title}: it is plugged in, but the kernel has made no tty of it; is its module"
                    " cdc-acm there? as root `modprobe cdc-acm`; `hil usb doctor` says more"
                )
            await asyncio.sleep(_TTY_LOOK_S)
        raise PortError(f"{self._title}: {self._away or 'closed'}; `hil usb doctor` says more")

    def _lost(self, reason: str) -> None:
        """Note that the host controller has ended the session."""
        log.warning("%s: %s: %s; it plugs itself in again", self._title, self.address, reason)
        self._pull_out(reason, AGAIN_S)

    def _pull_out(self, reason: str, for_s: float) -> None:
        session, self._session = self._session, None
        plugged, self._plugged = self._plugged, None
        tty, self._tty = self._tty, None
        self._away, self._for_s = reason, for_s
        if tty:
            stable_name.withdraw(self._name, Path(tty))
        if session:
            session.end(tells=not self._is_closing)
        if plugged:
            plugged.detach()
        if self._keeper:
            self._news.set()

    async def _keep(self) -> None:
        """Plug the device in again after it was pulled out, until the port is closed."""
        tries = TRIES
        while True:
            await self._news.wait()
            self._news.clear()
            if self._is_closing:
                return
            if self._session or not self._has_power:
                continue
            await self._wait(self._for_s)
            if self._is_closing or not self._has_power:
                continue
            try:
                await self._plug_in()
            except PortError as error:
                tries -= self._has_power
                if not tries:
                    self._away = str(error)
                    self._host.port_failed(str(error))
                    return
                self._news.set()
            else:
                tries = TRIES
                log.info("%s: plugged in at %s", self._title, self.address)
                if not self._has_power:
                    self._pull_out(_NO_POWER, RESET_S)

    async def _wait(self, duration_s: float) -> None:
        """Wait; no longer than until the port closes."""
        end_s = asyncio.get_running_loop().time() + duration_s
        with suppress(TimeoutError):
            async with asyncio.timeout_at(end_s):
                while not self._is_closing:
                    await self._news.wait()
                    self._news.clear()
