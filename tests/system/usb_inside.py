"""A client of USB boards, in the virtual machine: usb_inside.py TEST ARGUMENT... It asserts, and prints what
it has measured.

A board of its own (``Echo``) is one that answers with what it hears.
"""

import asyncio
import os
import pty
import random
import select
import signal
import subprocess
import sys
import termios
import time
import tty
from collections.abc import Callable
from itertools import product
from pathlib import Path

import serial
from serial.tools import list_ports

PATIENCE_S = 60.0
MENU = b"print main menu"
STATUS = Path("/sys/devices/platform/vhci_hcd.0/status")


def until(condition: Callable[[], bool], what: str, patience_s: float = PATIENCE_S) -> None:
    deadline = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline, f"waited {patience_s:g} s for {what}"
        time.sleep(0.05)


def plugged_in() -> int:
    return sum(" 006 " in text for path in STATUS.parent.glob("status*") for text in path.open())


# ---- programs ----


def terminal(*command: str) -> None:
    """Type m into a program at a terminal of its own until the menu is on its screen."""
    pid, screen = pty.fork()
    if pid == 0:
        os.environ["TERM"] = "xterm"
        os.execvp(command[0], command)
    shown = b""

    def is_shown() -> bool:
        nonlocal shown
        os.write(screen, b"m\r" if command[0] == "plink" else b"m")
        while select.select([screen], [], [], 1)[0]:
            shown += os.read(screen, 4096)
        return MENU in shown

    try:
        until(is_shown, f"the menu in {command}")
    finally:
        if command[0] == "screen":  # what holds the port goes on in the background
            subprocess.run(["screen", "-S", "hil", "-X", "quit"], check=True)
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        os.close(screen)


def listed(path: str, *words: str) -> None:
    """Find a port as pyserial's tools do."""
    (port,) = (port for port in list_ports.comports() if port.device == path)
    assert [port.vid, port.pid, port.serial_number] == [int(words[0], 16), int(words[1], 16), words[2]], vars(
        port
    )


# ---- lines ----


def hears(port: serial.Serial) -> bool:
    port.reset_input_buffer()
    port.write(b"m")
    return MENU in port.read_until(MENU, 4096)


def lines(path: str) -> None:
    """Toggle the modem lines, and send a break."""
    with serial.Serial(path, 115200, timeout=3, exclusive=True) as port:
        until(lambda: hears(port), "the menu")
        assert (port.dtr, port.rts, port.cts, port.dsr, port.cd, port.ri) == (*[True] * 5, False)
        for line, is_on in product(("dtr", "rts"), (False, True, False)):
            setattr(port, line, is_on)
            assert getattr(port, line) == is_on
        assert not hears(port), "without DTR and RTS the board says nothing"
        port.dtr = True
        assert hears(port)
        port.send_break(0.2)
        assert hears(port)
        try:
            serial.Serial(path, exclusive=True)
        except serial.SerialException:
            return
        raise AssertionError("a second program got what the first one has for itself")


def formats(native: str, adapter: str, opens: str) -> None:
    """Open a board again and again with formats of all kinds: native USB answers in each, what is behind an
    adapter hears 8N1 alone."""
    kinds = [("N", 8, 1), ("E", 7, 1), ("O", 7, 2), ("E", 8, 1), ("N", 8, 2)]
    for number in range(int(opens)):
        for parity, data_bits, stop_bits in kinds:
            how = {"parity": parity, "bytesize": data_bits, "stopbits": stop_bits, "timeout": 5}
            with serial.Serial(native, random.choice([9600, 115200, 1000000]), **how) as port:
                port.write(b"p")
                assert b"stepNumber" in port.read_until(b"stepNumber"), (number, how)
    with serial.Serial(adapter, 38400, timeout=3) as port:
        until(lambda: port.write(b"\r") and b"SAC>" in port.read_until(b"SAC>"), "a SAC's prompt")
    with serial.Serial(adapter, 38400, parity="E", bytesize=7, timeout=3) as port:
        port.write(b"$V\r")
        assert b"SAC>" not in port.read_until(b"SAC>"), "7E1 is not what a SAC hears"
    print(f"{opens} opens x {len(kinds)} formats")


# ---- a board that echoes ----


class Echo:
    """Board at a port of this process, as a ``PortHost``."""

    def __init__(self, kind: str) -> None:
        from importlib import import_module

        from hil.vocab.ports import PortContext

        module = import_module(f"virtual_ports.{kind}.port")
        context = PortContext("inside", "echo", Path("/tmp/usb-inside"))
        self.port = module.make(module.Options(), context)
        self.heard_bytes = 0

    def received(self, data: bytes) -> None:
        self.heard_bytes += len(data)
        self.port.write(data)

    def room(self) -> int:
        return max(0, 65536 - int(self.port.backlog()))

    def drained(self) -> None:
        self.port.resume_reading()

    def client_left(self, baud: int | None) -> None:
        pass

    def port_failed(self, reason: str) -> None:
        raise AssertionError(reason)


def opened(path: str) -> int:
    file = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(file)
    settings = termios.tcgetattr(file)
    settings[4] = settings[5] = termios.B115200
    termios.tcsetattr(file, termios.TCSANOW, settings)
    return file


