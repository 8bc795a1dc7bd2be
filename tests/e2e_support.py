"""Runs ``hil`` as its users do: a process, its ports, its commands. Every wait has a deadline."""

import json
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import pytest
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.net.control_client import ControlError, ask
from hil.vocab.time import FOREVER

HIL = str(Path(sys.executable).with_name("hil"))
STRANGER_UID = 65534
PATIENCE_S = 120.0
"""A bound for what takes well under a second on an idle machine."""
READY_NS = 4_000_000_000
"""Simulated time at which the board answers."""
SAC_READY_NS = 1_150_000_000
"""Simulated time at which a SAC answers."""
Q_BYTES = 126_682
"""Length of the answer to q with the identity table."""
LOOKUP_HEAD = b"lookup[16384] = {\r\n"
LAST_WORDS = "Ctrl-C ends the bench."
"""Last line of what a daemon says at its start."""
NEEDS_RUNTIME_DIR = (
    "list",
    "status",
    "monitor",
    "reset",
    "pin",
    "set",
    "pause",
    "plot",
    "resume",
    "step",
    "pulses",
    "axis",
    "type",
    "wait",
    "zero",
)
FAULTS_OF_OURS = ("Traceback", "never awaited", "Exception ignored")
"""Words of what no daemon may say."""
TERMINAL = {"COLUMNS": "100", "TERM": "dumb"}
T = TypeVar("T")
Devices = Mapping[str, Mapping[str, Any]]


def until(condition: Callable[[], T], what: str, timeout_s: float = PATIENCE_S) -> T:
    """Wait for the first true value of ``condition``, asked every 10 ms, and return it."""
    deadline = time.monotonic() + timeout_s
    while not (value := condition()):
        assert time.monotonic() < deadline, f"waited {timeout_s:g} s for {what}"
        select.select([], [], [], 0.01)
    return value


