"""Edges of pins and lines are those of the run, over any window."""

import pytest
from exported_bench import CONFIG, recorded

from hil.recorded.exports.signal_sources import SignalCourse, signal_sources
from hil.recorded.recorded_run import RecordedRun
from hil.sim.input_log import InputLog
from hil.testing import Bench
from hil.vocab.line_format import FORMATS
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.wire.character_edges import character_edges

Edges = dict[str, list[tuple[int, int]]]


@pytest.fixture(scope="module")
def log() -> InputLog:
    return recorded()


def course(log: InputLog, from_ns: int = 0, to_ns: int | None = None) -> tuple[dict[str, int], Edges]:
    """Levels at the beginning of a window, and edges in it, of all signals."""
    run = RecordedRun(log)
    sources = signal_sources(run)
    names = [name for each in sources for name in each.names]
    made = SignalCourse(run, sources, names, SimTimeNs(from_ns), SimTimeNs(to_ns or run.end_ns))
    levels, edges = dict(made.levels), {name: [] for name in names}
    last_ns = 0
    for at_ns, name, level in made.edges():
        assert at_ns >= last_ns
        last_ns = at_ns
        edges[name].append((at_ns, level))
    return levels, edges


def test_a_window_is_a_part_of_the_whole(log: InputLog) -> None:
    levels, whole = course(log)
    # In the middle of a packet, of pulses, and of characters.
    bit_ns = NS_PER_S // 19200
    packet_ns = whole["bus1"][0][0]
    for from_ns in (packet_ns + 13 * bit_ns, 5 * NS_PER_S + 123, whole["s1.tx"][7][0]):
        to_ns = from_ns + 300 * NS_PER_MS
        begin, part = course(log, from_ns, to_ns)
        for name, edges in whole.items():
            assert part[name] == [edge for edge in edges if from_ns < edge[0] <= to_ns], name
            before = [level for at_ns, level in edges if at_ns <= from_ns]
            assert begin[name] == (before[-1] if before else levels[name]), name


def test_inputs_are_as_the_axis_has_them(log: InputLog) -> None:
    _, edges = course(log)
    assert len(edges["m1.step"]) == 2 * 240
    assert edges["m1.step"] == edges["s1.clk"]
    run, at = RecordedRun(log), edges["m1.step"][101]
    run.run_until(SimTimeNs(at[0] - 1))
    assert run.runtime.snapshot("m1").pin_step == 1 - at[1]
    run.run_until(SimTimeNs(at[0]))
    assert run.runtime.snapshot("m1").pin_step == at[1]


def test_outputs_are_those_that_the_test_kit_saw() -> None:
    with Bench(CONFIG) as bench:
        bench.run(1500)
        clk = bench.device("s1").pin("clk")
        bench.port("s1").write(b"m5v10\r")
        bench.run(500)
        seen, log = clk.edges(), bench.inputs.log()
        end_ns = bench.now_ns
    _, edges = course(log, 0, end_ns)
    assert edges["s1.clk"] == seen


def test_a_collision_is_drawn_as_the_wire_was() -> None:
    """Two that send at once: the wire is low only where both are, and read so by who reads its levels."""
    one, other = b"\x0f\x0f", b"\x33"

    def drive(bench: Bench) -> None:
        bench.run(100)
        bench.tap("bus0.a").write(one)
        bench.tap("bus0.b").write(other)
        bench.run(50)

    taps = {name: {"port": "memory"} for name in "ab"}
    line = {"modbus": {"units": {"m1": 1}}, "baud": 9600, "format": "8N1", "taps": taps}
    config = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}, "segments": {"bus0": line}}
    log = recorded(drive, config)
    _, edges = course(log, 0, 200 * NS_PER_MS)
    begin_ns = edges["bus0"][0][0]
    bit_ns = NS_PER_S / 9600
    levels = []
    for bit in range(20):
        at_ns = begin_ns + (bit + 0.5) * bit_ns
        levels.append([1, *(level for edge_ns, level in edges["bus0"] if edge_ns <= at_ns)][-1])
    bits_of = FORMATS["8N1"].levels
    alone = [*bits_of(one[0]), *bits_of(one[1])]
    assert levels[10:] == alone[10:]
    assert levels[:10] == [a | b for a, b in zip(bits_of(one[0]), bits_of(other[0]), strict=True)]


def test_characters_have_their_parity_and_stop_bits() -> None:
    edges = [*character_edges(0, b"\x01", 1000, FORMATS["8E1"])]
    ms = 1_000_000
    assert edges == [
        (0, 0),
        (1 * ms, 1),
        (2 * ms, 0),
        (9 * ms, 1),
    ]  # one 1: the parity bit is 1, as the stop bit
    assert [*character_edges(5, b"\x00\xff", 3, FORMATS["8N2"])][-2:] == [
        (5 + 11 * NS_PER_S // 3, 0),
        (5 + 12 * NS_PER_S // 3, 1),
    ]
