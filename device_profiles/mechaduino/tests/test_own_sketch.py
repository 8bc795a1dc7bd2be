"""Sketches of a user's own on the board: the manual's examples, controllers and interrupts, and mistakes."""

from pathlib import Path

import pytest

from hil.testing import Bench
from hil.vocab.problem import ConfigError
from hil.wire.step_dir import generate

EXAMPLES = Path(__file__).parents[3] / "examples" / "own_mechaduino"
SETUP = "def setup(board):\n    yield from board.start()\n"


def _bench(sketch, **keys):
    device = {"profile": "mechaduino", "sketch": str(sketch), "flash": {"table": "identity"}, **keys}
    bench = Bench({"bench": "t", "devices": {"m1": device, "m2": {"profile": "mechaduino"}}})
    port = bench.port("m1")
    bench.run(ms=4100)
    return bench, port


def _own(tmp_path, text):
    (tmp_path / "mine.py").write_text(text)
    return _bench(tmp_path / "mine.py")


def test_the_button_turns_the_shaft_for_three_seconds():
    bench, _ = _bench(EXAMPLES / "button.py")
    bench.run(ms=500)
    assert abs(bench.axis("m1").snapshot().yw) < 0.2
    bench.device("m1").pin("D3", 1)
    bench.run(ms=10)
    bench.device("m1").pin("D3", 0)
    bench.run(ms=2900)
    assert bench.axis("m1").snapshot().yw == pytest.approx(90, abs=0.2)
    bench.run(ms=500)
    assert abs(bench.axis("m1").snapshot().yw) < 0.2


def test_it_prints_its_state_ten_times_a_second_beside_the_stock_commands():
    bench, port = _bench(EXAMPLES / "print_state.py")
    said = port.read()
    assert b"Identifier: x" in said
    assert said.endswith(b"setpoint: 0.00, error: " + said.rpartition(b"error: ")[2])
    bench.run(ms=2000)
    assert port.read().count(b"setpoint: 0.00, error: ") == 20
    port.write(b"r45\n")
    bench.run(ms=1000)
    said = port.read()
    assert b"Enter setpoint:\r\n45.00\r\n" in said
    assert b"setpoint: 45.00, error: " in said


def test_a_push_takes_the_shaft_on_by_90_degrees():
    bench, _ = _bench(EXAMPLES / "torque_detect.py")
    bench.run(ms=500)
    begun = bench.axis("m1").snapshot().r
    for torque_Nm, turned in ((0.15, 90), (-0.15, 0)):
        bench.axis("m1").load_torque_Nm = torque_Nm
        while bench.axis("m1").snapshot().r == pytest.approx(begun + (90 - turned), abs=1):
            bench.run(ms=1)
        bench.axis("m1").load_torque_Nm = 0.0
        bench.run(ms=500)
        assert bench.axis("m1").snapshot().r == pytest.approx(begun + turned, abs=0.1)


def test_slow_moves_take_the_time_that_they_are_told():
    bench, _ = _bench(EXAMPLES / "slow_moves.py")
    bench.run(ms=2)
    assert bench.axis("m1").snapshot().r == pytest.approx(90, abs=0.2)  # 90 ms, from 4,000 ms on
    bench.run(ms=2000)
    speeds = []
    for _ in range(60):
        before = bench.axis("m1").snapshot().r
        bench.run(ms=100)
        speeds.append((bench.axis("m1").snapshot().r - before) * 10)
    assert max(speeds) == pytest.approx(100, rel=0.05)
    bench.run(ms=1000)
    most = 0.0
    for _ in range(20):
        bench.run(ms=100)
        most = max(most, bench.axis("m1").snapshot().r)
    assert most == pytest.approx(450, abs=0.3)


def test_a_command_of_its_own_beside_the_stock_ones():
    bench, port = _bench(EXAMPLES / "serial_interface.py")
    port.read()
    port.write(b"xy")
    bench.run(ms=200)
    assert b"New setpoint " in port.read()
    port.write(b"g120\n")
    bench.run(ms=3000)
    assert b"120.00\r\n" in port.read()
    assert bench.axis("m1").snapshot().yw == pytest.approx(120, abs=0.3)


def test_a_step_interrupt_of_its_own_sees_each_pulse():
    bench, port = _bench(EXAMPLES / "step_dir.py")
    bench.run(ms=500)
    port.read()
    bench.device("m1").pin("dir", 1)
    bench.device("m1").pin("dir", 0)
    bench.device("m1").drive(generate(800, rate_hz=10_000))
    bench.run(ms=200)
    port.write(b"?")
    bench.run(ms=5)
    assert port.read() == b"800\r\n"
    assert bench.axis("m1").snapshot().r == pytest.approx(90, abs=0.01)
    bench.run(ms=500)
    assert bench.axis("m1").snapshot().yw == pytest.approx(90, abs=0.3)


def test_a_controller_of_its_own_runs_at_each_control_interrupt():
    bench, port = _bench(EXAMPLES / "controller.py")
    bench.run(ms=500)
    steps = bench.axis("m1").snapshot().control_steps
    bench.run(ms=1000)
    assert bench.axis("m1").snapshot().control_steps - steps == pytest.approx(6500, abs=1)
    port.write(b"r30\n")
    bench.run(ms=1500)
    now = bench.axis("m1").snapshot()
    assert now.yw == pytest.approx(30, abs=1.5)
    assert now.e == pytest.approx(now.r - now.yw, abs=1e-3)
    assert now.u == pytest.approx(2 * now.e, abs=0.5)


def test_the_same_run_twice_has_the_same_bytes():
    def run():
        bench, port = _bench(EXAMPLES / "controller.py")
        port.write(b"r33\n")
        bench.run(ms=700)
        return port.read(), bytes(str(bench.axis("m1").snapshot().values), "ascii")

    assert run() == run()