def free_port() -> int:
    """Number of a port at which nobody listens now."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


AS_STRANGER = (
    *("setpriv", "--reuid", str(STRANGER_UID), "--regid", str(STRANGER_UID), "--clear-groups"),
    *("--inh-caps=-all,+dac_read_search", "--ambient-caps=-all,+dac_read_search"),
)
"""Runs a command as a user without any rights but to read this program, wherever it is installed."""
needs_stranger = pytest.mark.skipif(
    os.getuid() != 0 or not shutil.which("setpriv"), reason="only root with setpriv can become another user"
)


def config(
    bench: str = "t", speed: float = 20, devices: Mapping[str, Mapping[str, Any]] | None = None, **top: Any
) -> str:
    """A bench as YAML (of which JSON is a part); by default ``m1`` on a pty with the identity table."""
    chosen = devices or {"m1": {}}
    default = {"profile": "mechaduino", "port": "pty", "flash": {"table": "identity"}}
    return json.dumps(
        {"bench": bench, "speed": speed, "devices": {n: default | dict(d) for n, d in chosen.items()}} | top
    )


class Client:
    """A program that has a port open; it never blocks longer than it is told to."""

    def __init__(self, address: str | socket.socket) -> None:
        self._socket = address if isinstance(address, socket.socket) else None
        if isinstance(address, str) and address.startswith("socket://"):
            host, _, number = address.removeprefix("socket://").rpartition(":")
            self._socket = socket.create_connection((host, int(number)), timeout=PATIENCE_S)
        if self._socket:
            self._socket.setblocking(False)
            self.fd = self._socket.fileno()
        else:
            assert isinstance(address, str)
            self.fd = os.open(address, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.got = bytearray()
        """Bytes that came and were not taken by ``read_until`` or ``read_exactly``."""

    def write(self, data: bytes, timeout_s: float = PATIENCE_S) -> None:
        """Write all of ``data``; what comes meanwhile is kept."""
        deadline = time.monotonic() + timeout_s
        while data:
            left_s = deadline - time.monotonic()
            assert left_s > 0, f"{len(data)} bytes could not be written within {timeout_s:g} s"
            readable, writable, _ = select.select([self.fd], [self.fd], [], left_s)
            if readable:
                self._take()
            if writable:
                with suppress(BlockingIOError):
                    data = data[os.write(self.fd, data) :]

    def write_until_full(self, data: bytes) -> int:
        """Write as much of ``data`` as goes without waiting, and return how much that was."""
        sent = 0
        with suppress(BlockingIOError):
            while sent < len(data):
                sent += os.write(self.fd, data[sent:])
        return sent

    def _take(self, size: int = 65536) -> int:
        data = b""
        with suppress(BlockingIOError):
            data = os.read(self.fd, size)
        self.got += data
        return len(data)

    def read_until(self, marker: bytes, timeout_s: float = PATIENCE_S) -> bytes:
        """Read everything up to and with ``marker``."""
        deadline = time.monotonic() + timeout_s
        searched = 0
        while (at := self.got.find(marker, max(searched - len(marker), 0))) < 0:
            searched = len(self.got)
            self._wait(deadline, f"{marker!r} within {timeout_s:g} s after {bytes(self.got[-300:])!r}")
        return self._taken(at + len(marker))

    def read_exactly(self, size: int, timeout_s: float = PATIENCE_S, piece: int = 65536) -> bytes:
        """Read ``size`` bytes, in reads of at most ``piece``."""
        deadline = time.monotonic() + timeout_s
        while len(self.got) < size:
            self._wait(deadline, f"{size} bytes within {timeout_s:g} s, got {len(self.got)}", piece)
        return self._taken(size)

    def _taken(self, size: int) -> bytes:
        answer = bytes(self.got[:size])
        del self.got[:size]
        return answer

    def _wait(self, deadline: float, what: str, piece: int = 65536) -> None:
        left_s = deadline - time.monotonic()
        assert left_s > 0, f"no {what}"
        if select.select([self.fd], [], [], left_s)[0]:
            assert self._take(piece) or left_s > 0

    def quiet(self, for_s: float) -> bytes:
        """Read everything until nothing has come for ``for_s``."""
        while select.select([self.fd], [], [], for_s)[0] and self._take():
            pass
        return self._taken(len(self.got))

    def ask(self, command: bytes, end: bytes = b"\r\n", timeout_s: float = PATIENCE_S) -> bytes:
        self.write(command)
        return self.read_until(end, timeout_s)

    def close(self) -> None:
        if self._socket:
            self._socket.close()
        elif self.fd >= 0:
            os.close(self.fd)
        self.fd = -1

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Server:
    """One ``hil serve``. Its output goes to files, so that it never waits for a reader."""

    def __init__(self, place: "Place", command: Sequence[str], bench: str, **popen: Any) -> None:
        self.control = place.runtime / bench / "control.sock"
        # Appending: a position of its own is none of the process's business.
        self._out = tempfile.TemporaryFile("a+b")  # noqa: SIM115 - closed with the server
        streams = {"stdin": subprocess.DEVNULL, "stdout": self._out, "stderr": self._out}
        # The suite itself may run under nohup, which children inherit; a shell's daemon does not.
        ignored = signal.signal(signal.SIGHUP, signal.SIG_DFL)
        try:
            self.process: subprocess.Popen[bytes] = subprocess.Popen(command, **streams, **popen)
        except OSError:
            self._out.close()
            raise
        finally:
            signal.signal(signal.SIGHUP, ignored)
        self.pid = self.process.pid

    @property
    def output(self) -> str:
        # Not by seek and read: the process has the same file position, and a write in between moves it.
        return os.pread(self._out.fileno(), 1 << 24, 0).decode()

    def started(self, timeout_s: float = PATIENCE_S) -> "Server":
        """Wait until the daemon answers, and has begun to say how to reach its ports."""
        until(lambda: self.serves or self.process.poll() is not None, "the start", timeout_s)
        assert self.process.poll() is None, self.output
        return self

    @property
    def serves(self) -> bool:
        """True once the control socket answers; what is said at the start is on its way by then."""
        with suppress(ControlError):
            return bool(self.ask("list") and self.output)
        return False

    def refused(self, code: int = 2) -> str:
        """Wait until the daemon has ended by itself, and return what it said."""
        assert self.process.wait(PATIENCE_S) == code, self.output
        assert "Traceback" not in self.output
        return self.output

    def ask(self, verb: str, **arguments: Any) -> Any:
        return ask(self.control, verb, **arguments)

    def status(self, device: str = "m1") -> dict[str, Any]:
        """The device's row of ``hil status --json``."""
        row: dict[str, Any] = next(row for row in self.ask("status")["devices"] if row["device"] == device)
        return row

    def ready(self, device: str | None = None, since_ns: int = 0, boot_ns: int = READY_NS) -> "Server":
        """Wait until a board, or each, that was switched on at ``since_ns`` answers. The bench's time says
        it not: on a busy machine a board is behind it, and its boot text still to come."""

        def have_booted() -> bool:
            rows = [row for row in self.ask("status")["devices"] if device in (None, row["device"])]
            times_ns = [row["snapshot"]["at_ns"] for row in rows if row.get("snapshot")]  # a twin
            return min(times_ns, default=FOREVER) > since_ns + boot_ns + 50_000_000

        until(have_booted, "the boards' boot")
        return self

    def client(self, device: str = "m1") -> Client:
        rows = self.ask("list")["devices"]
        return Client(next(row["address"] for row in rows if row["device"] == device))

    def stop(self, number: int = signal.SIGTERM) -> str:
        """End the daemon by a signal, properly, and return what it said."""
        self.process.send_signal(number)
        assert self.process.wait(PATIENCE_S) == 0, self.output
        assert not any(word in self.output for word in FAULTS_OF_OURS), self.output
        return self.output

    def kill(self) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.kill()
        self.process.wait(PATIENCE_S)

    def close(self) -> None:
        self.kill()
        self._out.close()


