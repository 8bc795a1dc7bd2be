"""Standard streams that nobody reads, that are full, or that are closed: a bench serves without them."""

import os
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from e2e_support import HIL, PATIENCE_S, Place, config, until

from hil.net.control_client import ControlError, ask

OPEN_DOOR = config(bridges={"metrics": {"listen": "0.0.0.0:0", "insecure": True}})


@contextmanager
def shell(place: Place, streams: str, text: str | None = None) -> Iterator[subprocess.Popen[bytes]]:
    """``hil serve`` as a shell starts it; stdout and stderr are pipes that nobody reads."""
    path = place.write(OPEN_DOOR if text is None else text)
    command = f'exec "$0" serve "$@" {streams}'
    with subprocess.Popen(
        ["sh", "-c", command, HIL, str(path), *place.folders()],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def answers(control: Path) -> bool:
    try:
        return bool(ask(control, "list")["devices"])
    except (ControlError, OSError):
        return False


def end(process: subprocess.Popen[bytes], within_s: float = PATIENCE_S) -> None:
    process.send_signal(signal.SIGTERM)
    assert process.wait(within_s) == 0


@pytest.mark.parametrize(
    "streams", [">&-", "2>&-", "<&- >&- 2>&-", ">/dev/full", "2>/dev/full", ">/dev/full 2>&1"]
)
def test_streams_that_take_nothing(place: Place, streams: str) -> None:
    control = place.runtime / "t" / "control.sock"
    with shell(place, streams) as process:
        until(lambda: answers(control) or process.poll() is not None, "the start")
        assert process.poll() is None
        assert process.stderr
        end(process)
        assert b"Traceback" not in process.stderr.read()


def test_closed_streams_of_a_bench_with_problems(place: Place) -> None:
    """The exit code is all that is left to tell."""
    for streams in ("2>&-", "2>/dev/full"):
        with shell(place, streams, "bench: t\n") as process:
            assert process.wait(PATIENCE_S) == 2


def test_a_reader_that_goes(place: Place) -> None:
    control = place.runtime / "t" / "control.sock"
    with shell(place, "") as process:
        assert process.stdout
        process.stdout.close()
        until(lambda: answers(control) or process.poll() is not None, "the start")
        end(process)


def test_a_log_that_nobody_reads(place: Place) -> None:
    """The bench starts, serves and ends; at its end nobody waits until the log is read."""
    control, path = place.runtime / "t" / "control.sock", place.write(OPEN_DOOR)
    reads, writes = os.pipe()
    os.set_blocking(writes, False)
    with suppress(BlockingIOError):
        while os.write(writes, b"x" * 4096):
            pass
    os.set_blocking(writes, True)
    command = [HIL, "serve", str(path), *place.folders()]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=writes, stderr=writes) as process:
        os.close(writes)
        try:
            until(lambda: answers(control) or process.poll() is not None, "the start")
            assert ask(control, "status")["health"]
            end(process, 10)
        finally:
            process.kill()
            os.close(reads)


def test_the_end_of_the_log_is_there(place: Place) -> None:
    """The log comes first, then why nothing was started."""
    with socket.create_server(("0.0.0.0", 0)) as taken:
        listen = f"0.0.0.0:{taken.getsockname()[1]}"
        text = config(bridges={"metrics": {"listen": listen, "insecure": True}})
        warned, _, refused, *_ = place.launch(text).refused().splitlines()
    assert warned.startswith("WARNING bridges.metrics: insecure")
    assert ": bridges.metrics.listen: 0.0.0.0:" in refused
