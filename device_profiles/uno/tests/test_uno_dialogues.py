"""The Uno at its terminal: commands, errors, and what its pins do."""

import os
from collections.abc import Iterator
from itertools import pairwise
from random import Random

import pytest

from hil.testing import Bench

CONFIG = {"bench": "t", "devices": {"u1": {"profile": "uno"}}}
COMMANDS = ("move", "swing", "stop", "set", "show", "defaults", "pin", "?", "jump", "")
WORDS = (
    *(
        "1",
        "-1",
        "16",
        "0",
        "-0",
        "+5",
        "1600",
        "2000000001",
        "-2000000001",
        "9" * 30,
        "500",
        "125000",
        "490",
    ),
    *("l", "v", "iMax", "stepPin", "dirPin", "microStepping", "accelDuring", "1e3", "nan", "-inf", "1e999"),
    *("0.135", "6", "7", "13", "14", "1", "0", "2", "x", "--3", "+-3", "\u00b2", "\x00", "\x7f", "\xff"),
)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(CONFIG) as made:
        made.run(ms=100)
        made.port("u1").read()
        yield made


def typed(bench: Bench, line: str, ms: float = 100.0) -> str:
    """Answer to a line; the first one closes the last line of boot."""
    bench.port("u1").write(line.encode() + b"\n")
    bench.run(ms=ms)
    return bench.port("u1").read().decode().removeprefix("\r\n")


@pytest.mark.parametrize("end", [b"\n", b"\r", b"\r\n"])
def test_lines_end_as_terminals_end_them(bench: Bench, end: bytes) -> None:
    bench.port("u1").write(b"pin 3" + end + b"pin 4" + end)
    bench.run(ms=20)
    assert bench.port("u1").read() == b"\r\npin 3 is 0\r\npin 4 is 0\r\n"


def test_a_move_pulses_the_step_pin(bench: Bench) -> None:
    at_ns = bench.now_ns
    assert typed(bench, "move 3 1000") == "moving 3 steps, 1000 us each\r\nmoved 3 steps\r\n"
    step, direction = bench.device("u1").pin("D6").edges(), bench.device("u1").pin("D7").edges()
    assert [level for _, level in step] == [1, 0] * 3
    rises_ns = [at for at, level in step if level]
    assert [later - earlier for earlier, later in pairwise(rises_ns)] == [242 * 8000, 229 * 8000]
    assert all(fall[0] - rise[0] == 6000 for rise, fall in zip(step[::2], step[1::2], strict=True))
    begun_ns = direction[-1][0]
    assert at_ns < begun_ns == rises_ns[0] - 255 * 8000
    assert (direction[-1][1], bench.device("u1").pin("D6").edges()[-1][1]) == (1, 0)
    typed(bench, "move -2 1000")
    assert bench.device("u1").pin("D7").edges()[-1][1] == 0


def test_a_rate_is_rounded_to_counts_that_are_no_faster(bench: Bench) -> None:
    assert typed(bench, "move 1 7000").startswith("moving 1 steps, 144 us each")
    assert typed(bench, "move 1 125000").startswith("moving 1 steps, 8 us each")
    assert typed(bench, "move 1 491").startswith("moving 1 steps, 2040 us each")


def test_stop_ends_a_move_at_once(bench: Bench) -> None:
    typed(bench, "move 100000", ms=50)
    answer = typed(bench, "stop", ms=5)
    shot = bench.axis("u1").snapshot()
    assert answer == f"stopped, {100_000 - shot.pulses_sent} steps left\r\n"
    sent = shot.pulses_sent
    assert 0 < sent < 100_000
    bench.run(ms=100)
    assert (bench.axis("u1").snapshot().pulses_sent, bench.port("u1").read()) == (sent, b"")
    assert typed(bench, "stop") == "stopped, 0 steps left\r\n"


def test_swing_goes_there_and_back_with_a_pause(bench: Bench) -> None:
    typed(bench, "swing 20 5000", ms=3200)
    steps = [at for at, level in bench.device("u1").pin("D6").edges() if level]
    gaps_ns = [later - earlier for earlier, later in pairwise(steps) if later - earlier > 100_000_000]
    assert len(steps) == 80
    assert gaps_ns == [6000 + 1_000_000_000 + 255 * 8000] * 3  # from the end of the last pulse
    assert [level for _, level in bench.device("u1").pin("D7").edges()] == [1, 0, 1, 0, 1]
    typed(bench, "stop")
    bench.run(ms=1500)
    assert len([1 for _, level in bench.device("u1").pin("D6").edges() if level]) == len(steps)