def exchange(file: int, amount: int) -> float:
    """Send bytes, and read them back; answers the time in seconds."""
    data, got, sent = random.Random(1).randbytes(amount), bytearray(), 0
    os.set_blocking(file, False)
    since = time.monotonic()
    while len(got) < amount:
        readable, writable, _ = select.select([file], [file] if sent < amount else [], [], PATIENCE_S)
        assert readable or writable, f"{sent} sent, {len(got)} came back, and nothing for {PATIENCE_S:g} s"
        if readable:
            got += os.read(file, 65536)
        if writable:
            sent += os.write(file, data[sent : sent + 16384])
    assert bytes(got) == data
    return time.monotonic() - since


def round_trips(files: list[int], count: int) -> list[list[float]]:
    """Times of one byte there and back, in ms, of each in turn: a busy machine is busy for all of them."""
    times_ms: list[list[float]] = [[] for _ in files]
    for _ in range(count):
        for file, found in zip(files, times_ms, strict=True):
            since = time.perf_counter()
            os.write(file, b"x")
            os.read(file, 1)
            found.append((time.perf_counter() - since) * 1e3)
    return [sorted(found) for found in times_ms]


def figures(kinds: str, amount: str, count: str) -> None:
    """Measure a board at each kind of port, and see that no byte is lost."""

    def measure(paths: dict[str, str]) -> None:
        files = {kind: opened(path) for kind, path in paths.items()}
        for kind, times_ms in zip(files, round_trips([*files.values()], int(count)), strict=True):
            middle, late = times_ms[len(times_ms) // 2], times_ms[int(len(times_ms) * 0.99)]
            print(f"{kind}: round trip {middle:.2f} ms, p99 {late:.2f} ms")
        for kind, file in files.items():
            took_s = exchange(file, int(amount))
            print(f"{kind}: {amount} bytes there and back in {took_s:.1f} s")
            os.close(file)

    async def serve() -> None:
        boards = {kind: Echo(kind) for kind in kinds.split(",")}
        for board in boards.values():
            await board.port.open(board)
        await asyncio.to_thread(measure, {kind: board.port.address for kind, board in boards.items()})
        for board in boards.values():
            stats = board.port.stats()
            assert (stats.dropped_bytes, stats.unheard_bytes) == (0, 0), stats
            await board.port.close()

    asyncio.run(serve())


def plugging(count: str) -> None:
    """Plug a board in and pull it out, sometimes while a program has it open."""

    async def serve() -> None:
        before, took_s = plugged_in(), []
        for number in range(int(count)):
            board, since = Echo("usb"), time.monotonic()
            await board.port.open(board)
            took_s.append(time.monotonic() - since)
            # In a thread of its own: to open it is to ask this event loop.
            file = await asyncio.to_thread(opened, board.port.address) if number % 3 == 0 else -1
            await board.port.close()
            if file >= 0:
                await asyncio.to_thread(os.close, file)
            if number == 0:
                files = len(os.listdir("/proc/self/fd"))
        assert len(os.listdir("/proc/self/fd")) == files
        until(lambda: plugged_in() == before, "the last hub port to be free")
        print(f"{count} times: {sum(took_s) / len(took_s):.2f} s each, at most {max(took_s):.2f} s")

    asyncio.run(serve())


# ---- requests that no driver makes ----


def fuzz(vendor: str, seconds: str, seed: str) -> None:
    """Send a board requests of all kinds by usbfs, and take transfers back in the middle."""
    import usb.core
    import usb.util

    chance = random.Random(int(seed))
    device = usb.core.find(idVendor=int(vendor, 16))
    for number in (0, 1):
        if device.is_kernel_driver_active(number):
            device.detach_kernel_driver(number)
    end, sent, answered = time.monotonic() + float(seconds), 0, 0
    while time.monotonic() < end:
        sent += 1
        try:
            match chance.randrange(4):
                case 0:
                    kind = chance.choice([0x00, 0x01, 0x02, 0x21, 0x22, 0x40, 0x41])
                    body = chance.randbytes(chance.choice([0, 1, 7, 8, 64, 300]))
                    numbers = (chance.randrange(256), chance.choice([0, 1, 3, 0xFFFF]), chance.randrange(4))
                    if numbers[:2] != (9, 0) and numbers[0] != 5:  # it stays configured, with its address
                        device.ctrl_transfer(kind, *numbers, body, timeout=500)
                case 1:
                    kind = chance.choice([0x80, 0x81, 0x82, 0xA1, 0xA2, 0xC0])
                    numbers = (chance.randrange(256), chance.choice([0, 0x0100, 0x0200, 0x0301, 0x0F00]))
                    length = chance.choice([0, 1, 7, 8, 18, 255, 4096])
                    device.ctrl_transfer(kind, *numbers, chance.randrange(4), length, timeout=500)
                case 2:
                    device.write(2, chance.randbytes(chance.choice([0, 1, 63, 64, 65, 1280])), timeout=200)
                case _:
                    # A time-out takes the transfer back, in a race with the board's answer.
                    device.read(
                        chance.choice([0x81, 0x83]),
                        chance.choice([1, 16, 64, 128]),
                        timeout=chance.randrange(1, 20),
                    )
            answered += 1
        except usb.core.USBError:
            pass
    device.reset()
    usb.util.dispose_resources(device)  # else the interfaces stay this program's
    device.attach_kernel_driver(0)
    print(f"{sent} requests, {answered} without an error")


def main() -> None:
    tests = (terminal, listed, lines, formats, figures, plugging, fuzz)
    {test.__name__: test for test in tests}[sys.argv[1]](*sys.argv[2:])


main()