def test_a_reset_initialises_the_variables_of_the_sketch(tmp_path):
    bench, port = _own(
        tmp_path,
        "turns = 0\n" + SETUP + "def loop(board):\n    global turns\n    turns += 1\n"
        "    if turns == 10: board.SerialUSB.println(board.millis())\n",
    )
    first = port.read().splitlines()[-1]
    bench.device("m1").reset()
    bench.run(ms=4100)
    assert port.read().splitlines()[-1] == first == b"4009"


def test_what_a_sketch_raises_stops_its_device_with_file_and_line(tmp_path):
    bench, _ = _own(tmp_path, SETUP + "def loop(board):\n    board.r = 1 / 0\n")
    assert bench.device("m1").failed == "ZeroDivisionError: division by zero (mine.py:4)"
    assert bench.device("m2").failed is None
    bench.device("m1").reset()
    bench.run(ms=100)
    assert bench.device("m1").failed is None


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("    board.delay(5)\n", 'nothing waits here: write "yield board.delay(5)" (mine.py:4)'),
        ("    board.serialCheck()\n", 'write "yield from board.serialCheck()" (mine.py:4)'),
        ("    board.delay(5)\n    yield board.delay(6)\n", "yield board.delay(5)"),
        ("    board.yw = 3\n", "yw is set by the control interrupt: a sketch reads it (mine.py:4)"),
        ("    yield 5\n", '5 is nothing that can be waited for: write "yield board.delay(1)" (mine.py:4)'),
        ("    board.spin()\n", "'SketchBoard' object has no attribute 'spin' (mine.py:4)"),
    ],
)
def test_a_mistake_of_a_loop_is_said(tmp_path, body, said):
    bench, _ = _own(tmp_path, SETUP + "def loop(board):\n" + body)
    assert said in (bench.device("m1").failed or "")


def test_a_byte_that_is_peeked_at_waits_for_the_next(tmp_path):
    """The Arduino core of 2018 counts what waits behind the byte that it holds."""
    text = "def loop(board):\n    board.SerialUSB.peek()\n    yield from board.serialCheck()\n"
    bench, port = _own(tmp_path, text)
    port.read()
    port.write(b"p")
    bench.run(ms=100)
    assert port.read() == b""
    port.write(b"p")
    bench.run(ms=100)
    assert b"stepNumber" in port.read()


def test_a_controller_that_raises_stops_its_board_at_that_interrupt(tmp_path):
    text = SETUP + "    board.enableTCInterrupts()\nn = 0\ndef controller(board):\n    global n\n    n += 1\n"
    bench, _ = _own(tmp_path, text + "    if n == 50: raise RuntimeError('boom')\ndef loop(b): pass\n")
    bench.run(ms=100)
    assert bench.device("m1").failed == "RuntimeError: boom (mine.py:8)"
    assert bench.device("m2").failed is None


def test_a_time_of_a_turn_that_is_computed_and_wrong_is_a_mistake(tmp_path):
    bench, _ = _own(tmp_path, "LOOP_US = 5 - 5\ndef loop(board): pass\n")
    failed = bench.device("m1").failed or ""
    assert "LOOP_US is the time of a turn in us, above 0, and not 0" in failed
    assert failed.endswith("(mine.py)")


def test_each_level_but_0_is_high(tmp_path):
    text = SETUP + "    board.digitalWrite(13, 2)\n    board.digitalWrite(12, 0)\ndef loop(board): pass\n"
    bench, _ = _own(tmp_path, text)
    told = bench.runtime.devices["m1"].told
    assert (told["d13"], told["d12"]) == (1, 0)


def test_an_interrupt_that_waits_is_a_mistake(tmp_path):
    text = SETUP + "    board.enableTCInterrupts()\ndef controller(board):\n    yield board.delay(1)\n"
    bench, _ = _own(tmp_path, text + "def loop(board): pass\n")
    assert "an interrupt does neither" in (bench.device("m1").failed or "")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def loop(board:\n", ":1:9: this is no Python: "),
        ("def setup(board): pass\n", ":1:1: the sketch has no loop() (write"),
        ("\ndef loop(): pass\n", ":2:1: loop() takes one argument"),
        ("async def loop(board): pass\n", ":1:1: loop() is async"),
        ("LOOP_US = 0\ndef loop(board): pass\n", ":1:11: LOOP_US is the time of a turn in us, above 0"),
        ("LOOP_US = 'slow'\ndef loop(board): pass\n", ":1:11: LOOP_US is the time of a turn in us, above 0"),
    ],
)
def test_a_sketch_that_cannot_run_is_refused_with_its_line(tmp_path, text, said):
    with pytest.raises(ConfigError) as error:
        _own(tmp_path, text)
    assert "mine.py" + said in str(error.value)


def test_a_sketch_that_is_not_there_and_a_board_that_takes_none():
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        _bench("nowhere.py")
    with pytest.raises(ConfigError, match="the firmware of a sac takes no sketch"):
        Bench({"bench": "t", "devices": {"s1": {"profile": "sac", "sketch": "x.py"}}})


def test_a_limit_switch_is_searched_and_left_by_half_a_turn():
    device = {
        "profile": "mechaduino",
        "sketch": str(EXAMPLES / "limit_switch.py"),
        "flash": {"table": "identity"},
    }
    lower = {"axis": "m1", "to_deg": -90, "hysteresis_deg": 1, "bounce_ms": 2, "to": "m1.D3"}
    bench = Bench({"bench": "t", "devices": {"m1": device}, "switches": {"lower": lower}})
    bench.run(ms=8000)
    assert bench.axis("m1").snapshot().yw == pytest.approx(90, abs=0.2)
    assert not bench.device("m1").failed
