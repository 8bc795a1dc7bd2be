"""`hil monitor` at benches that end and come again, with the times of what came, and beside another one."""

import os
import pty
import re
import select
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from e2e_support import HIL, PATIENCE_S, Place, config, until

from hil.wire.pcapng import read

TCP = {"port": "tcp"}


class Screen:
    """Terminal of a command. ``shown``: all that it has shown."""

    def __init__(self, place: Place, *words: str) -> None:
        self._child, self.terminal = pty.fork()
        if self._child == 0:
            os.execv(HIL, [HIL, *words, "--runtime-dir", str(place.runtime)])
        self.shown = b""

    def shows(self, wanted: bytes) -> bool:
        if select.select([self.terminal], [], [], 0)[0]:
            self.shown += os.read(self.terminal, 65536)
        return wanted in self.shown

    def type(self, keys: bytes) -> None:
        os.write(self.terminal, keys)

    def ends(self) -> int:
        self.type(b"\x1d")
        while select.select([self.terminal], [], [], PATIENCE_S)[0]:
            try:
                self.shown += os.read(self.terminal, 65536)
            except OSError:  # it has closed its end
                break
        os.close(self.terminal)
        return os.waitstatus_to_exitcode(os.waitpid(self._child, 0)[1])


@contextmanager
def screen(place: Place, *words: str) -> Iterator[Screen]:
    made = Screen(place, *words)
    yield made
    assert made.ends() == 0


@pytest.mark.parametrize("device", ["m1", "m2"])
def test_a_monitor_goes_on_at_a_bench_that_was_killed_and_started_again(place: Place, device: str) -> None:
    text = config(devices={"m1": {}, "m2": TCP}, speed=10)
    server = place.serve(text).ready()
    with screen(place, "monitor", device) as monitor:
        until(lambda: monitor.shows(b"to see it answer.\r\n"), "the beginning")
        monitor.type(b"p")
        until(lambda: monitor.shows(b"raw encoder: "), "an answer")
        server.kill()
        until(lambda: monitor.shows(b"waiting until it is there (Ctrl-] ends the monitor)"), "the end")
        place.serve(text).ready()
        until(lambda: monitor.shows(f"hil: {device} is there, at ".encode()), "the second bench")
        before = monitor.shown.count(b"raw encoder: ")

        def answers() -> bool:
            monitor.type(b"p")
            return not monitor.shows(b"\0") and monitor.shown.count(b"raw encoder: ") > before

        until(answers, "an answer of the second bench")


def test_each_line_has_the_time_that_a_capture_has(place: Place) -> None:
    server = place.serve(config(speed=10, devices={"m1": {}})).ready()
    file, log = place.folder / "out.pcapng", place.folder / "m1.log"
    capture = subprocess.Popen([HIL, "capture", "m1", "-w", str(file), "--runtime-dir", str(place.runtime)])
    until(lambda: file.exists() and file.stat().st_size, "the capture")
    begun_ns = server.ask("status")["sim_ns"]
    place.cli("pause")
    place.cli("resume")
    shown = place.hil("monitor", "m1", "--timestamps", "--log", str(log), input=b"pm")
    ended_ns = server.ask("status")["sim_ns"]
    capture.terminate()
    capture.wait(PATIENCE_S)
    lines = shown.encode().splitlines(keepends=True)
    times = [float(line[:12]) for line in lines]
    assert log.read_bytes() == b"".join(line[13:] for line in lines)
    assert begun_ns * 1e-9 - 1e-6 <= times[0] <= times[-1] <= ended_ns * 1e-9
    said = [(each.at_ns, each.data) for each in read(file.read_bytes()) if each.event == 2]
    assert b"".join(data for _, data in said) == log.read_bytes()
    starts, is_begin = [], True
    for at_ns, data in said:
        for byte in data:
            starts += [at_ns] * is_begin
            is_begin = byte == 0x0A
    apart = [at_ns * 1e-9 - time for at_ns, time in zip(starts, times, strict=True)]
    assert max(apart) - min(apart) < 1  # 100 ms of the wall: each capture reads the clock by itself


def test_two_monitors_at_a_port_are_both_told(place: Place) -> None:
    place.serve(config(devices={"m2": TCP})).ready("m2")
    told = rb"another program has this port open, too: both get all"
    with screen(place, "monitor", "m2") as one, screen(place, "monitor", "m2") as other:
        until(lambda: other.shows(b"Ctrl-T ? lists"), "the second")
        until(lambda: one.shows(b"another program has this port open, too"), "a word to the first")
        other.shows(b"")
        until(lambda: other.shows(b"another program has this port open, too"), "a word to the second")
        assert re.search(told, one.shown)
        assert re.search(told, other.shown)
