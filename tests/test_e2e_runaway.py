"""A firmware that runs away, in each of the ways that it can: it is stopped, and the others go on."""

import signal
import time

import pytest
from e2e_support import Place, Server, config, until

PROGRAM = """
import asyncio, logging, re, sys, time
from pathlib import Path
from hil.config import parse
from hil.compose import find_catalogue
from hil.cli.bench.started import started as say_started
from hil.host.log_writer import LogWriter
from hil.daemon import Daemon
from hil.vocab.firmware import ByteAvailable, Delay

class Runaway:
    def __init__(self, board):
        self.board = board

    def interrupt(self, event):
        pass

    def main(self):
        self.board.uart.write(b"up\\r\\n")
        while True:
            yield ByteAvailable()
            way = chr(self.board.uart.read())
            (Path(sys.argv[2]) / "began").write_text(f"{time.monotonic()} {time.thread_time()}")
            match way:
                case "l":  # spins
                    while True:
                        pass
                case "p":  # prints
                    while True:
                        self.board.uart.write(b"0123456789" * 10)
                case "P":
                    while True:
                        self.board.uart.write(b"0123456789" * 10)
                        yield Delay(0)
                case "0":
                    while True:
                        yield Delay(0)
                case "u":
                    while True:
                        yield Delay(1_000)
                case "4":
                    while True:
                        yield Delay(8_000)
                case "w":  # each step works longer than it waits
                    while True:
                        sum(range(10_000))
                        yield Delay(50_000)
                case "a":  # takes memory
                    kept = []
                    while True:
                        kept.append(bytearray(1_000_000))
                case "r":  # a regular expression that backtracks forever
                    re.match("(a+)+$", "a" * 60 + "b")
                case "s":  # C code that looks at no signals
                    sum(range(10**12))
                case "z":  # waits in the kernel
                    time.sleep(3600)

def started(serving):
    sim = serving.live.sim
    sim.devices["m1"]._sketch._make = Runaway
    power = sim.devices["m1"].power
    before = power._on_failed
    def failed():
        (Path(sys.argv[2]) / "ended").write_text(f"{time.monotonic()} {time.thread_time()}")
        before()
    power._on_failed = failed
    say_started(serving, LogWriter(2))

logging.basicConfig(level=logging.INFO)
path, runtime, state = map(Path, sys.argv[1:])
bench = parse(path.read_text(), str(path), find_catalogue())
daemon = Daemon(bench, config_folder=path.parent, runtime_base=runtime, state_base=state)
asyncio.run(daemon.run(started))
"""
WAYS = {
    "l": "one step took more than 200 ms",
    "p": "one step took more than 200 ms",
    "P": "one step took more than 200 ms",
    "0": "one step took more than 200 ms",
    "u": "its steps took 200 ms of CPU time and did not come as far in simulated time",
    "w": "its steps took 200 ms of CPU time and did not come as far in simulated time",
    "a": "one step took more than 200 ms",
    "r": "one step took more than 200 ms",
    "z": "one step has waited for more than 200 ms",
}
LIMIT_CPU_S = 2.0
"""Maximum for a runaway of 200 ms: the watchdog is a thread, which waits on a busy computer. 0.57 s were seen
beside two busy loops."""


LOGGED = (
    PROGRAM.partition("def started(")[0]
    + """
from dataclasses import replace
from device_profiles.mechaduino import board
from hil.compose.replay import replay

board.PROFILE = replace(board.PROFILE, firmware=Runaway)
path, runtime, state, log = map(Path, sys.argv[1:5])
if sys.argv[5:] == ["replay"]:
    done = replay(log)
    print("difference:", done.difference(), flush=True)
    print([(each.device, each.input.reason) for each in done.logged.inputs if hasattr(each.input, "reason")])
else:
    logging.basicConfig(level=logging.INFO)
    bench = parse(path.read_text(), str(path), find_catalogue())
    daemon = Daemon(
        bench, config_folder=path.parent, runtime_base=runtime, state_base=state, input_log=log
    )
    asyncio.run(daemon.run(lambda serving: say_started(serving, LogWriter(2))))
"""
)


def run(place: Place, **devices: object) -> Server:
    path = place.write(config(devices={"m1": {}, "m2": {}} | devices))  # type: ignore[arg-type]
    return place.script(PROGRAM, str(path), str(place.runtime), str(place.state)).started().ready("m2")


def times(place: Place, name: str) -> list[float]:
    """Times of an event in the daemon: seconds of the wall and of its main thread's CPU time."""
    return [float(word) for word in until((place.runtime / name).read_text, f"its {name}").split()]


@pytest.mark.parametrize(
    "way",
    ["l", "0", "a", *(pytest.param(way, marks=pytest.mark.thorough) for way in WAYS if way not in "l0a")],
)
def test_a_runaway_is_stopped_and_the_others_go_on(place: Place, way: str) -> None:
    server = run(place)
    with server.client("m1") as client, server.client("m2") as other:
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")
        client.write(way.encode())
        until((place.runtime / "ended").exists, "the end of the runaway")
        other.ask(b"p")
        until(lambda: server.status("m1")["failed"], "the failure")
        assert WAYS[way] in server.status("m1")["failed"]
        assert server.status("m2")["failed"] is None
        remedies = {each["about"]: each["remedy"] for each in server.ask("status")["health"]["problems"]}
        assert remedies["m1"] == "`hil reset m1` restarts it"
        wall_s, used_s = (
            end - begin for begin, end in zip(times(place, "began"), times(place, "ended"), strict=True)
        )
        print(f"{way}: stopped after {wall_s * 1e3:.0f} ms, {used_s * 1e3:.0f} ms of CPU time")
        assert used_s < LIMIT_CPU_S
        client.quiet(0.2)
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")
    (place.runtime / "began").unlink()
    (place.runtime / "ended").unlink()
    server.stop()