def test_constants_are_kept_without_power(bench: Bench) -> None:
    answer = typed(bench, "set iMax 0.33")
    assert answer.startswith("43.00\r\n21\r\n253\r\nInter Step Delay: 343 us\r\n")
    bench.device("u1").reset()
    bench.run(ms=100)
    assert bench.port("u1").read().startswith(b"43.00\r\n")
    assert "iMax 0.3300\r\n" in typed(bench, "show")
    assert typed(bench, "defaults").startswith("18.00\r\n")


@pytest.mark.parametrize("text", [b"", b"\x00\xff", b"step/dir 0\nl 3", b"step/dir 1\nl x\nl\nv -1"])
def test_a_memory_of_something_else_is_the_manuals(text: bytes) -> None:
    from device_profiles.uno.constants import Constants
    from device_profiles.uno.memory import read_constants

    assert read_constants(text) == Constants()


def test_pins_can_be_others(bench: Bench) -> None:
    assert typed(bench, "set stepPin 2").startswith("18.00")
    typed(bench, "move 5")
    assert len(bench.device("u1").pin("D2").edges()) == 10
    assert bench.device("u1").pin("D6").edges() == []


def test_a_pin_is_driven_and_read(bench: Bench) -> None:
    assert typed(bench, "pin 8") == "pin 8 is 0\r\n"
    bench.device("u1").pin("D8", 1)
    assert typed(bench, "pin 8") == "pin 8 is 1\r\n"
    assert typed(bench, "pin 8 0") == "pin 8 is 0\r\n"
    bench.device("u1").pin("D8", 1)  # against the board's own level
    assert typed(bench, "pin 8") == "pin 8 is 0\r\n"


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("jump", "there is no jump; ? lists the commands"),
        ("move", "write move N [RATE]"),
        ("move 1 2 3", "write move N [RATE]"),
        ("move 0", "0 steps are no move"),
        ("move x", "N is a whole number of -2000000000 to 2000000000, not x"),
        ("move 1.5", "N is a whole number of -2000000000 to 2000000000, not 1.5"),
        ("move 2000000001", "N is a whole number of -2000000000 to 2000000000, not 2000000001"),
        ("move 1 490", "RATE is a whole number of 491 to 125000, not 490"),
        ("move 1 125001", "RATE is a whole number of 491 to 125000, not 125001"),
        ("stop now", "write stop"),
        ("set l", "write set NAME VALUE"),
        (
            "set L 5",
            "there is no L; constants are microStepping stepsPerRev l v iMax accelDuring"
            " stepPin dirPin nVoltes",
        ),
        ("set l much", "much is no number"),
        ("set l nan", "l is 0.001 to 10000"),
        ("set v 0", "v is 0.1 to 1000"),
        ("set accelDuring 1.5", "accelDuring is a whole number of 0 to 255"),
        ("set dirPin 6", "stepPin and dirPin are two pins"),
        ("set l 5000", "14062 us between steps; Timer2 counts 1 to 2040 us"),
        ("pin 1", "P is a whole number of 2 to 13, not 1"),
        ("pin 2 2", "a level is a whole number of 0 to 1, not 2"),
    ],
)
def test_what_cannot_be_done_is_said(bench: Bench, line: str, answer: str) -> None:
    assert typed(bench, line) == f"error: {answer}\r\n"


@pytest.mark.parametrize("line", ["move 5", "swing 5", "set l 40", "defaults", "pin 6 1", "pin 7 0"])
def test_a_move_is_not_disturbed(bench: Bench, line: str) -> None:
    typed(bench, "move 100000", ms=20)
    assert typed(bench, line, ms=20) == "error: it moves; stop it, or wait for its end\r\n"
    assert bench.axis("u1").snapshot().pulses_left > 0


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"pin \x003\n", "byte 0x00 is no text; send the line again"),
        (b"\xfe\n", "byte 0xFE is no text; send the line again"),
        (b"x" * 41 + b"\n", "a line has at most 40 characters; send the line again"),
        (b" " * 400 + b"\n", "a line has at most 40 characters; send the line again"),
    ],
)
def test_noise_costs_a_line(bench: Bench, line: bytes, answer: str) -> None:
    bench.port("u1").write(line + b"pin 3\n")
    bench.run(ms=100)
    assert bench.port("u1").read().decode() == f"\r\nerror: {answer}\r\npin 3 is 0\r\n"


