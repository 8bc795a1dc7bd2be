"""Wires between boards: exact to the nanosecond, in one simulated time."""

from typing import Any

import pytest

from hil.config import ConfigError
from hil.testing import Bench


def bench_of(wires: list[dict[str, str]], **devices: str) -> dict[str, Any]:
    return {
        "bench": "wired",
        "devices": {name: {"profile": profile, "port": "memory"} for name, profile in devices.items()},
        "wires": wires,
    }


def send(bench: Bench, name: str, text: str) -> None:
    bench.port(name).write(text.encode() + b"\r")


def rises(bench: Bench, name: str, pin: str) -> list[int]:
    return [at_ns for at_ns, level in bench.device(name).pin(pin).edges() if level]


def test_a_sac_drives_a_mechaduinos_step_and_dir() -> None:
    wires = [{"from": "s1.clk", "to": "m1.step"}, {"from": "s1.dir", "to": "m1.dir"}]
    with Bench(bench_of(wires, m1="mechaduino", s1="sac")) as bench:
        bench.run(1500)
        before = bench.axis("m1").snapshot().r
        send(bench, "s1", "m100v60")
        bench.run(3000)
        clk = bench.device("s1").pin("clk").edges()
        assert len(clk) == 2 * 200  # two pulses a step
        # Its firmware has not seen an edge at dir yet.
        assert bench.axis("m1").snapshot().r - before == pytest.approx(-200 * 1.8 / 32, abs=1e-3)
        send(bench, "s1", "m-50v60")
        bench.run(3000)
        assert bench.axis("m1").snapshot().r - before == pytest.approx(-300 * 1.8 / 32, abs=1e-3)
        send(bench, "s1", "m50v60")
        bench.run(3000)
        assert bench.axis("m1").snapshot().r - before == pytest.approx(-200 * 1.8 / 32, abs=1e-3)


def test_an_edge_acts_at_its_own_nanosecond() -> None:
    """The Mechaduino's set-point changes with the rise and not before it, whatever the slices of time."""
    wires = [{"from": "s1.clk", "to": "m1.D1"}]
    with Bench(bench_of(wires, s1="sac", m1="mechaduino")) as bench:
        bench.run(1500)
        send(bench, "s1", "m5v10")
        bench.run(500)
        expected = rises(bench, "s1", "clk")
    for look in (-1, 0):
        with Bench(bench_of(wires, s1="sac", m1="mechaduino")) as bench:
            bench.run(1500)
            send(bench, "s1", "m5v10")
            bench.run_until((expected[3] + look) / 1e6)
            assert bench.axis("m1").snapshot().at_ns == expected[3] + look
            steps = bench.axis("m1").snapshot().r / (1.8 / 32)
            assert round(abs(steps)) == (4 if look == 0 else 3)


def test_the_end_of_one_releases_the_sync_of_another() -> None:
    with Bench(bench_of([{"from": "s1.OP_SA", "to": "s2.sync"}], s1="sac", s2="sac")) as bench:
        bench.run(1500)
        send(bench, "s2", "m10s")
        bench.run(100)
        assert bench.device("s2").pin("clk").edges() == []
        send(bench, "s1", "m10")
        bench.run(2000)
        fall = [at_ns for at_ns, level in bench.device("s1").pin("OP_SA").edges() if not level]
        assert rises(bench, "s2", "clk")[0] == fall[-1]
        assert bench.axis("s2").snapshot().pulses == 20


def test_wired_boards_share_one_time_and_others_do_not_wait() -> None:
    wires = [{"from": "s1.OP_SA", "to": "s3.sync"}, {"from": "s2.OP_SB", "to": "s3.Estop"}]
    with Bench(bench_of(wires, s1="sac", s2="sac", s3="sac", s4="sac")) as bench:
        assert len({id(group) for group in bench._runtime.parts._groups.values()}) == 2
        bench.run(1500)
        for name in ("s1", "s2", "s3", "s4"):
            send(bench, name, "q")
        bench.run(1000)
        assert all(b"Q is at 1" in bench.port(name).read() for name in ("s1", "s2", "s3", "s4"))
        assert {bench.axis(name).snapshot().at_ns for name in ("s1", "s2", "s3", "s4")} == {bench.now_ns}


def test_a_clock_wire_is_a_frequency() -> None:
    with Bench(bench_of([{"from": "s1.clock", "to": "s2.xclk"}], s1="sac", s2="sac")) as bench:
        assert bench.axis("s2").snapshot().clock_Hz == 1_000_000
        assert bench.axis("s1").snapshot().clock_Hz == -1


TEXT = """bench: b
devices:
  s1: {profile: sac}
  s2: {profile: sac}
  m1: {profile: mechaduino}
wires:
  - {from: %s, to: %s}
  - {from: s1.clk, to: m1.step}
"""


@pytest.mark.parametrize(
    ("output", "to", "at", "message", "remedy"),
    [
        ("s3.clk", "s2.sync", "from", 'there is no device "s3"', "known are: m1, s1, s2"),
        ("s1.clock_out", "s2.sync", "from", 's1 has no pin "clock_out"', 'did you mean "clock"?'),
        ("s1", "s2.sync", "from", '"s1" is no pin', "as in s1.clk"),
        ("s1.sync", "s2.sync", "from", "sync of s1 is an input", "write one of clk, dir"),
        ("m1.step", "s2.sync", "from", "step of m1 is an input", "no pin that a wire can begin at"),
        ("s1.clk", "s2.OP_SA", "to", "OP_SA of s2 is an output", "write one of sync, Estop"),
        ("s1.clk", "s2.synch", "to", 's2 has no pin "synch"', 'did you mean "sync"?'),
        ("s1.clock", "s2.sync", "wire", '"clock" and "sync" do not fit', "clock to xclk"),
        ("s1.dir", "s2.xclk", "wire", '"dir" and "xclk" do not fit', "clock to xclk"),
    ],
)
def test_a_wrong_wire_is_refused(output: str, to: str, at: str, message: str, remedy: str) -> None:
    with pytest.raises(ConfigError) as caught:
        Bench(TEXT % (output, to))
    (problem,) = caught.value.problems
    assert message in problem.message
    assert remedy in problem.remedy
    column = {"wire": 5, "from": 12, "to": 12 + len(output) + len(", to: ")}[at]
    assert (problem.line, problem.column) == (7, column)


def test_an_input_takes_one_wire() -> None:
    with pytest.raises(ConfigError) as caught:
        Bench(TEXT % ("s1.dir", "m1.D1"))
    (problem,) = caught.value.problems
    assert problem.message.endswith("m1.step is driven by s1.dir already")
    assert problem.line == 8


def test_a_wire_without_an_end_is_refused() -> None:
    with pytest.raises(ConfigError) as caught:
        Bench(bench_of([{"from": "s1.clk"}], s1="sac"))
    assert "missing" in caught.value.problems[0].message


def test_as_many_wires_from_one_board_as_the_core_has_room_for() -> None:
    names = [f"t{n}" for n in range(17)]
    wires = [{"from": "s1.clk", "to": f"{name}.sync"} for name in names]
    Bench(bench_of(wires[:16], s1="sac", **dict.fromkeys(names, "sac")))
    with pytest.raises(ConfigError, match="s1 has 16 wires already"):
        Bench(bench_of(wires, s1="sac", **dict.fromkeys(names, "sac")))
