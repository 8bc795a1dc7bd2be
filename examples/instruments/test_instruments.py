"""Three instruments by tables: what they answer, what they do meanwhile, and the checks of all boards."""

from pathlib import Path

import pytest
import yaml

from hil.testing import check_profile

HERE = Path(__file__).parent
BOARDS = HERE / "boards"


@pytest.fixture
def b(bench):
    made = yaml.safe_load((HERE / "bench.yaml").read_text())
    return bench(made | {"profile_path": [str(BOARDS)]})


def asked(b, device, line, ms=500):
    b.port(device).write(line)
    b.run(ms=ms)
    return b.port(device).read()


def test_relays_switch_and_are_read(b):
    assert asked(b, "relays", bytes.fromhex("FF0101 FF0401 FF0900")) == b"\x01\x00\x00\x01"
    no_command = "01 FFFF0400"
    assert asked(b, "relays", bytes.fromhex(no_command + "FF0900")) == b"\x01\x00\x00\x01"
    assert b.axis("relays").snapshot().switched == 2


def test_the_oven_ramps_and_keeps_its_set_point(b):
    asked(b, "oven", b"RANGE 3\r\nRAMP 1,1,60\r\nSETP 1,315\r\n")
    b.run(ms=10_000)
    assert b.axis("oven").snapshot().target_K == pytest.approx(305, abs=1)
    b.run(ms=300_000)
    assert asked(b, "oven", b"KRDG? A\r\n")[:5] == b"+315."
    b.device("oven").reset()
    assert asked(b, "oven", b"SETP? 1\r\nRANGE?\r\n") == b"+315.000\r\n0\r\n"


def test_the_supply_limits_its_current(b):
    assert asked(b, "supply", b"VOLT 5;CURR 2;:OUTP ON;:MEAS:CURR?\n") == b"+5.00000000E-01\r\n"
    b.axis("supply").set("load_ohm", 1)
    assert asked(b, "supply", b"MEAS:VOLT?;CURR?\n") == b"+2.00000000E+00;+2.00000000E+00\r\n"
    assert asked(b, "supply", b"VOLT 9;:SYST:ERR?;ERR?\n") == b'-222,"Data out of range";+0,"No error"\r\n'


def test_answers_are_lost_on_a_bad_line(b):
    with b.fault("byte_drop", "supply", rate=1):
        assert asked(b, "supply", b"*IDN?\n") == b""
    assert asked(b, "supply", b"*IDN?\n").startswith(b"Agilent Technologies,E3640A")


@pytest.mark.parametrize("board", ["power_supply"])
def test_the_checks_of_all_boards(board):
    check_profile(BOARDS / board)
