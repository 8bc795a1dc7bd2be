"""A terminal under a stable name, as a ``Port``. A pty that dies is replaced by another."""

import grp
import os
from functools import partial
from typing import NamedTuple

from hil.net import stable_name
from hil.net.line_openings import Opening
from hil.net.traffic import Outgoing, Traffic
from hil.vocab.ports import PortContext, PortError, PortHost, PortStats
from virtual_ports.pty.clients import Clients
from virtual_ports.pty.pair import PtyPair
from virtual_ports.pty.pty_options import Options

_READ_BYTES = 65536


class _Open(NamedTuple):
    pair: PtyPair
    clients: Clients
    out: Outgoing


class PtyPort:
    """``Port`` of a pty. Clients compete for what the device sends, as on any terminal; use one reader at a
    time.

    ``connects`` may be too low, and ``clients`` wrong for 20 ms (see ``Clients``). The counters of bytes are
    exact always.
    """

    def __init__(self, options: Options, context: PortContext) -> None:
        self._options = options
        self._group = options.group or context.group
        self._title = f"pty port of {context.device}"
        self._name = context.runtime_dir / (options.path or context.device)
        self._is_chosen = not self._name.is_relative_to(context.runtime_dir)
        self._traffic = Traffic()
        # So one that dies before anybody was there is replaced as well, once.
        self._connects_before = -1
        self._pty: _Open | None = None
        self._reading = self._answering = False
        self._opening = Opening()

    @property
    def address(self) -> str:
        return str(self._name)

    async def open(self, host: PortHost) -> None:
        self._host = host
        import asyncio  # where a port is opened; its options are read without

        self._loop = asyncio.get_running_loop()
        self._open_pty()

    def _open_pty(self) -> None:
        """Make a pty, point the name at it and read.

        Raises:
            PortError: it cannot be made, or not be named; nothing of it is left then.
        """
        try:
            pair = PtyPair(self._died)
        except OSError as error:
            raise self._no_pty(error) from error
        clients = None
        try:
            self._set_access(pair)
            clients = Clients(pair, self._loop, self._came, self._left)
            stable_name.publish(self._title, self._name, pair.pts, is_chosen=self._is_chosen)
        except BaseException as error:
            if clients is not None:
                clients.close()
            pair.close()
            if isinstance(error, OSError):
                raise self._no_pty(error) from error
            raise
        send = partial(os.write, pair.master)
        out = Outgoing(
            pair.master, send, self._loop, self._traffic, self._tell_drained, pair.fail, look=clients.notice
        )
        self._pty = _Open(pair, clients, out)
        self.resume_reading()

    def _no_pty(self, error: OSError) -> PortError:
        return PortError(
            f"{self._title}: no pty, or no watch on it: {error.strerror}; see the limits kernel.pty.max, "
            "fs.inotify.max_user_instances and RLIMIT_NOFILE"
        )

    def _set_access(self, pair: PtyPair) -> None:
        group = self._group
        if group is not None:
            try:
                os.fchown(pair.slave, -1, grp.getgrnam(group).gr_gid)
            except KeyError as error:
                raise PortError(
                    f"{self._title}: there is no group {group!r}; create it or choose another group:"
                ) from error
            except PermissionError as error:
                raise PortError(
                    f"{self._title}: may not give {pair.pts} to group {group!r}; add user {os.geteuid()} to "
                    f"that group, or {'set group: null' if self._options.group else 'leave out --port-group'}"
                ) from error
        os.fchmod(pair.slave, int(self._options.mode, 8))

    def write(self, data: bytes) -> None:
        pty = self._pty
        if pty and not self._answering:
            pty.clients.notice()
        if pty and pty.clients.count:
            pty.out.write(data)
        else:
            self._traffic.unheard_bytes += len(data)

    def _tell_drained(self) -> None:
        # Later, because the host may answer with a write, and this may be in the middle of one.
        self._loop.call_soon(self._drained)

    def _drained(self) -> None:
        if self._pty and not self._pty.out.backlog_bytes:
            self._host.drained()

    def resume_reading(self) -> None:
        if not self._reading and self._pty and not self._pty.pair.is_dead:
            self._reading = True
            self._loop.add_reader(self._pty.pair.master, self._readable, self._pty)

    def _stop_reading(self, pty: _Open) -> None:
        if self._reading:
            self._reading = False
            self._loop.remove_reader(pty.pair.master)

    def _readable(self, pty: _Open) -> None:
        # First, so that the answer to a client just come is not discarded with the rest of one just gone.
        pty.clients.notice()
        room = self._host.room()
        if room <= 0:
            self._stop_reading(pty)
            return
        try:
            data = os.read(pty.pair.master, min(room, _READ_BYTES))
        except BlockingIOError:
            return
        except OSError as error:
            pty.pair.fail(error)
            return
        if not pty.clients.count:
            pty.clients.doubt()  # from one that has left, or that was not seen to come
        self._traffic.rx_bytes += len(data)
        self._opening.tell(self._host)
        self._answering = True  # clients were counted just now: once for each command, not for each piece too
        self._host.received(data)
        self._answering = False
        pty.clients.input_was_read()

    def backlog(self) -> int:
        return self._pty.out.backlog_bytes if self._pty else 0

    def client_baud(self) -> int | None:
        """Baud of the client, or of the last one while bytes of it wait to be read."""
        return self._pty.clients.baud() if self._pty else None

    def stats(self) -> PortStats:
        return PortStats(clients=self._pty.clients.count if self._pty else 0, **vars(self._traffic))

    def _came(self) -> None:
        self._traffic.connects += 1
        if self._pty and self._pty.clients.count == 1:
            self._opening.begin()
            # Later, because this may be in the middle of what the host writes.
            self._loop.call_soon(self._opening.tell, self._host)

    def _left(self, baud: int | None) -> None:
        if self._pty:
            self._pty.out.discard()
            # Later, because the host may answer with a write, and this may be in the middle of one.
            self._loop.call_soon(self._tell_client_left, baud)

    def _tell_client_left(self, baud: int | None) -> None:
        if self._pty and not self._pty.pair.is_dead:
            self._host.client_left(baud)

    def _died(self, error: OSError) -> None:
        """Replace the terminal, which is dead, as after root's vhangup: soon another is behind the name."""
        if self._pty:
            self._stop_reading(self._pty)
            self._pty.out.stop()
            # Later, because this may be in the middle of what the watch tells.
            self._loop.call_soon(
                self._replace, self._pty, f"{self._title}: {self._pty.pair.pts} is dead: {error}"
            )

    def _replace(self, dead: _Open, why: str) -> None:
        if self._pty is not dead:
            return  # closed meanwhile
        if self._traffic.connects == self._connects_before:
            self._host.port_failed(why)  # nobody was there since the last: another is no help
            return
        self._connects_before = self._traffic.connects
        self._pty = None
        try:
            self._open_pty()
        except PortError as error:
            self._host.port_failed(f"{why}; {error}")
        self._close_pty(dead)
        if dead.clients.count:
            self._host.client_left(None)

    def _close_pty(self, pty: _Open) -> None:
        stable_name.withdraw(self._name, pty.pair.pts)
        pty.clients.close()
        pty.pair.close()

    async def close(self) -> None:
        if self._pty is not None:
            self._stop_reading(self._pty)
            self._pty.out.stop()
            self._close_pty(self._pty)
            self._pty = None
