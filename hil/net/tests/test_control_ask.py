"""Interruption of a request at the control socket, at any point."""

import gc
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

import pytest

from hil.net.control_client import ask


@pytest.fixture
def control() -> Iterator[Path]:
    """A socket that answers each request with its verb."""
    with TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX) as listener:
        path = Path(folder) / "control.sock"
        listener.bind(str(path))
        listener.listen()

        thread = threading.Thread(target=serve, args=(listener,))
        thread.start()
        yield path
        listener.shutdown(socket.SHUT_RDWR)
        thread.join()


def serve(listener: socket.socket) -> None:
    with suppress(OSError):  # the listener's end
        while True:
            client, _ = listener.accept()
            with client, suppress(OSError):  # a client that has gone
                client.recv(1000)
                client.sendall(b'{"ok": true, "result": {"effective_at_ns": 1}}\n')
                client.recv(1000)


def interrupted(control: Path, line: int) -> bool:
    """Ask, with Ctrl-C before a line of what runs then; whether there were so many lines."""
    lines = 0

    def trace(frame: FrameType, event: str, argument: Any) -> Any:
        nonlocal lines
        if event == "line" and (lines := lines + 1) == line:
            raise KeyboardInterrupt
        return trace

    gc.collect()  # sockets of interrupted lines: a finalizer would be counted, and swallows what is raised
    gc.disable()
    try:
        sys.settrace(trace)
        ask(control, "pin", device="m1", pin="D0", level=1)
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(None)
        gc.enable()
    assert lines < line, f"Ctrl-C before line {line} of {lines} was lost"
    return False


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # of a socket that was interrupted while it was made
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_no_interrupt_is_lost(control: Path) -> None:
    gc.freeze()  # each collection below looks at what this test leaves, and not at the whole test run
    line = 1
    try:
        while interrupted(control, line):
            line += 1
    finally:
        gc.unfreeze()
        gc.collect()
    assert line > 10
