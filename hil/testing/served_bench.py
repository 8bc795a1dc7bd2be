"""Benches in processes of their own, in real time, behind real ports: for tests of programs that know nothing
of hil; and the record of their traffic in a file."""

import contextlib
import json
import os
import re
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import serial

from hil.net.control_client import ControlError, ask, begin
from hil.testing.given import GivenConfig, NamedThings, as_json, checked_bytes, path_of, unreadable
from hil.testing.serial_ports.open_benches import LIVE
from hil.testing.served_program import ServedProgram

ANSWER_S = 60.0
"""Maximum time for an answer: of twenty benches that start at once on two CPUs each waits for its turns."""
_PIECE = 1 << 16


class LiveCapture:
    """Capture of all ports and lines that a bench has now, for a ``with`` block, as pcapng."""

    def __init__(self, control: Path, file: Path) -> None:
        self._control = control
        self._path = file

    def __enter__(self) -> "LiveCapture":
        self._client: socket.socket | None = None
        listed = ask(self._control, "status", timeout_s=ANSWER_S)
        rows = [*listed["segments"], *listed["buses"]]
        lines = [row.get("segment") or row["bus"] for row in rows]
        on_lines = {tap["tap"] for tap in listed["taps"]}
        places = [
            name
            for row in listed["devices"]
            for name in (row["device"] if row["address"] else "", *row["ports"])
        ]
        names = [*lines, *(name for name in places if name and name not in on_lines)]
        if names:
            self._client, _ = begin(self._control, "capture", timeout_s=ANSWER_S, ports=names)
            self._file = self._path.open("wb", buffering=0)
            self._thread = threading.Thread(target=self._copy, name="hil capture", daemon=True)
            self._thread.start()
        return self

    def _copy(self) -> None:
        assert self._client is not None
        with contextlib.suppress(OSError):
            while piece := self._client.recv(_PIECE):
                self._file.write(piece)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._client is None:
            return
        with contextlib.suppress(OSError):
            self._client.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._client.close()
        self._file.close()


READY_S = 120.0
"""Maximum time until the boards answer, by default: many that start at once have to wait for a CPU."""
END_S = 60.0
"""Maximum time for a daemon to end in after SIGTERM."""
SHORT_PATH = 60
"""Maximum length of the folder for temporary files: the path of a socket has at most 107 bytes."""
SHOWN_LINES = 40
OPEN: "list[ServedBench]" = []
"""Benches that run, for the reports of tests that fail."""


class LiveError(Exception):
    """Error of a live bench: ``str(error)`` is what ``hil`` said."""


