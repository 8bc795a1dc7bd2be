"""Child processes of a program on simulated time, and the bench's ports for them."""

import fcntl
import json
import os
import pty
import select
import shutil
import subprocess
import tempfile
import termios
import tty
import weakref
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from hil.testing.owned_time.thread_turn import Outside
from hil.testing.owned_time.turns import Turns
from hil.testing.serial_ports.port_terminal import PortTerminal
from hil.vocab.time import FOREVER, SimTimeNs

_waitpid, _execute = os.waitpid, subprocess.Popen._execute_child  # type: ignore[attr-defined]
_poll = select.poll
_PIECE = 4096


class ChildPort:
    """Terminal of a port for child processes: a pty, whose bytes pass while somebody has it open; and
    a file by which both sides lock it."""

    def __init__(self, terminal: PortTerminal, path: Path) -> None:
        self._terminal = terminal
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self._settings = termios.tcgetattr(slave)
        os.set_blocking(self._master, False)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.symlink_to(os.ttyname(slave))
        os.close(slave)
        self._lock = path.with_suffix(".lock").open("w")
        terminal.lock_outside = self._lock_outside
        if terminal.lock:
            self._lock_outside(True)
        self._events = _poll()
        self._events.register(self._master, select.POLLIN | select.POLLHUP)
        self._is_open = False

    def pass_on(self, now_ns: SimTimeNs) -> None:
        """Pass on what has come on both sides."""
        is_open = not any(event & select.POLLHUP for _, event in self._events.poll(0))
        if is_open and not self._is_open:
            self._terminal.open(now_ns)
        if self._is_open or is_open:
            self._send(now_ns)
        if self._is_open and not is_open:
            self._terminal.close(now_ns)
        elif is_open and (data := self._terminal.read(_PIECE, now_ns)):
            with suppress(BlockingIOError):
                os.write(self._master, data)
        self._is_open = is_open

    def _lock_outside(self, is_locked: bool) -> bool:
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB if is_locked else fcntl.LOCK_UN)
        except BlockingIOError:
            return False
        return True

    def _send(self, now_ns: SimTimeNs) -> None:
        with suppress(OSError):
            settings = termios.tcgetattr(self._master)
            if settings[:6] != self._settings[:6]:
                self._settings = settings
                self._terminal.set(settings, now_ns)
        with suppress(OSError):
            if data := os.read(self._master, _PIECE):
                self._terminal.write(data, now_ns)


class Children(Outside):
    """Child processes of a program. While one lives, time passes at the wall's pace: it has no other.
    ``terminals``: ports by the names that the program has for them."""

    def __init__(self, turns: Turns, terminals: Mapping[str, PortTerminal]) -> None:
        self._turns, self._terminals = turns, terminals
        self._started = weakref.WeakSet[Any]()
        self._folder = Path(tempfile.mkdtemp(prefix="hil-virtual-"))
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._ports: list[ChildPort] = []

    def environment(self) -> dict[str, str]:
        """Environment of children: Python reads a start of ours from it."""
        start = self._folder / "sitecustomize.py"
        start.write_text(Path(__file__).with_name("child_start.py").read_text())
        ports = {name: str(self._path(number)) for number, name in enumerate(self._terminals)}
        (self._folder / "ports.json").write_text(json.dumps(ports))
        path = os.environ.get("PYTHONPATH")
        return {"PYTHONPATH": os.pathsep.join([str(self._folder), *([path] if path else [])])}

    def _path(self, number: int) -> Path:
        return self._folder / "ports" / str(number)

    def is_there(self) -> bool:
        return bool(self._ports) and any([self._lives(each) for each in [*self._started]])

    def pass_on(self, now_ns: SimTimeNs) -> None:
        for each in self._ports:
            each.pass_on(now_ns)

    def _lives(self, child: Any) -> bool:
        if child.returncode is None:
            try:
                options = os.WEXITED | os.WNOHANG | os.WNOWAIT
                if os.waitid(os.P_PID, child.pid, options) is None:
                    return True
            except ChildProcessError:
                pass
        self._started.discard(child)
        return False

    def execute_child(self, child: Any, *options: Any) -> None:
        """Start a child, as ``Popen._execute_child``."""
        if not self._ports:
            self._ports = [
                ChildPort(terminal, self._path(number))
                for number, terminal in enumerate(self._terminals.values())
            ]
        with self._turns.inside():  # it reads from a pipe what the child says before it begins
            _execute(child, *options)
        self._started.add(child)
        self._turns.tell_once(
            "child", "a child process has the wall's time: this run passes at its pace, another may differ"
        )

    def waitpid(self, pid: int, options: int) -> tuple[int, int]:
        """Wait for a child, as ``os.waitpid``."""
        if options & os.WNOHANG:
            return _waitpid(pid, options)
        found = 0, 0

        def ready() -> bool:
            nonlocal found
            found = _waitpid(pid, options | os.WNOHANG)
            return found[0] != 0

        self._turns.wait(ready, FOREVER, f"child process {pid}", is_outside=True)
        return found
