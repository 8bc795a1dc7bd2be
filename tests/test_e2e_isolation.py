"""Firmware with a bug: its own device stops, loudly; the other devices and the daemon go on."""

import time

import pytest
from e2e_support import Client, Place, Server, config, until

BROKEN = """
import asyncio, logging, sys
from pathlib import Path
from hil.config import parse
from hil.compose import find_catalogue
from hil.cli.bench.started import started as say_started
from hil.host.log_writer import LogWriter
from hil.daemon import Daemon
from hil.vocab.firmware import ByteAvailable, Delay

class Broken:
    def __init__(self, board):
        self.board = board
        if Broken.in_constructor:
            raise RuntimeError("no such board")

    in_constructor = False

    def interrupt(self, event):
        raise RuntimeError("interrupt of " + event.kind)

    def main(self):
        self.board.uart.write(b"up\\r\\n")
        while True:
            yield ByteAvailable()
            match chr(self.board.uart.read()):
                case "r":
                    raise ValueError("a [/bold] mistake")
                case "l":
                    while True:
                        pass
                case "s":
                    while True:
                        try:
                            sum(range(1000))
                        except Exception:  # what a careless firmware does: the guard must get through it
                            continue
                case "z":
                    while True:
                        yield Delay(0)
                case "e":
                    return
                case "y":
                    yield "nonsense"
                case "m":
                    self.board.axis.set("no such field", 1)
                case "x":
                    sys.exit(3)
                case "c":
                    Broken.in_constructor = True

def started(serving):
    serving.live.sim.devices["m1"]._sketch._make = Broken
    say_started(serving, LogWriter(2))

logging.basicConfig(level=logging.INFO)
path, runtime, state = map(Path, sys.argv[1:])
bench = parse(path.read_text(), str(path), find_catalogue())
daemon = Daemon(bench, config_folder=path.parent, runtime_base=runtime, state_base=state)
asyncio.run(daemon.run(started))
"""
REASONS = {
    b"r": "ValueError: a [/bold] mistake",
    b"l": "FirmwareHung: one step took more than 200 ms of CPU time",
    b"s": "FirmwareHung: one step took more than 200 ms of CPU time",
    b"z": "Firmware",  # stuck or hung, whichever limit it meets first
    b"e": "FirmwareStuck: the main program returned",
    b"y": "FirmwareStuck: the main program yielded 'nonsense'",
    b"m": "KeyError: 'no such field'",
    b"x": "SystemExit: 3",
}


def typed(server: Server, client: Client, data: bytes) -> None:
    """Type at m1, and wait until it has come: a request at the control socket may be quicker than a pty."""
    come = server.status("m1")["rx_bytes"] + len(data)
    client.write(data)
    until(lambda: server.status("m1")["rx_bytes"] == come, "what was typed")


@pytest.mark.thorough
@pytest.mark.parametrize("port", [{"port": "pty"}, {"port": {"kind": "tcp"}}], ids=["pty", "tcp"])
def test_a_broken_firmware_stops_its_device_alone(place: Place, port: dict[str, object]) -> None:
    path = place.write(config(speed=20, devices={"m1": port, "m2": {}}))
    server = place.script(BROKEN, str(path), str(place.runtime), str(place.state)).started().ready("m2")
    with server.client("m1") as client, server.client("m2") as other:
        for letter, reason in REASONS.items():
            place.cli("reset", "m1")
            client.read_until(b"up\r\n")
            start = time.monotonic()
            client.write(letter)
            said = client.read_until(b"]\r\n" if letter != b"r" else b")]\r\n").decode()
            assert time.monotonic() - start < 10
            assert f"[hil: m1 stopped: {reason}" in said
            assert other.ask(b"p").startswith(b"stepNumber: 0 ")
            assert time.monotonic() - start < 10
            assert server.status("m1")["failed"].startswith(reason)
            assert server.status("m2")["failed"] is None
            assert f"m1: stopped: {reason}"[:60] in place.cli("status")
            assert f"m1: stopped: {reason}"[:60] in place.cli("list")
            assert f"m1 stopped: {reason}" in server.output
        assert "the other devices go on; `hil reset m1` restarts it" in server.output
        # What is typed to a stopped device is not kept for the next start.
        typed(server, client, b"rrr")
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")

        typed(server, client, b"c")
        place.cli("reset", "m1")
        client.read_until(b"[hil: m1 stopped: RuntimeError: no such board (script.py:")
        until(lambda: "no such board (script.py:" in (server.status("m1")["failed"] or ""), "the reason")
        assert other.ask(b"p").startswith(b"stepNumber: 0 ")
    assert "Traceback" not in server.stop()
    assert not place.runtime.exists()


def test_an_interrupt_that_raises(place: Place) -> None:
    path = place.write(config(speed=20, devices={"m1": {}, "m2": {}}))
    server = place.script(BROKEN, str(path), str(place.runtime), str(place.state)).started().ready("m2")
    with server.client("m1") as client:
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")
        place.cli("pin", "m1", "D2", "1")
        client.read_until(b"[hil: m1 stopped: RuntimeError: interrupt of enable (script.py:")
    with server.client("m2") as other:
        other.ask(b"p")
    server.stop()