class ServedBench:
    """Bench in a process of its own. ``folder`` has its ports and memories, ``kept`` its log and capture."""

    def __init__(self, process: subprocess.Popen[bytes], folder: Path, kept: Path) -> None:
        self._process = process
        self.folder = folder
        self.log_file = kept / "hil.log"
        self.capture_file = kept / "capture.pcapng"
        self.info: Mapping[str, Any] = {}
        """Report of ``hil serve --json`` from when the boards answered; the reference has its keys."""
        self.programs: list[ServedProgram] = []
        """Programs that ran beside it."""

    @property
    def pid(self) -> int:
        """Process of ``hil serve``."""
        return self._process.pid

    @property
    def ports(self) -> Mapping[str, str]:
        """Paths and URLs of all ports by address: ``m1``, ``s1.network``, ``bus0.master``."""
        return NamedThings("port", self.info["ports"])

    def port(self, name: str) -> str:
        """Path or URL of a port, as pyserial's ``serial_for_url`` takes it. Raises KeyError: with the names
        that there are."""
        __tracebackhide__ = True
        return self.ports[name]

    @property
    def log(self) -> str:
        """Log of the daemon so far."""
        return self.log_file.read_text(errors="replace")

    def ask(self, verb: str, **arguments: Any) -> Any:
        """Ask at the control socket, as in ``ask("inject", fault="packet_nak", target="s4.network",
        parameters={})``; the reference has its verbs. Raises LiveError: it was refused."""
        __tracebackhide__ = True
        try:
            return ask(Path(self.info["control"]), verb, timeout_s=ANSWER_S, **arguments)
        except ControlError as error:
            raise LiveError(str(error)) from None

    def hil(self, *arguments: str, timeout_s: float = READY_S) -> str:
        """Run a command on this bench, as in ``hil("fault", "clear")``; answers what it printed. Raises
        LiveError: it exits with another code than 0."""
        __tracebackhide__ = True
        command = [*_HIL, *arguments, "--runtime-dir", str(self.folder / "run")]
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout_s, check=False)
        if done.returncode:
            raise LiveError(f"hil {' '.join(arguments)}: exit code {done.returncode}\n{done.stderr}")
        return done.stdout

    def type(self, name: str, *lines: bytes, until: bytes, timeout_s: float = ANSWER_S) -> bytes:
        """Send lines to a port, and read after each up to ``until``; answers all that came. Raises LiveError:
        it did not come in time; TypeError: something is not bytes."""
        __tracebackhide__ = True
        lines, until = tuple(map(checked_bytes, lines)), checked_bytes(until)
        heard, address = b"", self.port(name)
        baud = self.info["bauds"][name] or 115200
        with serial.serial_for_url(address, baud, timeout=timeout_s) as port:
            for line in lines:
                port.write(line)
                heard += (answer := port.read_until(until))
                if not answer.endswith(until):
                    raise LiveError(
                        f"{name} did not answer {until!r} to {line!r} in {timeout_s:g} s: {answer!r}"
                    )
        return heard

    def program(
        self,
        words: Sequence[str | os.PathLike[str]],
        map: Mapping[str, str] | None = None,
        **options: Any,
    ) -> ServedProgram:
        """Run a program beside this bench, until its end or the bench's. A word that is the name of a port,
        or is one of ``map``, which has names of ports by such words, is given to it as the port's path.

        Raises:
            KeyError: there is no such port.
            OSError: it cannot be run.
        """
        __tracebackhide__ = True
        self.programs.append(ServedProgram(self.ports, words, map or {}, self.info["speed"], options))
        return self.programs[-1]

    def end_programs(self) -> None:
        """End the programs that still run beside it."""
        for each in self.programs:
            each.close()

    def report(self) -> list[tuple[str, str]]:
        """Titles and texts for the report of a test that failed: the ends of the log and of the traffic,
        in words."""
        name = self.info.get("bench", "live")
        sections = [(f"hil serve {name} ({self.log_file})", _end_of(self.log))]
        if self.capture_file.exists():
            decode = [*_HIL, "decode", str(self.capture_file)]
            text = subprocess.run(decode, capture_output=True, text=True, timeout=READY_S, check=False).stdout
            if text:
                sections.append((f"traffic of {name} ({self.capture_file})", _end_of(text)))
        return [*sections, *(section for each in self.programs for section in each.sections())]


_MAIN = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"
_HIL = (sys.executable, "-P", "-c", _MAIN)
"""Command of this installation, whatever a shell finds, and whatever is in the current folder."""


@contextmanager
def live(
    config: GivenConfig,
    *,
    options: tuple[str, ...] = (),
    capture: bool = True,
    keep: Path | None = None,
    timeout_s: float = READY_S,
) -> Iterator[ServedBench]:
    """Run a bench in a process of its own for the block, which begins when its boards answer.

    ``config`` is a path, YAML text or a dict; files that a text or a dict names need absolute paths.
    ``options``: further ones of ``hil serve``, as ``("--log", "run.jsonl")``; ``capture``: record the traffic
    of all ports and lines; ``keep``: folder in which log and capture stay.

    Raises:
        LiveError: the configuration has problems, which it lists, or the boards did not answer within
            ``timeout_s``.
        TypeError: ``config`` is no path, no text and no dict.
    """
    __tracebackhide__ = True
    with ExitStack() as stack:
        folder = Path(tempfile.mkdtemp(prefix="hil-", dir=_short_folder()))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        bench = stack.enter_context(_served(config, options, folder, keep or folder, timeout_s))
        if capture:
            stack.enter_context(LiveCapture(Path(bench.info["control"]), bench.capture_file))
        OPEN.append(bench)
        stack.callback(OPEN.remove, bench)
        LIVE.append((bench.info["bench"], bench.ports))
        stack.callback(LIVE.remove, LIVE[-1])
        stack.callback(bench.end_programs)
        try:
            yield bench
        except BaseException as error:
            error.add_note(f"--- the end of what hil serve said\n{_end_of(bench.log)}")
            raise


