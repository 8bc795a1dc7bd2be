"""Facts of the profile's README, "Good to know", tried on the twin; Estop is in
``test_sac_firmware.py``, the encoder's beginning too."""

from itertools import pairwise

import pytest

from device_profiles.sac.packet import PacketDecoder, encode
from hil.testing import Bench

NS_PER_US = 1000
CHARACTER_NS = 10 * 10**9 // 38400


class Board:
    """A board past its cold start, and what somebody types at it."""

    def __init__(self, *setup: str) -> None:
        device = {"profile": "sac", "port": "memory"}
        self.bench = Bench({"bench": "t", "devices": {"s1": device}})
        self.port = self.bench.port("s1")
        self.network = self.bench.port("s1", "network")
        self.device = self.bench.device("s1")
        self.axis = self.bench.axis("s1")
        self.bench.run(ms=1100)
        self.started_with = self.port.read()
        for line in setup:
            self.say(line)

    def say(self, line: str, ms: float = 100) -> str:
        self.port.write(line.encode() + b"\r")
        self.bench.run(ms=ms)
        return self.port.read().decode("latin-1")

    def pulses(self) -> int:
        return int(self.axis.snapshot().pulses)

    def rises(self) -> list[int]:
        """Times in ns at which clk has risen."""
        return [at_ns for at_ns, level in self.device.pin("clk").edges() if level]

    def periods_us(self) -> list[float]:
        """Periods between the pulses so far; two pulses are a step."""
        return [(after - before) / NS_PER_US for before, after in pairwise(self.rises())]

    def steps_us(self) -> list[float]:
        return [(after - before) / NS_PER_US for before, after in pairwise(self.rises()[::2])]

    def turn(self, cycles: int) -> None:
        for name, level in (("EnA", 1), ("EnB", 1), ("EnA", 0), ("EnB", 0)) * cycles:
            self.device.pin(name, level)
            self.bench.run(ms=1)


def test_queued_commands_ramp_down_unless_they_have_d999() -> None:
    for dec, slowest_us in (("d1", 15_016), ("d999", 1000)):
        board = Board("m300v150a1" + dec, "m300v150a1" + dec)
        board.bench.run(ms=8000)
        assert max(board.periods_us()[500:700]) == slowest_us


@pytest.mark.parametrize(("late_us", "first_us"), [(-100, 1000), (100, 15_000)])
def test_the_gap_ends_when_op_sa_falls(late_us: int, first_us: int) -> None:
    first, second = "m100v150a999d999", "m100v150a1d999"
    board = Board()
    board.say(first, ms=2000)
    last_ns = board.rises()[-1]
    falls_ns = board.device.pin("OP SA").edges()[-1][0]
    assert falls_ns == last_ns + 1000 * NS_PER_US  # one period
    board = Board()
    board.port.write(first.encode() + b"\r")
    typed_ns = (len(second) + 1) * CHARACTER_NS
    board.bench.run_until(ms=(falls_ns + late_us * NS_PER_US - typed_ns) / 1e6)
    board.say(second, ms=3000)
    assert board.periods_us()[200] == pytest.approx(first_us)


@pytest.mark.parametrize(("key", "goes_on"), [("n", True), ("N", True), ("s", False), ("S", False)])
def test_a_continuous_motion_that_has_cut_a_loop(key: str, goes_on: bool) -> None:
    board = Board("q1m100v100a999d999", "q2m-100v100a999d999", "ls1", "lf2")
    board.say("m", ms=1000)
    assert board.axis.snapshot().queue_position == 0
    board.say(key, ms=5000)
    assert (board.axis.snapshot().queue_position in (1, 2)) is goes_on
    assert (board.axis.snapshot().motion_state != 0) is goes_on


def test_the_encoder_is_a_throttle_after_dollar_n() -> None:
    for setup, rpm in ((), 100), (("$n",), 105):
        board = Board(*setup, "mv100a999")
        board.turn(5)
        assert board.axis.snapshot().speed_rpm == rpm


@pytest.mark.parametrize(("number", "moves"), [(1, False), (2, True)])
def test_autorun_1_starts_nothing(number: int, moves: bool) -> None:
    board = Board(f"$CA{number}")
    board.device.reset()
    board.bench.run(ms=3000)
    assert (board.pulses() != 0) is moves


@pytest.mark.parametrize("line", ["u6", "t500000", "p", "f"])
def test_single_attributes_as_lines_do_nothing(line: str) -> None:
    board = Board()
    before = board.say("cf"), board.say("q", ms=1500)
    board.say(line)
    assert (board.say("cf"), board.say("q", ms=1500)) == before


@pytest.mark.parametrize(("dec", "steps"), [(40, 2), (46, 0), (60, 0), (30, 3)])
def test_no_factor_gives_one_step_down_in_a_truncated_move(dec: int, steps: int) -> None:
    board = Board()
    board.say(f"m200v100a.4d{dec}", ms=10_000)
    assert board.pulses() == 400
    periods = board.steps_us()
    assert sum(after > before for before, after in pairwise(periods)) + bool(steps) == steps


def test_a_linear_ramp_has_no_limit_of_52_us() -> None:
    board = Board("$CJ4", "$R", "$L1")
    board.say("m3200v600a300d300", ms=3000)
    periods = board.periods_us()
    ramp = periods[: periods.index(min(periods))]
    assert min(ramp) < 35


