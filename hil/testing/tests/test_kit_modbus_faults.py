"""Faults, noise and collisions at Modbus nodes; and that a log of all of it is the same again."""

import io

import pytest
from modbus_line import M1, MASTER, Line, config, f32

from bridges.modbus.protocol import client_side as client
from bridges.modbus.protocol.frame import Frame, encode
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers import layout
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Play
from hil.sim.log_checks import without_checks
from hil.testing import Bench, replay
from hil.vocab.faults import FAULT_KINDS, MODBUS_NODE, FaultRefused

READ = encode(1, 4, b"\0\0\0\1")
GOOD = encode(1, 4, b"\2\0\1")
NODE = "m1.modbus"


@pytest.fixture
def line():
    with Bench(config({"m1": M1, "m2": M1})) as bench:
        yield Line(bench)


def test_a_wrong_crc(line: Line) -> None:
    with line.bench.fault("packet_bad_crc", NODE):
        raw = line.send(READ)
        assert raw[:-2] == GOOD[:-2]
        assert Frame(0, raw).fault == "CRC"
    assert line.send(READ) == GOOD


def test_no_answer_to_what_was_carried_out(line: Line) -> None:
    with line.bench.fault("modbus_no_answer", NODE):
        assert line.send(encode(1, 6, b"\0\0\0\1")) == b""
    assert line.bench.axis("m1").snapshot().loop_on == 1
    assert line.send(READ) == GOOD


def test_an_exception_instead_of_what_was_asked(line: Line) -> None:
    with line.bench.fault("modbus_exception", NODE, code=4):
        assert line.send(encode(1, 6, b"\0\0\0\1")) == encode(1, 0x86, b"\4")
    assert line.bench.axis("m1").snapshot().loop_on == 0
    assert line.send(READ) == GOOD


def test_a_late_answer_the_later_faults_counts(line: Line) -> None:
    line.send(READ)
    usual_ns = line.wire[1].at_ns - line.wire[0].at_ns
    with line.bench.fault("modbus_late", NODE, late_ms=500), line.bench.fault("modbus_late", NODE, late_ms=9):
        assert line.send(READ) == GOOD
    assert line.wire[3].at_ns - line.wire[2].at_ns == usual_ns + 9_000_000


def test_another_units_number(line: Line) -> None:
    with line.bench.fault("modbus_wrong_unit", NODE):
        # The next one is there: it takes the answer for a request to it, which has the wrong length.
        assert line.send(READ) == encode(2, 4, b"\2\0\1") + encode(2, 0x84, b"\3")
        with line.bench.fault("modbus_wrong_unit", NODE, unit=99):
            assert line.send(READ) == encode(99, 4, b"\2\0\1")
    assert line.send(READ) == GOOD


def test_chance_is_of_the_seed_alone() -> None:
    def answered() -> list[bool]:
        with Bench(config({"m1": M1})) as bench:
            line = Line(bench)
            bench.fault("modbus_no_answer", NODE, rate=0.5, seed=7)
            return [bool(line.send(READ)) for _ in range(40)]

    first = answered()
    assert first == answered()
    assert 10 < sum(first) < 30


@pytest.mark.parametrize("target", ["m1", MASTER, "bus0"])
def test_a_fault_of_nodes_is_on_nodes(line: Line, target: str) -> None:
    with pytest.raises(FaultRefused, match=r"has no Modbus node; there are m1\.modbus, m2\.modbus"):
        line.bench.fault("modbus_late", target)
    with pytest.raises(FaultRefused):
        line.bench.fault("packet_no_ack", NODE)
    with pytest.raises(FaultRefused):
        line.bench.fault("shaft_jam", NODE)


def test_faults_of_the_wire_are_on_it_as_on_any_station(line: Line) -> None:
    for kind in ("wire_cut", "wire_swapped"):
        with line.bench.fault(kind, NODE):
            assert line.send(READ) == b"", kind
        assert line.send(READ) == GOOD, kind
    with line.bench.fault("node_babble", "m2.modbus", bytes=200, every_ms=1.0):
        assert line.send(READ) != GOOD
    line.bench.run(ms=200)
    line.master.read()
    assert line.send(READ) == GOOD
    with line.bench.fault("driver_stuck", NODE):
        line.send(READ)
    line.bench.run(ms=100)
    line.master.read()
    assert line.send(READ) == GOOD


@pytest.mark.parametrize("form", ["8N1", "8E1", "8O1", "8N2"])
def test_noise_spoils_frames_and_none_is_taken_for_good(form: str) -> None:
    with Bench(config({"m1": M1}, format=form)) as bench:
        line = Line(bench)
        with bench.fault("wire_noise", "bus0", rate=0.01, seed=3):
            answers = [line.send(READ) for _ in range(60)]
        good = answers.count(GOOD)
        assert 2 < good < 50
        assert answers.count(b"") > 10, "requests that it has not understood"
        assert line.send(READ) == GOOD
        errors = bench.segment("bus0").counters(bench.now_ns)["errors"]
        assert errors["CRC"] >= 60 - good