class Place:
    """A folder with short paths (a socket's path has at most 107 bytes)."""

    def __enter__(self) -> "Place":
        self.folder = Path(tempfile.mkdtemp(prefix="hil-e2e-"))
        self.folder.chmod(0o755)
        self.runtime, self.state = self.folder / "run", self.folder / "state"
        self._servers: list[Server] = []
        self._clients: list[Client] = []
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for server in self._servers:
            # Always: a fixture is not told of its test's failure, and only then it is shown.
            print(f"--- hil serve, process {server.pid}\n{server.output[-4000:]}")
            server.close()
        shutil.rmtree(self.folder)

    def write(self, text: str, name: str = "bench.yaml") -> Path:
        path = self.folder / name
        path.write_text(text)
        path.chmod(0o644)
        return path

    def folders(self) -> tuple[str, ...]:
        """The options that make ``hil`` use this place."""
        return "--runtime-dir", str(self.runtime), "--state-dir", str(self.state)

    def launch(
        self, text: str, *options: str, bench: str = "t", prefix: Sequence[str] = (), **popen: Any
    ) -> Server:
        """Start ``hil serve`` without waiting for anything."""
        path = self.write(text, f"{bench}.yaml")
        command = [*prefix, HIL, "serve", str(path), *self.folders(), *options]
        server = Server(self, command, bench, **popen)
        self._servers.append(server)
        return server

    def serve(self, text: str, *options: str, **launch: Any) -> Server:
        """Start ``hil serve`` and wait until its ports are there and it has said all of it."""
        server = self.launch(text, *options, **launch).started()
        if "--json" not in options:
            until(lambda: LAST_WORDS in server.output or server.process.poll() is not None, "its words")
        return server

    def fork(self, log: Path, *options: str, bench: str = "t-replay") -> Server:
        """Start ``hil replay --serve``, and wait until it serves."""
        command = [HIL, "replay", str(log), "--serve", *self.folders(), *options]
        server = Server(self, command, bench)
        self._servers.append(server)
        return server.started()

    def script(self, source: str, *arguments: str, bench: str = "t", **popen: Any) -> Server:
        """Start a Python program instead of ``hil serve`` that says the same when it has started."""
        command = [sys.executable, str(self.write(source, "script.py")), *arguments]
        server = Server(self, command, bench, **popen)
        self._servers.append(server)
        return server

    def _command(self, arguments: Sequence[str]) -> list[str]:
        where = (
            ("--runtime-dir", str(self.runtime))
            if arguments[:1] and arguments[0] in NEEDS_RUNTIME_DIR
            else ()
        )
        return [*arguments, *where]

    def cli(self, *arguments: str, code: int = 0) -> str:
        """Run a command in this process, check its exit code, and return what it wrote, errors included."""
        done = CliRunner().invoke(app, self._command(arguments), env=TERMINAL)
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exc_info
        assert done.exit_code == code, f"exit code {done.exit_code}: {done.output}"
        return done.output

    def hil(self, *arguments: str, code: int = 0, input: bytes = b"", timeout_s: float = PATIENCE_S) -> str:
        """Run ``hil`` as ``cli`` does, but as a process of its own with a standard input."""
        done = subprocess.run(
            [HIL, *self._command(arguments)],
            input=input,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=timeout_s,
            env=os.environ | TERMINAL,
            check=False,
        )
        text = done.stdout.decode()
        assert done.returncode == code, f"exit code {done.returncode}: {text}"
        assert "Traceback" not in text, text
        return text


# ---- reloads ----


def reload(place: Place, server: Server, devices: Devices, **top: Any) -> dict[str, Any]:
    """Reload with these devices, and return what came of it, by kind of change."""
    place.write(config(devices=devices, **top), "t.yaml")
    done = server.ask("reload")
    assert "problems" not in done, done["problems"]
    return {word: names for word, names in done.items() if names}


def refused(place: Place, server: Server, devices: Devices, **top: Any) -> str:
    """Try a reload that is refused and changes nothing, and return why."""
    before = listed(server), folder(place), server.ask("faults")
    place.write(config(devices=devices, **top), "t.yaml")
    with pytest.raises(ControlError) as why:
        server.ask("reload")
    assert (listed(server), folder(place), server.ask("faults")) == before
    return str(why.value)


def listed(server: Server) -> dict[str, Any]:
    """Bench and devices as ``hil list`` has them, without the time until boards answer, which passes."""
    answer: dict[str, Any] = server.ask("list")
    return answer | {
        "devices": [{key: row[key] for key in row if key != "ready_in_ns"} for row in answer["devices"]]
    }


def folder(place: Place) -> dict[str, str]:
    """Names in the bench's runtime directory, each with the target of its symlink, if it is one."""
    paths = (place.runtime / "t").iterdir()
    return {path.name: str(path.readlink()) if path.is_symlink() else "" for path in paths}


def ended(server: Server, name: str) -> dict[str, Any]:
    """Progress of a run that has ended, waited for."""

    def end() -> Any:
        (progress,) = server.ask("runs", name=name)
        return progress if progress["state"] not in ("queued", "running") else None

    result: dict[str, Any] = until(end, f"the end of {name}")
    return result
