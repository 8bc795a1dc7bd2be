"""Modules in virtual time: bytes in, bytes out, and when."""

from collections.abc import Callable
from typing import Any

import pytest

from hil.testing import Bench
from tmcl_bus.frames import Command, Reply, Request, Status, request_of

BAUD = 9600
CHARACTER_NS = 10 * 10**9 / BAUD
BENCH: dict[str, Any] = {
    "bench": "t",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac", "flash": {}},
        "c1": {"profile": "canopen_drive"},
        "u1": {"profile": "uno"},
    },
    "segments": {
        "bus0": {
            "baud": BAUD,
            "tmcl": {"modules": {"m1": 1, "s1": 3, "c1": 4, "u1": 5}},
            "taps": {"master": {}},
        }
    },
}
TURN = 51_200
READY_MS = 5000


class Master:
    def __init__(self, bench: Bench) -> None:
        self.bench, self.tap = bench, bench.tap("bus0.master")
        bench.run(ms=READY_MS)

    def raw(self, data: bytes, ms: float = 40) -> bytes:
        self.tap.write(data)
        self.bench.run(ms=ms)
        return self.tap.read()

    def ask(self, module: int, command: int, type_: int = 0, motor: int = 0, value: int = 0) -> Reply:
        raw = self.raw(Request(module, command, type_, motor, value).encode())
        assert len(raw) == 9
        assert sum(raw[:-1]) & 0xFF == raw[-1]
        fields = request_of(raw)
        return Reply(fields.module, fields.command, fields.type, fields.motor, fields.value)

    def value(self, module: int, command: int, type_: int = 0, motor: int = 0, value: int = 0) -> int:
        reply = self.ask(module, command, type_, motor, value)
        assert reply.status == Status.OK, reply
        return reply.value

    def until_there(self, module: int, seconds: float = 10) -> None:
        for _ in range(round(seconds * 20)):
            if self.value(module, Command.GAP, 8):
                return
        raise AssertionError("it has not arrived")


@pytest.fixture
def master(bench: Callable[..., Bench]) -> Master:
    return Master(bench(BENCH))


def test_bytes_and_times(master: Master) -> None:
    """The reply to GAP 1 of motor 0 begins 1 ms after the request's last bit."""
    began_ns = master.bench.now_ns
    master.tap.write(bytes.fromhex("01 06 01 00 00 00 00 00 08"))
    master.bench.run(ms=40)
    heard = master.tap.read_timed()
    data = bytes(byte for _, byte in heard)
    assert (data[:4], len(data)) == (bytes((2, 1, 100, 6)), 9)
    ends_ns = [at_ns - began_ns for at_ns, _ in heard]
    assert ends_ns == [int((9 + place) * CHARACTER_NS) + 10**6 for place in range(1, 10)]