@contextmanager
def _served(
    config: GivenConfig,
    options: tuple[str, ...],
    folder: Path,
    kept: Path,
    timeout_s: float,
) -> Iterator[ServedBench]:
    __tracebackhide__ = True
    path = _config_file(config, folder)
    where = ("--runtime-dir", str(folder / "run"), "--state-dir", str(folder / "state"))
    command = [*_HIL, "serve", str(path), "--json", *where, *options]
    kept.mkdir(parents=True, exist_ok=True)
    with (kept / "hil.log").open("wb") as log:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log)
    bench = ServedBench(process, folder, kept)
    assert process.stdout is not None
    try:
        line, is_over = _line(process.stdout, timeout_s)
        if not line.endswith(b"\n"):
            _end(process)
            late = "" if is_over else f"the boards do not answer after {timeout_s:g} s\n"
            said = bench.log.strip() or f"hil serve ended with {process.returncode}"
            raise LiveError(late + _without_our_file(said, config, path))
        bench.info = json.loads(line)
        if error := bench.info.get("error"):
            raise LiveError(_without_our_file(error["message"], config, path))
        if failed := bench.info["failed"]:
            raise LiveError("\n".join(f"{name} has stopped: {why}" for name, why in failed.items()))
        yield bench
    finally:
        _end(process)


def _line(stream: IO[bytes], timeout_s: float) -> tuple[bytes, bool]:
    """Read a line, or what there is of it when the time is over or the stream ends; answers too whether it
    has ended."""
    line, until_s = b"", time.monotonic() + timeout_s
    while not line.endswith(b"\n") and (left_s := until_s - time.monotonic()) > 0:
        if select.select([stream], [], [], left_s)[0]:
            piece = os.read(stream.fileno(), 65536)
            if not piece:
                return line, True
            line += piece
    return line, False


def _end(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.terminate()
        process.wait(END_S)
    if process.poll() is None:
        process.kill()
        process.wait()
    if process.stdout:
        process.stdout.close()


def _config_file(config: GivenConfig, folder: Path) -> Path:
    __tracebackhide__ = True
    if given := path_of(config):
        try:
            given.stat()  # the daemon reads it, and says whatever else is wrong with it
        except (OSError, ValueError) as error:
            raise LiveError(str(unreadable(given, error))) from None
        return given
    path = folder / "bench.yaml"
    path.write_text(as_json(config) if isinstance(config, Mapping) else str(config))
    return path


def _without_our_file(said: str, config: GivenConfig, path: Path) -> str:
    """Name a configuration in a message as its writer knows it: a dict has no lines."""
    if isinstance(config, Mapping):
        return re.sub(re.escape(str(path)) + r"(:\d+:\d+)?", "<dict>", said)
    return said if path == path_of(config) else said.replace(str(path), "<text>")


def _short_folder() -> str:
    usual = tempfile.gettempdir()
    return usual if len(os.fsencode(usual)) <= SHORT_PATH else "/tmp"


def _end_of(text: str) -> str:
    lines = text.splitlines()
    left_out = [f"... {len(lines) - SHOWN_LINES} lines before"] if len(lines) > SHOWN_LINES else []
    return "\n".join([*left_out, *lines[-SHOWN_LINES:]]) or "nothing"
