"""Targets of a capture: lines on the standard output, a file, or Wireshark.

Each says in ``told`` where it has put what; ``is_live`` of one whose user waits for the last packet, and
``out`` is the file descriptor that somebody may close, which ends the capture.
"""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress

from hil.cli.captures.capture_files import CaptureFile, Stream, capture_file, check_line, log_kind
from hil.cli.framework.ask import fail
from hil.cli.framework.installed_files import installed
from hil.cli.framework.problem_lines import has_colours
from hil.compose.decoded_item import DecodedItem
from hil.discovery.named_kinds import find_logs
from hil.host.shown_stream import own
from hil.wire.pcapng import Interface

DISSECTOR = "wireshark/sac_packets.lua"
_PATIENCE_S = 2
_NO_DISPLAY = re.compile(r"could not connect to display|cannot open display|no Qt platform plugin")
"""Messages of Qt, by way of Wireshark, on a computer without a screen."""
_SHOWN_BYTES = 4000


class LinesTarget:
    """Lines on the standard output, for people or as JSON."""

    name, is_live = "the standard output", True

    def __init__(self, *, as_json: bool, with_fields: bool = False) -> None:
        self._as_json, self._with_fields = as_json, with_fields
        self._colours = has_colours(sys.stdout)

    @contextmanager
    def open(self) -> Iterator[None]:
        """Have the standard output until the block ends, or nobody reads any more."""
        with _quiet_output():
            yield

    def begin(self, interfaces: Sequence[Interface]) -> int:
        """Begin; answers ``out``."""
        return sys.stdout.fileno()

    def write(self, blocks: bytes) -> None:
        """Take blocks of pcapng."""

    def show(self, items: Iterable[DecodedItem], first_ns: int) -> None:
        """Show items. ``first_ns``: where time begins."""
        if text := "".join(f"{self._line(item, first_ns)}\n" for item in items):
            out = own(sys.stdout)  # items are harmless, and may be red
            out.write(text)
            out.flush()

    def _line(self, item: DecodedItem, first_ns: int) -> str:
        if self._as_json:
            return json.dumps(item.as_dict(first_ns, with_fields=self._with_fields))
        line = item.line(first_ns, colours=self._colours)
        return "\n".join([line, *item.field_lines()]) if self._with_fields else line

    def told(self) -> str:
        return ""


class FileTarget:
    """File, or several one after the other; or pcapng on the standard output."""

    is_live = False

    def __init__(self, write: str, rotate_bytes: int, files: int) -> None:
        self.name = write
        self._rotation = rotate_bytes, files
        self._file: CaptureFile | None = None

    @contextmanager
    def open(self) -> Iterator[None]:
        with _quiet_output():
            try:
                yield
            finally:
                if self._file:
                    self._file.close()

    def begin(self, interfaces: Sequence[Interface]) -> int | None:
        if kind := log_kind(self.name):
            for each in interfaces:
                check_line(each, kind)
        self._file = capture_file(self.name, *self._rotation)
        return sys.stdout.fileno() if self.name == "-" else None

    def write(self, blocks: bytes) -> None:
        assert self._file
        self._file.write(blocks)

    def show(self, items: Iterable[DecodedItem], first_ns: int) -> None:
        """Show nothing."""

    def told(self) -> str:
        return f"; {self._file.told()}" if self._file else ""

    def openers(self) -> list[str]:
        """Commands that open the file, for people; none of the standard output and of several files."""
        if self.name == "-" or self._rotation[0]:
            return []
        file, dissector = shlex.quote(self.name), installed(DISSECTOR)
        shown = f" -X lua_script:{shlex.quote(str(dissector))}" if dissector else ""
        shark = f"tshark -r {file}{shown}"
        return [f"hil decode {file}", *([] if log_kind(self.name) else [shark])]


class WiresharkTarget:
    """Wireshark, which stays when the capture has ended."""

    name, is_live = "wireshark", False

    def __init__(self) -> None:
        if not (found := shutil.which(self.name)):
            raise fail(
                "hil: wireshark is not installed: install it (Debian: apt install wireshark), or leave out"
                " --wireshark to see the packets here"
            )
        self._program = found
        self._process: subprocess.Popen[bytes] | None = None
        self._patience_s = 0
        """Time for which Wireshark may take to end; 0: it goes on."""

    @contextmanager
    def open(self) -> Iterator[None]:
        try:
            yield
        except BrokenPipeError:
            self._patience_s = _PATIENCE_S
        finally:
            if self._process and self._process.stdin:
                with suppress(BrokenPipeError):
                    self._process.stdin.close()

    def begin(self, interfaces: Sequence[Interface]) -> int:
        command = [self._program, "-k", "-i", "-", *chosen_dissectors(interfaces)]
        # No pipe: Wireshark goes on when this command has ended, and writes on.
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 - closed in ``told``
        # In a session of its own: Ctrl-C in this terminal ends the capture, and not Wireshark.
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stderr=self._said, start_new_session=True
        )
        assert self._process.stdin
        self._stream = Stream(self._process.stdin, self.name)  # type: ignore[arg-type]
        return self._process.stdin.fileno()

    def write(self, blocks: bytes) -> None:
        self._stream.write(blocks)

    def show(self, items: Iterable[DecodedItem], first_ns: int) -> None:
        """Show nothing."""

    def told(self) -> str:
        """Raises typer.Exit: Wireshark has failed."""
        if self._process is None:
            return ""
        with self._said, suppress(subprocess.TimeoutExpired):
            if code := self._process.wait(self._patience_s):
                raise fail(f"hil: {self._failure(code)}")
        return f"; {self._stream.told()}"

    def _failure(self, code: int) -> str:
        said = os.pread(self._said.fileno(), _SHOWN_BYTES, 0).decode("utf-8", "replace").strip()
        if _NO_DISPLAY.search(said):
            return (
                "wireshark has no display to show itself on: call this in a graphical session (over ssh with"
                " -X), or write a file with -w FILE and open it where there is a display"
            )
        how = f"with exit code {code}" if code > 0 else f"by {signal.Signals(-code).name}"
        return f"wireshark ended {how}" + (f"; it said:\n{said}" if said else "")


def chosen_dissectors(interfaces: Sequence[Interface]) -> list[str]:
    """Options of Wireshark and tshark with which lines and buses are dissected."""
    options = []
    if dissector := installed(DISSECTOR):
        options += ["-X", f"lua_script:{dissector}"]
    for kind in find_logs():
        if any(map(kind.has, interfaces)):
            options += kind.dissectors
    return options


@contextmanager
def _quiet_output() -> Iterator[None]:
    """End the block quietly where nobody reads the standard output any more."""
    try:
        yield
    except (OSError, KeyboardInterrupt) as error:
        # What is left in its buffer would be an error at the exit, or wait forever.
        null = os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)
        if not isinstance(error, BrokenPipeError):
            raise
