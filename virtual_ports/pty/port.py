"""The pty port: see ``PtyPort._clients_changed`` and ``write`` for what makes it more than a pair of fds."""

import asyncio
import errno
import grp
import os
import select
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from hil.vocab.ports import Port, PortContext, PortError, PortHost, PortStats
from virtual_ports.pty import line, stable_name
from virtual_ports.pty.inotify import ClientWatch

QUEUE_BYTES = 4 * 1024 * 1024  # thirty answers of the longest kind (q of a Mechaduino: 126 kB)
_READ_BYTES = 65536
_AUDIT_AFTER_S = 0.02
_AUDIT_AGAIN_S = 0.2


class Options(BaseModel):
    """A pseudo-terminal under a stable path."""

    model_config = ConfigDict(strict=True, extra="forbid")

    mode: str = Field(
        default="0660",
        pattern=r"^0?[67][0-7]{2}$",
        description="Permissions of the terminal, in octal; its owner must be able to read and write.",
    )
    group: str | None = Field(
        default=None,
        min_length=1,
        description="Group that owns the terminal, such as dialout; null takes that of "
        "`hil serve --port-group`, or leaves the system's choice.",
    )
    path: str | None = Field(
        default=None,
        min_length=1,
        description="Path of the symlink that clients open, relative to the bench's runtime directory; "
        "null takes the device's name there.",
    )


def make(options: Options, context: PortContext) -> Port:
    """The port, still closed."""
    return PtyPort(options, context)


