"""``gcode_plotter.ino``: its answers, and the path that it draws."""

from pathlib import Path

import pytest

from hil.gcode.reader import read_program
from hil.testing import FollowedPath, followed_by
from hil.toolpath.deviation import asked_path
from hil.toolpath.machine import parse_machine

HERE = Path(__file__).parent / "gcode_plotter"


@pytest.fixture
def plotter(bench, built):
    b = bench(built("gcode_plotter") / "bench.yaml")
    port = b.serial("u1", timeout=30)
    assert port.readline() == b"plotter\r\n"
    return b, port


def ask(port, line):
    port.write(line + b"\n")
    return port.readline().decode().strip()


def test_it_draws_what_the_program_asks_for(plotter):
    b, port = plotter
    machine = parse_machine((HERE / "machine.yaml").read_text(), "machine.yaml")
    lines = (HERE / "star.gcode").read_bytes()

    def carry_out():
        for line in lines.splitlines():
            assert ask(port, line) == "ok"
        b.run(ms=100)

    followed = followed_by(b, machine, carry_out)
    drawn = FollowedPath(machine, asked_path(read_program(lines).motions, machine), followed)
    assert drawn.deviation.largest < 0.1
    assert drawn.deviation.rest < 0.1
    assert drawn.picture(".png", title="star").startswith(b"\x89PNG")


def test_both_motors_make_their_share_of_a_line(plotter):
    b, port = plotter
    assert ask(port, b"G1 X10 Y-2.5") == "ok"
    assert [b.axis(name).snapshot().steps_taken for name in ("dx", "dy")] == [400, -100]
    port.write(b"M114\n")
    assert [port.readline(), port.readline()] == [b"X:10.00 Y:-2.50\r\n", b"ok\r\n"]


def test_a_line_takes_as_long_as_its_feed_says(plotter):
    b, port = plotter
    begun_ns = b.now_ns
    assert ask(port, b"G1 X30 Y40 F1500") == "ok"  # 50 mm at 25 mm/s
    assert (b.now_ns - begun_ns) / 1e9 == pytest.approx(2, abs=0.01)


def test_motors_that_are_off_stay(plotter):
    b, port = plotter
    assert ask(port, b"M18") == "ok"
    assert ask(port, b"G0 X10") == "ok"
    b.run(ms=100)
    axis = b.axis("dx").snapshot()
    assert axis.outputs_on == 0
    assert axis.position_deg < 5


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"G2 X1", "error: no such G"),
        (b"M3", "error: no such M"),
        (b"G1 X", "error: no number"),
        (b"G1 X1e9", "error: too far"),
        (b"G1 F0 X1", "error: F is 1 to 1800"),
        (b"T1", "error: no such letter"),
        (b"X1" * 50, "error: too long"),
        (b" g0x0 ; nothing to do", "ok"),
        (b"", "ok"),
    ],
)
def test_what_it_cannot_do_moves_nothing(plotter, line, answer):
    b, port = plotter
    assert ask(port, line) == answer
    assert b.axis("dx").snapshot().steps_taken == 0