def test_two_wrong_bits_in_one_character_pass_parity_and_one_does_not() -> None:
    """A byte with two bits inverted whose CRC fits: parity sees nothing; one bit more, and it does."""
    with Bench(config({"m1": M1})) as bench:
        line = Line(bench)
        node = bench._runtime.cards[NODE]
        got: list[bytes] = []
        node._receiver._ended = lambda now_ns, start_ns, raw: got.append(raw)
        segment = bench._runtime.parts.wires["bus0"]

        class Noise:
            def __init__(self, data: bytes) -> None:
                self.data = data

            def apply(self, data: bytes) -> list[tuple[int, bytes]]:
                return [(0, self.data)]

        for meant in (bytes((READ[0] ^ 3, *READ[1:])), bytes((READ[0] ^ 1, *READ[1:]))):
            segment.noise[1] = Noise(READ)  # type: ignore[attr-defined]
            line.send(meant)
        assert got == [READ]


def test_a_collision_of_two_answers(line: Line) -> None:
    """Two masters ask at once: nobody understands anything; then everybody does again."""
    runtime = line.bench._runtime
    other = encode(2, 4, b"\0\0\0\1")
    runtime.apply_to(runtime.taps[MASTER], Play(((0, READ.hex()),)))
    segment = runtime.parts.wires["bus0"]
    runtime.parts.group_of("m2").at(
        line.bench.now_ns + 2_000_000,
        lambda now_ns: segment.transmit("m2.modbus", now_ns, other, 19200),
    )
    line.bench.run(ms=100)
    assert line.bench.segment("bus0").counters(0)["collisions"] == 1
    assert line.master.read() != GOOD
    assert line.send(READ) == GOOD
    assert line.send(other) == encode(2, 4, b"\2\0\1")


def test_two_answers_collide_when_one_is_late(line: Line) -> None:
    with line.bench.fault("modbus_late", NODE, late_ms=17):
        line.send(READ, ms=14)
        line.send(encode(2, 17), ms=100)
    assert line.bench.segment("bus0").counters(0)["collisions"] == 1
    assert line.send(READ) == GOOD


def test_a_line_that_is_never_silent_is_not_kept(line: Line) -> None:
    node = line.bench._runtime.cards[NODE]
    line.bench.fault("node_babble", "m2.modbus", bytes=10_000, every_ms=1.0)
    for _ in range(20):
        line.bench.run(ms=1000)
        line.master.read()
    assert len(node._receiver._data) < 12_000


def session(file: io.StringIO) -> str:
    with Bench(CONFIG) as bench:
        memories = {name: dict(bench.device(name).nvm) for name in CONFIG["devices"]}
    log = InputLogWriter(file, "test", CONFIG, memories)
    with Bench(CONFIG, around=BenchHooks(log=log)) as bench:
        line = Line(bench)
        line.send(encode(0, 6, b"\0\0\0\1"))
        move = encode(1, 16, client.encode(client.write(TABLE, layout.COMMAND_AT, (9, *f32(90.0))))[1:])
        bench.fault("wire_noise", "bus0", rate=0.001, seed=5)
        bench.fault("modbus_no_answer", "m2.modbus", rate=0.3, seed=6)
        bench.fault("modbus_late", NODE, rate=0.3, seed=8, late_ms=15)
        for at in range(40):
            line.send(move, ms=20)
            line.send(encode(2, 4, b"\0\0\0\x0a"), ms=11)
            line.send(encode(3, 1, b"\0\0\0\1")[: 4 + at % 8], ms=12 if at % 4 else 3)
            bench.port("m2").write(b"p")
        bench.run(ms=500)
    return file.getvalue()


TABLE = Table.HOLDING_REGISTERS
CONFIG = config({"m1": M1, "m2": M1, "s1": {"profile": "sac"}})


def test_a_log_is_the_same_again() -> None:
    text = session(io.StringIO())
    replayed = replay(text.splitlines(keepends=True))
    assert replayed.difference() is None
    ports = {sent.port for sent in replayed.logged.sent}
    assert ports == {"", "modbus"}
    answers = [sent for sent in replayed.sent["m1"] if sent.port == "modbus"]
    assert len(answers) >= 3
    assert replayed.runtime.segments["bus0"].counters(0)["collisions"] > 0
    spoiled = text.replace(answers[-1].data.hex(), "00" * len(answers[-1].data), 1)
    assert "m1, piece" in str(replay(without_checks(spoiled)).difference())


def test_the_same_session_is_the_same_text() -> None:
    assert session(io.StringIO()) == session(io.StringIO())


def test_each_kind_of_a_node_is_tested_here() -> None:
    kinds = {kind.name for kind in FAULT_KINDS.values() if kind.target == MODBUS_NODE}
    assert kinds == {"modbus_no_answer", "modbus_exception", "modbus_late", "modbus_wrong_unit"}