@pytest.mark.parametrize("second", ["m10v100a1d1", "m10v150a2.5d3l1"])
def test_a_load_takes_16_us_whatever_it_has_to_reckon(second: str) -> None:
    board = Board("m10v100a1d1", second)
    board.bench.run(ms=3000)
    ended_ns, begun_ns = (at_ns for at_ns, _ in board.device.pin("OP SA").edges()[1:3])
    assert begun_ns - ended_ns == 16 * NS_PER_US


def test_a_factory_restore_by_a_byte_is_silent() -> None:
    board = Board("$CL20")
    board.device.reset()
    board.bench.run(ms=500)
    board.port.write(b"x")
    board.bench.run(ms=1000)
    assert board.port.read() == board.started_with == b"SAC 1.0\r\nSAC>"
    assert "L slow\t\t10\r\n" in board.say("cc", ms=300)


def test_a_linear_ramp_has_half_the_steps_of_appendix_d() -> None:
    """The table has 349 steps for 100 RPM at 10 rad/s2; v2 / (2 alpha a) is 174, and the ramp takes v / a."""
    board = Board()
    board.say("m1000v100a10d999l1", ms=15_000)
    periods = board.steps_us()
    ramp = periods[: periods.index(3000)]
    assert len(ramp) == 174
    assert sum(ramp) / 1e6 == pytest.approx(
        10.472 / 10, rel=0.03
    )  # Austin's 0.676 makes the first step short


@pytest.mark.parametrize(("acc", "rpm"), [(1, 1.8), (10.47, 5.7)])
def test_linear_ramps_start_and_end_below_slow(acc: float, rpm: float) -> None:
    board = Board()
    board.say(f"m2000v30a{acc}d{acc}l1", ms=60_000)
    periods = board.steps_us()
    for period in (periods[0], board.periods_us()[-1] * 2):
        assert 300_000 / period == pytest.approx(rpm, abs=0.05)


def test_256_is_a_broadcast_and_a_reply_to_one_goes_nowhere() -> None:
    board = Board()
    board.say("256m20")
    assert board.network.read() == encode(0, 85, b"m20")
    board.network.write(encode(85, 86, b" hello"))
    board.bench.run(ms=100)
    board.network.write(encode(0, 87, b" all"))
    board.bench.run(ms=100)
    board.network.read()
    board.say("\\ thanks")
    assert PacketDecoder().feed(board.network.read()) == []


@pytest.mark.parametrize("mode", ["qp", "xp"])
@pytest.mark.parametrize("way_out", ["x", "packet", "Estop"])
def test_s_is_not_heard_in_a_program_mode(mode: str, way_out: str) -> None:
    board = Board("m", mode)
    board.bench.run(ms=1500)
    board.say("S")
    assert board.axis.snapshot().speed_rpm > 0
    if way_out == "x":
        board.say("x")
        board.say("S")
    elif way_out == "packet":
        board.network.write(encode(85, 1, b"S"))
        board.bench.run(ms=100)
    else:
        board.device.pin("Estop", 0)
    assert board.axis.snapshot().speed_rpm == 0


def test_s_is_not_heard_on_the_configuration_screen() -> None:
    board = Board("$C")
    board.network.write(encode(85, 1, b"m"))
    board.bench.run(ms=1500)
    assert board.axis.snapshot().speed_rpm > 0
    board.say("S")
    assert board.axis.snapshot().speed_rpm > 0


def test_without_gap_the_velocity_stays_in_play() -> None:
    for setup, first_us in ((), 15_000), (("g",), 1000):
        board = Board(*setup, "m100v150a999d999")
        board.bench.run(ms=2000)
        board.say("m100v150a1d999", ms=2000)
        assert board.periods_us()[200] == first_us


# ---- decisions where the manual is ambiguous ----


def test_the_listing_has_two_rules_and_one_place() -> None:
    board = Board("m2000v100a999d999")
    for place in (1, 2):  # it runs; it has ended, and the next command goes there
        listing = board.say("q", ms=1500).split("\r\n")
        assert listing[2] == listing[33] == "=" * 70
        assert listing[34] == f"Q is at {place}\t+ pulse \t\t* linear\t\ts sync"
        board.bench.run(ms=10_000)


def test_ramps_have_two_decimals_also_where_the_board_keeps_none() -> None:
    row = Board("q1m200a999d150.5").say("q", ms=1500).split("\r\n")[3]
    assert row == "1\t200\t CW\t100\t3000\t 999.00\t150.00\t0\t  0"


def test_an_acceleration_of_0_is_no_ramp() -> None:
    board = Board("m50v300a0d0")
    board.bench.run(ms=1000)
    assert board.pulses() == 100
    assert set(board.periods_us()) == {500}


@pytest.mark.parametrize(("mode", "edit"), [("qp", "1m300"), ("xp", "1,2"), ("$C", "K40")])
def test_the_prompt_is_the_same_in_the_program_modes(mode: str, edit: str) -> None:
    board = Board()
    for line in (mode, edit, "x", "vd"):
        said = board.say(line, ms=1500)
        assert said.endswith("\r\nSAC>")
        assert said.count(">") == 1


def test_a_software_port_above_38400_baud_works_and_is_warned_of() -> None:
    board = Board("$Cn57600", "$R")
    board.bench.run(ms=1000)
    assert "the software port is above 38400 baud" in str(board.device.notes)
    board.network.read()
    board.port.write(b"86vd\r")
    board.bench.run(ms=100)
    times = [at_ns for at_ns, _ in board.network.read_characters()]
    character_ns = min(after - before for before, after in pairwise(times))
    assert 10e9 / character_ns == pytest.approx(57_600, rel=0.05)
