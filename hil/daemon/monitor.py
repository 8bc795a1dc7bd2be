"""``hil monitor``: a serial monitor in the terminal, on a port's address as any other client."""

import os
import select
import socket
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

QUIT = 0x1D  # Ctrl-]
_BITS_OFF_AT_INPUT = termios.ICRNL | termios.INLCR | termios.IXON


class MonitorError(Exception):
    """The port cannot be opened."""


def monitor(address: str, seconds: float | None = None) -> None:
    """Copy the terminal to the port and the port to the terminal, until Ctrl-], the end of standard
    input (if it is not a terminal: and until ``seconds`` have passed without an answer), or the port's end.

    Raises:
        MonitorError: the address cannot be opened.
    """
    with _opened(address) as port, _raw_terminal():
        _copy(port, 1.0 if seconds is None else seconds)


@contextmanager
def _opened(address: str) -> Iterator[int]:
    try:
        if address.startswith("socket://"):
            host, _, number = address.removeprefix("socket://").rpartition(":")
            with socket.create_connection((host.strip("[]"), int(number))) as connection:
                yield connection.fileno()
            return
        port = os.open(address, os.O_RDWR | os.O_NOCTTY)
    except (OSError, ValueError) as error:
        raise MonitorError(f"{address}: {error}") from error
    try:
        tty.setraw(port)
        yield port
    finally:
        os.close(port)


@contextmanager
def _raw_terminal() -> Iterator[None]:
    if not sys.stdin.isatty():
        yield
        return
    before = termios.tcgetattr(0)
    print("Ctrl-] ends the monitor.\r")
    try:
        tty.setraw(0)
        yield
    finally:
        termios.tcsetattr(0, termios.TCSADRAIN, before)
        print()


def _copy(port: int, quiet_s: float) -> None:
    interactive = sys.stdin.isatty()
    inputs, timeout_s = [port, 0], None
    while True:
        ready, _, _ = select.select(inputs, [], [], timeout_s)
        if not ready:
            return
        if port in ready:
            try:
                data = os.read(port, 4096)
            except OSError:
                return
            if not data:
                return
            os.write(1, data)
        if 0 in ready:
            typed = os.read(0, 4096)
            if interactive and QUIT in typed:
                return
            if not typed:
                inputs, timeout_s = [port], quiet_s
                continue
            os.write(port, typed)
