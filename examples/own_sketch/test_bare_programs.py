"""The programs in ``bare``, as they are kept: no compiler is needed."""

import subprocess
from itertools import pairwise
from pathlib import Path

import pytest

from device_profiles.sac.packet import encode

BARE = Path(__file__).parent / "bare"
COUNTS = [*range(225, 17, -23), *[18] * 1580, *range(41, 226, 23)]
"""OCR2A behind each step of a move but the last."""
COMPILER = "avr-gcc (GCC) 5.4.0"
NODE, MASTER, ACK = 41, 1, b"\x06"


def uno(name, **more):
    return {"profile": "uno", "firmware": str(BARE / f"{name}.hex"), **more}


def test_each_step_comes_at_its_cycle(bench):
    b = bench({"bench": "ramp", "devices": {"u1": uno("bare_ramp")}})
    pin = b.device("u1").pin("D6")
    b.run(ms=2000)
    rises = [at_ns * 16 // 1000 for at_ns, level in pin.edges() if level]
    gaps = [later - earlier for earlier, later in pairwise(rises)][: len(COUNTS)]
    assert all(abs(gap - (count + 1) * 128) <= 1 for gap, count in zip(gaps, COUNTS, strict=True))
    assert abs(rises[len(COUNTS)] - rises[0] - 128 * sum(count + 1 for count in COUNTS)) <= 1


@pytest.mark.parametrize(("name", "is_whole"), [("bare_node", True), ("bare_node_early", False)])
def test_the_answer_of_a_node_needs_its_driver_to_the_end(bench, name, is_whole):
    devices = {"u1": uno(name, rs485={"de": "D2"}), "s1": {"profile": "sac"}}
    segments = {"bus0": {"stations": ["u1", "s1"], "baud": 38400, "taps": {"master": {"port": "memory"}}}}
    b = bench({"bench": "line", "devices": devices, "segments": segments})
    b.start()
    led = b.device("u1").pin("D13")
    b.tap("bus0.master").write(encode(NODE, MASTER, b"y"))
    b.run(ms=20)
    assert (b.tap("bus0.master").read() == encode(MASTER, NODE, ACK)) == is_whole
    assert [level for _, level in led.edges()][-1:] == [1]  # it has understood the command


def test_they_are_what_their_sources_make(tmp_path):
    try:
        said = subprocess.run(["avr-gcc", "--version"], capture_output=True, text=True, check=True).stdout
    except OSError:
        pytest.skip("avr-gcc is not installed: apt install gcc-avr avr-libc")
    if not said.startswith(COMPILER):
        pytest.skip(f"made by {COMPILER}; here is {said.partition(chr(10))[0]}")
    for each in (*BARE.glob("*.c"), BARE / "Makefile"):
        (tmp_path / each.name).write_text(each.read_text())
    subprocess.run(["make", "-s"], cwd=tmp_path, check=True)
    for kept in BARE.glob("*.hex"):
        assert kept.read_text() == (tmp_path / kept.name).read_text()