@pytest.mark.parametrize(("module", "within"), [(1, 60), (3, 260), (4, 60)], ids=["m1", "s1", "c1"])
def test_moves(master: Master, module: int, within: int) -> None:
    start = master.value(module, Command.GAP, 1)
    assert master.value(module, Command.SAP, 1, value=0) == 0
    assert abs(master.value(module, Command.GAP, 1)) <= within, start
    assert master.value(module, Command.MVP, 0, value=TURN // 4) == TURN // 4
    assert master.value(module, Command.GAP, 8) == 0
    master.until_there(module)
    assert master.value(module, Command.GAP, 1) == pytest.approx(TURN // 4, abs=within)
    assert master.value(module, Command.MVP, 1, value=-TURN // 2) == -TURN // 4, "from the target"
    master.until_there(module)
    assert master.value(module, Command.GAP, 1) == pytest.approx(-TURN // 4, abs=within)
    assert master.value(module, Command.GAP, 0) == -TURN // 4


@pytest.mark.parametrize("module", [1, 3, 4], ids=["m1", "s1", "c1"])
def test_rotates_and_stops(master: Master, module: int) -> None:
    assert master.value(module, Command.ROR, value=TURN) == TURN
    master.bench.run(ms=1000)
    assert master.value(module, Command.GAP, 3) == pytest.approx(TURN, rel=0.05)
    assert master.value(module, Command.GAP, 2) == TURN
    assert master.value(module, Command.ROL, value=TURN // 2) == TURN // 2
    master.bench.run(ms=2000)
    assert master.value(module, Command.GAP, 3) == pytest.approx(-TURN // 2, rel=0.05)
    assert master.value(module, Command.GAP, 8) == 0
    assert master.ask(module, Command.MST).status == Status.OK
    master.bench.run(ms=1000)
    assert master.value(module, Command.GAP, 3) == pytest.approx(0, abs=TURN // 200)
    assert master.value(module, Command.GAP, 2) == 0


def test_statuses(master: Master) -> None:
    ask = master.ask
    assert ask(1, 77).status == Status.INVALID_COMMAND
    assert ask(1, Command.MVP, 2).status == Status.WRONG_TYPE
    assert ask(1, Command.GAP, 99).status == Status.WRONG_TYPE
    assert ask(1, Command.ROR, motor=1).status == Status.INVALID_VALUE
    assert ask(1, Command.SAP, 140, value=9).status == Status.INVALID_VALUE
    assert ask(1, Command.SAP, 4, value=2**31 - 1).status == Status.OK
    assert ask(1, Command.MVP, 0, value=100).status == Status.INVALID_VALUE, "it is faster than the axis"
    assert ask(1, Command.SGP, 66, value=9).status == Status.EEPROM_LOCKED
    wrong = master.raw(bytes.fromhex("01 06 01 00 00 00 00 00 09"))
    assert wrong == Reply(2, 1, Status.WRONG_CHECKSUM, 6, 0).encode()
    assert master.bench.segment("bus0").counters(master.bench.now_ns)["errors"] == {"checksum": 1}


def test_what_has_no_motor_is_not_moved(master: Master) -> None:
    for command in (Command.MVP, Command.ROR, Command.MST):
        assert master.ask(5, command, value=1).status == Status.NOT_AVAILABLE
    assert master.ask(5, Command.GIO, 0, 0).status == Status.WRONG_TYPE, "its pins tell no level"


def test_settings(master: Master) -> None:
    for number, value in ((4, 25_600), (5, 100_000), (6, 200), (7, 0), (127, 1), (140, 4)):
        assert master.value(1, Command.SAP, number, value=value) == value
        assert master.value(1, Command.GAP, number) == value
    assert master.value(1, Command.GGP, 66) == 1
    assert master.value(1, Command.GGP, 76) == 2
    assert master.value(1, Command.SIO, 1, 2, 1) == 1
    assert [master.value(1, Command.GIO, port, 2) for port in (0, 1)] == [0, 1]
    assert master.value(1, Command.GIO, 0, 0) in (0, 1)


def test_a_coarser_resolution_keeps_the_position_and_moves_further(master: Master) -> None:
    master.value(4, Command.SAP, 1, value=0)
    master.value(4, Command.SAP, 140, value=0)
    master.value(4, Command.SAP, 4, value=200)
    master.value(4, Command.SAP, 5, value=2000)
    before_deg = master.bench.axis("c1").snapshot().position_deg
    master.value(4, Command.MVP, 0, value=50)
    master.until_there(4)
    after_deg = master.bench.axis("c1").snapshot().position_deg
    assert after_deg - before_deg == pytest.approx(90, abs=1)


def test_version_as_text_and_as_number(master: Master) -> None:
    text = master.raw(Request(1, Command.GFV, 0, 0, 0).encode())
    assert (text[0], len(text), text[5:6]) == (2, 9, b"V")
    assert master.value(1, Command.GFV, 1) > 0


def test_nobody_replies_to_another_address(master: Master) -> None:
    for module in (0, 2, 6, 255):
        assert master.raw(Request(module, Command.GAP, 1, 0, 0).encode()) == b""


def test_a_request_that_was_broken_off_is_forgotten_after_a_silence(master: Master) -> None:
    whole = Request(1, Command.GAP, 6, 0, 0).encode()
    assert master.raw(whole[:4]) == b""
    assert master.raw(whole) == Reply(2, 1, Status.OK, Command.GAP, 128).encode()


def test_without_power_nobody_replies_and_settings_start_again(master: Master) -> None:
    master.value(4, Command.SAP, 6, value=7)
    with master.bench.fault("node_brown_out", "c1"):
        assert master.raw(Request(4, Command.GAP, 6, 0, 0).encode()) == b""
    master.bench.run(ms=1000)
    assert master.value(4, Command.GAP, 6) == 128


def test_faults_of_the_line(master: Master) -> None:
    whole = Request(1, Command.GAP, 6, 0, 0).encode()
    good = Reply(2, 1, Status.OK, Command.GAP, 128).encode()
    with master.bench.fault("packet_bad_crc", "m1.tmcl"):
        spoiled = master.raw(whole)
        assert (spoiled[:-1], spoiled[-1] == good[-1]) == (good[:-1], False)
    with master.bench.fault("packet_no_ack", "m1.tmcl"):
        assert master.raw(whole) == b""
    assert master.raw(whole) == good


def test_a_ghost_replies_at_its_address(master: Master) -> None:
    with master.bench.fault("node_clash", "bus0", address=9):
        assert master.ask(9, Command.MVP, 0, value=5) == Reply(2, 9, Status.OK, Command.MVP, 5)