@pytest.mark.parametrize(
    ("way", "m1"),
    [
        ("p", {}),
        *(pytest.param(way, m1, marks=pytest.mark.thorough) for way, m1 in (("w", {}), ("z", {}))),
        pytest.param("p", {"baud": 115200}, marks=pytest.mark.thorough),
    ],
    ids=str,
)
def test_the_replay_stops_what_the_guard_stopped(place: Place, way: str, m1: dict[str, object]) -> None:
    """The replay stops it in the same turn, with the same bytes; nothing of the wall's time is in the
    replay."""
    path = place.write(config(devices={"m1": m1, "m2": {}}))  # type: ignore[arg-type]
    log = place.runtime / "log.jsonl"
    arguments = [str(path), str(place.runtime), str(place.state), str(log)]
    server = place.script(LOGGED, *arguments).started().ready("m2")
    with server.client("m1") as client:
        client.write(way.encode())
        until(lambda: server.status("m1")["failed"], "the failure")
        place.cli("reset", "m1")
    (place.runtime / "began").unlink(missing_ok=True)
    server.stop()
    again = place.script(LOGGED, *arguments, "replay")
    again.process.wait(60)
    assert "difference: None\n[('m1', 'FirmwareHung: " in again.output
    log.unlink()


def test_a_paced_line_does_not_keep_what_a_runaway_printed(place: Place) -> None:
    """28 MB at 115200 baud would take 40 minutes, and the daemon as long to put them on the line."""
    server = run(place, m1={"baud": 115200})
    with server.client("m1") as client, server.client("m2") as other:
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")
        client.write(b"p")
        until(lambda: server.status("m1")["failed"], "the failure")
        began = time.monotonic()
        other.ask(b"p")
        assert time.monotonic() - began < 10
        assert (server.status("m1")["tx_bytes"], server.status("m1")["dropped_bytes"]) < (200_000, 1)


def test_what_cannot_be_interrupted_ends_the_daemon_and_is_known_afterwards(place: Place) -> None:
    server = run(place)
    with server.client("m1") as client:
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")
        client.write(b"s")
        output = server.refused(code=70)
    assert "CRITICAL m1: its firmware is in code that cannot be interrupted" in output
    (place.runtime / "began").unlink()
    again = place.serve(config(devices={"m1": {}, "m2": {}}))
    assert "which ended this bench the last time" in again.status("m1")["note"]
    assert again.status("m2")["note"] is None
    assert "m1: its firmware could not be interrupted" in again.output
    again.stop()
    assert place.serve(config(devices={"m1": {}, "m2": {}})).status("m1")["note"] is None, "it is told once"


def test_a_board_that_comes_behind_for_ever_leaves_the_others_alone(place: Place) -> None:
    """Steps of the board take less time than they get at the wall's pace, and more than at twenty times
    that."""
    server = run(place)
    with server.client("m1") as client, server.client("m2") as other:
        place.cli("reset", "m1")
        client.read_until(b"up\r\n")
        client.write(b"4")
        until((place.runtime / "began").exists, "the beginning")
        for _ in range(20):
            began_s = time.monotonic()
            other.ask(b"p")
            server.status("m2")
            assert time.monotonic() - began_s < 10
        client.write(b"x")
        place.cli("reset", "m1")  # it is late, and can be reset
        other.ask(b"p")
    (place.runtime / "began").unlink()
    server.stop()


def test_a_client_that_asks_for_much_is_no_runaway(place: Place) -> None:
    """Type as many queries of the look-up table as a device takes, at one instant; each takes 20 ms."""
    server = place.serve(config(speed=1, devices={"m1": {}})).ready()
    with server.client() as client:
        client.write(b"q" * 48)
        for _ in range(48):
            client.read_until(b"lookup[16384] = {\r\n")
        client.ask(b"p")
    assert server.status()["failed"] is None
    server.stop()


@pytest.mark.thorough
def test_who_types_much_gets_no_board_stopped(place: Place) -> None:
    """64 MB of answers: the board takes no more at a time than from a client, and the other one goes on."""
    server = place.serve(config(speed=1, devices={"m1": {}, "m2": {}})).ready("m2")
    place.cli("axis", "m1", "type", "q" * 512)
    with server.client("m2") as other:
        for _ in range(3):
            other.ask(b"p")
    unheard = until(lambda: (n := server.status("m1")["unheard_bytes"]) > 512 * 120_000 and n, "all answers")
    assert unheard < 512 * 140_000
    assert server.status("m1")["failed"] is None
    server.stop()


@pytest.mark.thorough
def test_byte_faults_on_a_long_answer_get_no_board_stopped(place: Place) -> None:
    server = place.serve(config(speed=1, devices={"m1": {}})).ready()
    server.ask("inject", fault="byte_flip", target="m1", parameters={"rate": 0.0001})
    place.cli("axis", "m1", "type", "q" * 64)
    until(lambda: server.status("m1")["unheard_bytes"] > 64 * 120_000, "all answers")
    assert server.status("m1")["failed"] is None
    server.stop()


def test_a_daemon_that_was_stopped_suspects_nobody(place: Place) -> None:
    """The daemon's devices catch up; the time in which it did not run is nobody's."""
    server = place.serve(config(speed=20, devices={f"m{i}": {} for i in range(1, 9)})).ready()
    server.process.send_signal(signal.SIGSTOP)
    began_s = time.monotonic()
    until(lambda: time.monotonic() - began_s > 2, "two seconds")
    server.process.send_signal(signal.SIGCONT)
    with server.client("m8") as client:
        client.ask(b"p")
    assert all(row["failed"] is None for row in server.ask("status")["devices"])
    server.stop()