class PtyPort:
    """A ``Port``. Clients compete for what the device sends, as on any terminal; use one reader at a time.

    When two clients open or close within the same microsecond the kernel can merge the two (see
    ``inotify.py``): ``connects`` stays one too low, and ``clients`` is wrong until a byte or a close that
    does not fit makes ``_audit`` look, 20 ms later. The counters of bytes are exact always.
    """

    def __init__(self, options: Options, context: PortContext) -> None:
        self._options = options
        self._group = options.group or context.group
        self._title = f"pty port of {context.device}"
        self._name = context.runtime_dir / (options.path or context.device)
        self._pts = Path()
        self._master = self._slave = -1
        self._connects_before = -1
        self._clients = self._connects = 0
        self._rx_bytes = self._tx_bytes = self._dropped_bytes = self._unheard_bytes = 0
        self._queue = bytearray()
        self._reading = self._failed = self._answering = False
        self._baud_of_departed: int | None = None
        self._own_steps: list[int] = []
        self._resting = b""
        self._watch: ClientWatch | None = None
        self._audit_twice = False
        self._audit_timer: asyncio.TimerHandle | None = None

    @property
    def address(self) -> str:
        return str(self._name)

    async def open(self, host: PortHost) -> None:
        self._host = host
        self._loop = asyncio.get_running_loop()
        try:
            self._open_pty()
        except BaseException:
            await self.close()
            raise

    def _open_pty(self) -> None:
        """Make a pty, point the name at it and read.

        Raises:
            PortError: it cannot be made, or not be named; what was made of it is for ``_close_pty``.
        """
        try:
            self._master, self._slave = os.openpty()
            self._pts = Path(os.ttyname(self._slave))
            os.set_blocking(self._master, False)
            self._input = select.poll()
            self._input.register(self._master, select.POLLIN)
            self._resting = line.resting(self._slave)
            line.apply(self._slave, self._resting)
            self._set_access()
            self._watch = ClientWatch(self._pts, self._clients_changed)
            stable_name.publish(self._title, self._name, self._pts)
        except OSError as error:
            raise PortError(
                f"{self._title}: no pty, or no watch on it: {error.strerror}; see the limits kernel.pty.max, "
                "fs.inotify.max_user_instances and RLIMIT_NOFILE"
            ) from error
        self.resume_reading()

    def _set_access(self) -> None:
        group = self._group
        if group is not None:
            try:
                os.fchown(self._slave, -1, grp.getgrnam(group).gr_gid)
            except KeyError as error:
                raise PortError(
                    f"{self._title}: there is no group {group!r}; create it or choose another group:"
                ) from error
            except PermissionError as error:
                raise PortError(
                    f"{self._title}: may not give {self._pts} to group {group!r}; add user {os.geteuid()} to "
                    f"that group, or {'set group: null' if self._options.group else 'leave out --port-group'}"
                ) from error
        os.fchmod(self._slave, int(self._options.mode, 8))

    def write(self, data: bytes) -> None:
        if not self._answering:
            self._notice_clients()
        if not self._clients:
            self._unheard_bytes += len(data)
            return
        sent = 0 if self._queue else self._send(data)
        waiting = data[sent : sent + QUEUE_BYTES - len(self._queue)]
        self._dropped_bytes += len(data) - sent - len(waiting)
        if waiting and not self._failed:
            if not self._queue:
                self._loop.add_writer(self._master, self._writable)
            self._queue += waiting
        else:
            self._dropped_bytes += len(waiting)

    def _writable(self) -> None:
        self._notice_clients()
        if self._queue:
            del self._queue[: self._send(self._queue)]
            if not self._queue:
                self._backlog_gone()

    def _send(self, data: bytes | bytearray) -> int:
        if self._failed:
            return 0
        try:
            sent = os.write(self._master, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            self._fail(error)
            return 0
        self._tx_bytes += sent
        return sent

    def _discard_queue(self) -> None:
        if self._queue:
            self._dropped_bytes += len(self._queue)
            self._queue.clear()
            self._backlog_gone()

    def _backlog_gone(self) -> None:
        self._loop.remove_writer(self._master)
        # Later, because the host may answer with a write, and this may be in the middle of one.
        self._loop.call_soon(self._tell_drained)

    def _tell_drained(self) -> None:
        if not self._queue and self._master >= 0:
            self._host.drained()

    def resume_reading(self) -> None:
        if not self._reading and self._master >= 0 and not self._failed:
            self._reading = True
            self._loop.add_reader(self._master, self._readable)

    def _stop_reading(self) -> None:
        if self._reading:
            self._reading = False
            self._loop.remove_reader(self._master)

    def _readable(self) -> None:
        # First, so that the answer to a client just come is not discarded with the rest of one just gone.
        self._notice_clients()
        room = self._host.room()
        if room <= 0:
            self._stop_reading()
            return
        try:
            data = os.read(self._master, min(room, _READ_BYTES))
        except BlockingIOError:
            return
        except OSError as error:
            self._fail(error)
            return
        if not self._clients:
            self._audit_in(_AUDIT_AFTER_S)  # from one that has left, or that was not seen to come
        self._rx_bytes += len(data)
        self._answering = True  # clients were counted just now: once for each command, not for each piece too
        self._host.received(data)
        self._answering = False
        if self._baud_of_departed is not None and self._master >= 0 and not self._input.poll(0):
            self._baud_of_departed = None

    def backlog(self) -> int:
        return len(self._queue)

    def client_baud(self) -> int | None:
        """While nobody is there but bytes of a client that has left wait to be read: its baud."""
        if self._clients:
            return line.baud(self._master)
        return self._baud_of_departed

    def stats(self) -> PortStats:
        return PortStats(
            clients=self._clients,
            connects=self._connects,
            rx_bytes=self._rx_bytes,
            tx_bytes=self._tx_bytes,
            dropped_bytes=self._dropped_bytes,
            unheard_bytes=self._unheard_bytes,
        )

    def _notice_clients(self) -> None:
        if self._watch is not None:
            self._watch.drain()

    def _clients_changed(self, steps: list[int], events_lost: bool) -> None:
        for own in self._own_steps:
            if own in steps:
                steps.remove(own)
        emptied, doubtful = False, events_lost
        for step in steps:
            if step > 0:
                self._clients += 1
                self._connects += 1
                continue
            # One that was never seen to come, or of several, of which another may have left unseen.
            doubtful |= self._clients != 1
            self._clients = max(self._clients - 1, 0)
            emptied |= self._clients == 0
        if emptied:
            self._last_client_left()
        with self._failing_loudly():
            if -1 in steps and not emptied:
                line.end_stop(self._slave)  # nobody can tell whose it is, and it would hold up those who stay
            line.baud(self._slave)  # after a hang-up nothing else would tell
        if doubtful:
            self._audit_in(_AUDIT_AFTER_S)

    def _last_client_left(self) -> None:
        # A next client may be there already, but all that was written so far was for those before it.
        self._discard_queue()
        baud = None
        with self._failing_loudly():
            line.let_go_on(self._slave)  # also if the next is there: it would be held up for ever
            line.discard_unread(self._slave)
            baud = line.baud(self._master)
        # Later, because the host may answer with a write, and this may be in the middle of one.
        self._loop.call_soon(self._tell_client_left, baud)
        self._reset_line()

    def _tell_client_left(self, baud: int | None) -> None:
        if self._master >= 0 and not self._failed:
            self._host.client_left(baud)

    def _reset_line(self) -> None:
        if self._clients or self._failed or self._watch is None:
            return
        with self._failing_loudly():
            if self._input.poll(0):
                self._baud_of_departed = line.baud(self._master) or self._baud_of_departed
            if self._watch.pending():  # perhaps the next client, whose settings must stay
                self._loop.call_soon(self._reset_line_later)
                return
            if line.is_locked(self._slave):
                raise OSError(errno.EPERM, "its settings are locked")
            line.apply(self._slave, self._resting)
            line.end_exclusive(self._slave)

    def _reset_line_later(self) -> None:
        self._notice_clients()
        self._reset_line()

    def _audit_in(self, delay_s: float) -> None:
        if self._audit_timer is None:
            self._audit_timer = self._loop.call_later(delay_s, self._audit)
        else:
            self._audit_twice = True  # the one that is due may come too soon after this event

    def _audit(self) -> None:
        """Put a count right that merged or lost events have left wrong.

        The kernel shows whether a slave fd is open, ours included, so that one has to go for a moment. Not
        done without a reason: its coming back could be merged with the coming of a client.
        """
        self._audit_timer = None
        if self._failed:
            return
        if self._audit_twice:
            self._audit_twice = False
            self._audit_in(_AUDIT_AFTER_S)
        self._notice_clients()
        nobody = False
        with self._failing_loudly():
            # Exclusive since the last client left: somebody is there, and we might not get back in.
            nobody = not line.is_exclusive(self._slave) and self._no_other_slave()
        if nobody and self._clients:
            self._clients = 0
            self._last_client_left()
        self._notice_clients()
        self._own_steps = []
        if not nobody and not self._clients and not self._failed:
            self._clients = 1
            self._audit_in(_AUDIT_AGAIN_S)  # it may have been a client in the middle of its close

    def _no_other_slave(self) -> bool:
        self._own_steps = [-1, 1]
        slave, self._slave = self._slave, -1
        os.close(slave)
        hung_up = any(events & select.POLLHUP for _, events in self._input.poll(0))
        self._slave = os.open(self._pts, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
        return hung_up

    @contextmanager
    def _failing_loudly(self) -> Iterator[None]:
        """An error here must not stop the other ports, which may be told of their clients after this one."""
        try:
            yield
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> None:
        """The terminal is dead, as after root's vhangup: soon another is behind the name."""
        if not self._failed:
            self._failed = True
            self._stop_reading()
            self._discard_queue()
            # Later, because this may be in the middle of what the watch tells.
            self._loop.call_soon(self._replace_pty, f"{self._title}: {self._pts} is dead: {error}")

    def _replace_pty(self, why: str) -> None:
        if self._master < 0:
            return  # closed meanwhile
        if self._connects == self._connects_before:  # nobody was there since the last: another is no help
            self._host.port_failed(why)
            return
        self._connects_before = self._connects
        dead, had_clients = (self._master, self._slave, self._pts, self._watch), self._clients > 0
        self._clients, self._baud_of_departed, self._own_steps = 0, None, []
        self._master = self._slave = -1
        self._watch, self._failed = None, False
        try:
            self._open_pty()
        except PortError as error:
            self._failed = True
            self._host.port_failed(f"{why}; {error}")
        self._close_pty(*dead)
        if had_clients:
            self._host.client_left(None)

    def _close_pty(self, master: int, slave: int, pts: Path, watch: ClientWatch | None) -> None:
        stable_name.withdraw(self._name, pts)
        if watch is not None:
            watch.close()
        for fd in (master, slave):
            if fd >= 0:
                os.close(fd)

    async def close(self) -> None:
        if self._audit_timer is not None:
            self._audit_timer.cancel()
            self._audit_timer = None
        if self._watch is not None:
            self._stop_reading()
            self._discard_queue()
        self._clients = 0
        self._baud_of_departed = None
        self._close_pty(self._master, self._slave, self._pts, self._watch)
        self._master = self._slave = -1
        self._watch = None
