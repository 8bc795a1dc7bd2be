"""The board step_node with its program, as it is kept: no compiler is needed."""

import subprocess
from itertools import pairwise
from pathlib import Path

import pytest
import yaml

from hil.testing import check_profile

HERE = Path(__file__).parent
CYCLE_NS = 125
READY_MS = 200
COMPILER = "avr-gcc (GCC) 5.4.0"


def config(**device):
    made = yaml.safe_load((HERE / "bench.yaml").read_text())
    made["profile_path"] = [str(HERE / "boards")]
    made["devices"]["x1"] |= {"firmware": str(HERE / "program/step_node.hex"), **device}
    return made


@pytest.fixture
def b(bench):
    made = bench(config())
    made.start()
    made.run(ms=READY_MS)
    assert made.port("x1").read() == b"ready\r\n"
    return made


def asked(b, letter=b"?", ms=20):
    b.port("x1").write(letter)
    b.run(ms=ms)
    return b.port("x1").read()


def test_its_steps_turn_the_motor_at_its_clock(b):
    step, begun_deg = b.pin("x1.STEP"), b.axis("d1").snapshot().position_deg
    assert asked(b, b"s", ms=230) == b"done\r\n"
    rises = [at_ns for at_ns, level in step.edges if level]
    assert len(rises) == 200
    gaps = {(later - earlier) / CYCLE_NS for earlier, later in pairwise(rises)}
    assert gaps == {8007}  # two delays of 1 ms together, and what the loop takes
    turned_deg = b.axis("d1").snapshot().position_deg - begun_deg  # DIR is low
    assert turned_deg == pytest.approx(-200 * 1.8 / 8, abs=0.1)


def test_the_line_is_sent_at_the_speed_of_its_clock(b):
    b.port("x1").write(b"?")
    b.run(ms=20)
    timed = b.port("x1").read_timed()
    begun = [at_ns for at_ns, _ in timed]
    assert min(later - earlier for earlier, later in pairwise(begun)) == 10 * 8 * 26 * CYCLE_NS


@pytest.mark.parametrize(("volts", "counts"), [(0.0, 0), (0.825, 256), (1.65, 512), (3.3, 1023), (5.0, 1023)])
def test_voltages_are_counted_against_its_reference(bench, volts, counts):
    b = bench(config(voltages={"SENSE": volts}))
    b.start()
    b.run(ms=READY_MS)
    b.port("x1").read()
    assert asked(b) == b"sense %d feedback 0\r\n" % counts
    assert b.axis("x1").snapshot().sense_V == volts


def test_its_fan_is_a_mean_voltage_behind_a_filter(b):
    assert asked(b) == b"sense 512 feedback 104\r\n"  # 515 * (1 - exp(-2.3 / 10)), 2.3 ms later
    fan_V = b.axis("x1").snapshot().fan_V
    assert fan_V == pytest.approx(3.3 * 129 / 256)
    b.run(ms=100)  # ten time constants
    assert asked(b) == b"sense 512 feedback 515\r\n"


def test_its_pins_have_its_names(b):
    assert list(b.device("x1").pin("LED").edges()) == []
    asked(b)
    assert [level for _, level in b.pin("x1.LED").edges] == [1]
    assert b.axis("x1").snapshot().vcc_V == 3.3
    with pytest.raises(KeyError, match=r"no pin 'D13'; there are RX, TX, DE, FAN, DIR, STEP, LED, FEEDBACK$"):
        b.pin("x1.D13")


def test_an_upload_finds_the_bootloader_at_its_speed(bench):
    b = bench(config())
    with b.serial("x1", baudrate=57600, timeout=0.2) as port:  # opening it resets the board
        b.run(ms=600)  # its start, and the flashes of the LED
        port.write(b"0 ")
        assert port.read(2) == b"\x14\x10"


def test_it_passes_the_checks_of_all_boards():
    check_profile(HERE / "boards/step_node")


def test_its_program_is_what_its_source_makes(tmp_path):
    try:
        said = subprocess.run(["avr-gcc", "--version"], capture_output=True, text=True, check=True).stdout
    except OSError:
        pytest.skip("avr-gcc is not installed: apt install gcc-avr avr-libc")
    if not said.startswith(COMPILER):
        pytest.skip(f"made by {COMPILER}; here is {said.partition(chr(10))[0]}")
    for name in ("step_node.c", "Makefile"):
        (tmp_path / name).write_text((HERE / "program" / name).read_text())
    subprocess.run(["make", "-s"], cwd=tmp_path, check=True)
    assert (HERE / "program/step_node.hex").read_text() == (tmp_path / "step_node.hex").read_text()