def test_a_line_at_another_baud_is_noise(bench: Bench) -> None:
    bench.port("u1").write(b"move 100\n", client_baud=9600)
    bench.run(ms=100)
    bench.port("u1").read()
    assert bench.axis("u1").snapshot().pulses_sent == 0
    assert typed(bench, "\npin 3").endswith("pin 3 is 0\r\n")


def dialogue(random: Random) -> bytes:
    """A few lines of words of chance, some damaged."""
    lines = []
    for _ in range(random.randrange(1, 6)):
        words = [random.choice(COMMANDS), *random.choices(WORDS, k=random.randrange(4))]
        lines.append(" ".join(words).encode("latin-1") + random.choice((b"\n", b"\r", b"\r\n")))
    data = bytearray(b"".join(lines))
    for _ in range(random.choice((0, 0, 1, 5))):
        data[random.randrange(len(data))] = random.randrange(256)
    return bytes(data)


def test_fuzzed_dialogues_are_answered_and_harm_nothing(bench: Bench) -> None:
    """``HIL_FUZZ``: how many dialogues, a thousand times the number of lines; ``HIL_FUZZ_SEED``."""
    random = Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    port = bench.port("u1")
    for _ in range(int(os.environ.get("HIL_FUZZ", "300"))):
        port.write(dialogue(random))
        bench.run(ms=random.choice((0.1, 5, 40)))
        port.timeline.clear()
        port.read()
    assert bench.device("u1").failed is None
    port.write(b"\nstop\npin 3\n")
    bench.run(ms=500)
    assert port.read().decode().splitlines()[-1].startswith("pin 3 is ")


# ---- what the sketch does by itself ----


def ways(bench: Bench) -> list[tuple[float, int, int]]:
    """Ways of the motor so far: seconds of the first pulse, pulses, DIR."""
    rises = [at_ns for at_ns, level in bench.device("u1").pin("D6").edges() if level]
    turns = bench.device("u1").pin("D7").edges()
    found: list[list[int]] = []
    for before, at_ns in pairwise([-(10**10), *rises]):
        if at_ns - before > 500_000_000:
            found.append([])
        found[-1].append(at_ns)
    return [(way[0] / 1e9, len(way), [level for at, level in turns if at < way[0]][-1]) for way in found]


def test_the_motor_turns_there_and_back_by_itself() -> None:
    """A turn of 1600 eighth steps each way, a pause of 1 s before each: 1.27 s a way, of which the ramps
    take 10 steps each."""
    with Bench(CONFIG) as bench:
        bench.run(ms=6000)
        found = ways(bench)
        assert [(pulses, level) for _, pulses, level in found[:2]] == [(1600, 1), (1600, 0)]
        assert found[0][0] == pytest.approx(1.008, abs=0.002)  # the lines of boot take 6 ms
        way_s = 1600 * 144e-6 + 2 * sum(23 * n for n in range(11)) * 8e-6
        assert found[1][0] - found[0][0] == pytest.approx(1 + way_s, abs=0.005)
        assert bench.port("u1").read().endswith(b"Max Speed Real: 260.42")


@pytest.mark.parametrize("line", ["stop", "show", "pin 8", "jump"])
def test_any_command_ends_that(line: str) -> None:
    with Bench(CONFIG) as bench:
        bench.run(ms=1100)
        sent = bench.axis("u1").snapshot().pulses_sent
        assert 0 < sent < 1600
        said = typed(bench, line, ms=5)
        sent = bench.axis("u1").snapshot().pulses_sent
        if line == "stop":
            assert said.endswith(f"stopped, {1600 - sent} steps left\r\n")
        bench.run(ms=5000)
        assert bench.axis("u1").snapshot().pulses_sent == sent
        bench.device("u1").reset()
        bench.run(ms=1500)
        assert bench.axis("u1").snapshot().pulses_sent > sent


def test_it_rests_where_the_memory_says_so(bench: Bench) -> None:
    typed(bench, "set nVoltes 0")
    bench.device("u1").reset()
    bench.run(ms=5000)
    assert bench.axis("u1").snapshot().pulses_sent == 0
    assert "moving 3 steps" in typed(bench, "move 3 1000")


def test_an_empty_line_ends_nothing(bench: Bench) -> None:
    typed(bench, "", ms=2000)
    assert bench.axis("u1").snapshot().pulses_sent > 0
